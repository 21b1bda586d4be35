"""What a person can measure of a turned part with a micrometer, a caliper or a depth gauge, and where."""

from collections.abc import Iterator
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.geometry.feature import Feature
from trueloop.geometry.names import kind_of
from trueloop.geometry.profile import Profile

ANVIL_MM: Final = 6.5
"""Width of a micrometer's faces: over less length there is one place to measure, at the middle."""
LONG_MM: Final = 60.0
"""A cylinder from this length on is measured in the middle as well: it may be curved."""


def gauge_plan(profile: Profile) -> tuple[Characteristic, ...]:
    """Diameters of the cylinders, at two places each where there is room, and lengths of faces; in the profile's order.

    Lengths count from the face nearest the free end that looks there, or from the part's zero where there is none.
    Cones and arcs are left out: a micrometer does not say where on them it touches.
    """
    datum = _datum(profile)
    planned: list[Characteristic] = []
    for feature in profile.features:
        kind = kind_of(feature)
        if kind == "cylinder":
            planned += _diameters(feature)
        elif kind == "face" and feature is not datum:
            planned.append(_length(feature, datum))
    return tuple(planned)


def _datum(profile: Profile) -> Feature | None:
    """The face from which lengths count."""
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
