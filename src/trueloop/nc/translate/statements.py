"""What a program does, in no control's words. Lengths in mm, X a radius; feeds in mm/min or mm/rev."""

from dataclasses import dataclass
from typing import TypeAlias

from trueloop.arrays import Array, Flags
from trueloop.errors import Severity

Vector: TypeAlias = tuple[float, float, float]
Partial: TypeAlias = tuple[float | None, float | None, float | None]
"""X, Y, Z; None for an axis that is not named and does not move."""


@dataclass(frozen=True)
class Lost:
    """Something that is not written: an error where the machine would move otherwise, a warning where it would not cut
    as before, a note otherwise. `refuses`: nothing sensible can be written at all.
    """

    severity: Severity
    what: str
    refuses: bool = False


@dataclass(frozen=True)
class Remark:
    """A comment."""

    text: str


@dataclass(frozen=True)
class Verbatim:
    """A word that only this dialect has, for a translation into the same one."""

    text: str


@dataclass(frozen=True)
class Modes:
    """What is in force: the program unit, X as a diameter, the plane of arcs (17, 18, 19), feed a revolution."""

    inch: bool
    diameter: bool
    plane: int
    per_revolution: bool


@dataclass(frozen=True)
class WorkOffset:
    """A work offset of the control, from 1 (G54); 0 for none."""

    number: int


@dataclass(frozen=True)
class Register:
    """The present position gets these values."""

    at_mm: Partial


@dataclass(frozen=True)
class Spindle:
    """Revolutions a minute, or a constant surface speed in the control's unit."""

    surface_speed: bool
    speed: float


@dataclass(frozen=True)
class SpeedLimit:
    """The greatest speed of the spindle, 1/min."""

    per_minute: float


@dataclass(frozen=True)
class ToolChange:
    """A tool, with the row of the offset table that goes with it: 0 for none, None where that is said elsewhere."""

    number: int
    offset: int | None
    by_m6: bool


@dataclass(frozen=True)
class LengthOffset:
    """The row of the table from which the tool's offset is taken, None for the tool's own; or no offset."""

    number: int | None
    on: bool


@dataclass(frozen=True)
class Switch:
    """An M code that all controls share: M00, M01, M03 to M05, M07 to M09."""

    code: int


@dataclass(frozen=True)
class Dwell:
    """A wait."""

    seconds: float


@dataclass(frozen=True)
class Compensation:
    """40 none, 41 left, 42 right; by the tool of that number where one is named."""

    side: int
    tool: int | None = None


@dataclass(frozen=True)
class Straight:
    """A rapid move or a line, entering or leaving compensation on the way; `machine`: in machine coordinates."""

    rapid: bool
    end_mm: Partial
    feed: float | None = None
    compensation: Compensation | None = None
    machine: bool = False


@dataclass(frozen=True, eq=False)
class Straights:
    """Rapid moves and lines one after another, with nothing between them; `end_mm` (n, 3) is NaN along an axis that is
    not named and does not move, `feed` (n,) where none is known.
    """

    end_mm: Array
    rapid: Flags
    feed: Array


@dataclass(frozen=True)
class Circle:
    """An arc or a helix; the sign of `sweep_rad` is that of `ToolPath.sweep_rad`. `rises`: along the third axis."""

    start_mm: Vector
    end_mm: Vector
    centre_mm: Vector
    sweep_rad: float
    plane: int
    rises: bool
    feed: float | None = None


@dataclass(frozen=True)
class Thread:
    """A line synchronised with the spindle.

    `lead`: program units a revolution along `axis`, that on which it is longest (X a radius); `slant`: its length over
    that on this axis.
    """

    end_mm: Partial
    lead: float
    axis: int = 2
    slant: float = 1.0


@dataclass(frozen=True)
class Home:
    """To the reference point of these axes from where they stand."""

    axes: tuple[int, ...]


@dataclass(frozen=True)
class End:
    """M02 or M30."""

    code: int


Statement: TypeAlias = (
    Remark
    | Verbatim
    | Modes
    | WorkOffset
    | Register
    | Spindle
    | SpeedLimit
    | ToolChange
    | LengthOffset
    | Switch
    | Dwell
    | Compensation
    | Straight
    | Straights
    | Circle
    | Thread
    | Home
    | End
)
