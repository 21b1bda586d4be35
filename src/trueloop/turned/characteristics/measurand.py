"""A characteristic of a turned part as sizes that are linear in the part error: value = nominal + gains · error.

The part error e displaces a surface by e along its outward normal n = (n_x, n_z). To first order, what is left on

- changes a diameter at a fixed z by 2 e/n_x;
- moves a face along z by e/n_z;
- turns a cone by its slope e′: the angle to the axis by e′ times the signs of the tangent's components;
- changes the radius of an arc by that of the least-squares circle, centre free: e = ±δR + n·δc.

Second-order terms are e²/2R, below 1 nm for 0.1 mm on any radius that is turned.

Nominals and limits of characteristics held against the profile that the correction aims at.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.intersection import sign_changes
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.tolerances.iso2768 import Edge

ALONG: Final = 1e-6
"""A tangent's component this small is none: the feature runs along the other axis."""
FACES: Final = 0.5
"""A size along an axis needs a surface that faces it: 1/n of at most 2."""
EDGE: Final = 0.02
"""Share of a feature at either end that has no size of its own: edges are broken."""
LEAST_PLACES: Final = 7
"""An arc's circle and a straight line are fitted to at least as many places."""


@dataclass(frozen=True, eq=False)
class Measurand:
    """Sizes of one characteristic: `nominal` (m,) + `gains` (m, n) · error in mm at n places of the profile.

    In mm, of an angle in degrees. Several sizes are local ones along a feature, each of which has to be in.
    """

    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    nominal: Array
    gains: Array


def measurand(
    profile: Profile, characteristic: Characteristic, touches: NDArray[np.intp], part_zero_z_mm: float = 0.0
) -> Measurand:
    """Returns the sizes of a characteristic; `touches` counts those on every feature of the profile.

    A feature is looked at in as many places as it was touched in, so that what scatters from touch to touch averages
    out as far as touches show. `part_zero_z_mm` is z of the part's zero in the frame of the profile. Raises TOL-FEATURE
    and TOL-PLACE for what the part does not have.
    """
    index = feature_index(profile, characteristic)
    feature = profile.features[index]
    count = int(touches[index])
    match characteristic.quantity:
        case Quantity.DIAMETER:
            return _diameter(index, feature, characteristic, count)
        case Quantity.LENGTH:
            return _length(profile, index, characteristic, touches, part_zero_z_mm)
        case Quantity.ANGLE:
            return _angle(index, feature, characteristic, count)
        case Quantity.RADIUS:
            # The radius of the least-squares circle, its centre free
            if not isinstance(feature, Arc):
                raise no_such(characteristic, "it is no arc", "of a cylinder or a cone, ask for a diameter")
            s = spread(feature, max(count, LEAST_PLACES))
            row = np.linalg.pinv(_circle(feature, s))[0]
            return Measurand(np.full(len(s), index), s, np.array([feature.radius_mm]), row[None, :])
        case Quantity.FORM:
            return _form(index, feature, count)
        case _:
            known = "diameter, length, angle, radius and form are"
            raise no_such(characteristic, f"a {characteristic.quantity} of a turned part is not judged", known)


def feature_index(profile: Profile, characteristic: Characteristic, name: str | None = None) -> int:
    """Returns the index in the profile of the feature of a characteristic, or of another one it names."""
    name = characteristic.feature if name is None else name
    if name not in profile.names:
        raise Code.TOL_FEATURE.refusal(
            f"characteristic {characteristic.name!r} is of feature {name!r}, which the part does not have",
            hint=f"its features are {', '.join(profile.names)}",
            values={"characteristic": characteristic.name, "feature": name},
        )
    return profile.names.index(name)


def no_such(characteristic: Characteristic, why: str, hint: str) -> TrueloopError:
    """Returns the refusal of a characteristic that its feature cannot have."""
    return Code.TOL_PLACE.refusal(
        f"characteristic {characteristic.name!r} of feature {characteristic.feature!r}: {why}",
        hint=hint,
        values={"characteristic": characteristic.name, "feature": characteristic.feature},
    )


def _diameter(index: int, feature: Feature, asked: Characteristic, touches: int) -> Measurand:
    cylinder = isinstance(feature, Line) and abs(feature.tangent(0.0)[0]) < ALONG
    if asked.at_z_mm is not None:
        s = np.array([_arc_length_at(feature, asked, asked.at_z_mm)])
    elif cylinder:
        s = feature.length_mm * np.linspace(EDGE, 1.0 - EDGE, max(touches, LEAST_PLACES))
    else:
        raise no_such(asked, "a diameter that changes along it has to have a place", "give at_z_mm")
    if np.any(np.abs(feature.outward_normal(s)[:, 0]) < FACES):
        raise no_such(asked, "a surface that faces along z has no diameter to measure there", "ask for a length")
    return diameters_at(index, feature, s)


def diameters_at(index: int, feature: Feature, arc_length_mm: Array) -> Measurand:
    """Returns the local diameters of a feature that does not face along z, at arc lengths (n,)."""
    n, normal_x = len(arc_length_mm), feature.outward_normal(arc_length_mm)[:, 0]
    diameter = 2.0 * feature.point_mm(arc_length_mm)[:, 0]
    return Measurand(np.full(n, index), arc_length_mm, diameter, np.diag(2.0 / normal_x))


def _length(
    profile: Profile, index: int, asked: Characteristic, touches: NDArray[np.intp], part_zero_z_mm: float
) -> Measurand:
    """Returns the length from the other face, or from the part's zero; always positive."""
    faces = [index, *([feature_index(profile, asked, asked.other)] if asked.other else [])]
    if len(set(faces)) < len(faces):
        raise no_such(
            asked, "a length needs a second face", "`characteristic.other` names the face that it counts from"
        )
    at, z, gains = [], [], []
    for k in faces:
        feature = profile.features[k]
        normal_z = feature.outward_normal(0.5 * feature.length_mm)[1]
        if not isinstance(feature, Line) or abs(feature.tangent(0.0)[1]) > ALONG:
            raise no_such(asked, f"a length is between faces, and {feature.name!r} is none", "give two faces")
        s = spread(feature, max(int(touches[k]), 1))
        at.append(s)
        z.append(float(feature.start_mm[1]))
        gains.append(np.full(len(s), 1.0 / normal_z / len(s)))
    length = z[0] - (z[1] if asked.other else part_zero_z_mm)
    if length == 0.0:
        raise no_such(asked, "its length is zero", "a length is between two places; `other` names the second face")
    signs = [math.copysign(1.0, length), -math.copysign(1.0, length)]
    row = np.concatenate([sign * gain for sign, gain in zip(signs, gains, strict=False)])
    indices = np.repeat(faces, [len(s) for s in at])
    return Measurand(indices.astype(np.intp), np.concatenate(at), np.array([abs(length)]), row[None, :])


def _angle(index: int, feature: Feature, asked: Characteristic, touches: int) -> Measurand:
    """Returns the angle to the axis, 0 to 90 degrees: half of a cone's own angle."""
    s = spread(feature, max(touches, LEAST_PLACES))
    along_x, along_z = feature.tangent(0.0)
    if not isinstance(feature, Line) or min(abs(along_x), abs(along_z)) < ALONG:
        raise no_such(asked, "it is no cone", "of a cylinder, ask for diameters at two places; of a face, for its form")
    slope = (s - s.mean()) / np.sum((s - s.mean()) ** 2)
    turned = math.copysign(1.0, along_x * along_z)
    angle = math.degrees(math.atan2(abs(along_x), abs(along_z)))
    return Measurand(np.full(len(s), index), s, np.array([angle]), np.degrees(turned * slope)[None, :])


def _form(index: int, feature: Feature, touches: int) -> Measurand:
    """Returns the residual of a fitted line, or of the circle of an arc, at every place; the form is its range.

    A curve is moved along z, the one way in which a turned surface can be: its form is its profile deviation.
    """
    s = spread(feature, max(touches, LEAST_PLACES))
    fitted = np.stack([np.ones(len(s)), s], axis=1)
    if isinstance(feature, Arc):
        fitted = _circle(feature, s)
    elif isinstance(feature, Curve):
        fitted = feature.outward_normal(s)[:, 1:]
    left = np.eye(len(s)) - fitted @ np.linalg.pinv(fitted)
    return Measurand(np.full(len(s), index), s, np.zeros(len(s)), left)


def _circle(feature: Arc, s: Array) -> Array:
    """Returns the error by the radius and the centre of a circle, (n, 3)."""
    convex = math.copysign(1.0, feature.sweep_rad)
    return np.column_stack([np.full(len(s), convex), feature.outward_normal(s)])


def spread(feature: Feature, count: int) -> Array:
    """Places evenly spread along a feature, half a distance from its ends."""
    return feature.length_mm * (np.arange(count) + 0.5) / count


def _arc_length_at(feature: Feature, characteristic: Characteristic, z_mm: float) -> float:
    """Returns the arc length at which a feature passes a z; the one place of it."""
    found = [s for s in _crossings(feature, z_mm) if -1e-9 <= s <= feature.length_mm + 1e-9]
    if len(found) != 1:
        ends = f"it runs from z {feature.start_mm[1]:.3f} to {feature.end_mm[1]:.3f} mm"
        why = f"z {z_mm:.3f} mm is not on it" if not found else f"it passes z {z_mm:.3f} mm {len(found)} times"
        raise no_such(characteristic, why, ends)
    return min(max(found[0], 0.0), feature.length_mm)


def _crossings(feature: Feature, z_mm: float) -> list[float]:
    if isinstance(feature, Arc):
        x, z = feature.centre_mm
        high = feature.radius_mm**2 - (z_mm - z) ** 2
        points = [(x + side * math.sqrt(high), z_mm) for side in (1.0, -1.0)] if high >= 0.0 else []
        return [float(feature.locate(point)[0]) for point in points]
    if isinstance(feature, Curve):
        return [float(s) for s in sign_changes(feature, lambda points: points[:, 1] - z_mm)]
    along = float(feature.tangent(0.0)[1])
    return [(z_mm - feature.start_mm[1]) / along] if abs(along) > ALONG else []


SAME: Final = 1e-6
"""mm or degrees: sizes that differ by less are the same, for conversions round."""
FACTOR_WITHIN: Final = 0.02
"""A ratio this close to 2 or 1/2 is that of a diameter and its radius."""


def profile_has(characteristic: Characteristic, profile: Profile) -> float:
    """Returns the nominal of a characteristic on the profile, mm or degrees. Raises TOL-FEATURE and TOL-PLACE."""
    untouched = np.zeros(len(profile.features), dtype=np.intp)
    return float(measurand(profile, characteristic, untouched).nominal[0])


def with_nominal(characteristic: Characteristic, nominal: float | None, profile: Profile) -> Characteristic:
    """Returns the characteristic with its nominal: the given one, or the profile's."""
    has = profile_has(characteristic, profile)
    if nominal is None:
        return replace(characteristic, nominal=has)
    if characteristic.quantity in (Quantity.DIAMETER, Quantity.RADIUS) and has > 0.0:
        for factor, words in ((2.0, "twice"), (0.5, "half")):
            if abs(nominal / has / factor - 1.0) < FACTOR_WITHIN:
                raise _not_the_profiles(characteristic, nominal, has, f"{words} of")
    return replace(characteristic, nominal=nominal)


def place_of(characteristic: Characteristic, profile: Profile) -> tuple[object, ...]:
    """Returns what is measured where: two characteristics that agree in it are the same.

    A face at z = 0 is the part's zero, from which a length counts that names no other face.
    """
    ends = {characteristic.feature, characteristic.other}
    if characteristic.quantity is Quantity.LENGTH:
        at_zero = {profile.names[k] for k in profile.faces_at(0.0)}
        ends = {"" if name in at_zero else name for name in ends}
    return characteristic.quantity, frozenset(ends), characteristic.at_z_mm


def checked(
    characteristic: Characteristic, lower: float | None, upper: float | None, tolerance: str, profile: Profile
) -> Characteristic:
    """Returns the characteristic with its limits. Raises TOL-ZONE where they are empty or exclude the nominal."""
    unit, limits = characteristic.quantity.unit, (lower, upper)
    words = " to ".join("…" if limit is None else f"{limit:.4f}" for limit in limits) + f" {unit}"
    if lower is not None and upper is not None and lower >= upper:
        raise _zone(characteristic, f"its limits {words} hold nothing between them", "the smaller one is `lower_limit`")
    has = profile_has(characteristic, profile)
    if (lower is not None and has < lower - SAME) or (upper is not None and has > upper + SAME):
        raise _zone(
            characteristic,
            f"its limits {words} exclude the {has:.4f} {unit} that the profile has, which the correction aims at",
            "limits are absolute and in diameters of a diameter; of a fit away from the nominal, draw the profile to "
            "the middle of the zone and give the drawing's `characteristic.nominal`",
        )
    return replace(characteristic, lower_limit=lower, upper_limit=upper, tolerance=tolerance)


def usual(feature: Feature) -> Characteristic | None:
    """Returns the characteristic usually drawn of a feature's shape, without nominal; None: at z = 0, a curve."""
    if isinstance(feature, Curve):
        return None
    if isinstance(feature, Arc):
        quantity = Quantity.RADIUS
    else:
        along_x, along_z = np.abs(feature.tangent(0.0)) > ALONG
        quantity = Quantity.ANGLE if along_x and along_z else Quantity.DIAMETER if along_z else Quantity.LENGTH
    if quantity is Quantity.LENGTH and abs(feature.start_mm[1]) < SAME:
        return None
    return Characteristic(f"{feature.name} {quantity}", quantity, feature.name, 0.0)


def edge_of(profile: Profile, index: int) -> Edge:
    """Returns a feature for general tolerances: a convex arc of up to 90°, tangent at both ends, breaks an edge."""
    feature, last = profile.features[index], len(profile.features) - 1
    tangent = 0 < index < last and all(j.kind is JunctionKind.TANGENT for j in profile.junctions[index - 1 : index + 1])
    turns = feature.sweep_rad if isinstance(feature, Arc) else 0.0
    return Edge(feature.length_mm, tangent and 0.0 < turns <= math.pi / 2 + ALONG)


def _zone(characteristic: Characteristic, why: str, hint: str) -> TrueloopError:
    message = f"characteristic {characteristic.name!r}: {why}"
    return Code.TOL_ZONE.refusal(message, hint=hint, values={"characteristic": characteristic.name})


def _not_the_profiles(asked: Characteristic, nominal: float, has: float, ratio: str) -> TrueloopError:
    return Code.TOL_NOMINAL.refusal(
        f"characteristic {asked.name!r}: its nominal {nominal:.4f} mm is {ratio} the {has:.4f} mm of the profile",
        hint=f"a {asked.quantity} is given as a {asked.quantity}, whatever part.x_is is",
        values={"characteristic": asked.name, "nominal_mm": nominal, "profile_mm": has},
    )
