"""An inspection: what was measured on one part, by which device, in which frame, when and how warm it was."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal, TypeAlias

from trueloop.domain.part import Part
from trueloop.geometry.feature import Point

Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
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


@dataclass(frozen=True)
class GaugeReading:
    """One characteristic read on a gauge, in mm: a diameter as a diameter, which deviates by twice the radial error.

    Limits are absolute; None: not stated.
    """

    characteristic: str
    actual_mm: float
    nominal_mm: float | None = None
    lower_limit_mm: float | None = None
    upper_limit_mm: float | None = None


@dataclass(frozen=True)
class CmmPoint:
    """One point of a coordinate measuring machine, mm, in the frame of the inspection; normals leave the material."""

    measured_mm: Vector
    nominal_mm: Vector | None = None
    outward_normal: Vector | None = None
    name: str = ""


Values: TypeAlias = tuple[Touch, ...] | tuple[GaugeReading, ...] | tuple[CmmPoint, ...]


@dataclass(frozen=True)
class Inspection:
    """What was measured on one part in one run of a device.

    `sha256` is that of the file it was read from. `count` says how many `values` were measured: they are left out
    where the file holds too many to repeat, and then `values` is empty. `ball_radius_mm`: where it is above 0, measured
    points are centres of that ball; else they are points of the surface. `frame`: "part" where positions are counted
    from the part's datums, "machine" where from the machine tool's zero, "device" where from the measuring device's,
    so that they have to be aligned. `z_reference` names the touch from which the part's z was taken. `temperatures` by
    the name of the sensor, °C, with further signals in the unit of their data. Empty text and None: not stated.
    """

    part: Part
    measured: Literal["touches", "gauge readings", "CMM points"]
    sha256: str
    count: int
    values: Values = ()
    device: str = ""
    frame: Literal["part", "machine", "device"] = "part"
    measured_at: datetime | None = None
    ball_radius_mm: float = 0.0
    z_reference: str | None = None
    temperatures: Mapping[str, float] = field(default_factory=dict)
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def touches(self) -> tuple[Touch, ...]:
        """The values that are touches."""
        return tuple(one for one in self.values if isinstance(one, Touch))

    @property
    def identity(self) -> tuple[str, ...]:
        """The hash of its file alone: the same file read twice is one inspection."""
        return (self.sha256,)
