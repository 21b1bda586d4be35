"""Kinematic chain: which axis carries which, from the bed to the work and from the bed to the tool.

Coordinates are those of the control: a larger X moves the tool towards +X *as seen from the work*, whichever of the
two moves (ISO 841: an axis that carries the work moves the other way). Lengths in mm, angles in rad.
Names of axis errors after ISO 230-1: E, then the component that errs, then the axis whose motion it belongs to.

EXX, EYX, EZX, EAX, EBX, ECX are the six error motions of X: displacements along X, Y, Z and rotations about them.
A 0 in the middle makes it a constant of the axis itself: EB0C is the tilt of axis C about Y, EC0Y the angle by which Y
departs from square in the XY plane. [4773 §2.4] writes δx(z) for EXZ and εy(x) for EBX.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

import numpy as np

from trueloop.arrays import Array
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
            f"{text!r} ({len(text)} characters) is not an axis error in the notation of ISO 230-1",
            hint="E, one of XYZABC, a 0 for a constant of the axis itself, the axis: EXX, EBZ, EC0Y, EX0C",
            values={"name": text},
        )
    return ErrorName(text[1], text[-1], place)


Vector = tuple[float, float, float]
ZERO: Final[Vector] = (0.0, 0.0, 0.0)


class AxisKind(StrEnum):
    """A spindle turns at speed: it has a place, which drifts, and no commanded position."""

    LINEAR = "linear"
    ROTARY = "rotary"
    SPINDLE = "spindle"


def in_words(value: float, unit: str) -> str:
    """Formats a value: `12.5 mm`, `30°`; without its unit where that is not known (`""`)."""
    return f"{value:g}°" if unit == "°" else f"{value:g} {unit}".rstrip()


@dataclass(frozen=True)
class Axis:
    """One joint. `number` is the machine direction 0, 1, 2 along or about which it moves.

    `offset_mm` leads from the frame that carries the axis to the axis' own frame, at the axis' zero. The arms of the
    rotational errors are counted from that frame, of an axis that carries the tool as it has moved, of one that carries
    the work as it stands on what carries it (`kinematics.py`): so it states where the angular error was defined.
    `travel` is in mm or rad, in control coordinates. `sense` is −1 for a rotary axis whose angles grow against ISO 841;
    errors stay right-handed, tool as seen from the work.
    """

    name: str
    kind: AxisKind
    number: int
    offset_mm: Vector = ZERO
    travel: tuple[float, float] = (-np.inf, np.inf)
    sense: float = 1.0

    def shown(self, position: float) -> str:
        """Formats a position: `12.5 mm`, `30°`."""
        return in_words(self.in_unit(position), self.unit)

    @property
    def unit(self) -> str:
        """Returns the unit in which positions are shown."""
        return "mm" if self.kind is AxisKind.LINEAR else "°"

    def in_unit(self, position: float) -> float:
        """Returns a position, mm or radians, in `unit`."""
        return float(position if self.kind is AxisKind.LINEAR else np.degrees(position))

    def errors(self) -> tuple[ErrorName, ...]:
        """Returns every error the axis can have: six of its motion (not for a spindle), and those of its place.

        A linear axis has a direction only, so two angles; a rotary axis a line in space and the angle of its zero, so
        five; a spindle its growth along that line too. A spindle's angle matters where it is oriented.
        """
        motion = [] if self.kind is AxisKind.SPINDLE else [ErrorName(c, self.name) for c in COMPONENTS]
        if self.kind is AxisKind.LINEAR:
            place = [c for c in ROTATIONS if ROTATIONS.index(c) != self.number]
        else:
            spindle = self.kind is AxisKind.SPINDLE
            place = [c for k, c in enumerate(COMPONENTS) if spindle or k != self.number]
        return tuple(motion + [ErrorName(c, self.name, place=True) for c in place])


@dataclass(frozen=True)
class Chain:
    """The axes that carry the work and those that carry the tool, each counted from the bed outwards."""

    work: tuple[Axis, ...]
    tool: tuple[Axis, ...]

    def __post_init__(self) -> None:
        names = [axis.name for axis in self.axes]
        if len(set(names)) != len(names) or not names:
            raise Code.MCH_STRUCTURE.refusal(
                f"{len(names)} axes have the names {names}: a chain needs one at least, each name once",
                hint="name the tool spindle S where a rotary axis is called C",
            )

    @property
    def order(self) -> tuple[str, ...]:
        """Names of the axes that have a commanded position, in the order of position arrays: X Y Z A B C U V W."""
        moving = [axis.name for axis in self.axes if axis.kind is not AxisKind.SPINDLE]
        return tuple(sorted(moving, key="XYZABCUVW".find))

    @property
    def axes(self) -> tuple[Axis, ...]:
        """Returns all axes, the work's first."""
        return self.work + self.tool

    def axis(self, name: str) -> Axis:
        """Returns the axis of that name. Raises MCH-AXIS."""
        for axis in self.axes:
            if axis.name == name:
                return axis
        raise Code.MCH_AXIS.refusal(
            f"the machine has no axis {name!r}; it has {len(self.axes)}: {' '.join(a.name for a in self.axes)}",
            hint="check that the data and the model belong to this machine",
        )

    def errors(self) -> tuple[ErrorName, ...]:
        """Returns every error of every axis."""
        return tuple(name for axis in self.axes for name in axis.errors())

    def with_axes(self, changed: Mapping[str, Axis]) -> "Chain":
        """Returns the structure with other offsets or travels of some axes."""
        return replace(
            self,
            work=tuple(changed.get(axis.name, axis) for axis in self.work),
            tool=tuple(changed.get(axis.name, axis) for axis in self.tool),
        )

    def positions(self, values: Mapping[str, Array | float]) -> Array:
        """Axis positions by name as an array (n, axes) in `order`; axes not given stand at 0. Raises MCH-AXIS."""
        for name in values:
            self.axis(name)
        columns = np.broadcast_arrays(*[np.asarray(values.get(name, 0.0), dtype=np.float64) for name in self.order])
        return np.stack([np.atleast_1d(column) for column in columns], axis=-1)
