"""The fit of a nose model to several parts.

The nose model's curve on the arcs of one part, as a spline like any other.

The nose model: one error function of contact angle, shared by all features that one tool nose cuts.

A worn or off-size nose errs where it is worn, so that the part error depends on the contact angle φ alone:

    e(part, feature, φ) = w(φ) + dX·sin φ + dZ·cos φ + left(feature)

with w the nose, dX and dZ the tool offsets of the part in hand, and a constant by which a straight feature deviates.
w is a cubic spline in φ fitted to the arcs of several parts; two touches then set the offsets of the next part, and its
whole arc is known. sin φ and cos φ could be moved between w and the offsets: w is fixed by having no part in common
with them, ∫w sin φ dφ = ∫w cos φ dφ = 0 over the fitted range.

It stops being valid when the nose goes on wearing, is turned to another edge, or cuts at angles outside the range; and
on straight features it knows only what was left on them: the cones of [6811] stand 11 to 17 µm off (30 µm on one
part whose taper looks falsified; the report says that some were).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import is_curved
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.chain_fit import Chain, ChainFit, Knots, fit_determined, touches_of
from trueloop.turned.fit.spline import EndConditions, Spline, SplineFit
from trueloop.turned.touches.error_vectors import ErrorVectors

APART_RAD: Final = math.radians(5.0)
"""Touches that shall set both offsets must span more than this."""

BEYOND_RAD: Final = math.radians(1.0)
"""Distance beyond its fitted range to which w is used, along end tangents: under the spacing of touches on a dome."""


@dataclass(frozen=True)
class NoseTouches:
    """Errors of one part by contact angle, (n,); `feature` names each touch's own; `on_arc`: the angle turns there."""

    part: str
    feature: tuple[str, ...]
    on_arc: NDArray[np.bool_]
    contact_angle_rad: Array
    error_mm: Array

    def subset(self, chosen: ArrayLike) -> "NoseTouches":
        """Returns some of the touches, by position or mask."""
        which = np.arange(len(self.feature))[np.asarray(chosen)]
        names = tuple(self.feature[k] for k in which)
        return NoseTouches(self.part, names, self.on_arc[which], self.contact_angle_rad[which], self.error_mm[which])


@dataclass(frozen=True)
class NoseModel:
    """A fitted nose. Angles in rad from `lowest_rad` to `highest_rad`, errors in mm.

    `w` runs over φ − lowest and carries its covariance. `offsets_mm` holds (dX, dZ) of every part of the fit, `left_mm`
    what is left on its straight features, by part and feature. `scatter_mm` is the standard deviation of a touch on an
    arc about the model, with `degrees_of_freedom`.
    """

    lowest_rad: float
    highest_rad: float
    w: Spline
    offsets_mm: Mapping[str, tuple[float, float]]
    left_mm: Mapping[tuple[str, str], float]
    scatter_mm: float
    degrees_of_freedom: int

    def covers(self, angle_rad: ArrayLike) -> NDArray[np.bool_]:
        """Returns whether contact angles lie within the fitted range, or at most a degree beyond."""
        angle = np.asarray(angle_rad, dtype=np.float64)
        return (angle >= self.lowest_rad - BEYOND_RAD) & (angle <= self.highest_rad + BEYOND_RAD)

    def w_mm(self, angle_rad: ArrayLike) -> Array:
        """Returns the nose's own error at contact angles, (n,). Raises FIT-ANGLE outside the fitted range."""
        return self.basis(angle_rad) @ self.w.coefficients_mm

    def basis(self, angle_rad: ArrayLike) -> Array:
        """Returns the row of w's basis functions for each contact angle, (n, coefficients)."""
        angle = np.atleast_1d(np.asarray(angle_rad, dtype=np.float64))
        if not np.all(self.covers(angle)):
            bad = angle[~self.covers(angle)][0]
            raise Code.FIT_ANGLE.refusal(
                f"the nose model was fitted from {math.degrees(self.lowest_rad):.1f}° to "
                f"{math.degrees(self.highest_rad):.1f}° of contact angle and is asked for {math.degrees(bad):.1f}°",
                hint="fit it to parts whose arcs reach that angle, or use the feature's own curve there",
                values={
                    "angle_deg": math.degrees(bad),
                    "lowest_deg": math.degrees(self.lowest_rad),
                    "highest_deg": math.degrees(self.highest_rad),
                },
            )
        form = self.w.value_form(angle - self.lowest_rad)
        return form.dense(len(self.w.coefficients_mm))

    def predict(self, touches: NoseTouches) -> "NosePrediction":
        """Predicts a part from two touches on its arcs or more, by offsets. Raises FIT-POINTS, FIT-ANGLE."""
        angle, error = touches.contact_angle_rad, touches.error_mm
        if len(angle) < 2 or float(np.ptp(angle)) < APART_RAD:
            raise refuse_too_few(touches)
        solve = np.asarray(np.linalg.pinv(offset_terms(angle)), dtype=np.float64)
        basis = self.basis(angle)
        return NosePrediction(self, solve @ (error - basis @ self.w.coefficients_mm), solve, solve @ basis)


@dataclass(frozen=True)
class NosePrediction:
    """The prediction of one part by a nose model: `offsets_mm` = (dX, dZ) from its touches."""

    model: NoseModel
    offsets_mm: Array
    _from_touches: Array
    _from_w: Array

    def value_mm(self, angle_rad: ArrayLike) -> Array:
        """Returns the expected part error at contact angles, (n,)."""
        angle = np.atleast_1d(np.asarray(angle_rad, dtype=np.float64))
        return self.model.w_mm(angle) + offset_terms(angle) @ self.offsets_mm

    def root_of_covariance_mm(self, angle_rad: ArrayLike) -> Array:
        """Returns F with F·Fᵀ the covariance of the expected errors, (n, m): from w and the touches' scatter."""
        angle = np.atleast_1d(np.asarray(angle_rad, dtype=np.float64))
        terms = offset_terms(angle)
        rows = self.model.basis(angle) - terms @ self._from_w
        return np.hstack([rows @ self.model.w.prescribed_mm, self.model.scatter_mm * (terms @ self._from_touches)])

    def standard_deviation_mm(self, angle_rad: ArrayLike) -> Array:
        """Returns the standard uncertainty of the expected error, (n,)."""
        variance: Array = np.sum(self.root_of_covariance_mm(angle_rad) ** 2, axis=1)
        return np.sqrt(variance)


def offset_terms(angle_rad: Array) -> Array:
    """Returns (sin φ, cos φ): the effect of tool offsets dX and dZ on the error along the normal, (n, 2)."""
    return np.column_stack([np.sin(angle_rad), np.cos(angle_rad)])


def refuse_too_few(touches: NoseTouches) -> TrueloopError:
    """Returns the error for touches that do not set dX and dZ."""
    span = math.degrees(float(np.ptp(touches.contact_angle_rad))) if len(touches.feature) else 0.0
    return Code.FIT_POINTS.refusal(
        f"part {touches.part!r}: {len(touches.feature)} touches over {span:.1f}° of contact angle do not set the two "
        f"tool offsets; at least 2 over {math.degrees(APART_RAD):.0f}° are needed",
        hint="touch the arc at two places far apart",
        values={"touches": len(touches.feature)},
    )


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
