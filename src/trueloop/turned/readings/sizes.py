"""The features that a size may be of: diameters, radii, lengths and angles, compared with those of a profile.

The sizes that a person can measure of a turned part with a micrometer, a caliper or a depth gauge, and their
places.
"""

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Reading
from trueloop.geometry.feature import Arc, Feature, Line, distance_mm
from trueloop.geometry.profile import Profile, kind_of

STRAIGHT: Final = 1e-6
"""A line whose direction has less than this across an axis runs along it: below what coordinates are rounded to."""
NOMINAL_WITHIN_MM: Final = 0.02
"""A nominal size is that of a feature within this: twice what a report in hundredths rounds to."""
ACTUAL_WITHIN_MM: Final = 0.5
"""An actual size without a nominal value: what a finish cut may have been left on, as a diameter."""
ANGLE_WITHIN_DEG: Final = 0.05
"""An angle, by the rounding to a tenth of a degree."""
ACTUAL_WITHIN_DEG: Final = 1.0
"""An actual angle without a nominal value."""


@dataclass(frozen=True)
class Candidate:
    """A feature that a size may be of, and by how much the two differ: mm, of angles degrees."""

    feature_index: int
    differs: float
    other_index: int | None = None


def is_cylinder(feature: Feature) -> bool:
    """Returns whether it is a line along the axis."""
    return isinstance(feature, Line) and abs(float(feature.outward_normal(0.0)[1])) < STRAIGHT


def is_face(feature: Feature) -> bool:
    """Returns whether it is a line across the axis."""
    return isinstance(feature, Line) and abs(float(feature.outward_normal(0.0)[0])) < STRAIGHT


def angle_deg(feature: Feature) -> float | None:
    """Returns the angle between a cone and the axis, 0 to 90 degrees; None for other features."""
    if not isinstance(feature, Line) or is_cylinder(feature) or is_face(feature):
        return None
    normal = feature.outward_normal(0.0)
    return math.degrees(math.atan2(abs(float(normal[1])), abs(float(normal[0]))))


def candidates(profile: Profile, reading: Reading) -> list[Candidate]:
    """Returns the features that a reading's size fits, the nearest first; none for other quantities."""
    size, within = size_of(reading), within_of(reading)
    found: Iterator[Candidate]
    if reading.quantity is Quantity.ANGLE:
        found = _angles(profile, size)
    elif reading.quantity is Quantity.LENGTH:
        found = _lengths(profile, size)
    elif reading.quantity in (Quantity.DIAMETER, Quantity.RADIUS):
        found = _round(profile, reading, size)
    else:
        return []
    return sorted(
        (candidate for candidate in found if candidate.differs <= within), key=lambda candidate: candidate.differs
    )


def within_of(reading: Reading) -> float:
    """Returns by how much a size may differ from a feature's own: mm, of an angle degrees."""
    if reading.quantity is Quantity.ANGLE:
        return ANGLE_WITHIN_DEG if reading.nominal is not None else ACTUAL_WITHIN_DEG
    return NOMINAL_WITHIN_MM if reading.nominal is not None else ACTUAL_WITHIN_MM


def size_of(reading: Reading) -> float:
    """Returns the size to be compared with a feature: the nominal value, and the actual one where none is stated."""
    return reading.actual if reading.nominal is None else reading.nominal


def differs_from(profile: Profile, index: int, reading: Reading) -> float | None:
    """Returns by how much a size differs from that of one feature; None where the feature has no such size."""
    feature, size = profile.features[index], size_of(reading)
    if reading.quantity is Quantity.ANGLE:
        angle = angle_deg(feature)
        return None if angle is None else abs(size - angle)
    if reading.quantity in (Quantity.DIAMETER, Quantity.RADIUS):
        return next(
            (candidate.differs for candidate in _round(profile, reading, size) if candidate.feature_index == index),
            None,
        )
    return None


def axial_mm(reading: Reading) -> float | None:
    """Returns where along the spindle a size was measured; None where that is not stated."""
    return reading.place_mm[-1] if reading.place_mm else None


def _round(profile: Profile, reading: Reading, size: float) -> Iterator[Candidate]:
    """Diameters and radii. With a place: what lies there; without: cylinders, and arcs by their radius."""
    twice = 2.0 if reading.quantity is Quantity.DIAMETER else 1.0
    radius, z = size / twice, axial_mm(reading)
    for index, feature in enumerate(profile.features):
        if on_other_side(feature, reading):
            continue
        if reading.quantity is Quantity.RADIUS and isinstance(feature, Arc):
            yield Candidate(index, abs(feature.radius_mm - radius))
        elif z is not None and not is_face(feature):
            yield Candidate(index, twice * distance_mm(feature, (radius, z)))
        elif z is None and is_cylinder(feature):
            yield Candidate(index, twice * abs(feature.start_mm[0] - radius))


def on_other_side(feature: Feature, reading: Reading) -> bool:
    """Returns whether the file states a bore and the feature is an outside, or the other way round."""
    if not reading.side or (reading.quantity is Quantity.RADIUS and isinstance(feature, Arc)):
        return False
    n_x = float(feature.outward_normal(feature.length_mm / 2)[0])
    return n_x * (1.0 if reading.side == "inner" else -1.0) > 0.0


def _lengths(profile: Profile, size: float) -> Iterator[Candidate]:
    """From the part's zero to a face, and between two faces."""
    faces = [(k, one.start_mm[1]) for k, one in enumerate(profile.features) if is_face(one)]
    for index, z in faces:
        if z != 0.0:
            yield Candidate(index, abs(abs(z) - abs(size)))
    for (index, z), (other, further) in itertools.combinations(faces, 2):
        if z != further:
            yield Candidate(index, abs(abs(further - z) - abs(size)), other)


def _angles(profile: Profile, size: float) -> Iterator[Candidate]:
    for index, feature in enumerate(profile.features):
        if (angle := angle_deg(feature)) is not None:
            yield Candidate(index, abs(angle - abs(size)))


ANVIL_MM: Final = 6.5
"""Width of a micrometer's faces: over less length there is one place to measure, at the middle."""
LONG_MM: Final = 60.0
"""A cylinder from this length on is measured in the middle as well: it may be curved."""


def gauge_plan(profile: Profile, characteristics: Sequence[Characteristic] = ()) -> tuple[Characteristic, ...]:
    """Returns the sizes of the drawing that a gauge can read, then diameters of the other cylinders and lengths of
    other faces.

    A diameter is read at two places where there is room, at three on a long cylinder. Lengths count from the face
    nearest the free end that looks there, or from the part's zero where there is none. Cones and arcs are left out
    unless a place on them is asked for: a micrometer does not say where it touches them.
    """
    datum, planned = _datum(profile), list[Characteristic]()
    for feature in profile.features:
        own = [characteristic for characteristic in characteristics if characteristic.feature == feature.name]
        planned += [place for characteristic in own for place in _places_of(characteristic, feature)]
        kind = kind_of(feature)
        if kind == "cylinder" and not any(characteristic.quantity is Quantity.DIAMETER for characteristic in own):
            planned += _diameters(feature)
        elif (
            kind == "face"
            and feature is not datum
            and not any(characteristic.quantity is Quantity.LENGTH for characteristic in own)
        ):
            planned.append(_length(feature, datum))
    return tuple(planned)


def _places_of(asked: Characteristic, feature: Feature) -> Iterable[Characteristic]:
    """A diameter that holds everywhere at its places, another size as it is; form is read by no gauge here."""
    if asked.quantity is Quantity.FORM:
        return ()
    if asked.quantity is not Quantity.DIAMETER or asked.at_z_mm is not None:
        return (asked,)
    return (
        replace(asked, name=f"{asked.name} {place.name[-1]}", at_z_mm=place.at_z_mm) for place in _diameters(feature)
    )


def _datum(profile: Profile) -> Feature | None:
    """Returns the face from which lengths count."""
    faces = [feature for feature in profile.features if kind_of(feature) == "face"]
    return next((face for face in reversed(faces) if float(face.outward_normal(0.0)[1]) > 0), None)


def _diameters(feature: Feature) -> Iterator[Characteristic]:
    for letter, share in zip("abc", _places(feature.length_mm), strict=False):
        x, z = (float(value) for value in feature.point_mm(share * feature.length_mm))
        name = f"{feature.name} {letter}"
        yield Characteristic(name, Quantity.DIAMETER, feature.name, round(2 * x, 6), at_z_mm=round(z, 3))


def _places(length_mm: float) -> tuple[float, ...]:
    """Shares of the length at which a diameter is measured: the gauge's faces lie on the cylinder as a whole."""
    if length_mm < 2 * ANVIL_MM:
        return (0.5,)
    inset = max(0.2, ANVIL_MM / 2 / length_mm)
    return (inset, 0.5, 1 - inset) if length_mm >= LONG_MM else (inset, 1 - inset)


def _length(face: Feature, datum: Feature | None) -> Characteristic:
    z, zero = float(face.point_mm(0.0)[1]), 0.0 if datum is None else float(datum.point_mm(0.0)[1])
    other = "" if datum is None else datum.name
    return Characteristic(f"{face.name} length", Quantity.LENGTH, face.name, round(abs(z - zero), 6), other=other)
