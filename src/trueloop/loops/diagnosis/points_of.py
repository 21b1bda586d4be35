"""Stored inspections as errors at points: touches, readings of gauges, points of a measuring machine in the plane.

What is matched with which feature, and what a diameter or a length says of the surface, is decided as in corrections
(`turned.readings`): errors count from the nominal shape of a feature, and a nominal value beside a reading only says
which feature it is of.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.features.feature_place import FeaturePlace
from trueloop.diagnosis.features.seen_points import SeenPoints
from trueloop.domain.inspection import CmmPoint, Inspection
from trueloop.geometry.feature import Feature, is_curved
from trueloop.geometry.profile import Junction, JunctionKind, Profile
from trueloop.loops.diagnosis.inferred import inferred_shapes
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matched import MatchedReading
from trueloop.turned.readings.matches import Axis, Matches
from trueloop.turned.readings.observed import corrected
from trueloop.turned.readings.points import AXES
from trueloop.turned.readings.sizes import is_cylinder, is_face
from trueloop.turned.readings.vectors import with_readings
from trueloop.turned.touches.touches import Gauging, standard_uncertainty_mm

ALONG_ARC: Final = 65
"""Points of an arc between which its range of radii and of z is taken."""


@dataclass(frozen=True)
class _Row:
    """One value at one point."""

    feature: str
    nominal_mm: Array
    normal: Array
    error_mm: float
    standard_u_mm: float
    spindle_rad: float = float("nan")
    repeat: int = 1


def places_of(inspections: Sequence[Inspection], profile: Profile | None = None) -> dict[str, FeaturePlace]:
    """Features with their places: all of the profile, or without one those that the inspections name or imply.

    Without a profile, nominal points, normals and names make features: cylinders, faces and cones, no arcs.
    """
    shapes = inferred_shapes(inspections) if profile is None else profile.features
    return {shape.name: _place(shape) for shape in shapes}


def points_of(
    inspection: Inspection,
    places: Mapping[str, FeaturePlace],
    gauging: Gauging | None = None,
    standard_u_mm: float | None = None,
) -> SeenPoints:
    """All values of an inspection that are errors of the surface of one of the features, in the order of kind.

    Readings repeat as they say; touches and points at one nominal place are repeats in their order. `standard_u_mm` is
    that of one touch or point, of which the inspection says nothing; without it that of `gauging`, which readings
    without an uncertainty have too. A face from which lengths count is 0 by definition, with an uncertainty of 0. The
    angle of the part is that of a measuring machine's points about the axis; of touches it is not known. Values that
    belong to no feature are left out. Raises MSR errors for readings that cannot be right.
    """
    shapes = tuple(place.shape for place in places.values() if place.shape is not None)
    if not shapes:
        return _points([])
    profile, how = _profile(shapes), gauging or Gauging()
    matches = match_inspection(profile, inspection)
    if inspection.points and matches.axis is None:
        matches = match_inspection(profile, inspection, axis="z")
    touched = _touched(profile, inspection, matches, how, standard_u_mm)
    return _points([*_counted(touched), *_read(profile, matches.readings, how)])


def _profile(shapes: Sequence[Feature]) -> Profile:
    """The shapes as what values are matched with; they need not meet."""
    return Profile(tuple(shapes), tuple(Junction(JunctionKind.CORNER, 0.0) for _ in pairwise(shapes)))


def _place(shape: Feature) -> FeaturePlace:
    count = ALONG_ARC if is_curved(shape) else 2
    radius, z = shape.point_mm(np.linspace(0.0, shape.length_mm, count)).T
    kind = "arc" if is_curved(shape) else "shaft" if is_cylinder(shape) else "face" if is_face(shape) else "cone"
    radii, zs = ((float(values.min()), float(values.max())) for values in (radius, z))
    return FeaturePlace(shape.name, kind, radii, zs, shape=shape)


def _touched(
    profile: Profile, inspection: Inspection, matches: Matches, gauging: Gauging, standard_u_mm: float | None
) -> Iterator[_Row]:
    """Touches, then points of a measuring machine; both have become touches of the plane."""
    angles = _angles(inspection, matches)
    touches = matches.touches
    for matched, angle in zip(touches, [float("nan")] * (len(touches) - len(angles)) + angles, strict=True):
        feature, touch = profile.features[matched.feature_index], matched.touch
        nominal = np.array(touch.nominal_mm)
        normal = feature.outward_normal(feature.locate(nominal)[0])
        u = float(standard_uncertainty_mm(normal, gauging)[0]) if standard_u_mm is None else standard_u_mm
        assert touch.error_mm is not None  # matched touches have one
        yield _Row(feature.name, nominal, normal, touch.error_mm - gauging.allowance_mm, u, angle)


def _angles(inspection: Inspection, matches: Matches) -> list[float]:
    """About the axis of each point that was matched, rad, in their order, counted as a right-handed turn about z."""
    left = {id(one.value) for one in matches.left}
    return [_angle(one, matches.axis or "z") for one in inspection.points if id(one) not in left]


def _angle(point: CmmPoint, axis: Axis) -> float:
    _, first, second, sign = AXES[axis]
    place = point.nominal_mm or point.measured_mm
    return float(sign * np.arctan2(place[second], place[first]))


def _counted(rows: Iterator[_Row]) -> Iterator[_Row]:
    """With the number of the repeat."""
    times: dict[tuple[object, ...], int] = {}
    for row in rows:
        angle = None if np.isnan(row.spindle_rad) else round(row.spindle_rad, 6)
        key = (row.feature, *np.round(row.nominal_mm, 6).tolist(), angle)
        times[key] = times.get(key, 0) + 1
        yield replace(row, repeat=times[key])


def _read(profile: Profile, readings: Sequence[MatchedReading], gauging: Gauging) -> Iterator[_Row]:
    """Readings at places, the repeats apart: lengths between faces are resolved within one repeat."""
    used = corrected(readings)
    for repeat in sorted({one.reading.repeat for one in used}):
        vectors, _ = with_readings(profile, [one for one in used if one.reading.repeat == repeat], None, gauging)
        for k, index in enumerate(vectors.feature_index.tolist()):
            error_mm, u_mm = float(vectors.error_mm[k]), float(vectors.standard_u_mm[k])
            nominal, normal = vectors.nominal_mm[k], vectors.outward_normal[k]
            yield _Row(profile.names[index], nominal, normal, error_mm, u_mm, repeat=repeat)


def _points(rows: Sequence[_Row]) -> SeenPoints:
    return SeenPoints(
        tuple(row.feature for row in rows),
        np.array([row.nominal_mm for row in rows], dtype=np.float64).reshape(-1, 2),
        np.array([row.normal for row in rows], dtype=np.float64).reshape(-1, 2),
        np.array([row.error_mm for row in rows], dtype=np.float64),
        np.array([row.standard_u_mm for row in rows], dtype=np.float64),
        np.array([row.spindle_rad for row in rows], dtype=np.float64),
        np.array([row.repeat for row in rows], dtype=np.intp),
    )
