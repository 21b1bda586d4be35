"""The nominal profile that a job's `[part]` table spells out, and the table that spells out a profile.

The curve that a feature table spells out, in mm with x a radius; and what to know of one through points.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.domain.characteristic import Characteristic
from trueloop.errors import Code
from trueloop.formats.jobs.part_tables import (
    AsphereTable,
    EllipseTable,
    FeatureTable,
    PartTable,
    PointsTable,
    PolynomialTable,
    SplineTable,
)
from trueloop.formats.toml_tables import toml_keys, toml_value
from trueloop.geometry.curve import Curve
from trueloop.geometry.curve_kinds import (
    END_MM,
    asphere,
    b_spline,
    between_ends,
    curve_through,
    ellipse,
    off_points_mm,
    power_series,
    spline_of,
)
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.profile import TANGENT_WITHIN_RAD, Junction, JunctionKind, Profile, Side
from trueloop.geometry.validate import checked_profile
from trueloop.units import MM_PER_INCH
from trueloop.wording import Um, wording

ROUNDED_MM: Final = 1e-3
"""A radius may fall this much short of half the chord: both are rounded on a drawing."""

UNSURE_RAD: Final = 1e-6
"""More than rounding its ends to a picometre turns a feature by, from 2 µm of length up."""


def profile_of_table(part: PartTable) -> Profile:
    """The profile of `part.start` and `part.feature`, in mm with x a radius. Raises GEO errors."""
    x_scale, scale = scales_of(part)
    assert part.start is not None
    points = [(x * x_scale, z * scale) for x, z in (part.start, *(feature.to for feature in part.feature))]
    features = [
        _feature(table, start, end, scale, x_scale)
        for table, (start, end) in zip(part.feature, pairwise(points), strict=True)
    ]
    return checked_profile(features, junctions_by_design(part.junctions), side=Side(part.side))


def junctions_by_design(named: Mapping[str, str]) -> dict[tuple[str, str], JunctionKind]:
    """`{"neck/dome": "tangent"}` of a job as pairs of feature names."""
    pairs = {name: name.partition("/") for name in named}
    return {(before, after): JunctionKind(named[name]) for name, (before, _, after) in pairs.items()}


def part_table_toml(name: str, profile: Profile, notes: Sequence[str] = ()) -> str:
    """A `[part]` table in mm and radii that reads back as this profile, to a picometre; `notes` as comments above."""
    lines = [
        *(f"# {' '.join(note.split())}" for note in notes),
        "[part]",
        *toml_keys({"name": name, "unit": "mm", "x_is": "radius", "side": side_key(profile)}),
        *toml_keys({"start": _pair(profile.features[0].start_mm)}),
    ]
    for feature in profile.features:
        lines += ["", "[[part.feature]]", *toml_keys({"name": feature.name, "to": _pair(feature.end_mm)})]
        if isinstance(feature, Arc):
            turn = "convex" if feature.sweep_rad > 0 else "concave"
            lines += toml_keys({"centre": _pair(feature.centre_mm), "turn": turn})
        elif isinstance(feature, Curve):
            control, knots, degree = spline_of(feature)
            spline = {"degree": degree, "knots": knots.tolist(), "control": [*map(_pair, control.tolist())]}
            lines += ["[part.feature.spline]", *toml_keys(spline)]
    fixed = {
        toml_value(f"{before}/{after}"): junction.kind
        for (before, after), junction in zip(pairwise(profile.names), profile.junctions, strict=True)
        if junction.by_design or _could_read_otherwise(junction)
    }
    return "\n".join([*lines, *(["", "[part.junctions]", *toml_keys(fixed)] if fixed else []), ""])


def side_key(profile: Profile) -> Side | None:
    """Returns the value of the key `side`, where it has to be stated."""
    return None if profile.side is Side.OUTSIDE else profile.side


def _feature(table: FeatureTable, start: Point, end: Point, scale: float, x_scale: float) -> Feature:
    if (curve := curve_of(table, start, end, (x_scale, scale))) is not None:
        return curve
    if table.centre is not None:
        centre = (table.centre[0] * x_scale, table.centre[1] * scale)
    elif table.radius is not None:
        centre = _centre(table, start, end, table.radius * scale)
    else:
        return Line(table.name, start, end)
    return Arc(table.name, start, end, centre, _sweep_rad(table, start, end, centre))


def _centre(table: FeatureTable, start: Point, end: Point, radius_mm: float) -> Point:
    """The centre lies on the material's side of the chord for a convex arc of less than half a turn."""
    (x0, z0), (x1, z1) = start, end
    half = math.dist(start, end) / 2
    if radius_mm < half - ROUNDED_MM or half == 0:
        raise Code.GEO_ARC.refusal(
            f"'{table.name}' has a radius of {radius_mm:.4f} mm, but its ends are {2 * half:.4f} mm apart",
            hint="a radius is at least half the distance of start and end; x is a radius unless x_is says diameter",
            values={"feature": table.name, "radius_mm": radius_mm},
        )
    towards_material = (table.turn == "convex") != table.more_than_half
    away = math.sqrt(max(radius_mm**2 - half**2, 0.0)) / (2 * half) * (-1 if towards_material else 1)
    return (x0 + x1) / 2 + away * (z1 - z0), (z0 + z1) / 2 - away * (x1 - x0)


def _sweep_rad(table: FeatureTable, start: Point, end: Point, centre: Point) -> float:
    from_angle, to_angle = (math.atan2(x - centre[0], z - centre[1]) for x, z in (start, end))
    if table.turn == "convex":
        return (from_angle - to_angle) % (2 * math.pi)
    return -((to_angle - from_angle) % (2 * math.pi))


def _could_read_otherwise(junction: Junction) -> bool:
    """Returns whether the rounding of printed coordinates could take a corner for tangent, or the other way round."""
    return abs(abs(junction.turn_rad) - TANGENT_WITHIN_RAD) < UNSURE_RAD


def _pair(point: Sequence[float]) -> list[float]:
    return [round(value, 9) + 0.0 for value in point]  # + 0.0 turns −0.0 into 0.0


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
    """Returns how many mm a 1 is, in x (as a radius) and in z of the part's coordinates."""
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


ROUNDED: Final = 9
"""Decimals of a size: conversions of inches end there."""


def characteristics_toml(characteristics: Sequence[Characteristic]) -> str:
    """A `[[part.characteristic]]` for each, lengths in mm; they follow a `[part]` table in mm. "" for none."""
    return "".join("\n".join(["", "[[part.characteristic]]", *_keys(one), ""]) for one in characteristics)


def _keys(of: Characteristic) -> list[str]:
    lower, upper = (None, None) if of.tolerance else (of.lower_limit, of.upper_limit)
    return toml_keys(
        {
            "name": of.name,
            "quantity": of.quantity,
            "feature": of.feature,
            "other": of.other or None,
            "nominal": round(of.nominal, ROUNDED) if of.nominal else None,
            "tolerance": of.tolerance or None,
            "lower_limit": None if lower is None else round(lower, ROUNDED),
            "upper_limit": None if upper is None else round(upper, ROUNDED),
        }
    )
