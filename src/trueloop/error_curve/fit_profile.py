"""From error vectors to the error model of a whole profile."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.error_curve.chain import TangentPolicy
from trueloop.error_curve.check import check_options, check_vectors
from trueloop.error_curve.choose import ModelChoice, NoseOnPart, nose_on_part
from trueloop.error_curve.curve import ErrorCurve
from trueloop.error_curve.fit_chains import fit_chains
from trueloop.error_curve.junctions import DisplacedJunction, displaced_junctions
from trueloop.error_curve.nose_model import NoseModel
from trueloop.error_curve.options import FitOptions
from trueloop.error_curve.spline import EndConditions
from trueloop.error_curve.tangency import Tangency, tangencies
from trueloop.error_curve.uncertainty import FittedChains, finish
from trueloop.errors import TrueloopError
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.geometry.feature import Array
from trueloop.geometry.profile import Profile
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

DRAWN_OUT: Final = 3.0
"""An end that is this many times as uncertain as a single touch is worth a warning."""


@dataclass(frozen=True)
class ProfileErrorModel:
    """Error curves of all features, and how far they can be trusted. Positive = material left on; lengths in mm.

    `curves` and the RMS values go by feature index, `residual_mm` (error − curve: what a full correction would have
    left) and `leave_one_out_mm` (error − what the other touches say there; NaN where they say nothing) by touch. RMS
    values are NaN for features without a touch they could be taken from. `scatter_mm` is the largest standard deviation
    of a touch about its curve, known with `degrees_of_freedom` spare touches. `notes` explain every decision;
    `choices` compares own curve and nose model where a nose model was given.
    """

    profile: Profile
    vectors: ErrorVectors
    options: FitOptions
    curves: tuple[ErrorCurve, ...]
    residual_mm: Array
    leave_one_out_mm: Array
    residual_rms_mm: Array
    leave_one_out_rms_mm: Array
    junctions: tuple[DisplacedJunction, ...]
    tangency: tuple[Tangency, ...]
    scatter_mm: float
    degrees_of_freedom: int
    notes: tuple[str, ...]
    choices: tuple[ModelChoice, ...]


def fit_profile(
    profile: Profile, vectors: ErrorVectors, options: FitOptions | None = None, nose: NoseModel | None = None
) -> ProfileErrorModel:
    """Straight lines on lines, constrained cubic splines on arcs, joined at the junctions [6517 §2–4, 6811 §3].

    Features without a touch follow their tangent neighbours, else what the same contact angle did elsewhere (module
    `untouched`); one touch gives a constant. Curves are fitted with equal weights: the scatter of the cut (about 1 µm)
    hides the differences of the touches' own uncertainty. With a nose model from other parts, each arc gets whichever
    of the two predicts its touches better, left out one at a time. Raises FIT errors; `tests/errors` has one of each.
    """
    options = options or FitOptions()
    check_options(profile, options)
    check_vectors(profile, vectors)
    on_part, unused = _nose(profile, vectors, nose)
    fits, choices = fit_chains(profile, vectors, options, on_part)
    fitted = finish(fits, vectors)
    free = fitted
    if options.tangent_policy == TangentPolicy.PATH:
        with_kinks = replace(options, tangent_policy=TangentPolicy.PART)
        free = finish(fit_chains(profile, vectors, with_kinks, on_part)[0], vectors)
    curves = tuple(_curves(profile, vectors, fitted, options))
    drawn_out = [note for i, curve in enumerate(curves) if len(vectors.of_feature(i)) for note in _drawn_out(curve)]
    residual, left_out = _by_touch(len(vectors.point), fitted)
    groups = [vectors.of_feature(i) for i in range(len(profile.features))]
    return ProfileErrorModel(
        profile=profile,
        vectors=vectors,
        options=options,
        curves=curves,
        residual_mm=residual,
        leave_one_out_mm=left_out,
        residual_rms_mm=np.array([_rms_of_known(residual[group]) for group in groups]),
        leave_one_out_rms_mm=np.array([_rms_of_known(left_out[group]) for group in groups]),
        junctions=displaced_junctions(profile, curves),
        tangency=tangencies(profile, free, options.tangent_policy),
        scatter_mm=max(fitted.scatter_mm),
        degrees_of_freedom=fitted.degrees_of_freedom,
        notes=(*unused, *(note for fit in fitted.fits for note in fit.notes), *drawn_out),
        choices=choices,
    )


def _nose(profile: Profile, vectors: ErrorVectors, nose: NoseModel | None) -> tuple[NoseOnPart | None, tuple[str, ...]]:
    """The nose model on this part, or a note why it does not serve."""
    if nose is None:
        return None, ()
    try:
        return nose_on_part(profile, vectors, nose), ()
    except TrueloopError as refusal:
        return None, (f"the nose model of other parts does not serve: {refusal.message}",)


def _curves(profile: Profile, vectors: ErrorVectors, fitted: FittedChains, options: FitOptions) -> Iterator[ErrorCurve]:
    for fit, spline, scatter in zip(fitted.fits, fitted.splines, fitted.scatter_mm, strict=True):
        within = options.repeatability_mm
        if within is None:
            within = scatter if fitted.process_mm is None else fitted.process_mm
        probe = vectors.own_u_mm[fit.touches] if len(fit.touches) else vectors.own_u_mm
        for k, index in enumerate(fit.chain.features):
            yield ErrorCurve(
                feature=profile.features[index].name,
                length_mm=profile.features[index].length_mm,
                spline=spline,
                start_mm=fit.chain.starts_mm[k],
                conditions=_share(fit.fit.conditions, k, len(fit.chain.features)),
                knot_every=fit.knot_every[k],
                scatter_mm=scatter,
                repeatability_mm=within,
                between_cuts=options.between_cuts,
                probe_share=min(rms(probe) / scatter, 1.0) ** 2 if scatter > 0.0 else 0.0,
                touches=len(fit.touches),
                unsupported=fit.unsupported,
                degrees_of_freedom=fitted.degrees_of_freedom or None,
                notes=fit.notes,
            )


def _drawn_out(curve: ErrorCurve) -> Iterator[str]:
    """A note for each end that the touches leave more uncertain than `DRAWN_OUT` times their scatter."""
    for end, s in (("start", 0.0), ("end", curve.length_mm)):
        u = float(curve.standard_deviation_mm(s)[0])
        if u > DRAWN_OUT * curve.scatter_mm:
            yield (
                f"{curve.feature}: drawn out beyond its touches, the curve is uncertain by {u * UM_PER_MM:.1f} µm "
                f"(standard uncertainty) at its {end}; a touch nearer to it would tell"
            )


def _share(conditions: EndConditions, k: int, features: int) -> EndConditions:
    """The conditions of a chain that stand at the ends of its k-th feature."""
    first, last = k == 0, k == features - 1
    return EndConditions(
        conditions.start_value_mm if first else None,
        conditions.start_slope if first else None,
        conditions.end_value_mm if last else None,
        conditions.end_slope if last else None,
    )


def _by_touch(count: int, fitted: FittedChains) -> tuple[Array, Array]:
    residual, left_out = np.full(count, np.nan), np.full(count, np.nan)
    for fit in fitted.fits:
        residual[fit.touches] = fit.residual_mm
        left_out[fit.touches] = fit.leave_one_out_mm
    return residual, left_out


def _rms_of_known(values: Array) -> float:
    return rms(values[~np.isnan(values)])
