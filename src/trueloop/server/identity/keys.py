"""Keys of programs: of one machine's cell, or for figures of the service. Shown once, kept as hashes, ended by time.

Who asks: `Who`, a person with a session or the holder of a key.
"""

import json
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from hashlib import sha256
from typing import Any, Final, Literal

from sqlalchemy import Connection, Row, insert, select, update

from trueloop.described import filled_from
from trueloop.domain.option import LengthUnit
from trueloop.errors import Code, TrueloopError
from trueloop.storage.schema import API_KEY, EVENT, stamp
from trueloop.storage.store import Store
from trueloop.wording import wording

Role = Literal["viewer", "operator", "engineer", "admin", "cell", "metrics"]
ROLES: tuple[Role, ...] = ("viewer", "operator", "engineer", "admin")
"""Roles of persons in ascending order: each has the rights of those before it."""


@dataclass(frozen=True)
class Who:
    """`name` of account or key; `session`: its id's hash, "" of a key; `once`: account and key of a request."""

    name: str
    role: Role
    display: str = ""
    language: str = "en"
    unit: LengthUnit = "mm"
    account: int = 0
    session: str = ""
    machine: str = ""
    expires_at: datetime | None = None
    once: tuple[str, str] | None = None

    @property
    def person(self) -> bool:
        """Returns whether it is a person with a session, not a program with a key."""
        return bool(self.session)


def note(connection: Connection, now: datetime, who: str, what: str, subject: str, values: Mapping[str, str]) -> None:
    """Writes a line of the event log."""
    document = json.dumps(dict(values), ensure_ascii=False)
    connection.execute(insert(EVENT).values(at=stamp(now), who=who, what=what, subject=subject, document=document))


def hashed(secret: str) -> str:
    """Returns the SHA-256 of a key or of a session's id, in which it is stored and looked up."""
    return sha256(secret.encode("utf-8", "surrogateescape")).hexdigest()


PREFIX: Final = "tl_"
LONGEST_DAYS: Final = 400
Scope = Literal["cell", "metrics"]


@dataclass(frozen=True)
class KeyRow:
    """A key as administrators see it: nothing by which it could be used."""

    id: int
    machine: str
    name: str
    scope: Scope
    made_by: str
    made_at: datetime
    expires_at: datetime
    ended_at: datetime | None


@dataclass(frozen=True)
class NewKey:
    """For which machine, what it is called, and how many days it holds."""

    machine: str
    name: str
    days: int = 365
    scope: Scope = "cell"


@dataclass(frozen=True)
class MadeKey:
    """The key itself, this once."""

    key: str
    row: KeyRow


def add_key(store: Store, new: NewKey, by: str, now: datetime) -> MadeKey:
    """Raises SRV-KEYS for a key without machine or name, or for a time that is none."""
    if not 1 <= new.days <= LONGEST_DAYS:
        raise _refused(f"{new.days} days", f"1 to {LONGEST_DAYS} days are taken")
    if new.scope not in ("cell", "metrics"):
        raise _refused(f"{new.scope!r} is no scope", "take cell or metrics")
    if not new.name or len(new.name) > 64 or (new.scope == "cell") != bool(new.machine) or len(new.machine) > 64:
        raise _refused(
            f"machine {new.machine!r}, name {new.name!r}, scope {new.scope}",
            "name the key, and the machine of a cell's key; a key for metrics has no machine",
        )
    key = PREFIX + secrets.token_urlsafe(32)
    row = insert(API_KEY).values(
        machine=new.machine,
        name=new.name,
        key_sha256=hashed(key),
        scope=new.scope,
        expires_at=stamp(now + timedelta(days=new.days)),
        made_by=by,
        created_at=stamp(now),
    )
    with store.writing() as connection:
        number = connection.execute(row.returning(API_KEY.c.id)).scalar_one()
        note(connection, now, by, "key made", f"key:{number}", {"machine": new.machine, "name": new.name})
        return MadeKey(key, _row(connection.execute(select(API_KEY).where(API_KEY.c.id == number)).one()))


def keys(store: Store) -> list[KeyRow]:
    """Lists all keys that were ever made, newest first."""
    with store.reading() as connection:
        return [_row(row) for row in connection.execute(select(API_KEY).order_by(API_KEY.c.id.desc()))]


def end_key(store: Store, number: int, now: datetime, by: str = "") -> None:
    """Ends a key: nothing gets in by it. Raises SRV-KEYS where there is none; one that has ended stays as it is."""
    with store.writing() as connection:
        if connection.execute(select(API_KEY.c.id).where(API_KEY.c.id == number)).one_or_none() is None:
            raise _refused(f"there is no key {number}", "list them: trueloop key list")
        still = (API_KEY.c.id == number) & API_KEY.c.ended_at.is_(None)
        if connection.execute(update(API_KEY).where(still).values(ended_at=stamp(now))).rowcount:
            note(connection, now, by, "key ended", f"key:{number}", {})


def of_bearer(store: Store, header: str, now: datetime) -> Who:
    """Returns whose key stands in `Authorization: Bearer …`. Raises SRV-KEY, equal whatever is wrong with it."""
    kind, _, key = header.partition(" ")
    row: Row[Any] | None = None
    if kind.casefold() == "bearer" and key.startswith(PREFIX):
        with store.reading() as connection:
            row = connection.execute(select(API_KEY).where(API_KEY.c.key_sha256 == hashed(key))).one_or_none()
    if row is None or row.ended_at is not None or now >= (expires := datetime.fromisoformat(row.expires_at)):
        raise Code.SRV_KEY.refusal(
            f"the key {PREFIX + '…'!r} is unknown, has ended or has expired",
            hint="send `Authorization: Bearer tl_…`; a new key: trueloop key add",
        )
    return Who(row.name, "cell" if row.scope == "cell" else "metrics", machine=row.machine, expires_at=expires)


def _refused(what: str, hint: str) -> TrueloopError:
    return Code.SRV_KEYS.refusal(wording("no key: {what}", what=what), hint=hint)


def _row(row: Row[Any]) -> KeyRow:
    ended = None if row.ended_at is None else datetime.fromisoformat(row.ended_at)
    made, expires = datetime.fromisoformat(row.created_at), datetime.fromisoformat(row.expires_at)
    return filled_from(KeyRow, row, made_at=made, expires_at=expires, ended_at=ended)
