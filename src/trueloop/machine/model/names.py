"""Names of axis errors after ISO 230-1: E, then the component that errs, then the axis whose motion it belongs to.

EXX, EYX, EZX, EAX, EBX, ECX are the six error motions of X: displacements along X, Y, Z and rotations about them.
A 0 in the middle makes it a constant of the axis itself: EB0C is the tilt of axis C about Y, EC0Y the angle by which Y
departs from square in the XY plane. [4773 §2.4] writes δx(z) for EXZ and εy(x) for EBX.
"""

from dataclasses import dataclass
from typing import Final

from trueloop.errors import Code

TRANSLATIONS: Final = "XYZ"
ROTATIONS: Final = "ABC"
COMPONENTS: Final = TRANSLATIONS + ROTATIONS


@dataclass(frozen=True)
class ErrorName:
    """One error of one axis. `place` distinguishes a constant of the axis itself from an error of its motion."""

    component: str
    axis: str
    place: bool = False

    @property
    def is_rotation(self) -> bool:
        """Rotations are in rad, displacements in mm."""
        return self.component in ROTATIONS

    @property
    def number(self) -> int:
        """Returns 0, 1, 2: the machine direction along or about which it acts."""
        return COMPONENTS.index(self.component) % 3

    @property
    def unit(self) -> str:
        """Returns the unit in which it is shown: µm or µrad."""
        return "µrad" if self.is_rotation else "µm"

    def __str__(self) -> str:
        return f"E{self.component}{'0' if self.place else ''}{self.axis}"


def error_name(text: str) -> ErrorName:
    """Reads EXX, EB0C … Raises MCH-NAME for anything that is not such a name."""
    place = len(text) == 4 and text[2] == "0"
    if len(text) != 3 + place or text[0] != "E" or text[1] not in COMPONENTS or not text[-1].isalpha():
        raise Code.MCH_NAME.refusal(
            f"{text!r} ({len(text)} characters) is no axis error in the notation of ISO 230-1",
            hint="E, one of XYZABC, a 0 for a constant of the axis itself, the axis: EXX, EBZ, EC0Y, EX0C",
            values={"name": text},
        )
    return ErrorName(text[1], text[-1], place)
