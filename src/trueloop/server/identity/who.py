"""Who asks: `Who`, a person with a session or the holder of a key."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from typing import Literal

from sqlalchemy import Connection, insert

from trueloop.domain.option import LengthUnit
from trueloop.storage.factory_tables import EVENT, stamp

Role = Literal["viewer", "operator", "engineer", "admin", "cell", "metrics"]
ROLES: tuple[Role, ...] = ("viewer", "operator", "engineer", "admin")
"""Of persons, each may do what those before it may."""


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
