"""Errors expected after a correction, touched or not, their uncertainty, and the errors an inspection measured."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.life import Cut
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.made_parts import program_that_ran
from trueloop.loops.turned.paths import Shifts
from trueloop.statistics import rms
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.compensation.shift import unasked_u_mm
from trueloop.turned.compensation.targets import Prediction, predict
from trueloop.turned.error_curve.curve import Budget, joined
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.fit.between_cuts import BetweenCuts
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording


def prediction_at_touches(
    touches: ErrorVectors,
    model: ProfileErrorModel,
    decision: Decision,
    shifts: Shifts,
    weight: float,
    not_kept_mm: Array,
) -> Prediction:
    """Predicts the errors left by the chosen correction: a curve where the contour moves, a constant where an offset
    does.

    The constant comes from all touches together, so that it is known better than a curve and has an uncertainty of its
    own. `not_kept_mm` (n,) is what of a correction in force is given up by an offset in its place. A touch left out as
    bad says nothing of the part: there, the error is what was fitted. Where earlier parts tell the next cut, its error
    had nothing been corrected is what they and the touches say, not what was touched.
    """
    left_out_as_bad = model.weight == 0.0
    fitted = model.vectors.error_mm - model.residual_mm
    process = expected_uncorrected_mm(model)
    left_out = process - np.where(left_out_as_bad, 0.0, model.leave_one_out_mm)
    constant = (not_kept_mm - np.asarray(touches.outward_normal @ np.array(decision.offset_mm))) / weight
    leverage = decision.leverage(touches.outward_normal, model.touch_sigma_mm(touches))
    without = process - (process - constant) / np.where(leverage < 1.0 - 1e-9, 1.0 - leverage, np.nan)
    by_offset = np.array(shifts.by_offset)[touches.feature_index]
    gain = np.array([curve.gain for curve in model.curves])[touches.feature_index]
    return predict(
        measured_mm=touches.error_mm,
        process_mm=process,
        fitted_mm=gain * np.where(by_offset, constant, fitted),
        left_out_fitted_mm=gain * np.where(by_offset, without, left_out),
        budget=joined([_budget(touches, model, shifts, decision, i) for i in range(len(model.curves))]),
        weight=weight,
    )


def expected_uncorrected_mm(model: ProfileErrorModel) -> Array:
    """Errors of the next cut at the touches had nothing been corrected, of the process, (n,)."""
    error_mm = model.vectors.error_mm
    return model.as_told(np.where(model.weight == 0.0, error_mm - model.residual_mm, error_mm))


def _budget(touches: ErrorVectors, model: ProfileErrorModel, shifts: Shifts, decision: Decision, index: int) -> Budget:
    """Uncertainties at the touches of one feature."""
    offset, touch_mm = decision.variance(touches.outward_normal), decision.touch_mm
    rows, curve = touches.of_feature(index), model.curves[index]
    s = touches.arc_length_mm[rows]
    unasked = unasked_u_mm(shifts.unasked[index], s)
    if shifts.by_offset[index] and curve.next_cut is None:
        # What the offset leaves at a touch that is vaguer than the best ones is known as its gauge measures; the touch
        # has a share in the offset.
        of_offset = offset[rows] * (touch_mm or curve.scatter_mm) ** 2
        sigma_mm = model.touch_sigma_mm(touches)
        own = np.maximum(1.0 - 2.0 * decision.leverage(touches.outward_normal, sigma_mm)[rows], 0.0)
        vaguer_mm2 = np.maximum(touches.standard_u_mm[rows] ** 2 - touch_mm**2, 0.0)
        left_u_mm = np.sqrt(of_offset + own * vaguer_mm2)
        return curve.budget_of(left_u_mm, s).with_more(unasked)
    return curve.budget(s).with_more(unasked)


PLACES: Final = 33
"""Places along a feature without a touch at which its outcome is looked at."""

EARLIER_PARTS: Final = "earlier parts"
"""The cause that stands where a next cut is predicted from earlier parts of the edge."""


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
    """Returns one outcome for each feature of the profile, in its order."""
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
    """Returns the error that the correction is expected to leave along feature `index`, (n,)."""
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
    """Returns the standard uncertainties at the first place of a budget, µm, by cause."""
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
    """Describes the assumed difference of the two cuts, its source, and how to state another."""
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


@dataclass(frozen=True)
class Obtained:
    """The expected against the measured errors at the inspected places on arcs of one part.

    `predicted_mm` is the RMS that errors have on average whose expected values and standard uncertainties are those of
    the prediction, √mean(e² + u²); `found_mm` that of the errors found. `inside` of `places` errors found differ
    from the expected one by at most U (95 %), in which the uncertainty of the inspection has no part.
    """

    serial: str
    predicted_mm: float
    found_mm: float
    inside: int
    places: int

    @property
    def words(self) -> str:
        """Describes it in one line."""
        predicted, found = Um(self.predicted_mm), Um(self.found_mm)
        return (
            f"{self.serial}: predicted {predicted} RMS, obtained {found} RMS; {self.inside} of {self.places} inside ±U"
        )

    @property
    def as_dict(self) -> dict[str, object]:
        """Returns it for machines, µm."""
        um = {"predicted_rms_um": self.predicted_mm * UM_PER_MM, "obtained_rms_um": self.found_mm * UM_PER_MM}
        return {"serial": self.serial, **um, "inside": self.inside, "places": self.places}


def obtained(correction: Correction, cut: Cut, vectors: ErrorVectors) -> Obtained | None:
    """Compares the errors measured by an inspection with those that the correction predicted.

    None without a place, and where another program ran than the one that the prediction is of. A place whose
    error is zero by definition, because z was taken from it, is left out. Raises STO-PROGRAM.
    """
    rows = np.flatnonzero(~vectors.at_reference)
    if len(rows) == 0 or program_that_ran(correction, cut) is not correction.recommended:
        return None
    at = vectors.chosen(rows)
    # The expected error, its standard uncertainty and U at places, each (n,)
    promised = np.empty((3, len(at.point)))
    for index in np.unique(at.feature_index):
        own_rows, s = at.of_feature(index), at.arc_length_mm[at.of_feature(index)]
        budget = correction.next_cut(index, s)
        promised[:, own_rows] = expected_mm(correction, index, s), budget.standard_u_mm, budget.expanded_u_mm
    expected, standard_u, expanded_u = promised[0], promised[1], promised[2]
    return Obtained(
        cut.part.serial,
        rms(np.hypot(expected, standard_u)),
        rms(at.error_mm),
        int(np.count_nonzero(np.abs(at.error_mm - expected) <= expanded_u)),
        len(rows),
    )
