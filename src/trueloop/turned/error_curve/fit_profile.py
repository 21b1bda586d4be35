"""From error vectors to the error model of a whole profile.

Error vectors that no curve can be fitted to, and options that fit no profile.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from functools import cache, partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from trueloop.arrays import Array, by_content
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.statistics import rms
from trueloop.turned.error_curve.bad_touches import SuspectTouch, suspect_touches
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.turned.error_curve.junctions import DisplacedJunction, Tangency, displaced_junctions, tangencies
from trueloop.turned.error_curve.uncertainty import FittedChains, finish, with_likeness
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.fit_chains import ModelChoice, NoseOnPart, fit_chains, nose_on_part
from trueloop.turned.fit.nose_fit import NoseModel
from trueloop.turned.fit.options import BadTouches, FitOptions
from trueloop.turned.fit.prior.part_state import part_state
from trueloop.turned.fit.prior.remembered_fit import Remembered
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

DRAWN_OUT: Final = 3.0
"""An end that is this many times as uncertain as a single touch is worth a warning."""


@by_content
@dataclass(frozen=True)
class ProfileErrorModel:
    """The error curves of all features, and their uncertainties. Positive = material left on; lengths in mm.

    `curves` and the RMS values go by feature index, `residual_mm` (error − curve: what a full correction would have
    left) and `leave_one_out_mm` (error − what the other touches say there; NaN where they say nothing) by touch. RMS
    values are over the touches with weight, NaN for features without one they could be taken from. `weight` is 1, and 0
    for touches left out as bad, whose `leave_one_out_mm` is their residual; `suspects` name those that the others
    contradict (`bad_touches`). `scatter_mm` is the largest standard deviation of a touch about its curve, known with
    `degrees_of_freedom` spare touches. `correlation` (k, k) is that of the scatter of touches that lie close, at the
    positions `correlated` (k,), its diagonal above 1 where they show less of it; all others are independent. `notes`
    explain every decision; `choices` compares own curve and nose model where a nose model was given.
    """

    profile: Profile
    vectors: ErrorVectors
    options: FitOptions
    curves: tuple[ErrorCurve, ...]
    residual_mm: Array
    leave_one_out_mm: Array
    weight: Array
    suspects: tuple[SuspectTouch, ...]
    residual_rms_mm: Array
    leave_one_out_rms_mm: Array
    junctions: tuple[DisplacedJunction, ...]
    tangency: tuple[Tangency, ...]
    scatter_mm: float
    degrees_of_freedom: int
    correlation: Array
    notes: tuple[str, ...]
    choices: tuple[ModelChoice, ...]
    correlated: NDArray[np.intp] | None = None
    """None of a model that was stored before there was this: all touches."""
    residual_scatter_mm: float | None = None
    """Standard deviation of all touches about their curves, pooled, from residuals alone: 0 without one to spare."""

    def touch_sigma_mm(self, vectors: ErrorVectors) -> Array:
        """Returns the standard deviations (n,) of touches: their scatter, and no less than their own uncertainty."""
        least = self.scatter_mm if self.residual_scatter_mm is None else self.residual_scatter_mm
        return np.maximum(least, vectors.standard_u_mm)

    def as_told(self, error_mm: Array) -> Array:
        """Errors at the touches, (n,), with the next cut's had nothing been corrected, by earlier parts."""
        expected = error_mm.copy()
        for index, curve in enumerate(self.curves):
            if curve.next_cut is not None:
                rows = self.vectors.of_feature(index)
                expected[rows] = curve.expected_mm(self.vectors.arc_length_mm[rows])
        return expected

    @property
    def farthest_words(self) -> str:
        """Describes the touch with weight that is farthest from the prediction of the others there."""
        off = np.where(np.isnan(self.leave_one_out_mm), self.residual_mm, self.leave_one_out_mm)
        k = int(np.argmax(np.abs(off) * self.weight))
        error_um, expected_um = UM_PER_MM * self.vectors.error_mm[k], UM_PER_MM * (self.vectors.error_mm[k] - off[k])
        return (
            f"farthest off is touch {self.vectors.point[k]} on {self.profile.names[self.vectors.feature_index[k]]}: "
            f"{error_um:+.1f} µm, where the others predict {expected_um:+.1f} µm"
        )


def fit_profile(
    profile: Profile,
    vectors: ErrorVectors,
    options: FitOptions | None = None,
    nose: NoseModel | None = None,
    remembered: Remembered | None = None,
) -> ProfileErrorModel:
    """Fits straight lines on lines, constrained cubic splines on arcs, joined at the junctions [6517 §2–4, 6811 §3].

    Features without a touch have what all touches and readings together show (module `prior.from_state`); one touch
    gives a constant. Curves are fitted with equal weights: the scatter of the cut (about 1 µm)
    hides the differences of the touches' own uncertainty. With a nose model from other parts, each arc gets whichever
    of the two predicts its touches better, left out one at a time. Arcs of which earlier parts of the edge tell enough
    have their curves from there (module `remembered`), with these touches among what is known. Touches that are bad
    beyond doubt are left out, and all suspect ones named (module `bad_touches`). Raises FIT errors; `tests/errors` has
    one of each.
    """
    options = options or FitOptions()
    check_options(profile, options)
    check_vectors(profile, vectors)
    suspects = suspect_touches(profile, vectors, options) if options.bad_touches == BadTouches.LEAVE_OUT else ()
    kept = np.setdiff1d(np.arange(len(vectors.point)), [suspect.position for suspect in suspects if suspect.left_out])
    good = vectors if len(kept) == len(vectors.point) else vectors.chosen(kept)
    on_part, unused = _nose(profile, good, nose)
    state = cache(partial(part_state, profile, good))
    fits, choices = fit_chains(profile, good, options, on_part, state, remembered=remembered)
    fitted = with_likeness(finish(fits, good), good, options.alike_over_mm)
    free = fitted
    if options.junctions == TangentPolicy.PATH:
        with_kinks = replace(options, junctions=TangentPolicy.PART)
        free = finish(fit_chains(profile, good, with_kinks, on_part, state, remembered=remembered)[0], good)
    curves = tuple(_curves(profile, good, fitted, options))
    drawn_out = [note for i, curve in enumerate(curves) if len(vectors.of_feature(i)) for note in _drawn_out(curve)]
    residual, left_out = _by_touch(vectors, curves, kept, fitted)
    close = [i for i in fitted.touches_mm2 if fitted.scatter_mm[i] > 0.0]
    groups = [kept[good.of_feature(i)] for i in range(len(profile.features))]
    return ProfileErrorModel(
        profile=profile,
        vectors=vectors,
        options=options,
        curves=curves,
        residual_mm=residual,
        leave_one_out_mm=left_out,
        weight=np.isin(np.arange(len(vectors.point)), kept).astype(np.float64),
        suspects=suspects,
        residual_rms_mm=np.array([_rms_of_known(residual[group]) for group in groups]),
        leave_one_out_rms_mm=np.array([_rms_of_known(left_out[group]) for group in groups]),
        junctions=displaced_junctions(profile, curves),
        tangency=tangencies(profile, free, options.junctions),
        scatter_mm=max(fitted.scatter_mm.values()),
        degrees_of_freedom=fitted.degrees_of_freedom,
        correlation=block_diag(np.zeros((0, 0)), *(fitted.touches_mm2[i] / fitted.scatter_mm[i] ** 2 for i in close)),
        notes=(*unused, *(note for fit in fitted.fits.values() for note in fit.notes), *drawn_out),
        choices=choices,
        correlated=np.concatenate([np.zeros(0, dtype=np.intp), *(kept[fitted.fits[i].touches] for i in close)]),
        residual_scatter_mm=fitted.residual_mm,
    )


def _nose(profile: Profile, vectors: ErrorVectors, nose: NoseModel | None) -> tuple[NoseOnPart | None, tuple[str, ...]]:
    """Returns the nose model on this part, or a note why it does not serve."""
    if nose is None:
        return None, ()
    try:
        return nose_on_part(profile, vectors, nose), ()
    except TrueloopError as refusal:
        return None, (wording("the nose model of other parts does not serve: {why}", why=refusal.message),)


def _curves(profile: Profile, vectors: ErrorVectors, fitted: FittedChains, options: FitOptions) -> Iterator[ErrorCurve]:
    process = fitted.process_mm
    for i, fit in fitted.fits.items():
        scatter, within = fitted.scatter_mm[i], options.repeatability_mm
        if within is None:
            within = scatter if process is None else process
        probe = vectors.own_u_mm[fit.touches] if len(fit.touches) else vectors.own_u_mm
        for k, index in enumerate(fit.chain.features):
            yield ErrorCurve(
                feature=profile.features[index].name,
                length_mm=profile.features[index].length_mm,
                spline=fitted.splines[i],
                start_mm=fit.chain.starts_mm[k],
                conditions=_share(fit.fit.conditions, k, len(fit.chain.features)),
                knot_every=fit.knot_every[k],
                scatter_mm=scatter,
                repeatability_mm=within,
                reference=None if fitted.reference is None else fitted.reference[i],
                between_cuts=options.between_cuts,
                probe_share=min(rms(probe) / scatter, 1.0) ** 2 if scatter > 0.0 else 0.0,
                touches=len(fit.touches),
                unsupported=fit.unsupported,
                degrees_of_freedom=fitted.degrees_of_freedom or None,
                notes=fit.notes,
                next_cut=fit.next_cut,
                from_memory=fit.scattered is not None,
            )


def _drawn_out(curve: ErrorCurve) -> Iterator[str]:
    """Yields a note for each end that the touches leave more uncertain than `DRAWN_OUT` times their scatter."""
    for end, s in ((wording("start"), 0.0), (wording("end"), curve.length_mm)):
        u = float(curve.standard_deviation_mm(s)[0])
        if curve.next_cut is None and u > DRAWN_OUT * curve.scatter_mm:
            yield wording(
                "{feature}: drawn out beyond its touches, the curve is uncertain by {u} (standard uncertainty) at its "
                "{end}; a touch nearer to it would tell",
                feature=curve.feature,
                u=Um(u),
                end=end,
            )


def _share(conditions: EndConditions, k: int, features: int) -> EndConditions:
    """Returns the conditions of a chain that stand at the ends of its k-th feature."""
    first, last = k == 0, k == features - 1
    return EndConditions(
        conditions.start_value_mm if first else None,
        conditions.start_slope if first else None,
        conditions.end_value_mm if last else None,
        conditions.end_slope if last else None,
    )


def _by_touch(
    vectors: ErrorVectors, curves: Sequence[ErrorCurve], kept: NDArray[np.intp], fitted: FittedChains
) -> tuple[Array, Array]:
    """Returns errors about the curves and about the others' predictions, of all touches; `fitted`: the kept ones."""
    residual, left_out = np.empty(len(vectors.point)), np.empty(len(vectors.point))
    for k in np.setdiff1d(np.arange(len(vectors.point)), kept):
        curve = curves[vectors.feature_index[k]]
        residual[k] = left_out[k] = vectors.error_mm[k] - curve.value_mm(vectors.arc_length_mm[k])[0]
    for fit in fitted.fits.values():
        residual[kept[fit.touches]] = fit.residual_mm
        left_out[kept[fit.touches]] = fit.leave_one_out_mm
    return residual, left_out


def _rms_of_known(values: Array) -> float:
    return rms(values[~np.isnan(values)])


def check_vectors(profile: Profile, vectors: ErrorVectors) -> None:
    """Refuses error vectors that no curve can be fitted to."""
    if len(vectors.point) == 0:
        raise Code.FIT_POINTS.refusal(
            f"0 touches on the {len(profile.features)} features of the part: there is nothing to fit",
            hint="touch at least one point",
            values={"touches": 0},
        )
    numbers = np.column_stack([vectors.arc_length_mm, vectors.error_mm, vectors.standard_u_mm])
    bad = ~np.all(np.isfinite(numbers), axis=1) | (vectors.standard_u_mm < 0.0)
    if np.any(bad):
        k = int(np.argmax(bad))
        raise Code.FIT_VALUE.refusal(
            f"touch {vectors.point[k]!r}: arc length {vectors.arc_length_mm[k]} mm, error {vectors.error_mm[k]} mm, "
            f"standard uncertainty {vectors.standard_u_mm[k]} mm; all must be numbers, the last not negative",
            hint="mend or leave out this touch",
        )
    _check_order(vectors)


def _check_order(vectors: ErrorVectors) -> None:
    """Touches of one feature ascend, and no two stand in one place."""
    for k in range(1, len(vectors.point)):
        step = vectors.arc_length_mm[k] - vectors.arc_length_mm[k - 1]
        if vectors.feature_index[k] == vectors.feature_index[k - 1] and step <= 0.0:
            raise Code.FIT_ORDER.refusal(
                f"touch {vectors.point[k]!r} at {vectors.arc_length_mm[k]:.4f} mm along its feature follows "
                f"{vectors.point[k - 1]!r} at {vectors.arc_length_mm[k - 1]:.4f} mm",
                hint="order touches along the profile and average those taken at one place",
                values={
                    "points": list(vectors.point[k - 1 : k + 1]),
                    "arc_length_mm": vectors.arc_length_mm[k - 1 : k + 1].tolist(),
                },
            )


def check_options(profile: Profile, options: FitOptions) -> None:
    """Refuses options for features that the part does not have, and numbers that are none."""
    for code, named in ((Code.FIT_KNOTS, options.knot_every_on), (Code.FIT_CONDITIONS, options.prescribed)):
        for name in named:
            if name not in profile.names:
                raise code.refusal(
                    f"the fit has an option for feature {name!r}, which the part does not have",
                    hint=f"the part's features are: {', '.join(profile.names)}",
                )
    for name, conditions in options.prescribed.items():
        given = [number for number in astuple(conditions) if number is not None]
        if not all(math.isfinite(number) for number in given):
            raise Code.FIT_CONDITIONS.refusal(
                f"{name!r}: the prescribed values and slopes are {given} mm or mm/mm, not all of them finite",
                hint="give numbers, or leave an end free",
            )
    between = options.between_cuts
    for words, value_mm in (
        ("process", options.repeatability_mm),
        ("whole cut", between.common_mm),
        ("cut along its contour", between.scatter_mm),
    ):
        if value_mm is not None and not 0.0 <= value_mm < math.inf:
            raise Code.FIT_VALUE.refusal(
                f"the repeatability of the {words} is given as {value_mm} mm",
                hint="a standard deviation is a number and not negative; leave it out to take the touches' scatter",
            )
    alike = options.alike_over_mm
    if alike is not None and not 0.0 <= alike < math.inf:
        raise Code.FIT_VALUE.refusal(
            f"the process is said to be alike over {alike} mm along a cut",
            hint="a length is a number and not negative; leave it out to take what the touches say",
        )
