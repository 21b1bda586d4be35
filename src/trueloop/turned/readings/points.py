"""Points of a measuring machine as touches of a turned part: x is the distance from the axis, z runs along it."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias, get_args

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.inspection import CmmPoint, Inspection, Touch, Vector
from trueloop.geometry.profile import Profile
from trueloop.turned.readings.matches import Axis, By, Left, MatchedTouch, feature_named
from trueloop.turned.touches.touches import CREDIBLE_ERROR_MM, ON_PROFILE_MM

Indices: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.intp]]

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
    """The result of matching points; `axis` is None where there are none, or none fits."""

    touches: tuple[MatchedTouch, ...] = ()
    left: tuple[Left, ...] = ()
    axis: Axis | None = None


def along_and_off(place_mm: Vector, axis: Axis) -> tuple[float, float]:
    """Returns the coordinate along an axis, and the distance from it."""
    along, first, second, sign = AXES[axis]
    return sign * place_mm[along], math.hypot(place_mm[first], place_mm[second])


def match_points(
    profile: Profile, inspection: Inspection, names: Mapping[str, str], axis: Axis | None = None
) -> PointMatches:
    """Returns the points of an inspection as touches, each on the one feature that it can be of.

    A nominal point may be `ON_PROFILE_MM` off; a measured one without a nominal `CREDIBLE_ERROR_MM`, its nominal is the
    nearest place. A part error is n·(measured − nominal) less the ball, n the profile's normal. Points are left, with
    the reason, where the frame is not the part's, where no axis is the spindle's, off the profile and between features.
    """
    points = inspection.points
    if not points:
        return PointMatches()
    if inspection.frame != "part":
        why = f"its position is counted from the {inspection.frame}'s zero, not from the part's"
        return PointMatches(left=tuple(Left(point, why) for point in points))
    places = _Places.of(points)
    found = axis or _axis(profile, places, inspection.ball_radius_mm)
    if found is None:
        why = f"along no axis of its frame do {MOST:.0%} of {len(points)} points lie on the profile"
        why += _explained(profile, places, inspection.ball_radius_mm)
        return PointMatches(left=tuple(Left(point, why) for point in points))
    outcomes = _matched(profile, points, places, inspection.ball_radius_mm, names, found)
    touches = tuple(outcome for outcome in outcomes if isinstance(outcome, MatchedTouch))
    return PointMatches(touches, tuple(outcome for outcome in outcomes if isinstance(outcome, Left)), found)


@dataclass(frozen=True)
class _Places:
    """The points as arrays (n, 3) in their own frame; nan where not stated."""

    nominal: Array
    measured: Array
    normal: Array

    @classmethod
    def of(cls, points: tuple[CmmPoint, ...]) -> "_Places":
        """Read once: there may be millions."""
        unknown = (math.nan,) * 3
        return cls(
            np.array([point.nominal_mm or unknown for point in points], dtype=np.float64),
            np.array([point.measured_mm for point in points], dtype=np.float64),
            np.array([point.outward_normal or unknown for point in points], dtype=np.float64),
        )


def _axis(profile: Profile, places: _Places, ball_mm: float) -> Axis | None:
    """Z where most points lie on the profile in it, else the only other one in which they do."""
    if _share(profile, places, ball_mm, "z") >= MOST:
        return "z"
    others: list[Axis] = [axis for axis in get_args(Axis) if axis != "z"]
    fitting = [axis for axis in others if _share(profile, places, ball_mm, axis) >= MOST]
    return fitting[0] if len(fitting) == 1 else None


def _explained(profile: Profile, places: _Places, ball_mm: float) -> str:
    """Describes what would let most points lie on the profile: some left out, or z counted from its other end."""
    shares = {axis: _share(profile, places, ball_mm, axis) for axis in get_args(Axis)}
    best: Axis = max(shares, key=lambda axis: (shares[axis], axis == "z"))
    if MOST > shares[best] >= 0.5:
        return f"; along {best} {shares[best]:.0%} do: --axis {best} takes these and lists the others"
    for end_mm in {profile.features[0].start_mm[1], profile.features[-1].end_mm[1]} - {0.0}:
        for axis in get_args(Axis):
            if _share(profile, places, ball_mm, axis, end_mm) >= MOST:
                return f"; along {axis} moved by {end_mm:+g} mm they do: where is the file's zero?"
    return ""


def _share(profile: Profile, places: _Places, ball_mm: float, axis: Axis, moved_mm: float = 0.0) -> float:
    """Returns the share of points that lie on the profile with this axis for its own, moved by so much along it."""
    nominal, measured, normal = _in_plane(places, axis)
    moved = np.array([0.0, moved_mm])
    nominal, measured = nominal + moved, measured + moved
    given = ~np.isnan(nominal[:, 0])
    away = np.abs(_distances(profile, np.where(given[:, None], nominal, measured), np.where(given, 0.0, ball_mm)))
    near = np.min(away, axis=0) <= np.where(given, ON_PROFILE_MM, CREDIBLE_ERROR_MM)
    across = np.isnan(normal[:, 2]) | (np.abs(normal[:, 2]) < 1.0 - SAME_WAY)
    return float(np.mean(near & across))


def _in_plane(places: _Places, axis: Axis) -> tuple[Array, Array, Array]:
    """Returns nominal and measured (x, z), (n, 2), x from the axis, and normals (x, z, around), (n, 3); nan: none."""
    along, first, second, sign = AXES[axis]
    nominal, measured, normal = places.nominal, places.measured, places.normal

    def turned(place: Array) -> Array:
        return np.stack([np.hypot(place[:, first], place[:, second]), sign * place[:, along]], axis=1)

    place = np.where(np.isnan(nominal), measured, nominal)
    radius = np.hypot(place[:, first], place[:, second])
    off = np.maximum(radius, ON_AXIS_MM)
    across = (normal[:, first] * place[:, first] + normal[:, second] * place[:, second]) / off
    around = (normal[:, second] * place[:, first] - normal[:, first] * place[:, second]) / off
    return turned(nominal), turned(measured), np.stack([across, sign * normal[:, along], around], axis=1)


def _distances(profile: Profile, places: Array, ball_mm: Array) -> Array:
    """Returns each place's distance from each feature, ends included, less the ball, (features, n); along n signed."""
    rows = []
    for feature in profile.features:
        arc_length, distance = feature.locate(places)
        beyond = np.maximum(np.maximum(-arc_length, arc_length - feature.length_mm), 0.0)
        rows.append(np.where(beyond > 0.0, np.hypot(distance, beyond) + ball_mm, distance - ball_mm))
    return np.array(rows)


def _matched(
    profile: Profile,
    points: tuple[CmmPoint, ...],
    in_space: _Places,
    ball_mm: float,
    names: Mapping[str, str],
    axis: Axis,
) -> list[MatchedTouch | Left]:
    nominal, measured, normal = _in_plane(in_space, axis)
    given = ~np.isnan(nominal[:, 0])
    places = np.where(given[:, None], nominal, measured)
    plane = _Plane(
        profile=profile,
        places=places,
        measured=measured,
        normal=normal,
        given=given,
        off_mm=np.where(given, 0.0, ball_mm),
        ball_mm=ball_mm,
    )
    away = np.abs(_distances(profile, places, plane.off_mm))
    # The features nearest and next to each point; of a profile of one feature both are that
    order = np.argsort(away, axis=0, kind="stable")
    nearest, second = order[0], order[min(1, len(order) - 1)]
    near = nearest.copy()
    by: list[By] = ["geometry"] * len(points)
    for k, named in _named(profile, points, names):
        near[k], by[k] = named, "name"
    distance = away[near, np.arange(len(points))]
    far = distance > plane.limits
    behind = away[second, np.arange(len(points))]
    tied = (near == nearest) & ~far & (behind <= np.minimum(plane.limits, distance + TIED_MM))
    left: dict[int, Left] = {
        int(k): plane.far(points[k], int(near[k]), int(k), distance[k]) for k in np.flatnonzero(far)
    }
    for k in (int(row) for row in np.flatnonzero(tied) if by[row] == "geometry"):
        chosen = plane.one_of(k, (int(nearest[k]), int(second[k])), points[k], away[:, k])
        if isinstance(chosen, Left):
            left[k] = chosen
        else:
            near[k] = chosen
    return plane.touches(points, near, by, left)


def _named(profile: Profile, points: tuple[CmmPoint, ...], names: Mapping[str, str]) -> Iterator[tuple[int, int]]:
    """Yields the points that name a feature, and which; each name is looked up once."""
    known: dict[str, int | None] = {"": None}
    for k, point in enumerate(points):
        if point.name not in known:
            known[point.name] = feature_named(profile, names.get(point.name, point.name))
        if (index := known[point.name]) is not None:
            yield k, index


@dataclass(frozen=True)
class _Plane:
    """The points in the plane (x, z), (n, 2), normals (x, z, around), (n, 3).

    `places` are nominal points, and measured ones where none is `given`; `off_mm`: how far off the surface a place lies
    if the part has no error.
    """

    profile: Profile
    places: Array
    measured: Array
    normal: Array
    given: Flags
    off_mm: Array
    ball_mm: float

    @property
    def limits(self) -> Array:
        """Returns how far a place may be off its feature."""
        return np.where(self.given, ON_PROFILE_MM, CREDIBLE_ERROR_MM)

    def far(self, point: CmmPoint, index: int, k: int, away_mm: float) -> Left:
        """A point whose place is off its feature."""
        kind = "nominal point" if self.given[k] else "surface touched"
        limit = ON_PROFILE_MM if self.given[k] else CREDIBLE_ERROR_MM
        name = self.profile.names[index]
        return Left(point, f"its {kind} is {away_mm:.3f} mm from {name!r}; at most {limit} mm is taken")

    def one_of(self, k: int, near: tuple[int, int], point: CmmPoint, away: Array) -> int | Left:
        """Returns the one of two features that point k is of: by its normal, where theirs differ."""
        normals = [self._outward(one, self.places[k]) for one in near]
        if float(normals[0] @ normals[1]) > SAME_WAY:
            return near[0]
        facing = [one for one, n in zip(near, normals, strict=True) if float(n @ self.normal[k, :2]) > SAME_WAY]
        if len(facing) == 1:
            return facing[0]
        first, second = (self.profile.names[one] for one in near)
        why = f"it may be of {first!r} or of {second!r}, {away[near[0]]:.3f} mm and {away[near[1]]:.3f} mm off"
        return Left(point, why, (first, second))

    def touches(
        self, points: tuple[CmmPoint, ...], near: Indices, by: list[By], left: dict[int, Left]
    ) -> list[MatchedTouch | Left]:
        """Returns the points as touches: e = n·(measured − nominal) − ball. Left where that is not credible."""
        nominal, error_mm, away_mm = self.places.copy(), np.zeros(len(points)), np.zeros(len(points))
        for index, feature in enumerate(self.profile.features):
            of_it = near == index
            arc_length, distance = feature.locate(self.places[of_it])
            foot = np.where(self.given[of_it, None], self.places[of_it], feature.point_mm(arc_length))
            along = np.einsum("ij,ij->i", feature.outward_normal(arc_length), self.measured[of_it] - foot)
            nominal[of_it], error_mm[of_it] = foot, along - self.ball_mm
            away_mm[of_it] = np.abs(distance - self.off_mm[of_it])
        at, to, names = nominal.tolist(), self.measured.tolist(), self.profile.names
        outcomes: list[MatchedTouch | Left] = []
        for k, (point, index, error, away) in enumerate(
            zip(points, near.tolist(), error_mm.tolist(), away_mm.tolist(), strict=True)
        ):
            name = names[index]
            if k in left:
                outcomes.append(left[k])
            elif abs(error) > CREDIBLE_ERROR_MM:
                said = f"a part error of {error:+.3f} mm; at most {CREDIBLE_ERROR_MM} mm is credible"
                outcomes.append(Left(point, f"on {name!r} it has {said}"))
            else:
                touch = Touch(point.name, tuple(at[k]), name, tuple(to[k]), error)
                outcomes.append(MatchedTouch(touch, index, by[k], away))
        return outcomes

    def _outward(self, index: int, place: Array) -> Array:
        feature = self.profile.features[index]
        return feature.outward_normal(feature.locate(place)[0])
