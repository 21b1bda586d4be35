"""The expected error of the finish cut at the gauging points. A prediction, not a measurement."""

from dataclasses import dataclass

from trueloop.arrays import Array, by_content
from trueloop.turned.error_curve.budget import Budget


@by_content
@dataclass(frozen=True)
class Prediction:
    """Part errors at the touches, all (n,), mm, positive = material left on.

    `before_mm` was measured. `after_mm` = process error − w · fitted process error. `leave_one_out_mm` is the same with
    each touch's own reading kept out of the fit: what an untouched point may expect. `budget` is the
    uncertainty of the next cut's error about `after_mm`.
    """

    before_mm: Array
    after_mm: Array
    leave_one_out_mm: Array
    budget: Budget

    @property
    def standard_u_mm(self) -> Array:
        """Returns the standard uncertainty of the next cut's error, all causes together, (n,)."""
        return self.budget.standard_u_mm

    @property
    def expanded_u_mm(self) -> Array:
        """Returns the half width of the band that holds the next cut's error with 95 %, (n,)."""
        return self.budget.expanded_u_mm


def predict(
    measured_mm: Array,
    process_mm: Array,
    fitted_mm: Array,
    left_out_fitted_mm: Array,
    budget: Budget,
    weight: float,
) -> Prediction:
    """Predicts the process error less w times its fit. The deviation commanded by the semi-finish program is no process
    error.
    """
    return Prediction(
        before_mm=measured_mm,
        after_mm=process_mm - weight * fitted_mm,
        leave_one_out_mm=process_mm - weight * left_out_fitted_mm,
        budget=budget,
    )
