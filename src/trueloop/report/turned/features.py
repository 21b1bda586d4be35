"""Every feature of a corrected part in figures and a few words: what the page, the terminal and JSON show of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import Outcome, causes_um, outcomes
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.statistics import rms
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

STAYS_MM = 5e-5
"""A cut that moves by less stays where it is."""


@dataclass(frozen=True)
class TouchFigures:
    """Errors at some touches in µm: RMS and the value of largest size; `nan` of no touch.

    Before: measured. Predicted: after the corrected cut. Left out: each touch predicted from all others.
    """

    touches: int
    before_rms_um: float
    before_worst_um: float
    predicted_rms_um: float
    predicted_worst_um: float
    left_out_rms_um: float


@dataclass(frozen=True)
class FeatureSummary:
    """One feature: its touches, and what it is expected to come out like, touched or not.

    `expected_um` is the expected error of largest size and `expanded_u_um` the largest expanded uncertainty, at the
    feature's touches or, without any, along it; `standard_u_um` what makes that up, by cause. `correction` and
    `expected` say in words how the feature is corrected and what to expect.
    """

    feature: str
    figures: TouchFigures
    correction: str
    expected_um: float
    expanded_u_um: float
    expected: str
    standard_u_um: dict[str, float]


def feature_summaries(correction: Correction, say: Texts = ENGLISH) -> list[FeatureSummary]:
    """One for each feature of the profile, in its order.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> for feature in trueloop.feature_summaries(trueloop.compensate(job.inputs))[-3:]:
    ...     print(feature.feature, feature.expected)
    main-face 0.0 ± 7.9 µm
    small-cylinder 0.0 ± 7.9 µm
    dome +2.9 ± 8.1 µm
    """
    return [_summary(correction, outcome, say) for outcome in outcomes(correction)]


def _summary(correction: Correction, outcome: Outcome, say: Texts) -> FeatureSummary:
    return FeatureSummary(
        feature=correction.profile.names[outcome.index],
        figures=touch_figures(correction, correction.touches.of_feature(outcome.index)),
        correction=say.note(kind_of_correction(correction, outcome.index)),
        expected_um=outcome.expected_mm * UM_PER_MM,
        expanded_u_um=outcome.expanded_u_mm * UM_PER_MM,
        expected=_expected_words(correction, outcome, say),
        standard_u_um=causes_um(outcome.budget),
    )


def touch_figures(correction: Correction, rows: NDArray[np.intp]) -> TouchFigures:
    """Computes the figures of the touches at these positions."""
    prediction = correction.prediction
    before, after, left_out = (
        values[rows] * UM_PER_MM for values in (prediction.before_mm, prediction.after_mm, prediction.leave_one_out_mm)
    )
    known = left_out[np.isfinite(left_out)]
    return TouchFigures(
        touches=len(rows),
        before_rms_um=rms(before),
        before_worst_um=worst_of(before),
        predicted_rms_um=rms(after),
        predicted_worst_um=worst_of(after),
        left_out_rms_um=rms(known),
    )


def worst_of(values: Array) -> float:
    """Returns the value of largest size, with its sign; nan of nothing."""
    return float(values[np.argmax(np.abs(values))]) if len(values) else float("nan")


def kind_of_correction(correction: Correction, index: int) -> str:
    """Describes in a few words how a feature's error is described and corrected."""
    curve = correction.model.curves[index]
    touches = len(correction.touches.of_feature(index))
    if _is_left(correction, index):
        return wording("not touched: left as programmed")
    if correction.by_offset[index]:
        return wording("constant offset")
    if curve.from_memory:
        return wording("by earlier parts and {n} touches", n=touches)
    return _shape_words(curve, touches)


def _shape_words(curve: ErrorCurve, touches: int) -> str:
    """The form of a curve through touches."""
    if touches == 0:
        return wording("not touched: estimated")
    if curve.spline.degree == 0:
        return wording("one touch: constant") if touches == 1 else wording("constant")
    if curve.spline.degree == 1:
        return wording("straight line: size and taper")
    knots = len(curve.knots_mm)
    shape = wording("parabola") if curve.spline.degree == 2 else wording("cubic spline")
    counted = wording("one knot") if knots == 1 else wording("{n} knots", n=knots)
    return wording("{curve}, {knots}", curve=shape, knots=counted)


def _expected_words(correction: Correction, outcome: Outcome, say: Texts) -> str:
    """Expected error and its expanded uncertainty; a feature that is left as programmed is called so."""
    u = say.size(outcome.expanded_u_mm * UM_PER_MM)
    if _is_left(correction, outcome.index):
        return say("left as programmed ± {u} {um}", u=u)
    return f"{say.error(outcome.expected_mm * UM_PER_MM)} ± {u} {say.um}"


def _is_left(correction: Correction, index: int) -> bool:
    """Returns True for a feature whose cut stays as programmed as its error is unknown: no offset moves it either."""
    feature = correction.profile.features[index]
    normals = feature.outward_normal(np.linspace(0.0, feature.length_mm, 17))
    moved = normals @ np.array(correction.decision.offset_mm) * correction.by_offset[index]
    return correction.model.curves[index].unsupported and bool(np.max(np.abs(moved)) < STAYS_MM)
