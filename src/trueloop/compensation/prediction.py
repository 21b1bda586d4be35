"""What the finish cut is expected to leave at the gauging points. A prediction, not a measurement."""

from dataclasses import dataclass

from trueloop.error_curve.coverage import coverage_factor
from trueloop.geometry.feature import Array


@dataclass(frozen=True)
class Prediction:
    """Part errors at the touches, all (n,), mm, positive = material left on.

    `before_mm` was measured. `after_mm` = process error − w · fitted process error. `leave_one_out_mm` is the same with
    each touch's own reading kept out of the fit: what an untouched point may expect. `standard_u_mm` is the standard
    uncertainty of the next cut's error: curve, gauging and process repeatability together; `coverage_factor` times as
    much holds 95 %.
    """

    before_mm: Array
    after_mm: Array
    leave_one_out_mm: Array
    standard_u_mm: Array
    coverage_factor: float

    @property
    def expanded_u_mm(self) -> Array:
        """Half width of the band that holds the next cut's error with 95 %, (n,)."""
        return self.coverage_factor * self.standard_u_mm


def predict(
    measured_mm: Array,
    process_mm: Array,
    fitted_mm: Array,
    left_out_fitted_mm: Array,
    standard_u_mm: Array,
    weight: float,
    degrees_of_freedom: int | None = None,
) -> Prediction:
    """Process error less w times what was fitted to it. What the semi-finish program commanded is no process error.

    `degrees_of_freedom` are the spare touches that the standard uncertainty is known from; None: from gauging alone.
    """
    return Prediction(
        before_mm=measured_mm,
        after_mm=process_mm - weight * fitted_mm,
        leave_one_out_mm=process_mm - weight * left_out_fitted_mm,
        standard_u_mm=standard_u_mm,
        coverage_factor=coverage_factor(degrees_of_freedom),
    )
