"""The place of a reading on its feature, and its nominal value; lengths in mm, angles in degrees."""

import math
from typing import Final

import numpy as np

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.curve import Curve
from trueloop.geometry.curve_crossings import sign_changes
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.chain_fit import ROUNDING_MM
from trueloop.turned.readings.matched import MatchedReading
from trueloop.turned.touches.plausibility import ON_PROFILE_MM

CORRECTED: Final = (Quantity.DIAMETER, Quantity.RADIUS, Quantity.LENGTH, Quantity.ANGLE)
"""The kinds of reading from which errors of the profile follow; from others none does."""
FACES_X: Final = 0.5
"""A diameter is read where the surface faces the spindle axis by 30° at least: a diameter grows by 2/n_x of the error,
and flatter surfaces no gauge finds the place on."""
FACES_Z: Final = math.cos(math.radians(3.0))
"""A length is read between faces, within 3° of square to the spindle axis."""


def nominal_of(profile: Profile, one: MatchedReading) -> float:
    """Returns the profile's nominal of a reading that is `CORRECTED`. Raises MSR-KIND and MSR-PLACE."""
    feature, reading = profile.features[one.feature_index], one.reading
    if reading.quantity is Quantity.LENGTH:
        other = None if one.other_index is None else profile.features[one.other_index]
        return abs(face_z_mm(feature, reading) - (0.0 if other is None else face_z_mm(other, reading)))
    if reading.quantity is Quantity.ANGLE:
        return math.degrees(abs(tilt_rad(feature, reading)))
    if reading.quantity is Quantity.RADIUS and isinstance(feature, Arc):
        return feature.radius_mm
    radius = float(feature.point_mm(arc_length_of(feature, reading))[0])
    return radius if reading.quantity is Quantity.RADIUS else 2.0 * radius


def arc_length_of(feature: Feature, reading: Reading) -> float:
    """Returns where along its feature a diameter was read; without a place, the middle of a cylinder.

    Raises MSR-PLACE where the place is not on the feature, or is not given and the diameter is not the same all along;
    MSR-KIND where the surface faces z.
    """
    if not reading.place_mm:
        return _anywhere(feature, reading)
    z_mm = reading.place_mm[-1]
    found = _at_place(feature, reading.place_mm) if len(reading.place_mm) > 1 else _at_z(feature, z_mm)
    if len(found) != 1:
        ends = sorted((feature.start_mm[1], feature.end_mm[1]))
        raise _misplaced(
            reading,
            f"z {z_mm:g} mm is at {len(found)} places of {feature.name!r}, which goes from {ends[0]:g} to "
            f"{ends[1]:g} mm",
            "z counts from the part's zero, away from the chuck; give x_mm too, a radius, where z is there twice",
        )
    n_x = abs(float(feature.outward_normal(found[0])[0]))
    if n_x < FACES_X:
        faces = f"its surface faces z there (n_x {n_x:.2f}, at least {FACES_X})"
        raise _unseen(feature, reading, faces, "read a diameter where the surface faces the axis; of a face, a length")
    return found[0]


def face_z_mm(feature: Feature, reading: Reading) -> float:
    """Returns z of a face's middle. Raises MSR-KIND for other features."""
    if not isinstance(feature, Line) or abs(float(feature.outward_normal(0.0)[1])) < FACES_Z:
        hint = "name the face at which the length ends, and in `from` the one where it begins (empty: the part's zero)"
        raise _unseen(feature, reading, "it is no face", hint)
    return float(feature.point_mm(0.5 * feature.length_mm)[1])


def tilt_rad(feature: Feature, reading: Reading) -> float:
    """Returns the angle of a line from the spindle axis, towards +x, from −π/2 to π/2. Raises MSR-KIND for an arc."""
    if not isinstance(feature, Line):
        raise _unseen(feature, reading, "it is curved", "read a diameter at a z, or an arc's radius")
    t_x, t_z = (float(component) for component in feature.tangent(0.0))
    return math.atan2(t_x, t_z) if t_z >= 0.0 else math.atan2(-t_x, -t_z)


def _anywhere(feature: Feature, reading: Reading) -> float:
    if not isinstance(feature, Line) or abs(feature.end_mm[0] - feature.start_mm[0]) > 1e-6:
        raise _misplaced(
            reading,
            f"the place is empty, and the diameter of {feature.name!r} changes from {2 * feature.start_mm[0]:.4g} to "
            f"{2 * feature.end_mm[0]:.4g} mm",
            "give z_mm, where it was read",
        )
    return 0.5 * feature.length_mm


def _at_place(feature: Feature, place_mm: tuple[float, ...]) -> list[float]:
    s, off = (float(value) for value in feature.locate((place_mm[0], place_mm[-1])))
    inside = -ROUNDING_MM <= s <= feature.length_mm + ROUNDING_MM and abs(off) <= ON_PROFILE_MM
    return [min(max(s, 0.0), feature.length_mm)] if inside else []


def _at_z(feature: Feature, z_mm: float) -> list[float]:
    """Returns the arc lengths at which a feature has this z, its ends with `ROUNDING_MM`."""
    if isinstance(feature, Curve):
        at = sign_changes(feature, lambda points: points[:, 1] - z_mm)
        places = feature.point_mm(at) if len(at) else np.array([feature.start_mm, feature.end_mm])
        return [s for x, z in places if abs(z - z_mm) <= ROUNDING_MM for s in _at_place(feature, (x, z))]
    if isinstance(feature, Arc):
        (x0, z0), radius = feature.centre_mm, feature.radius_mm
        height = math.sqrt(max(radius**2 - (z_mm - z0) ** 2, 0.0))
        points = [] if abs(z_mm - z0) > radius else sorted({(x0 - height, z_mm), (x0 + height, z_mm)})
        return [s for point in points for s in _at_place(feature, point)]
    rise = feature.end_mm[1] - feature.start_mm[1]
    if abs(rise) < 1e-9:
        return []
    s = (z_mm - feature.start_mm[1]) / rise * feature.length_mm
    return [float(np.clip(s, 0.0, feature.length_mm))] if -ROUNDING_MM <= s <= feature.length_mm + ROUNDING_MM else []


def _misplaced(reading: Reading, why: str, hint: str) -> TrueloopError:
    return TrueloopError(
        Code.MSR_PLACE,
        f"{reading.characteristic!r}: {why}",
        hint=hint,
        place=Place(line=reading.line),
        values={"feature": reading.feature},
    )


def _unseen(feature: Feature, reading: Reading, why: str, hint: str) -> TrueloopError:
    return TrueloopError(
        Code.MSR_KIND,
        f"{reading.characteristic!r}, {reading.actual:g} {reading.quantity.unit}: {feature.name!r} has no "
        f"{reading.quantity}: {why}",
        hint=hint,
        place=Place(line=reading.line),
        values={"feature": feature.name, "quantity": str(reading.quantity)},
    )
