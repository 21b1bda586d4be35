"""Parts: what one drawing asks for, and the single pieces made to it."""

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class PartType:
    """What all parts made to one drawing have in common: its name or number, its revision, the material.

    `drawing` is the drawing's number where that is not the name. Empty text: not stated.
    """

    name: str
    revision: str = ""
    material: str = ""
    drawing: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns name and revision: errors learned of one revision need not hold for the next."""
        return self.name, self.revision


@dataclass(frozen=True)
class Part:
    """One piece of a part type. `serial` is empty where nobody stated it: then only its inspections identify it."""

    part_type: PartType
    serial: str = ""
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the identity of the part type and the serial number."""
        return *self.part_type.identity, self.serial
