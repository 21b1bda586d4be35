"""Sessions: begun with a new id each time, known by its hash, ended by time, by hand, or with the account's rights."""

import secrets
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, Final

from sqlalchemy import Row, bindparam, insert, select, update

from trueloop.errors import Code, TrueloopError
from trueloop.server.identity.accounts import is_right
from trueloop.server.identity.keys import Who, hashed
from trueloop.server.settings import Settings
from trueloop.storage.schema import ACCOUNT, SESSION, stamp
from trueloop.storage.store import Store
from trueloop.wording import wording

SEEN: Final = timedelta(minutes=1)
"""So often at most a session's last use is noted."""
_BYTES: Final = 32
_OPEN: Final = (
    select(SESSION, ACCOUNT)
    .join(ACCOUNT, ACCOUNT.c.id == SESSION.c.account)
    .where(SESSION.c.id_sha256 == bindparam("id_sha256"))
)
"""Made once: every request asks for it."""


@dataclass(frozen=True)
class Begun:
    """A new session: its id, which goes to the browser and nowhere else."""

    id: str
    who: Who


def account_by_password(store: Store, name: str, password: str) -> Row[Any]:
    """Returns the account of that name, whose password it is. Raises SRV-LOGIN, equal whatever was wrong."""
    with store.reading() as connection:
        account = connection.execute(select(ACCOUNT).where(ACCOUNT.c.name == name)).one_or_none()
    usable = account is not None and not account.disabled
    if not is_right(account.argon2id if account is not None and usable else None, password) or account is None:
        raise Code.SRV_LOGIN.refusal(
            wording("the name {name!r} and the password do not go together", name=name[:64]),
            hint=wording("mind capitals; an administrator can set a new password: trueloop user password NAME"),
        )
    return account


def begin(store: Store, settings: Settings, account: Row[Any], address: str, now: datetime) -> Begun:
    """Begins a session of an account that has shown who it is."""
    new = secrets.token_urlsafe(_BYTES)
    expires_at = now + timedelta(seconds=settings.session_s)
    with store.writing() as connection:
        connection.execute(
            insert(SESSION).values(
                id_sha256=hashed(new),
                account=account.id,
                created_at=stamp(now),
                seen_at=stamp(now),
                expires_at=stamp(expires_at),
                address=address,
            )
        )
    return Begun(new, _who(account, hashed(new), expires_at))


def of_cookie(store: Store, settings: Settings, cookie: str, now: datetime, *, seen: bool = True) -> Who:
    """Returns whose session it is, with the role the account has now; `seen` as below. Raises SRV-SIGN-IN."""
    found = still_open(store, settings, hashed(cookie), now, seen=seen)
    if found is None:
        raise signed_out()
    return found


def still_open(store: Store, settings: Settings, id_sha256: str, now: datetime, *, seen: bool = True) -> Who | None:
    """Returns whose session that is, None where it has ended; `seen`: notes that it was used."""
    with store.reading() as connection:
        row = connection.execute(_OPEN, {"id_sha256": id_sha256}).one_or_none()
    if row is None or row.ended_at is not None or row.disabled:
        return None
    last, expires = datetime.fromisoformat(row.seen_at), datetime.fromisoformat(row.expires_at)
    since_used = abs(now - last)  # used in the future: the clock was ahead then, and may not keep it open until then
    if now >= expires or since_used.total_seconds() >= settings.idle_s:
        return None
    if seen and since_used >= SEEN:
        with store.writing() as connection:
            still = (SESSION.c.id_sha256 == id_sha256) & SESSION.c.ended_at.is_(None)
            connection.execute(update(SESSION).where(still).values(seen_at=stamp(now)))
    return _who(row, id_sha256, expires)


def end(store: Store, id_sha256: str, now: datetime) -> None:
    """Ends one session; one that has ended stays as it is."""
    with store.writing() as connection:
        still = (SESSION.c.id_sha256 == id_sha256) & SESSION.c.ended_at.is_(None)
        connection.execute(update(SESSION).where(still).values(ended_at=stamp(now)))


def signed_out() -> TrueloopError:
    """Makes the error SRV-SIGN-IN."""
    return Code.SRV_SIGN_IN.refusal(
        wording("this needs somebody signed in: there is no cookie 'session', or its session has ended"),
        hint=wording("sign in: POST /api/v1/session, or the page /"),
    )


def _who(account: Row[Any], id_sha256: str, expires_at: datetime) -> Who:
    return Who(
        account.name,
        account.role,
        account.display,
        account.language,
        account.unit,
        account=getattr(account, "account", None) or account.id,
        session=id_sha256,
        expires_at=expires_at,
    )


def end_of_cookie(store: Store, cookie: str, now: datetime) -> None:
    """Ends the session that a cookie names, if it names one."""
    end(store, hashed(cookie), now)
