"""The expected error of the finish cut at the gauging points. A prediction, not a measurement."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.turned.compensation.contour import CentrePiece
from trueloop.turned.error_curve.curve import Budget


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
    measured_mm: Array, process_mm: Array, fitted_mm: Array, left_out_fitted_mm: Array, budget: Budget, weight: float
) -> Prediction:
    """Predicts the process error less w times its fit. The semi-finish program's own deviation does not count."""
    return Prediction(
        before_mm=measured_mm,
        after_mm=process_mm - weight * fitted_mm,
        leave_one_out_mm=process_mm - weight * left_out_fitted_mm,
        budget=budget,
    )


STEP_MM = 0.25


@by_content
@dataclass(frozen=True)
class CorrectionTable:
    """Rows in cutting order, chuck end to free end: where the program sends the nose centre, and what to add there.

    `commanded_mm` and `correction_mm` are (n, 2) in (x as a radius, z). Between rows the correction is linear.
    """

    feature: tuple[str, ...]
    commanded_mm: Array
    correction_mm: Array


def correction_table(
    commanded: Sequence[CentrePiece], corrected: Sequence[CentrePiece], offset_mm: tuple[float, float] = (0.0, 0.0)
) -> CorrectionTable:
    """Tabulates both paths feature by feature at equal shares of each, so that corners go to corners.

    `offset_mm` (x as a radius, z) is what a tool offset moves the corrected path by, everywhere: who corrects in real
    time by the table does not change the offset too.

    Valid for small corrections: a row's share differs from the foot of the normal by the tangential shift of the
    corners, micrometres on features of millimetres.
    """
    names: list[str] = []
    positions: list[Array] = []
    corrections: list[Array] = []
    for before, after in zip(commanded, corrected, strict=True):
        count = max(2, int(np.ceil((before.end_mm - before.start_mm) / STEP_MM)) + 1)
        position = before.shifted.centre_mm(np.linspace(before.start_mm, before.end_mm, count))
        names += [before.shifted.feature.name] * count
        positions.append(position)
        corrections.append(after.shifted.centre_mm(np.linspace(after.start_mm, after.end_mm, count)) - position)
    return CorrectionTable(tuple(names), np.concatenate(positions), np.concatenate(corrections) + offset_mm)
