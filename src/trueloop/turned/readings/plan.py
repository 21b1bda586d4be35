"""The sizes that a person can measure of a turned part with a micrometer, a caliper or a depth gauge, and their
places.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.geometry.feature import Feature
from trueloop.geometry.profile import Profile, kind_of

ANVIL_MM: Final = 6.5
"""Width of a micrometer's faces: over less length there is one place to measure, at the middle."""
LONG_MM: Final = 60.0
"""A cylinder from this length on is measured in the middle as well: it may be curved."""


def gauge_plan(profile: Profile, asked: Sequence[Characteristic] = ()) -> tuple[Characteristic, ...]:
    """Returns the sizes of the drawing that a gauge can read, then diameters of the other cylinders and lengths of
    other faces.

    A diameter is read at two places where there is room, at three on a long cylinder. Lengths count from the face
    nearest the free end that looks there, or from the part's zero where there is none. Cones and arcs are left out
    unless a place on them is asked for: a micrometer does not say where it touches them.
    """
    datum, planned = _datum(profile), list[Characteristic]()
    for feature in profile.features:
        own = [one for one in asked if one.feature == feature.name]
        planned += [place for one in own for place in _places_of(one, feature)]
        kind = kind_of(feature)
        if kind == "cylinder" and not any(one.quantity is Quantity.DIAMETER for one in own):
            planned += _diameters(feature)
        elif kind == "face" and feature is not datum and not any(one.quantity is Quantity.LENGTH for one in own):
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
