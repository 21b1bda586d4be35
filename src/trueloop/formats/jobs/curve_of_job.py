"""The curve that a feature table spells out, in mm with x a radius; and what to know of one through points."""

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from trueloop.formats.jobs.part_tables import (
    AsphereTable,
    EllipseTable,
    FeatureTable,
    PartTable,
    PointsTable,
    PolynomialTable,
    SplineTable,
)
from trueloop.geometry.curve import Curve
from trueloop.geometry.curve_fit import curve_through, off_points_mm
from trueloop.geometry.curve_kinds import END_MM, Point, asphere, b_spline, between_ends, ellipse, power_series
from trueloop.geometry.profile import Profile
from trueloop.units import MM_PER_INCH
from trueloop.wording import Um, wording

MM_PER: Final = {"mm": 1.0, "inch": MM_PER_INCH}

Scales = tuple[float, float]
"""Mm of a unit along x, as a radius, and along z."""


def curve_of(table: FeatureTable, start: Point, end: Point, scales: Scales) -> Curve | None:
    """The curve of a feature between its ends; None for a line or an arc. Raises GEO-CURVE errors."""
    ends = (start, end)
    if table.asphere is not None:
        return _asphere(table.name, table.asphere, ends, scales)
    if table.ellipse is not None:
        return _ellipse(table, table.ellipse, ends, scales)
    if table.polynomial is not None:
        return _polynomial(table.name, table.polynomial, ends, scales)
    if table.spline is not None:
        return between_ends(_spline(table.name, table.spline, scales), start, end)
    if table.points is not None:
        through = points_of(table.points, start, end, scales)
        return between_ends(curve_through(table.name, through, table.points.tolerance * scales[1]), start, end)
    return None


def points_of(points: PointsTable, start: Point, end: Point, scales: Scales) -> list[Point]:
    """The points of a list in mm, with the feature's start and end where the list lacks them."""
    listed = [_mm(point, scales) for point in points.through]
    before = [] if math.dist(start, listed[0]) <= END_MM else [start]
    after = [] if math.dist(end, listed[-1]) <= END_MM else [end]
    return [*before, *listed, *after]


def fit_notes(part: PartTable, profile: Profile) -> tuple[str, ...]:
    """How far the curves through points are from these, of a profile made of this table."""
    return tuple(_fit_notes(part, profile))


def _fit_notes(part: PartTable, profile: Profile) -> Iterator[str]:
    scales = scales_of(part)
    for table, feature in zip(part.feature, profile.features, strict=bool(part.feature)):
        if table.points is not None and isinstance(feature, Curve):
            points = points_of(table.points, feature.start_mm, feature.end_mm, scales)
            yield wording(
                "{feature} is a curve through {count} points: it is up to {off} from them, tolerance {tolerance}.",
                feature=feature.name,
                count=len(points),
                off=Um(float(np.max(off_points_mm(feature, points)))),
                tolerance=Um(table.points.tolerance * scales[1]),
            )


def scales_of(part: PartTable) -> Scales:
    """Of the part's coordinates."""
    scale = MM_PER[part.unit]
    return (scale / 2 if part.x_is == "diameter" else scale), scale


def _asphere(name: str, table: AsphereTable, ends: tuple[Point, Point], scales: Scales) -> Curve:
    unit = scales[1]
    powers = {i: a * unit ** (1 - i) for i, a in table.coefficients.items()}
    outwards = table.sag_towards == "free end"
    return asphere(name, ends, _mm(table.vertex, scales), table.radius * unit, table.conic, powers, outwards)


def _ellipse(feature: FeatureTable, table: EllipseTable, ends: tuple[Point, Point], scales: Scales) -> Curve:
    axes = (table.semi_axes[0] * scales[1], table.semi_axes[1] * scales[1])
    centre, turned = _mm(table.centre, scales), math.radians(table.rotation_deg)
    return ellipse(feature.name, ends, centre, axes, turned, convex=feature.turn == "convex")


def _polynomial(name: str, table: PolynomialTable, ends: tuple[Point, Point], scales: Scales) -> Curve:
    of_x = table.gives == "z"
    value, argument = (scales[1], scales[0]) if of_x else scales
    coefficients = [c * value / argument**k for k, c in enumerate(table.coefficients)]
    return power_series(name, ends, coefficients, table.origin * argument, of_x=of_x)


def _spline(name: str, table: SplineTable, scales: Scales) -> Curve:
    control = np.array(table.control) * scales
    return b_spline(name, control, table.knots, table.degree, table.weights or None)


def _mm(point: Point, scales: Scales) -> Point:
    return point[0] * scales[0], point[1] * scales[1]
