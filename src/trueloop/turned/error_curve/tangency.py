"""The tangency of the next part at its tangent junctions.

The error of the uncorrected process has a kink at a tangent junction, because the nose errs as a function of contact
angle. Under the policy PART the path takes the opposite kink and the part is tangent up to the uncertainty of that
kink; under PATH the path has none and the kink stays on the part.
"""

from dataclasses import dataclass

import numpy as np

from trueloop.geometry.feature import Point
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.error_curve.uncertainty import FittedChains
from trueloop.turned.fit.chain import TangentPolicy
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class Tangency:
    """Predicted tangency error of the part at one tangent junction, for a full correction (weight 1).

    `kink` is the jump of the error's slope across the junction with the slope left free, mm per mm or rad;
    `predicted_rad` what of it the part will have, `standard_u_rad` its standard uncertainty. For a weight w under PART
    the part keeps (1 − w)·kink. `before` and `after` are feature indices.
    """

    before: int
    after: int
    point_mm: Point
    kink: float
    predicted_rad: float
    standard_u_rad: float

    @property
    def standard_u_um_per_mm(self) -> float:
        """Returns the standard uncertainty in the unit of the trade: µm of height a mm of length."""
        return self.standard_u_rad * UM_PER_MM


def tangencies(profile: Profile, free: FittedChains, policy: TangentPolicy) -> tuple[Tangency, ...]:
    """Returns one entry a tangent junction. `free` is the fit with continuous values and free slopes (PART)."""
    place = {index: (c, k) for c, fit in free.fits.items() for k, index in enumerate(fit.chain.features)}
    found = []
    for i, junction in enumerate(profile.junctions):
        if junction.kind != JunctionKind.TANGENT:
            continue
        chain, k = place[i]
        inside = place[i + 1][0] == chain
        kink, variance = _inside(free, chain, k) if inside else _between(free, chain)
        end = profile.features[i].point_mm(profile.features[i].length_mm)
        predicted = 0.0 if policy == TangentPolicy.PART else kink
        u = float(np.sqrt(max(variance, 0.0)))
        found.append(Tangency(i, i + 1, (float(end[0]), float(end[1])), kink, predicted, u))
    return tuple(found)


def _inside(free: FittedChains, chain: int, k: int) -> tuple[float, float]:
    """Returns the kink and its variance at a joint within a chain."""
    spline = free.splines[chain]
    form = spline.kink_form(free.fits[chain].chain.joints_mm[k])
    return float(spline.of(form)[0]), float(spline.variance(form)[0])


def _between(free: FittedChains, before: int) -> tuple[float, float]:
    """Returns the kink and its variance between the end of a chain and the start of the next.

    The value handed from one to the other ties the two slopes together; that covariance is subtracted twice.
    """
    after = before + 1
    a, b = free.splines[before], free.splines[after]
    slope_a, slope_b = a.slope_form(a.length_mm), b.slope_form(0.0)
    kink = float((b.of(slope_b) - a.of(slope_a))[0])
    variance = float((a.variance(slope_a) + b.variance(slope_b))[0])
    if free.reference is not None:  # the last column of both is one and the same error
        both = slope_a.of(a.prescribed_mm[:, -1]) * slope_b.of(b.prescribed_mm[:, -1])
        variance -= 2.0 * float(both[0])
    for here, there, at_end in ((before, after, False), (after, before, True)):
        variance -= 2.0 * _tied(free, here, there, at_end)
    return kink, variance


def _tied(free: FittedChains, taker: int, giver: int, giver_at_end: bool) -> float:
    """Returns the covariance of the slopes at a junction where chain `taker` takes its value from `giver`; else 0."""
    fit = free.fits[taker]
    source = fit.sources[0 if giver_at_end else 1].neighbour
    if source is None or source.chain != giver:
        return 0.0
    spline, given = free.splines[taker], free.splines[giver]
    at_taker, at_giver = (0.0, given.length_mm) if giver_at_end else (spline.length_mm, 0.0)
    column = 0 if giver_at_end else fit.fit.conditions.count - 1
    response = float(spline.slope_form(at_taker).of(fit.fit.sensitivity)[0, column])
    slope = given.slope_form(at_giver)
    return response * float(given.covariance(given.value_form(at_giver), slope)[0])
