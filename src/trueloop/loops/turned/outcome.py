"""What each feature is expected to come out like, touched or not, and how sure that is."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Correction
from trueloop.turned.error_curve.budget import Budget
from trueloop.turned.fit.between_cuts import BetweenCuts
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

PLACES: Final = 33
"""Places along a feature without a touch at which its outcome is looked at."""

EARLIER_PARTS: Final = "earlier parts"
"""The cause that stands where earlier parts of the edge tell a next cut."""


@dataclass(frozen=True)
class Outcome:
    """One feature after the corrected finish cut, mm, positive = material left on.

    `expected_mm` is the expected error of largest size, at a touch or, without touches, anywhere on the feature;
    `expanded_u_mm` the largest expanded uncertainty there (95 %), and `budget` what makes it up, at one place.
    """

    index: int
    touched: bool
    expected_mm: float
    expanded_u_mm: float
    budget: Budget


def outcomes(correction: Correction) -> tuple[Outcome, ...]:
    """One for each feature of the profile, in its order."""
    return tuple(_outcome(correction, index) for index in range(len(correction.profile.features)))


def _outcome(correction: Correction, index: int) -> Outcome:
    rows = correction.touches.of_feature(index)
    if len(rows):
        expected, budget = correction.prediction.after_mm[rows], correction.prediction.budget.at(rows)
    else:
        s = np.linspace(0.0, correction.profile.features[index].length_mm, PLACES)
        expected, budget = expected_mm(correction, index, s), correction.next_cut(index, s)
    u = budget.expanded_u_mm
    widest = int(np.argmax(u))
    return Outcome(
        index=index,
        touched=bool(len(rows)),
        expected_mm=float(expected[np.argmax(np.abs(expected))]),
        expanded_u_mm=float(u[widest]),
        budget=budget.at(np.array([widest])),
    )


def expected_mm(correction: Correction, index: int, arc_length_mm: Array) -> Array:
    """Error that the correction is expected to leave along feature `index`, (n,)."""
    curve = correction.model.curves[index]
    error = curve.expected_mm(arc_length_mm)
    if correction.by_offset[index]:
        normal = correction.profile.features[index].outward_normal(arc_length_mm)
        left = np.asarray(error + curve.gain * (normal @ np.array(correction.decision.offset_mm)))
        return left - correction.given_up_mm(index, arc_length_mm) if correction.decision.by_offset else left
    if curve.next_cut is not None:
        return error - correction.options.weight * curve.gain * curve.value_mm(arc_length_mm)
    return (1.0 - correction.options.weight) * error


def causes_um(budget: Budget) -> dict[str, float]:
    """Standard uncertainties at the first place of a budget, µm, by cause."""
    return {
        "probe": float(budget.probe_mm[0]) * UM_PER_MM,
        "curve": float(budget.curve_mm[0]) * UM_PER_MM,
        "process": float(budget.process_mm[0]) * UM_PER_MM,
        "between cuts (whole cut)": float(budget.common_mm[0]) * UM_PER_MM,
        "between cuts (along it)": float(budget.along_mm[0]) * UM_PER_MM,
        "no touch": float(budget.estimate_mm[0]) * UM_PER_MM,
        **({} if budget.memory_mm is None else {EARLIER_PARTS: float(budget.memory_mm[0]) * UM_PER_MM}),
    }


def between_cuts_words(between: BetweenCuts) -> str:
    """What is taken for the difference of the two cuts, where from, and how to say otherwise."""
    if between.difference_mm == 0.0:
        return wording("Between cuts: nothing; the bands hold for a finish cut that repeats the semi-finish cut.")
    return wording(
        "Between cuts: {source}, one standard deviation of {whole} that moves a whole cut and {along} that varies "
        "along it, for either cut ({both} between the two); `compensation.cut_to_cut_um` sets it, 0 switches it off.",
        source=between.source,
        whole=Um(between.common_mm, "g"),
        along=Um(between.scatter_mm, "g"),
        both=Um(between.difference_mm),
    )
