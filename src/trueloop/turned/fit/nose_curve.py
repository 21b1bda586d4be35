"""The nose model's curve on the arcs of one part, as a spline like any other."""

import math
from dataclasses import astuple, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.chain import Chain
from trueloop.turned.fit.chain_fit import ChainFit, touches_of
from trueloop.turned.fit.knots import Knots, fit_determined
from trueloop.turned.fit.nose_model import NoseModel, NosePrediction
from trueloop.turned.fit.spline import EndConditions, SplineFit
from trueloop.turned.touches.error_vectors import ErrorVectors

SAMPLE_RAD: Final = math.radians(1.0)
"""The nose model is carried over to a spline along the arc from samples this close: exact to a nanometre."""


def nose_curve(
    profile: Profile, vectors: ErrorVectors, fit: ChainFit, prediction: NosePrediction, joint_repeats: int
) -> ChainFit:
    """Fits a chain of arcs by the nose model's curve under its own end conditions; covariance from w and the offsets.

    Where the nose model does not reach (the last degrees before an end), the curve is drawn out like any other.
    """
    s, angle = _samples(profile, fit.chain, prediction.model)
    knots = Knots(_knots(profile, fit.chain, prediction.model, s), fit.chain.joints_mm, joint_repeats)
    curve, kept = fit_determined(s, prediction.value_mm(angle), knots, fit.chain.length_mm, 3, fit.fit.conditions)
    touches = touches_of(profile, fit.chain, vectors)
    return replace(
        fit,
        fit=curve,
        residual_mm=touches.error_mm - curve.spline.of(curve.spline.value_form(touches.arc_length_mm)),
        knot_every=(None,) * len(fit.chain.features),
        from_model_mm=carried(s, prediction.root_of_covariance_mm(angle), kept, curve),
    )


def carried(s: Array, root: Array, knots: Knots, curve: SplineFit) -> Array:
    """Carries the samples' covariance to the coefficients: each column is fitted like data, with zero at the ends."""
    zero = EndConditions(*(None if number is None else 0.0 for number in astuple(curve.conditions)))
    length, degree = curve.spline.length_mm, curve.spline.degree
    columns = [fit_determined(s, column, knots, length, degree, zero)[0].spline.coefficients_mm for column in root.T]
    return np.column_stack(columns)


def _samples(profile: Profile, chain: Chain, nose: NoseModel) -> tuple[Array, Array]:
    """Returns arc lengths along the chain, and contact angles, where the nose model covers it."""
    along, angles = [], []
    for i, start in zip(chain.features, chain.starts_mm, strict=True):
        feature = profile.features[i]
        turn = feature.length_mm * abs(float(feature.curvature_per_mm(0.0)))
        s = np.linspace(0.0, feature.length_mm, max(math.ceil(turn / SAMPLE_RAD), 8) + 1)
        angle = profile.contact_along_rad(i, s)
        inside = nose.covers(angle)
        along.append(start + s[inside])
        angles.append(angle[inside])
    return np.concatenate(along), np.concatenate(angles)


def _knots(profile: Profile, chain: Chain, nose: NoseModel, s: Array) -> tuple[float, ...]:
    """Returns where along the chain the contact angle passes a knot of w, within samples and clear of joints."""
    found: list[float] = []
    for i, start in zip(chain.features, chain.starts_mm, strict=True):
        feature = profile.features[i]
        first = float(profile.contact_along_rad(i, 0.0)[0])
        at = (first - nose.lowest_rad - nose.w.interior_knots_mm) / float(feature.curvature_per_mm(0.0))
        at = at[(at > 0.01 * feature.length_mm) & (at < 0.99 * feature.length_mm)] + start
        found += [float(t) for t in at if s[0] < t < s[-1]]
    return tuple(found)
