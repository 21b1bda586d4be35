"""Least squares of the errors of one feature, with what is neither form nor noise of the device."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import brentq

from trueloop.arrays import Array, by_content

FEWEST_SPARE: Final = 2
"""Residuals that a scatter is taken from: one alone would be enlarged by anything from nothing to 1000 %."""


@by_content
@dataclass(frozen=True)
class Fitted:
    """Coefficients (k,) with their covariance (k, k), in units of the columns.

    `scatter_mm` is the standard deviation of points beyond what the device states, of `spare` residuals.
    `degrees_of_freedom` are those of the covariance; None: it is as known as the stated uncertainties.
    """

    coefficients: Array
    covariance: Array
    scatter_mm: float
    spare: int
    degrees_of_freedom: int | None

    def of(self, row: Array) -> tuple[float, float]:
        """A linear combination of the coefficients, and its standard uncertainty."""
        return float(row @ self.coefficients), float(np.sqrt(row @ self.covariance @ row))


def fitted(columns: Array, error_mm: Array, u_mm: Array, scatter_mm: float | None = None) -> Fitted:
    """Least squares of columns (m, k) with weights 1/(u² + τ²).

    τ is `scatter_mm`, or is chosen so that Σ r²/(u² + τ²) equals the number of residuals to spare [Mandel, Paule 1970],
    and 0 where u alone explains them or fewer than `FEWEST_SPARE` are. Points are taken as independent. With τ above 0
    the covariance has as many degrees of freedom as residuals to spare.
    """
    spare = columns.shape[0] - columns.shape[1]
    tau = _scatter_mm(columns, error_mm, u_mm, spare) if scatter_mm is None else scatter_mm
    coefficients, covariance, _ = _weighted(columns, error_mm, np.hypot(u_mm, tau))
    return Fitted(coefficients, covariance, tau, spare, spare if tau > 0.0 else None)


def _scatter_mm(columns: Array, error_mm: Array, u_mm: Array, spare: int) -> float:
    if spare < FEWEST_SPARE:
        return 0.0

    def too_large(variance: float) -> float:
        return _weighted(columns, error_mm, np.sqrt(u_mm**2 + variance))[2] - spare

    if too_large(0.0) <= 0.0:
        return 0.0
    # weights that are all alike leave no less than these squares, so that the root lies below
    most = _weighted(columns, error_mm, np.ones_like(u_mm))[2] / spare
    return float(np.sqrt(brentq(too_large, 0.0, most, rtol=1e-9)))


def _weighted(columns: Array, error_mm: Array, u_mm: Array) -> tuple[Array, Array, float]:
    """Coefficients, their covariance and χ²."""
    inverse = np.linalg.pinv(columns / u_mm[:, None])
    coefficients = inverse @ (error_mm / u_mm)
    residual = (error_mm - columns @ coefficients) / u_mm
    return coefficients, inverse @ inverse.T, float(residual @ residual)
