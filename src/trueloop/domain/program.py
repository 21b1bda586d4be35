"""An NC program as what refers to it knows it: not its text but which one it is."""

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class Program:
    """One text of a program: its file's `name`, `dialect`, hash, and the unit in force at its first length.

    `unit` is None where the program has no length. The text itself is `trueloop.nc.program.program.Program`.
    """

    name: str
    dialect: str
    sha256: str
    unit: Literal["mm", "inch"] | None = None
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the hash alone: a program edited in one character is another one."""
        return (self.sha256,)


@dataclass(frozen=True)
class ProgramText:
    """The text of a program, byte for byte, by its hash."""

    sha256: str
    content: bytes
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the identity of the program."""
        return (self.sha256,)
