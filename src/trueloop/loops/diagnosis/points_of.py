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
from trueloop.diagnosis.features.feature_error import EXACT_MM, FeaturePlace, SeenPoints
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.domain.life import Ran
from trueloop.geometry.feature import Feature, Line, is_curved
from trueloop.geometry.profile import Junction, JunctionKind, Profile
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.made_parts import moved_mm
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import Axis, MatchedReading, Matches, feature_named
from trueloop.turned.readings.observed import corrected
from trueloop.turned.readings.points import AXES
from trueloop.turned.readings.sizes import is_cylinder, is_face
from trueloop.turned.readings.vectors import with_readings
from trueloop.turned.touches.touches import Gauging, standard_uncertainty_mm

ON_LINE_MM: Final = 0.02
"""Nominal points are on one line within this: twice what a report in hundredths rounds to."""
LEAST_MM: Final = 1.0
"""Length that a feature known from one place is given, so that values can be matched with it."""
ALONG: Final = 1e-3
"""A normal with less than this across an axis is along it."""


@dataclass(frozen=True)
class _Hint:
    """The evidence that a feature has a point (x as a radius, z); `normal` (x, z) outward, NaN where not stated."""

    name: str
    at_mm: tuple[float, float]
    normal: tuple[float, float] = (float("nan"), float("nan"))


def inferred_shapes(inspections: Sequence[Inspection]) -> tuple[Line, ...]:
    """Returns the straight features, in order from the chuck; those whose points lie on no line are left out."""
    groups: dict[str, list[_Hint]] = {}
    for hint in (hint for inspection in inspections for hint in _hints(inspection)):
        groups.setdefault(hint.name, []).append(hint)
    lengths = [reading for each in inspections for reading in each.readings if reading.quantity is Quantity.LENGTH]
    for name, z in _faces(lengths, {name: hints[0].at_mm[1] for name, hints in groups.items()}).items():
        groups.setdefault(name, [_Hint(name, (LEAST_MM / 2.0, z), (0.0, 1.0))])
    shapes = (_line(name, hints) for name, hints in groups.items())
    found = [shape for shape in shapes if shape is not None]
    return tuple(sorted(found, key=lambda line: line.start_mm[1] + line.end_mm[1]))


def _hints(inspection: Inspection) -> Iterator[_Hint]:
    for value in inspection.values:
        if isinstance(value, Touch) and value.feature is not None:
            yield _Hint(value.feature, value.nominal_mm)
        elif isinstance(value, CmmPoint):
            yield from _of_point(value)
        elif isinstance(value, Reading):
            # Yields the evidence of a size: a diameter or a radius makes a cylinder or a piece of a cone; at z 0 where
            # its place is not stated.
            size = value.nominal
            if size is not None and value.quantity in (Quantity.DIAMETER, Quantity.RADIUS):
                radius = size / 2.0 if value.quantity is Quantity.DIAMETER else size
                at = value.place_mm[-1] if value.place_mm else 0.0
                yield _Hint(_name(value), (radius, at), (-1.0 if value.side == "inner" else 1.0, 0.0))


def _of_point(point: CmmPoint) -> Iterator[_Hint]:
    """Yields the evidence of a point, named by the line of place and normal: its own name may be the point's alone."""
    if point.nominal_mm is None or point.outward_normal is None:
        return
    x, y, z = point.nominal_mm
    radius = float(np.hypot(x, y))
    across = point.outward_normal[0] if radius == 0.0 else float(np.dot(point.outward_normal[:2], (x, y))) / radius
    along = point.outward_normal[2]
    if abs(along) < ALONG:
        name = f"{'shaft' if across > 0 else 'bore'} of {2 * radius:.2f} mm"
    elif abs(across) < ALONG:
        name = f"face at {z:.2f} mm"
    else:
        off = across * radius + along * z
        name = f"cone of {np.degrees(np.arctan2(along, across)):.1f}° at {off:.1f} mm"
    yield _Hint(name, (radius, z), (across, along))


def _name(reading: Reading) -> str:
    return reading.feature or reading.characteristic


def _faces(lengths: Sequence[Reading], known_mm: Mapping[str, float]) -> dict[str, float]:
    """Returns z of the faces between which lengths are read, the first zero: z counts from it into the part, towards
    the chuck, as in a job, or away from it where what is stated of other places lies there.

    `known_mm` are places of other features.
    """
    z, into = {"": 0.0, **known_mm}, 1.0 if sum(known_mm.values()) > 0.0 else -1.0
    waiting = [length for length in lengths if length.nominal is not None]
    while waiting:
        tied = next((reading for reading in waiting if reading.other in z or _name(reading) in z), waiting[0])
        waiting.remove(tied)
        assert tied.nominal is not None  # those without one were left out
        if tied.other not in z:
            z[tied.other] = z[_name(tied)] - into * tied.nominal if _name(tied) in z else 0.0
        z.setdefault(_name(tied), z[tied.other] + into * tied.nominal)
    return {name: at for name, at in z.items() if name not in ("", *known_mm)}


def _line(name: str, hints: Sequence[_Hint]) -> Line | None:
    places = np.array(sorted({hint.at_mm for hint in hints}))
    middle = places.mean(axis=0)
    normal = _normal(places - middle, np.array([hint.normal for hint in hints]))
    if normal is None:
        return None
    tangent = np.array([-normal[1], normal[0]])
    along = (places - middle) @ tangent
    short = max(LEAST_MM - float(np.ptp(along)), 0.0) / 2.0
    start, end = middle + (along.min() - short) * tangent, middle + (along.max() + short) * tangent
    return Line(name, (float(start[0]), float(start[1])), (float(end[0]), float(end[1])))


def _normal(off_middle: Array, stated: Array) -> Array | None:
    """Returns the normal out of the material of the line through the points; None where none or several fit."""
    known = stated[~np.isnan(stated[:, 0])]
    side = known.mean(axis=0) if len(known) else np.array([1.0, ALONG])
    _, sizes, ways = np.linalg.svd(off_middle)
    if sizes[0] < ON_LINE_MM:
        length = float(np.linalg.norm(side))
        return side / length if len(known) and length > 0.5 else None
    if sizes[1] > ON_LINE_MM:
        return None
    normal: Array = np.where(np.abs(ways[1]) < ALONG, 0.0, ways[1])  # rounded coordinates make no cone
    turned: Array = np.copysign(1.0, normal @ side) * normal / np.linalg.norm(normal)
    return turned


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
    """Returns all values of an inspection that are errors of the surface of one of the features, in the order of kind.

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
    """Returns a profile of the shapes, by which values are matched with them; they need not meet."""
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
        yield _Row(
            feature=feature.name,
            nominal_mm=nominal,
            normal=normal,
            error_mm=touch.error_mm - gauging.allowance_mm,
            standard_u_mm=u,
            spindle_rad=angle,
        )


def _angles(inspection: Inspection, matches: Matches) -> list[float]:
    """Returns the angle about the axis of each point that was matched, rad, in their order, right-handed about z."""
    left = {id(one.value) for one in matches.left}
    return [_angle(point, matches.axis or "z") for point in inspection.points if id(point) not in left]


def _angle(point: CmmPoint, axis: Axis) -> float:
    _, first, second, sign = AXES[axis]
    place = point.nominal_mm or point.measured_mm
    return float(sign * np.arctan2(place[second], place[first]))


def _counted(rows: Iterator[_Row]) -> Iterator[_Row]:
    """Yields the rows with the number of the repeat."""
    times: dict[tuple[object, ...], int] = {}
    for row in rows:
        angle = None if np.isnan(row.spindle_rad) else round(row.spindle_rad, 6)
        key = (row.feature, *np.round(row.nominal_mm, 6).tolist(), angle)
        times[key] = times.get(key, 0) + 1
        yield replace(row, repeat=times[key])


def _read(profile: Profile, readings: Sequence[MatchedReading], gauging: Gauging) -> Iterator[_Row]:
    """Readings at places, the repeats apart: lengths between faces are resolved within one repeat."""
    used = corrected(readings)
    for repeat in sorted({reading.reading.repeat for reading in used}):
        vectors, _ = with_readings(
            profile, [reading for reading in used if reading.reading.repeat == repeat], None, gauging
        )
        for k, index in enumerate(vectors.feature_index.tolist()):
            error_mm, u_mm = float(vectors.error_mm[k]), float(vectors.standard_u_mm[k])
            nominal, normal = vectors.nominal_mm[k], vectors.outward_normal[k]
            yield _Row(profile.names[index], nominal, normal, error_mm, u_mm, repeat=repeat)


def taken_off_mm(points: SeenPoints, correction: Correction, ran: Ran) -> Array:
    """Returns how much a correction took off at points, (n,), counted as their errors are: along z from the face that
    is zero by definition, where there is one. 0 on features that its profile does not have.
    """
    profile, moved = correction.profile, np.zeros(len(points.feature))
    index = np.array([-1 if k is None else k for k in (feature_named(profile, one) for one in points.feature)])
    own = np.flatnonzero(index >= 0)
    along = [float(profile.features[index[k]].locate(points.nominal_mm[k])[0]) for k in own.tolist()]
    moved[own] = moved_mm(correction, ran, index[own], np.array(along))
    for datum in np.flatnonzero(points.standard_u_mm <= EXACT_MM)[:1]:
        moved -= points.normal[:, 1] / points.normal[datum, 1] * moved[datum]
    return 0.0 - moved


def by_machine_mm(points: SeenPoints, correction: Correction) -> tuple[Array, Array]:
    """Returns what the model of the machine tells of points that a correction was made from, (n,) each: E(T_probing),
    to be added to what the probe reported, and E of the cut, which the surface carries. Each point is the correction's
    nearest on its feature; 0 on features that it does not have, and without a model.
    """
    probed_mm, cut_in_mm = np.zeros((2, len(points.feature)))
    known, of = correction.composed, correction.touches
    for k, name in enumerate(points.feature if known is not None else ()):
        index = feature_named(correction.profile, name)
        rows = np.array([], np.intp) if index is None else of.of_feature(index)
        if known is not None and len(rows):
            row = rows[np.argmin(np.linalg.norm(of.nominal_mm[rows] - points.nominal_mm[k], axis=1))]
            probed_mm[k], cut_in_mm[k] = of.error_mm[row] - known.reported_mm[row], known.cut_in_mm[row]
    return probed_mm, cut_in_mm


def _points(rows: Sequence[_Row]) -> SeenPoints:
    return SeenPoints(
        feature=tuple(row.feature for row in rows),
        nominal_mm=np.array([row.nominal_mm for row in rows], dtype=np.float64).reshape(-1, 2),
        normal=np.array([row.normal for row in rows], dtype=np.float64).reshape(-1, 2),
        error_mm=np.array([row.error_mm for row in rows], dtype=np.float64),
        standard_u_mm=np.array([row.standard_u_mm for row in rows], dtype=np.float64),
        spindle_rad=np.array([row.spindle_rad for row in rows], dtype=np.float64),
        repeat=np.array([row.repeat for row in rows], dtype=np.intp),
    )
