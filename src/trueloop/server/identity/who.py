"""Who asks: `Who`, a person with a session or the holder of a key."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from trueloop.domain.page_options import LengthUnit

Role = Literal["viewer", "operator", "engineer", "admin", "cell", "metrics"]
ROLES: tuple[Role, ...] = ("viewer", "operator", "engineer", "admin")
"""Of persons, each may do what those before it may."""


@dataclass(frozen=True)
class Who:
    """`name`: of the account, or of the key. `session`: the hash of the session's id; empty for a key.

    `once`: as what account, and under which key, he asks for what is done once.
    """

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
