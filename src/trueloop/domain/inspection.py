"""An inspection: what was measured on one part, by which device, in which frame, when and how warm it was."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal, TypeAlias, TypeVar, cast

from trueloop.domain.characteristic import Quantity
from trueloop.domain.part import Part
from trueloop.geometry.feature import Point

T = TypeVar("T")
Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Touch:
    """One gauging point as it was reported: nominal (x, z) in mm with x a radius, and a measured point or an error.

    `error_mm` is along the outward normal, positive where material was left on. `line` is that of the file.
    """

    point: str
    nominal_mm: Point
    feature: str | None = None
    measured_mm: Point | None = None
    error_mm: float | None = None
    line: int | None = None


@dataclass(frozen=True, slots=True)
class Reading:
    """One characteristic of one part as a gauge, a measuring machine or a control reported it.

    `actual`, `nominal`, `standard_u` and the limits are in mm, of angles in degrees. A diameter is a diameter: it
    deviates by twice the radial error. Limits are absolute. `feature` is the feature's name in the file, which need
    not be that of the job; `other` names the one from which a length counts, empty: the part's zero; `axis` is that of
    a coordinate. `place_mm` is where it was read, in the part's frame: of a turned part z, or x as a radius and z; of
    others x, y, z. `repeat` counts readings of one characteristic on one part, from 1: they are kept apart, for their
    spread is the gauge's repeatability. None and empty: not stated.
    """

    characteristic: str
    quantity: Quantity
    actual: float
    nominal: float | None = None
    lower_limit: float | None = None
    upper_limit: float | None = None
    feature: str = ""
    other: str = ""
    axis: Literal["", "x", "y", "z"] = ""
    place_mm: tuple[float, ...] = ()
    repeat: int = 1
    standard_u: float | None = None
    measured_at: datetime | None = None
    temperature_c: float | None = None
    line: int | None = None
    side: Literal["", "inner", "outer"] = ""


@dataclass(frozen=True, slots=True)
class CmmPoint:
    """One point of a coordinate measuring machine, mm, in the frame of the inspection; normals leave the material."""

    measured_mm: Vector
    nominal_mm: Vector | None = None
    outward_normal: Vector | None = None
    name: str = ""


Values: TypeAlias = tuple[Touch | Reading | CmmPoint, ...]


@dataclass(frozen=True)
class Inspection:
    """What was measured on one part in one run of a device.

    `sha256` is that of the file it was read from: a file that holds several parts or runs gives several inspections.
    `count` says how many `values` were measured: they are left out where the file holds too many to repeat, and then
    `values` is empty. `ball_radius_mm`: where it is above 0, measured points are centres of that ball; else they are
    points of the surface. `frame`: "part" where positions are counted from the part's datums, "machine" where from the
    machine tool's zero, "device" where from the measuring device's, so that they have to be aligned. `z_reference`
    names the touch from which the part's z was taken. `temperatures` by the name of the sensor, °C, with further
    signals in the unit of their data. Empty text and None: not stated.
    """

    part: Part
    measured: Literal["touches", "readings", "CMM points", "readings and CMM points"]
    sha256: str
    count: int
    values: Values = ()
    device: str = ""
    operator: str = ""
    frame: Literal["part", "machine", "device"] = "part"
    measured_at: datetime | None = None
    ball_radius_mm: float = 0.0
    z_reference: str | None = None
    temperatures: Mapping[str, float] = field(default_factory=dict)
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def touches(self) -> tuple[Touch, ...]:
        """Returns the values that are touches."""
        return _of(Touch, self.values)

    @property
    def readings(self) -> tuple[Reading, ...]:
        """Returns the values that are readings."""
        return _of(Reading, self.values)

    @property
    def points(self) -> tuple[CmmPoint, ...]:
        """Returns the values that are points of a measuring machine."""
        return _of(CmmPoint, self.values)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the hash of its file, with part and time, as a file may hold several: read twice, it is the same."""
        return self.sha256, *self.part.identity, "" if self.measured_at is None else self.measured_at.isoformat()


def _of(kind: type[T], values: Values) -> tuple[T, ...]:
    """The values of one type; where there may be millions, mostly all of them."""
    kinds = set(map(type, values))
    if kinds <= {kind}:
        return cast(tuple[T, ...], values)
    return tuple(one for one in values if isinstance(one, kind)) if kind in kinds else ()
