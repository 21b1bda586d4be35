"""What the finish cut is expected to leave at the gauging points. A prediction, not a measurement."""

from dataclasses import dataclass

import numpy as np

from trueloop.geometry.feature import Array


@dataclass(frozen=True)
class Prediction:
    """Part errors at the touches, all (n,), mm, positive = material left on.

    `before_mm` was measured. `after_mm` = process error − w · fitted process error. `leave_one_out_mm` is the same with
    each touch's own reading kept out of the fit: what an untouched point may expect. `standard_u_mm` is the standard
    uncertainty of the next cut's error: curve, gauging and process repeatability together.
    """

    before_mm: Array
    after_mm: Array
    leave_one_out_mm: Array
    standard_u_mm: Array


def predict(
    error_mm: Array, fitted_mm: Array, left_out_fitted_mm: Array, commanded_mm: Array, curve_u_mm: Array,
    sigma_mm: Array, weight: float,
) -> Prediction:  # fmt: skip
    """Residual of w times the fitted process error; the commanded deviation is no error of the process."""
    process = error_mm - commanded_mm
    return Prediction(
        before_mm=error_mm,
        after_mm=process - weight * (fitted_mm - commanded_mm),
        leave_one_out_mm=process - weight * (left_out_fitted_mm - commanded_mm),
        standard_u_mm=np.hypot(weight * curve_u_mm, sigma_mm),
    )


def rms(values: Array) -> float:
    """Root mean square; nan of nothing."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")
