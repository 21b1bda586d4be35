"""A machine tool, one among others of the same make."""

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class Machine:
    """One machine tool: `name` as the shop calls it or as its maker does, `serial` its number; empty: not stated."""

    name: str
    serial: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns name and serial number: every machine errs in its own way."""
        return self.name, self.serial
