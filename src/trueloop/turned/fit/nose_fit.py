"""The fit of a nose model to several parts.

The nose model's curve on the arcs of one part, as a spline like any other.
"""

import math
from collections.abc import Sequence
from dataclasses import astuple, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.feature import is_curved
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.chain_fit import Chain, ChainFit, touches_of
from trueloop.turned.fit.knots import Knots, fit_determined
from trueloop.turned.fit.nose_model import (
    APART_RAD,
    NoseModel,
    NosePrediction,
    NoseTouches,
    offset_terms,
    refuse_too_few,
)
from trueloop.turned.fit.spline import EndConditions, Spline, SplineFit
from trueloop.turned.touches.error_vectors import ErrorVectors

KNOT_SPACING_RAD: Final = math.radians(7.5)
"""Knots of w stand about this far apart: every second touch of a dome with twenty. Any spacing from 6° to 15° predicts
the parts of [6811] equally well (2.1 to 2.5 µm from three touches)."""

SMALLEST_SINGULAR: Final = 1e-6
"""Below this share of the largest singular value the touches do not determine the model."""


def nose_touches(part: str, profile: Profile, vectors: ErrorVectors) -> NoseTouches:
    """Returns a part's error vectors by contact angle. Points at the z reference are left out: zero by definition."""
    used = ~vectors.at_reference
    index = vectors.feature_index[used]
    return NoseTouches(
        part,
        tuple(profile.features[i].name for i in index),
        np.array([is_curved(profile.features[i]) for i in index], dtype=np.bool_),
        profile.contact_angle_rad(index, vectors.arc_length_mm[used]),
        vectors.error_mm[used],
    )


def fit_nose_model(parts: Sequence[NoseTouches]) -> NoseModel:
    """Fits w and every part's offsets by least squares over the arcs of all parts; then the remainder on straight
    features.

    w has knots about every `KNOT_SPACING_RAD`, fewer where the touches do not carry them. Straight features are looked
    at only within the arcs' range of angles. Raises FIT-POINTS when some part's arcs do not set its offsets.
    """
    if not parts:
        raise Code.FIT_POINTS.refusal(
            "0 parts to fit a nose model to",
            hint="give the touches of at least one part with an arc",
            values={"touches": 0},
        )
    arcs = [part.subset(part.on_arc) for part in parts]
    for arc in arcs:
        if len(arc.feature) < 2 or float(np.ptp(arc.contact_angle_rad)) < APART_RAD:
            raise refuse_too_few(arc)
    angle = np.concatenate([arc.contact_angle_rad for arc in arcs])
    lowest, highest = float(np.min(angle)), float(np.max(angle))
    for knots in range(max(round((highest - lowest) / KNOT_SPACING_RAD) - 1, 0), -1, -1):
        # An empty spline over the range, with equally spaced knots
        length = highest - lowest
        n = knots + 4
        interior = length * np.arange(1, knots + 1) / (knots + 1)
        found = _solve(
            arcs,
            Spline(
                interior_knots_mm=interior,
                length_mm=length,
                degree=3,
                coefficients_mm=np.zeros(n),
                covariance_band_mm2=np.zeros((n, 4)),
                prescribed_mm=np.zeros((n, 1)),
            ),
            lowest,
        )
        if found is not None:
            # The mean error of each straight feature about the model of its part
            left: dict[tuple[str, str], list[float]] = {}
            for part in parts:
                straight = part.subset(~part.on_arc & found.covers(part.contact_angle_rad))
                expected = found.w_mm(straight.contact_angle_rad) + offset_terms(straight.contact_angle_rad) @ np.array(
                    found.offsets_mm[part.part]
                )
                for name, off in zip(straight.feature, straight.error_mm - expected, strict=True):
                    left.setdefault((part.part, name), []).append(float(off))
            return replace(found, left_mm={key: math.fsum(values) / len(values) for key, values in left.items()})
    raise refuse_too_few(arcs[0])


def _solve(arcs: Sequence[NoseTouches], space: Spline, lowest: float) -> NoseModel | None:
    """Returns the model on one spline space; None when the touches do not determine it with one to spare."""
    # Basis Z of the coefficients with ∫w sin φ dφ = ∫w cos φ dφ = 0, by Gauss quadrature between knots
    nodes, weights = np.polynomial.legendre.leggauss(8)
    breaks = np.concatenate([[0.0], space.interior_knots_mm, [space.length_mm]])
    half = np.diff(breaks)[:, None] / 2
    at = (breaks[:-1, None] + half * (1.0 + nodes)).ravel()
    rows = space.value_form(at).dense(len(space.coefficients_mm))
    moments = (offset_terms(at + lowest) * (half * weights).reshape(-1, 1)).T @ rows
    complete: Array = np.linalg.svd(moments)[2]
    free = complete[2:].T
    design = np.vstack([_rows(arcs, k, space, lowest, free) for k in range(len(arcs))])
    error = np.concatenate([arc.error_mm for arc in arcs])
    spare = len(error) - design.shape[1]
    if spare <= 0:
        return None
    u, singular, v = np.linalg.svd(design, full_matrices=False)
    if singular[-1] < SMALLEST_SINGULAR * singular[0]:
        return None
    solution = (v.T / singular) @ (u.T @ error)
    variance = float(np.sum((error - design @ solution) ** 2)) / spare
    n = free.shape[1]
    root = math.sqrt(variance) * free @ (v.T / singular)[:n]
    offsets = solution[n:].reshape(-1, 2)
    return NoseModel(
        lowest_rad=lowest,
        highest_rad=lowest + space.length_mm,
        w=replace(space, coefficients_mm=free @ solution[:n], prescribed_mm=root),
        offsets_mm={arc.part: (float(o[0]), float(o[1])) for arc, o in zip(arcs, offsets, strict=True)},
        left_mm={},
        scatter_mm=math.sqrt(variance),
        degrees_of_freedom=spare,
    )


def _rows(arcs: Sequence[NoseTouches], k: int, space: Spline, lowest: float, free: Array) -> Array:
    """Returns the design rows of one part: w in its gauge, then the offsets of all parts."""
    angle = arcs[k].contact_angle_rad
    offsets = np.zeros((len(angle), 2 * len(arcs)))
    offsets[:, 2 * k : 2 * k + 2] = offset_terms(angle)
    return np.hstack([space.value_form(angle - lowest).dense(len(space.coefficients_mm)) @ free, offsets])


SAMPLE_RAD: Final = math.radians(1.0)
"""The nose model is carried over to a spline along the arc from samples this close: exact to a nanometre."""


def nose_curve(
    profile: Profile, vectors: ErrorVectors, fit: ChainFit, prediction: NosePrediction, joint_repeats: int
) -> ChainFit:
    """Fits a chain of arcs by the nose model's curve under its own end conditions; covariance from w and the offsets.

    Where the nose model does not reach (the last degrees before an end), the curve is drawn out like any other.
    """
    s, angle = _samples(profile, fit.chain, prediction.model)
    # Where along the chain the contact angle passes a knot of w, within samples and clear of joints
    found: list[float] = []
    for i, start in zip(fit.chain.features, fit.chain.starts_mm, strict=True):
        feature = profile.features[i]
        first = float(profile.contact_along_rad(i, 0.0)[0])
        at = (first - prediction.model.lowest_rad - prediction.model.w.interior_knots_mm) / float(
            feature.curvature_per_mm(0.0)
        )
        at = at[(at > 0.01 * feature.length_mm) & (at < 0.99 * feature.length_mm)] + start
        found += [float(t) for t in at if s[0] < t < s[-1]]
    knots = Knots(tuple(found), fit.chain.joints_mm, joint_repeats)
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
