"""Nominals and limits of characteristics held against the profile that the correction aims at."""

import math
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.tolerances.iso2768 import Edge
from trueloop.turned.characteristics.measurand import ALONG, measurand

SAME: Final = 1e-6
"""mm or degrees: sizes that differ by less are the same, for conversions round."""
FACTOR_WITHIN: Final = 0.02
"""A ratio this close to 2 or 1/2 is that of a diameter and its radius."""


def profile_has(asked: Characteristic, profile: Profile) -> float:
    """Returns the nominal of a characteristic on the profile, mm or degrees. Raises TOL-FEATURE and TOL-PLACE."""
    untouched = np.zeros(len(profile.features), dtype=np.intp)
    return float(measurand(profile, asked, untouched).nominal[0])


def with_nominal(asked: Characteristic, nominal: float | None, profile: Profile) -> Characteristic:
    """Returns the characteristic with its nominal: the given one, or the profile's."""
    has = profile_has(asked, profile)
    if nominal is None:
        return replace(asked, nominal=has)
    if asked.quantity in (Quantity.DIAMETER, Quantity.RADIUS) and has > 0.0:
        for factor, words in ((2.0, "twice"), (0.5, "half")):
            if abs(nominal / has / factor - 1.0) < FACTOR_WITHIN:
                raise _not_the_profiles(asked, nominal, has, f"{words} of")
    return replace(asked, nominal=nominal)


def checked(
    asked: Characteristic, lower: float | None, upper: float | None, tolerance: str, profile: Profile
) -> Characteristic:
    """Returns the characteristic with its limits. Raises TOL-ZONE where they are empty or exclude the nominal."""
    unit, limits = asked.quantity.unit, (lower, upper)
    words = " to ".join("…" if one is None else f"{one:.4f}" for one in limits) + f" {unit}"
    if lower is not None and upper is not None and lower >= upper:
        raise _zone(asked, f"its limits {words} hold nothing between them", "the smaller one is `lower_limit`")
    has = profile_has(asked, profile)
    if (lower is not None and has < lower - SAME) or (upper is not None and has > upper + SAME):
        raise _zone(
            asked,
            f"its limits {words} exclude the {has:.4f} {unit} that the profile has, which the correction aims at",
            "limits are absolute and in diameters of a diameter; of a fit away from the nominal, draw the profile to "
            "the middle of the zone and give the drawing's `characteristic.nominal`",
        )
    return replace(asked, lower_limit=lower, upper_limit=upper, tolerance=tolerance)


def usual(feature: Feature) -> Characteristic | None:
    """Returns the characteristic that a drawing usually states of a feature of this shape, without a nominal; None of a
    face at z = 0, and of a curve.
    """
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


def _zone(asked: Characteristic, why: str, hint: str) -> TrueloopError:
    message = f"characteristic {asked.name!r}: {why}"
    return Code.TOL_ZONE.refusal(message, hint=hint, values={"characteristic": asked.name})


def _not_the_profiles(asked: Characteristic, nominal: float, has: float, ratio: str) -> TrueloopError:
    return Code.TOL_NOMINAL.refusal(
        f"characteristic {asked.name!r}: its nominal {nominal:.4f} mm is {ratio} the {has:.4f} mm of the profile",
        hint=f"a {asked.quantity} is given as a {asked.quantity}, whatever part.x_is is",
        values={"characteristic": asked.name, "nominal_mm": nominal, "profile_mm": has},
    )
