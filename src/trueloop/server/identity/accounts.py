"""Accounts: made, found and changed. A change of role, password or state ends the account's sessions."""

import math
import re
import secrets
import unicodedata
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from threading import BoundedSemaphore
from typing import Any, Final

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from sqlalchemy import Connection, Row, func, insert, select, update

from trueloop.domain.option import LengthUnit
from trueloop.errors import Code, TrueloopError
from trueloop.server.identity.keys import ROLES, Role, note
from trueloop.storage.schema import ACCOUNT, SESSION, stamp
from trueloop.storage.store import Store
from trueloop.wording import wording

SHORTEST: Final = 12
LONGEST: Final = 128
COMMON_LOG10: Final = 9.0
"""A password among the first 10⁹ guesses is common: by lists of passwords, words, names, rows of keys and dates."""
_LOOKED_AT: Final = 72
"""So many characters are judged, for the time that judging takes."""
_OF_THE_SHOP: Final = """
trueloop true loop correcthorsebatterystaple machine shop machineshop machinist workshop toolroom factory lathe
mill milling turning grinding machining spindle quality inspection operator admin administrator sommer winter
herbst frühling werkstatt maschine maschinenbau drehmaschine fräsmaschine drehbank drehteil drehen dreher fräsen
fräser schleifen bohren messen messraum prüfung qualität zerspanung fertigung produktion betrieb firma halle büro
meister schicht schichtleiter lehrling azubi passwort kennwort geheim zugang anmeldung benutzer willkommen hallo
schlüssel deutschland montag januar februar märz april mai juni juli august september oktober november dezember
fanuc siemens sinumerik heidenhain okuma mazak haas linuxcnc dmg mori hermle renishaw zeiss
"""
"""Words that people in a shop take first, which the lists of zxcvbn, English ones, are without."""
_WITHOUT_UMLAUTS: Final = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue"})
_HASHER: Final = PasswordHasher(time_cost=2, memory_cost=19 * 1024, parallelism=1)
_AT_ONCE: Final = BoundedSemaphore(2)
"""Each takes 19 MiB and a core for some 25 ms: attempts wait for each other, not other people for them."""


def hashed(password: str, name: str = "") -> str:
    """Returns what is stored. Raises SRV-PASSWORD for one that is too short, too long or common."""
    _require_good(_same(password), name)
    with _AT_ONCE:
        return _HASHER.hash(_same(password))


def is_right(stored: str | None, password: str) -> bool:
    """Returns whether it is the password; False after equal work without a stored one (no account, no password)."""
    with _AT_ONCE:
        try:
            right = _HASHER.verify(stored or _nobodys(), _same(password)[: 4 * LONGEST])
        except (VerificationError, InvalidHashError):
            return False
    return right and bool(stored)


def _same(password: str) -> str:
    return unicodedata.normalize("NFC", password)  # ü is typed in two ways


@cache
def _nobodys() -> str:
    return _HASHER.hash("of nobody")


_BETWEEN_WORDS: Final = re.compile(r"(?<=[^\W_])[-_.,+](?=[^\W_])|!+$")


def _guesses_log10(password: str, name: str) -> float:
    """Returns how many guesses it takes, as a power of ten: by the lists, the shop's words and the account's name."""
    from zxcvbn import zxcvbn  # an eighth of a second, for its lists

    words = [name, *re.split(r"[\W_]+", name), "correct horse battery staple", *_OF_THE_SHOP.split()]
    words += [word.translate(_WITHOUT_UMLAUTS) for word in words]
    as_typed = password[:_LOOKED_AT]
    return min(
        float(zxcvbn(text, user_inputs=words)["guesses_log10"])
        for text in {as_typed, _BETWEEN_WORDS.sub("", as_typed)}  # hyphens between words add nothing
    )


def _require_good(password: str, name: str) -> None:
    why = ""
    if not SHORTEST <= len(password) <= LONGEST:
        why = wording(
            "it has {n} characters; {shortest} to {longest} are taken",
            n=len(password),
            shortest=SHORTEST,
            longest=LONGEST,
        )
    elif (guesses_log10 := _guesses_log10(password, name)) < COMMON_LOG10:
        why = wording(
            "it is among the first 1e{n} guesses; 1e{needed:.0f} are to be needed",
            n=math.ceil(guesses_log10),
            needed=COMMON_LOG10,
        )
    if why:
        raise Code.SRV_PASSWORD.refusal(
            wording("the password is not taken: {why}", why=why),
            hint=wording(
                "take four words that have nothing to do with each other; any characters and blanks are allowed"
            ),
            values={"length": float(len(password)), "shortest": float(SHORTEST)},
        )


_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@-]{0,63}")
LANGUAGES: Final = ("en", "de")


@dataclass(frozen=True)
class AccountRow:
    """An account as administrators see it: nothing of its password. `etag` changes with it."""

    name: str
    display: str
    role: Role
    language: str
    disabled: bool
    made_at: datetime
    etag: str


@dataclass(frozen=True)
class NewAccount:
    """Without a password nobody can sign in by it yet."""

    name: str
    role: Role
    password: str | None = None
    display: str = ""
    language: str = "en"


@dataclass(frozen=True)
class Change:
    """Changes to an account; None: unchanged."""

    role: Role | None = None
    disabled: bool | None = None
    password: str | None = None
    language: str | None = None
    unit: LengthUnit | None = None
    """Of the lengths on the pages."""
    subject: str | None = None
    """Of an identity provider, as `subject_of` writes it; empty: of none any more."""


def subject_of(issuer: str, subject: str) -> str:
    """Names a person of an identity provider: the subject alone would be somebody else's at another provider."""
    return f"{issuer} {subject}"


class FirstAccount:
    """The right to make the first account of a store, for whoever reads what the service prints as it starts.

    Its secret has 256 bits and lasts for one run of the service, as long as the store has no account.
    """

    def __init__(self, store: Store) -> None:
        self._store, self._secret = store, secrets.token_urlsafe(32)

    @property
    def fragment(self) -> str:
        """Returns the end of the link, which browsers send nowhere; empty where there is an account already."""
        return "" if accounts(self._store) else f"#first={self._secret}"

    def add(self, secret: str, new: NewAccount, now: datetime) -> AccountRow:
        """Makes the account. Raises SRV-ACCOUNT for another secret and where there is an account, SRV-PASSWORD."""
        if not secrets.compare_digest(secret.encode(), self._secret.encode()):
            raise _refused(
                new.name,
                wording("the link is of an earlier start of the service"),
                wording("open the link printed last"),
            )
        return add_account(self._store, new, now, first=True)


def add_account(store: Store, new: NewAccount, now: datetime, by: str = "", *, first: bool = False) -> AccountRow:
    """Makes an account; `first`: only where none is. Raises SRV-ACCOUNT (name or role), SRV-PASSWORD."""
    if not _NAME.fullmatch(new.name):
        raise _refused(
            new.name, wording("it is no name"), wording("1 to 64 letters, digits and . _ @ -, a letter or digit first")
        )
    _require(new.name, new.role, new.language)
    argon2id = hashed(new.password, new.name) if new.password is not None else ""
    with store.writing() as connection:
        if first and connection.execute(select(ACCOUNT.c.id).limit(1)).first() is not None:
            raise _refused(
                new.name,
                wording("the service has its first account already"),
                wording("sign in, or ask an administrator"),
            )
        if _found(connection, new.name) is not None:
            raise _refused(
                new.name, wording("it is there already"), wording("take another name, or change the account")
            )
        connection.execute(
            insert(ACCOUNT).values(
                name=new.name,
                display=new.display or new.name,
                argon2id=argon2id,
                role=new.role,
                language=new.language,
                disabled=0,
                version=1,
                created_at=stamp(now),
            )
        )
        note(connection, now, by, "account made", f"account:{new.name}", {"role": new.role})
        return _row(_wanted(connection, new.name))


def change_account(
    store: Store, name: str, change: Change, now: datetime, etag: str | None = None, by: str = ""
) -> AccountRow:
    """Changes it and ends its sessions. `etag`: what is to be changed, None: whatever it is.

    Raises SRV-ACCOUNT for one that is not there, and where nobody could administer any more; SRV-STALE, SRV-PASSWORD.
    """
    _require(name, change.role or "viewer", change.language or "en")
    values: dict[str, Any] = {}
    if change.password is not None:
        values["argon2id"] = hashed(change.password, name)
    if change.role is not None:
        values["role"] = change.role
    if change.disabled is not None:
        values["disabled"] = int(change.disabled)
    if change.subject is not None:
        values["oidc_subject"] = change.subject or None
    ends = bool(values)
    if change.language is not None:
        values["language"] = change.language
    if change.unit is not None:
        values["unit"] = change.unit
    with store.writing() as connection:
        found = _wanted(connection, name)
        if etag is not None and etag != str(found.version):
            raise stale(etag, str(found.version))
        if change.subject and (other := _of_subject(connection, change.subject)) not in (None, name):
            raise _refused(name, f"{change.subject!r} is linked to {other!r}", "end that link first")
        connection.execute(update(ACCOUNT).where(ACCOUNT.c.id == found.id).values(version=found.version + 1, **values))
        if found.role == "admin" and not found.disabled and not _administrators(connection):
            raise _refused(
                name, wording("it is the last administrator"), wording("make another account administrator first")
            )
        if ends:
            open_ones = (SESSION.c.account == found.id) & SESSION.c.ended_at.is_(None)
            connection.execute(update(SESSION).where(open_ones).values(ended_at=stamp(now)))
        said = {"role": change.role or "", "disabled": "" if change.disabled is None else str(change.disabled).lower()}
        said["subject"] = "" if change.subject is None else change.subject or "none"
        said["password"] = "" if change.password is None else "changed"
        note(connection, now, by, "account changed", f"account:{name}", {k: v for k, v in said.items() if v})
        return _row(_wanted(connection, name))


def accounts(store: Store) -> list[AccountRow]:
    """Lists all accounts, by name."""
    with store.reading() as connection:
        return [_row(row) for row in connection.execute(select(ACCOUNT).order_by(ACCOUNT.c.name))]


def stale(expected: str, etag: str) -> TrueloopError:
    """Makes the error SRV-STALE."""
    return Code.SRV_STALE.refusal(
        wording(
            "it was changed meanwhile: the change is of state {expected!r}, it is {now!r} now",
            expected=expected,
            now=etag,
        ),
        hint=wording("read it again, then change it"),
        values={"expected": expected, "found": etag},
    )


def _administrators(connection: Connection) -> int:
    count = select(func.count()).where((ACCOUNT.c.role == "admin") & (ACCOUNT.c.disabled == 0))
    return int(connection.execute(count).scalar_one())


def _found(connection: Connection, name: str) -> Row[Any] | None:
    return connection.execute(select(ACCOUNT).where(ACCOUNT.c.name == name)).one_or_none()


def _of_subject(connection: Connection, subject: str) -> str | None:
    name: str | None = connection.execute(select(ACCOUNT.c.name).where(ACCOUNT.c.oidc_subject == subject)).scalar()
    return name


def _wanted(connection: Connection, name: str) -> Row[Any]:
    found = _found(connection, name)
    if found is None:
        raise _refused(name, "there is none", "list them: trueloop user list")
    return found


def _require(name: str, role: str, language: str) -> None:
    if role not in ROLES:
        raise _refused(name, f"{role!r} is no role", f"take one of {', '.join(ROLES)}")
    if language not in LANGUAGES:
        raise _refused(name, f"{language!r} is no language of the pages", f"take one of {', '.join(LANGUAGES)}")


def _refused(name: str, why: str, hint: str) -> TrueloopError:
    return Code.SRV_ACCOUNT.refusal(
        wording("account {name!r}: {why}", name=name, why=why), hint=hint, values={"name": name}
    )


def _row(row: Row[Any]) -> AccountRow:
    return AccountRow(
        name=row.name,
        display=row.display,
        role=row.role,
        language=row.language,
        disabled=bool(row.disabled),
        made_at=datetime.fromisoformat(row.created_at),
        etag=str(row.version),
    )


def stored_password(store: Store, name: str) -> str | None:
    """Returns the hash, None for an account that has no password."""
    with store.reading() as connection:
        return _wanted(connection, name).argon2id or None
