"""One touch, as it was reported."""

from dataclasses import dataclass

from trueloop.geometry.feature import Point


@dataclass(frozen=True)
class Touch:
    """One gauging point as it was reported: nominal (x, z) in mm with x a radius, and a measured point or an error."""

    point: str
    nominal_mm: Point
    feature: str | None = None
    measured_mm: Point | None = None
    error_mm: float | None = None
    line: int | None = None
