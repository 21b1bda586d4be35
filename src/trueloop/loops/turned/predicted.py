"""What the correction is expected to leave at the touches, and how sure that is."""

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.shifts import Shifts
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.compensation.lean import unasked_u_mm
from trueloop.turned.compensation.prediction import Prediction, predict
from trueloop.turned.error_curve.budget import Budget, joined
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.touches.error_vectors import ErrorVectors


def prediction_at_touches(
    touches: ErrorVectors,
    model: ProfileErrorModel,
    decision: Decision,
    shifts: Shifts,
    weight: float,
    not_kept_mm: Array,
) -> Prediction:
    """What the correction that was chosen leaves: a curve where the contour moves, a constant where an offset does.

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
    leverage = decision.leverage(touches.outward_normal)
    without = process - (process - constant) / np.where(leverage < 1.0 - 1e-9, 1.0 - leverage, np.nan)
    by_offset = np.array(shifts.by_offset)[touches.feature_index]
    gain = np.array([curve.gain for curve in model.curves])[touches.feature_index]
    return predict(
        measured_mm=touches.error_mm,
        process_mm=process,
        fitted_mm=gain * np.where(by_offset, constant, fitted),
        left_out_fitted_mm=gain * np.where(by_offset, without, left_out),
        budget=joined(
            [
                _budget(touches, model, shifts, decision.variance(touches.outward_normal), i)
                for i in range(len(model.curves))
            ]
        ),
        weight=weight,
    )


def expected_uncorrected_mm(model: ProfileErrorModel) -> Array:
    """Errors of the next cut at the touches had nothing been corrected, of the process, (n,)."""
    error_mm = model.vectors.error_mm
    return model.as_told(np.where(model.weight == 0.0, error_mm - model.residual_mm, error_mm))


def _budget(touches: ErrorVectors, model: ProfileErrorModel, shifts: Shifts, offset: Array, index: int) -> Budget:
    """Uncertainties at the touches of one feature; `offset` (n,) the constant's variance per unit of a touch's."""
    rows, curve = touches.of_feature(index), model.curves[index]
    s = touches.arc_length_mm[rows]
    unasked = unasked_u_mm(shifts.unasked[index], s)
    if shifts.by_offset[index] and curve.next_cut is None:
        return curve.budget_of(np.sqrt(offset[rows]) * curve.scatter_mm, s).with_more(unasked)
    return curve.budget(s).with_more(unasked)
