"""Moran's I and Geary's C: whether values scatter without regard to where they are.

Weights fall with distance, c = d^-k [MPM Eq. 3], none for a point with itself. I near its expectation means spatial
randomness; above it, neighbours resemble each other.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, for_kernel
from trueloop.errors import Code, TrueloopError
from trueloop.surface.separation.weights import Weights

EXPONENT = 3.0
"""k of [MPM §4]: 4 made the test too insensitive to machining errors."""


@dataclass(frozen=True)
class Null:
    """Expectation and standard deviation of Moran's I where nothing but chance is at work.

    `expected_error` is the standard error of the expectation where it was estimated, 0 where it is exact.
    """

    expected: float
    deviation: float
    expected_error: float = 0.0

    def p_value(self, moran_i: float) -> float:
        """Probability of an I at least as large, from the normal law that I approaches."""
        from scipy.special import ndtr  # slow to import

        return float(ndtr((self.expected - moran_i) / self.deviation))


def moran_i(points_mm: Array, values: Array, exponent: float = EXPONENT) -> float:
    """Moran's I = (n/S0) Σ c zᵢ zⱼ / Σ z² [MPM Eq. 2] for values (n,) at points (n, 3), z the values less their mean.

    Memory grows with n. To rounding up to `weights.MOST` points and on regular lattices; beyond, off by less than
    10^-`weights.DIGITS` max Σ c / mean Σ c. Coincident points have no weight. Raises SRF-MODEL for fewer than four
    points, values that are all the same, or an exponent that is not positive.
    """
    points, z = _checked(points_mm, values, exponent)
    total, products = Weights(points, exponent).sums(z)
    return float(len(z) * products / (total * (z @ z)))


def geary_c(points_mm: Array, values: Array, exponent: float = EXPONENT) -> float:
    """Geary's C = (n − 1) Σ c (zᵢ − zⱼ)² / (2 S0 Σ z²), about 1 for spatial randomness; raises as `moran_i`."""
    points, z = _checked(points_mm, values, exponent)
    return geary_of(Weights(points, exponent).times, z)


def geary_of(weighted: Callable[[Array], Array], z: Array) -> float:
    """Geary's C of values (n,) about zero, from what multiplies the weights with vectors (n, k)."""
    rows, products = weighted(np.stack([np.ones_like(z), z], axis=1)).T
    return float((len(z) - 1) * (rows @ z**2 - z @ products) / (np.sum(rows) * (z @ z)))


def raw_null(points_mm: Array, exponent: float = EXPONENT) -> Null:
    """Moments of I for independent normal values about one unknown mean (Cliff & Ord 1981): not for residuals.

    E = −1/(n − 1); E[I²] = (n² S1 − n S2 + 3 S0²) / ((n² − 1) S0²), S1 = 2 Σ c², S2 = Σᵢ (2 Σⱼ c)².
    """
    weights = Weights(for_kernel(points_mm), exponent)
    n, rows = weights.count, weights.times(np.ones((weights.count, 1)))
    s0, s1, s2 = float(np.sum(rows)), 2 * weights.squares, float(np.sum((2 * rows) ** 2))
    expected = -1.0 / (n - 1)
    second = (n * n * s1 - n * s2 + 3 * s0 * s0) / ((n * n - 1.0) * s0 * s0)
    return Null(expected, float(np.sqrt(second - expected**2)))


def _checked(points_mm: Array, values: Array, exponent: float) -> tuple[Array, Array]:
    points, z = for_kernel(points_mm), np.asarray(values, float)
    z = z - np.mean(z)
    if len(z) < 4 or points.shape != (len(z), 3) or not exponent > 0 or not z @ z > 0:
        raise TrueloopError(
            Code.SRF_MODEL,
            f"{len(z)} values at points of shape {points.shape}, weights d^-{exponent:g}, scatter {np.ptp(z):g} mm: "
            f"nothing to correlate",
            hint="give at least four points with different values, and a positive exponent",
        )
    return points, z
