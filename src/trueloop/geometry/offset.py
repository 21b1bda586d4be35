"""The path of the nose centre along a profile, and the contour that a given path of the nose centre leaves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.curve import Curve, moved_out, part_of
from trueloop.geometry.feature import Arc, Feature, Point, distance_mm
from trueloop.geometry.intersection import crossings, intersections
from trueloop.geometry.profile import Junction, JunctionKind, Profile, junctions_of
from trueloop.wording import wording

RUNS_TOGETHER_RAD: Final = 0.02
"""Features whose directions differ by less may be joined without an intersection: at the mean of their offset ends,
which deviates from either by at most R·turn²/8 (0.04 µm for a nose of 0.8 mm)."""

SHARPEST_CORNER: Final = 5.0
"""The distance that a corner of the offset may lie from its features' offset ends, as a multiple of the distance
between these: half the tangent of half the turn, so 5 admits edges and grooves down to an included angle of 11.4
degrees.
"""


@dataclass(frozen=True)
class CentrePath:
    """Path of the centre of a nose that rolls along a profile.

    `features[i]` is the profile's feature i moved along its outward normal by the nose radius, same name; consecutive
    ones meet exactly, at a convex corner by going on to their intersection. `reachable_mm`, shape (n, 2), is the
    interval of arc length on each *nominal* feature that the nose touches: at a concave corner the nose leaves a fillet
    and the features' ends are not reached.
    """

    features: tuple[Feature, ...]
    reachable_mm: Array
    nose_radius_mm: float


def nose_centre_path(profile: Profile, nose_radius_mm: float) -> CentrePath:
    """Offsets a profile by the nose radius. A radius of 0 is a pointed tool: the profile itself.

    Raises GEO-NOSE for a concave arc or curve not larger than the nose, GEO-NARROW where the nose does not fit between
    features (the offset would cross itself), GEO-SHARP where the offset of a convex corner runs too far out.
    """
    _require_radius(nose_radius_mm)
    moved = _offset_chain(profile.features, nose_radius_mm)
    for i, j, place in crossings(moved, tolerance_mm=1e-3):
        raise _narrow(profile.features[i].name, profile.features[j].name, place, nose_radius_mm)
    _require_clear_ends(profile.features, moved, nose_radius_mm)
    feet = [
        (float(nominal.locate(path.start_mm)[0]), float(nominal.locate(path.end_mm)[0]))
        for nominal, path in zip(profile.features, moved, strict=True)
    ]
    lengths = np.array([[feature.length_mm] for feature in profile.features])
    reachable = np.clip(np.array(feet), 0.0, lengths)
    for feature in np.flatnonzero(reachable[:, 1] <= reachable[:, 0]):
        raise _narrow(moved[feature].name, moved[feature].name, moved[feature].start_mm, nose_radius_mm)
    return CentrePath(tuple(moved), reachable, nose_radius_mm)


def contour_from_centre_path(features: Sequence[Feature], nose_radius_mm: float) -> tuple[Feature, ...]:
    """Returns the contour that a nose leaves when its centre follows `features`: the inverse of `nose_centre_path`.

    A convex arc of just the nose radius turns about a sharp edge and leaves no feature. Raises GEO-NOSE for one that is
    smaller, and GEO-NARROW or GEO-SHARP where the moved features do not meet.
    """
    _require_radius(nose_radius_mm)
    return tuple(_offset_chain([f for f in features if not _turns_about_edge(f, nose_radius_mm)], -nose_radius_mm))


def _turns_about_edge(feature: Feature, nose_radius_mm: float) -> bool:
    return isinstance(feature, Arc) and feature.sweep_rad > 0 and abs(feature.radius_mm - nose_radius_mm) < 1e-3


def _offset_chain(features: Sequence[Feature], distance_mm: float) -> list[Feature]:
    """Moves every feature along its outward normal and trims or extends it to meet its neighbours."""
    moved = [_moved(feature, distance_mm) for feature in features]
    joints = [_joint(*each, distance_mm) for each in zip(moved, moved[1:], junctions_of(features), strict=False)]
    starts = [moved[0].start_mm, *(after for _, after in joints)] if moved else []
    ends = [*(before for before, _ in joints), moved[-1].end_mm] if moved else []
    return [_between(*each, distance_mm) for each in zip(moved, starts, ends, strict=True)]


def _moved(feature: Feature, distance_mm: float) -> Feature:
    if isinstance(feature, Curve):
        tightest = feature.radius_range_mm()[0 if distance_mm > 0 else 1]
        if abs(distance_mm) >= tightest * (1 - 1e-9):
            raise _too_tight(feature, tightest, distance_mm)
        return moved_out(feature, distance_mm) if distance_mm else feature
    if isinstance(feature, Arc):
        radius_mm = feature.radius_mm + math.copysign(distance_mm, distance_mm * feature.sweep_rad)
        if radius_mm <= 1e-9 * feature.radius_mm:
            raise _too_tight(feature, feature.radius_mm, distance_mm)
    ends = np.array([0.0, feature.length_mm])
    start, end = feature.point_mm(ends) + distance_mm * feature.outward_normal(ends)
    return replace(feature, start_mm=_point(start), end_mm=_point(end))


def _joint(before: Feature, after: Feature, junction: Junction, distance_mm: float) -> tuple[Point, Point]:
    """Returns the end of one moved feature and the start of the next: their corner, unless they are apart."""
    if junction.kind is JunctionKind.APART:
        return before.end_mm, after.start_mm
    corner = _corner(before, after, junction.turn_rad, distance_mm)
    return corner, corner


def _corner(before: Feature, after: Feature, turn_rad: float, distance_mm: float) -> Point:
    """Returns the point where two moved features meet: their intersection next to the mean of their ends.

    Where none is near, features that run together are joined at the mean: rounding has made the intersection fail.
    """
    mean = _point((np.asarray(before.end_mm) + np.asarray(after.start_mm)) / 2)
    apart = max(math.dist(before.end_mm, after.start_mm), 2 * abs(distance_mm * math.sin(turn_rad / 2)))
    within = SHARPEST_CORNER * apart + 1e-9
    near = [point for point in intersections(before, after) if math.dist(point, mean) <= within]
    if near:
        return min(near, key=lambda point: math.dist(point, mean))
    if abs(turn_rad) <= RUNS_TOGETHER_RAD:
        return mean
    if turn_rad * distance_mm < 0:
        raise _narrow(before.name, after.name, mean, abs(distance_mm))
    raise Code.GEO_SHARP.refusal(
        f"'{before.name}' and '{after.name}' turn by {math.degrees(abs(turn_rad)):.1f}° at x = {mean[0]:.3f} mm, "
        f"z = {mean[1]:.3f} mm: their offsets by {abs(distance_mm):.4f} mm meet far outside or not at all",
        hint="break the edge: put a chamfer or a radius between the two features",
        values={
            "features": [before.name, after.name],
            "turn_deg": math.degrees(abs(turn_rad)),
            "x_mm": mean[0],
            "z_mm": mean[1],
        },
    )


def _between(moved: Feature, start: Point, end: Point, distance_mm: float) -> Feature:
    """Returns the moved feature from `start` to `end`, both on it. Raises GEO-NARROW where these are reversed."""
    if float(moved.locate(end)[0]) - float(moved.locate(start)[0]) <= 0:
        raise _narrow(moved.name, moved.name, start, abs(distance_mm))
    return from_to(moved, start, end)


def from_to(feature: Feature, start: Point, end: Point) -> Feature:
    """Returns the feature from `start` to `end` on it, shortened or continued along its line, circle or curve."""
    from_mm, to_mm = float(feature.locate(start)[0]), float(feature.locate(end)[0])
    if isinstance(feature, Curve):
        return part_of(feature, from_mm, to_mm)
    if isinstance(feature, Arc):
        sweep_rad = math.copysign((to_mm - from_mm) / feature.radius_mm, feature.sweep_rad)
        return replace(feature, start_mm=start, end_mm=end, sweep_rad=sweep_rad)
    return replace(feature, start_mm=start, end_mm=end)


def _require_clear_ends(features: Sequence[Feature], moved: Sequence[Feature], nose_radius_mm: float) -> None:
    """Raises where an end of a path cuts into the profile: a path that crosses itself nowhere can do so only there."""
    for cut, path in ((features, moved), (moved, features)):
        for end in (cut[0].start_mm, cut[-1].end_mm):
            nearest = min(path, key=lambda feature, end=end: distance_mm(feature, end))  # type: ignore[misc]
            if distance_mm(nearest, end) < nose_radius_mm - 1e-6:
                raise _narrow(nearest.name, nearest.name, end, nose_radius_mm)


def _point(xz: Array) -> Point:
    return float(xz[0]), float(xz[1])


def _require_radius(nose_radius_mm: float) -> None:
    if not (math.isfinite(nose_radius_mm) and nose_radius_mm >= 0):
        raise Code.GEO_NOSE.refusal(
            wording("nose radius {r} {mm}", r=nose_radius_mm, mm="mm"),
            hint=wording("give the nose radius in mm, zero or more"),
            values={"nose_radius_mm": nose_radius_mm},
        )


def _too_tight(feature: Arc | Curve, radius_mm: float, distance_mm: float) -> TrueloopError:
    least = wording("a radius") if isinstance(feature, Arc) else wording("a least radius of curvature")
    return Code.GEO_NOSE.refusal(
        wording(
            "'{feature}' has {least} of {radius_mm:.4f} mm, not larger than the nose radius of {distance_mm:.4f} mm",
            feature=feature.name,
            least=least,
            radius_mm=radius_mm,
            distance_mm=abs(distance_mm),
        ),
        hint=wording("draw a sharp corner where the nose itself is to leave the fillet, or use a smaller nose"),
        values={"nose_radius_mm": abs(distance_mm)},
    )


def _narrow(first: str, second: str, place: Point, nose_radius_mm: float) -> TrueloopError:
    where = f"'{first}'" if first == second else f"'{first}' and '{second}'"
    return Code.GEO_NARROW.refusal(
        f"a nose of radius {nose_radius_mm:.4f} mm does not fit at {where} near x = {place[0]:.3f} mm, "
        f"z = {place[1]:.3f} mm: its path would cross itself",
        hint="use an insert with a smaller nose, or widen the groove",
        values={
            "features": list(dict.fromkeys((first, second))),
            "nose_radius_mm": nose_radius_mm,
            "x_mm": place[0],
            "z_mm": place[1],
        },
    )
