"""Moran's I and Geary's C: whether values scatter without regard to where they are.

Weights fall with distance, c = d^-k [MPM Eq. 3], none for a point with itself. I near its expectation means spatial
randomness; above it, neighbours resemble each other.
"""

from dataclasses import dataclass

import numpy as np

from trueloop._core import pair_sums, weights_product
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array

EXPONENT = 3.0
"""k of [MPM §4]: 4 made the test too insensitive to machining errors."""


@dataclass(frozen=True)
class SpatialStatistics:
    """Moran's I = (n/S0) Σ c zᵢ zⱼ / Σ z² [MPM Eq. 2] and Geary's C = (n − 1) Σ c (zᵢ − zⱼ)² / (2 S0 Σ z²), for z the
    values less their mean; S0 is the sum of all weights, `squares` that of their squares.
    """

    moran_i: float
    geary_c: float
    weights: float
    squares: float


@dataclass(frozen=True)
class Null:
    """Expectation and standard deviation of Moran's I where nothing but chance is at work."""

    expected: float
    deviation: float

    def p_value(self, moran_i: float) -> float:
        """Probability of an I at least as large, from the normal law that I approaches."""
        from scipy.special import ndtr  # slow to import

        return float(ndtr((self.expected - moran_i) / self.deviation))


def spatial_statistics(points_mm: Array, values: Array, exponent: float = EXPONENT) -> SpatialStatistics:
    """Both statistics for values (n,) at points (n, 3). Coincident points have no weight.

    Memory grows with n, time with n². Raises SRF-MODEL for fewer than four points, values that are all the same, or
    an exponent that is not positive.
    """
    points, z = _checked(points_mm, values, exponent)
    n = len(z)
    weights, squares, products, differences = pair_sums(points, z, exponent)
    total = float(z @ z)
    return SpatialStatistics(
        n * products / (weights * total), (n - 1) * differences / (2 * weights * total), weights, squares
    )


def raw_null(points_mm: Array, exponent: float = EXPONENT) -> Null:
    """Moments of I for independent normal values about one unknown mean (Cliff & Ord 1981): not for residuals.

    E = −1/(n − 1); E[I²] = (n² S1 − n S2 + 3 S0²) / ((n² − 1) S0²), S1 = 2 Σ c², S2 = Σᵢ (2 Σⱼ c)².
    """
    points = np.ascontiguousarray(points_mm, float)
    n = len(points)
    _, squares, _, _ = pair_sums(points, np.zeros(n), exponent)
    rows, _ = weights_product(points, np.empty((n, 0)), exponent)
    s0, s1, s2 = float(np.sum(rows)), 2 * squares, float(np.sum((2 * rows) ** 2))
    expected = -1.0 / (n - 1)
    second = (n * n * s1 - n * s2 + 3 * s0 * s0) / ((n * n - 1.0) * s0 * s0)
    return Null(expected, float(np.sqrt(second - expected**2)))


def _checked(points_mm: Array, values: Array, exponent: float) -> tuple[Array, Array]:
    points, z = np.ascontiguousarray(points_mm, float), np.asarray(values, float)
    z = z - np.mean(z)
    if len(z) < 4 or points.shape != (len(z), 3) or not exponent > 0 or not z @ z > 0:
        raise TrueloopError(
            Code.SRF_MODEL,
            f"{len(z)} values at points of shape {points.shape}, weights d^-{exponent:g}, scatter {np.ptp(z):g} mm: "
            f"nothing to correlate",
            hint="give at least four points with different values, and a positive exponent",
        )
    return points, z
