"""Settings in force at a statement of a DMIS file: units, the plane of polar coordinates, the frame."""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from trueloop.domain.inspection import Vector
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.dmis.words import Words
from trueloop.formats.inspections.measured_file import Stated
from trueloop.units import MM_PER_INCH

LENGTHS_MM: Final = {"MM": 1.0, "CM": 10.0, "M": 1000.0, "INCH": MM_PER_INCH, "FEET": 12 * MM_PER_INCH}
ANGLES_DEG: Final = {"ANGDEC": 1.0, "ANGDMS": 1.0, "ANGRAD": 180.0 / math.pi}
PLANES: Final = {"XYPLAN": (0, 1, 2), "YZPLAN": (1, 2, 0), "ZXPLAN": (2, 0, 1)}
"""Axes of the plane in which polar coordinates turn, from the first to the second, and that of their height."""
Rotation = tuple[Vector, Vector, Vector]
UNTURNED: Final[Rotation] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Frame:
    """The coordinate system in force as seen from that of the first results: p = `rotation` · q + `shift_mm`."""

    rotation: Rotation = UNTURNED
    shift_mm: Vector = (0.0, 0.0, 0.0)

    def vector(self, q: Vector) -> Vector:
        """Returns a direction of this frame in the first one."""
        a, b, c = self.rotation
        return _dot(a, q), _dot(b, q), _dot(c, q)

    def point(self, q: Vector) -> Vector:
        """Returns a point of this frame in the first one."""
        if self is FIRST:
            return q
        (x, y, z), (dx, dy, dz) = self.vector(q), self.shift_mm
        return x + dx, y + dy, z + dz

    def shifted(self, shift_mm: Vector) -> "Frame":
        """Returns a frame whose origin lies there in this one."""
        return replace(self, shift_mm=self.point(shift_mm))

    def turned(self, axis: int, angle_deg: float) -> "Frame":
        """Returns a frame turned about an axis of this one, right-handed: from x to y about z."""
        cosine, sine = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
        first, second = (axis + 1) % 3, (axis + 2) % 3
        columns = [self.vector(unit) for unit in UNTURNED]
        new = list(columns)
        new[first] = _sum(cosine, columns[first], sine, columns[second])
        new[second] = _sum(-sine, columns[first], cosine, columns[second])
        rows = tuple(tuple(column[k] for column in new) for k in range(3))
        return replace(self, rotation=rows)  # type: ignore[arg-type]


FIRST: Final = Frame()


@dataclass(frozen=True)
class Settings:
    """Units as factors to mm and degrees; `mm` is None where the file has not stated one yet."""

    path: Path
    mm: float | None = None
    deg: float = 1.0
    sexagesimal: bool = False
    plane: str = "XYPLAN"
    frame: Frame = FIRST

    def length_factor(self, line: int) -> float:
        """Returns the factor to mm. Raises MSR-UNIT where neither file nor user has stated a unit."""
        if self.mm is None:
            raise TrueloopError(
                Code.MSR_UNIT,
                f"{self.path.name!r} has lengths from line {line} on and no statement UNITS before them",
                hint="state the unit: --unit mm or --unit inch",
                place=Place(str(self.path), line),
                values={"file": self.path.name},
            )
        return self.mm

    def place(self, polar: bool, q: Vector) -> Vector:
        """Returns Cartesian coordinates in the first frame; polar ones are radius, angle in degrees and height."""
        if polar:
            first, second, third = PLANES[self.plane]
            radius, angle_deg, height = q
            of = {first: radius * math.cos(math.radians(angle_deg)), second: radius * math.sin(math.radians(angle_deg))}
            q = tuple({**of, third: height}[axis] for axis in range(3))  # type: ignore[assignment]
        return self.frame.point(q)


def settings_from(path: Path, stated: Stated) -> Settings:
    """Returns the settings at a file's beginning."""
    return Settings(path, None if stated.unit is None else LENGTHS_MM[stated.unit.upper()])


def with_units(settings: Settings, statement: Words) -> Settings:
    """Returns the settings after `UNITS/MM,ANGDEC`; words of other quantities (temperatures) change nothing."""
    for field in statement.fields:
        word = field.upper()
        if word in LENGTHS_MM:
            settings = replace(settings, mm=LENGTHS_MM[word])
        if word in ANGLES_DEG:
            settings = replace(settings, deg=ANGLES_DEG[word], sexagesimal=word == "ANGDMS")
    return settings


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _sum(a: float, u: Vector, b: float, v: Vector) -> Vector:
    return a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2]
