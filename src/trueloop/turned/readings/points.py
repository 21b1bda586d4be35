"""Points of a measuring machine as touches of a turned part: x is the distance from the axis, z runs along it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, get_args

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.inspection import CmmPoint, Inspection, Touch, Vector
from trueloop.geometry.profile import Profile
from trueloop.turned.readings.matched import By, feature_named
from trueloop.turned.readings.matches import Axis, Left, MatchedTouch
from trueloop.turned.touches.plausibility import CREDIBLE_ERROR_MM, ON_PROFILE_MM

AXES: Final[dict[Axis, tuple[int, int, int, float]]] = {
    "z": (2, 0, 1, 1.0),
    "-z": (2, 0, 1, -1.0),
    "x": (0, 1, 2, 1.0),
    "-x": (0, 1, 2, -1.0),
    "y": (1, 2, 0, 1.0),
    "-y": (1, 2, 0, -1.0),
}
"""The coordinate along the axis, the two across, and its sign."""
MOST: Final = 0.9
"""The axis is the one in which this share of the points lies on the profile."""
TIED_MM: Final = 0.2
"""Of two features that a point may be of, the nearer is taken where the other is this much further."""
SAME_WAY: Final = 0.9
"""The cosine between a stated normal and the feature's, from which on they are one."""
ON_AXIS_MM: Final = 1e-6


@dataclass(frozen=True)
class PointMatches:
    """What became of the points; `axis` is None where there are none, or none fits."""

    touches: tuple[MatchedTouch, ...] = ()
    left: tuple[Left, ...] = ()
    axis: Axis | None = None


def along_and_off(place_mm: Vector, axis: Axis) -> tuple[float, float]:
    """The coordinate along an axis, and the distance from it."""
    along, first, second, sign = AXES[axis]
    return sign * place_mm[along], math.hypot(place_mm[first], place_mm[second])


def match_points(
    profile: Profile, inspection: Inspection, names: Mapping[str, str], axis: Axis | None = None
) -> PointMatches:
    """The points of an inspection as touches, each on the one feature that it can be of.

    A nominal point may be `ON_PROFILE_MM` off; a measured one without a nominal `CREDIBLE_ERROR_MM`, its nominal is the
    nearest place. A part error is n·(measured − nominal) less the ball, n the profile's normal. Points are left, with
    the reason, where the frame is not the part's, where no axis is the spindle's, off the profile and between features.
    """
    points = inspection.points
    if not points:
        return PointMatches()
    if inspection.frame != "part":
        why = f"its position is counted from the {inspection.frame}'s zero, not from the part's"
        return PointMatches(left=tuple(Left(one, why) for one in points))
    found = axis or _axis(profile, points, inspection.ball_radius_mm)
    if found is None:
        why = f"along no axis of its frame do {MOST:.0%} of {len(points)} points lie on the profile"
        return PointMatches(left=tuple(Left(one, why) for one in points))
    outcomes = _matched(profile, points, inspection.ball_radius_mm, names, found)
    touches = tuple(one for one in outcomes if isinstance(one, MatchedTouch))
    return PointMatches(touches, tuple(one for one in outcomes if isinstance(one, Left)), found)


def _axis(profile: Profile, points: tuple[CmmPoint, ...], ball_mm: float) -> Axis | None:
    """Z where most points lie on the profile in it, else the only other one in which they do."""
    fitting = []
    for axis in get_args(Axis):
        nominal, measured, normal = _in_plane(points, axis)
        given = ~np.isnan(nominal[:, 0])
        away = np.abs(_distances(profile, np.where(given[:, None], nominal, measured), np.where(given, 0.0, ball_mm)))
        near = np.min(away, axis=0) <= np.where(given, ON_PROFILE_MM, CREDIBLE_ERROR_MM)
        across = np.isnan(normal[:, 2]) | (np.abs(normal[:, 2]) < 1.0 - SAME_WAY)
        if np.mean(near & across) >= MOST:
            fitting.append(axis)
    if "z" in fitting or len(fitting) == 1:
        return "z" if "z" in fitting else fitting[0]
    return None


def _in_plane(points: tuple[CmmPoint, ...], axis: Axis) -> tuple[Array, Array, Array]:
    """Nominal and measured (x, z) with x the distance from the axis, (n, 2), and normals (x, z, around), (n, 3).

    nan where not stated.
    """
    along, first, second, sign = AXES[axis]
    unknown = (math.nan,) * 3
    nominal, measured, normal = (
        np.array([getattr(one, name) or unknown for one in points], dtype=np.float64)
        for name in ("nominal_mm", "measured_mm", "outward_normal")
    )

    def turned(place: Array) -> Array:
        return np.stack([np.hypot(place[:, first], place[:, second]), sign * place[:, along]], axis=1)

    place = np.where(np.isnan(nominal), measured, nominal)
    radius = np.hypot(place[:, first], place[:, second])
    off = np.maximum(radius, ON_AXIS_MM)
    across = (normal[:, first] * place[:, first] + normal[:, second] * place[:, second]) / off
    around = (normal[:, second] * place[:, first] - normal[:, first] * place[:, second]) / off
    return turned(nominal), turned(measured), np.stack([across, sign * normal[:, along], around], axis=1)


def _distances(profile: Profile, places: Array, ball_mm: Array) -> Array:
    """Of each place from each feature, its ends included and less the ball, (features, n); along n with its sign."""
    rows = []
    for feature in profile.features:
        arc_length, distance = feature.locate(places)
        beyond = np.maximum(np.maximum(-arc_length, arc_length - feature.length_mm), 0.0)
        rows.append(np.where(beyond > 0.0, np.hypot(distance, beyond) + ball_mm, distance - ball_mm))
    return np.array(rows)


def _matched(
    profile: Profile, points: tuple[CmmPoint, ...], ball_mm: float, names: Mapping[str, str], axis: Axis
) -> list[MatchedTouch | Left]:
    nominal, measured, normal = _in_plane(points, axis)
    given = ~np.isnan(nominal[:, 0])
    plane = _Plane(profile, nominal, measured, normal, given, np.where(given, 0.0, ball_mm), ball_mm)
    away = np.abs(_distances(profile, plane.places, plane.off_mm))
    by_distance = np.argsort(away, axis=0, kind="stable")
    outcomes: list[MatchedTouch | Left] = []
    for k, point in enumerate(points):
        named = feature_named(profile, names.get(point.name, point.name)) if point.name else None
        near = [named] if named is not None else [int(one) for one in by_distance[:2, k]]
        chosen = plane.one_of(k, near, away[:, k])
        by: By = "geometry" if named is None else "name"
        outcomes.append(
            Left(point, chosen[0], chosen[1]) if isinstance(chosen, tuple) else plane.touch(k, point, chosen, by)
        )
    return outcomes


@dataclass(frozen=True)
class _Plane:
    """The points in the plane (x, z); `off_mm`: how far off the surface its place lies if the part has no error."""

    profile: Profile
    nominal: Array
    measured: Array
    normal: Array
    given: Flags
    off_mm: Array
    ball_mm: float

    @property
    def places(self) -> Array:
        """Nominal points, and measured ones where there are none."""
        return np.where(self.given[:, None], self.nominal, self.measured)

    def one_of(self, k: int, near: list[int], away: Array) -> int | tuple[str, tuple[str, ...]]:
        """The feature that point k is of, of one or the nearest two; or why it is none, and which it may be of."""
        limit = ON_PROFILE_MM if self.given[k] else CREDIBLE_ERROR_MM
        if away[near[0]] > limit:
            kind = "nominal point" if self.given[k] else "surface touched"
            name = self.profile.names[near[0]]
            return f"its {kind} is {away[near[0]]:.3f} mm from {name!r}; at most {limit} mm is taken", ()
        if len(near) == 1 or away[near[1]] > min(limit, away[near[0]] + TIED_MM):
            return near[0]
        normals = [self._outward(one, k) for one in near]
        if float(normals[0] @ normals[1]) > SAME_WAY:
            return near[0]
        facing = [one for one, n in zip(near, normals, strict=True) if float(n @ self.normal[k, :2]) > SAME_WAY]
        if len(facing) == 1:
            return facing[0]
        names = tuple(self.profile.names[one] for one in near)
        return (
            f"it may be of {names[0]!r} or of {names[1]!r}, {away[near[0]]:.3f} mm and {away[near[1]]:.3f} mm off",
            names,
        )

    def touch(self, k: int, point: CmmPoint, index: int, by: By) -> MatchedTouch | Left:
        """Point k as a touch of a feature: e = n·(measured − nominal) − ball. Left where that is not credible."""
        feature = self.profile.features[index]
        arc_length, distance = (float(one) for one in feature.locate(self.places[k]))
        nominal = self.nominal[k] if self.given[k] else feature.point_mm(arc_length)
        outward = feature.outward_normal(arc_length)
        error_mm = float(outward @ (self.measured[k] - nominal)) - self.ball_mm
        if abs(error_mm) > CREDIBLE_ERROR_MM:
            said = f"a part error of {error_mm:+.3f} mm; at most {CREDIBLE_ERROR_MM} mm is credible"
            return Left(point, f"on {feature.name!r} it has {said}")
        at, to = ((float(one[0]), float(one[1])) for one in (nominal, self.measured[k]))
        touch = Touch(point.name, at, feature.name, to, error_mm)
        return MatchedTouch(touch, index, by, abs(distance - float(self.off_mm[k])))

    def _outward(self, index: int, k: int) -> Array:
        feature = self.profile.features[index]
        return feature.outward_normal(feature.locate(self.places[k])[0])
