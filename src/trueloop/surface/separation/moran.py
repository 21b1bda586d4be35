"""Moran's I and Geary's C: whether values scatter without regard to where they are.

Weights fall with distance, c = d^-k [MPM Eq. 3], none for a point with itself. I near its expectation means spatial
randomness; above it, neighbours resemble each other.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from trueloop._core import pair_sums, weights_product, weights_product_rows
from trueloop.arrays import Array, for_kernel
from trueloop.errors import Code, TrueloopError
from trueloop.surface.separation.lattice import Lattice, lattice_of

MOST: Final = 40_000
DIGITS: Final = 3.0
"""Beyond `MOST` places a product C v is off by less than 10^-DIGITS Σ c |v| anywhere, usually by a hundredth of it."""
CHECKED: Final = 64


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights c = max(d, nearest)^-exponent between places (n, 3), none of a place with itself.

    With `nearest_mm` zero, coincident places have no weight. The places are a contiguous array.
    """

    points_mm: Array
    exponent: float
    nearest_mm: float = 0.0

    @property
    def count(self) -> int:
        """Returns the number of places."""
        return len(self.points_mm)

    @cached_property
    def lattice(self) -> Lattice | None:
        """Returns the lattice that the places stand on."""
        return lattice_of(self.points_mm, self.exponent) if self.nearest_mm == 0 else None

    def times(self, vectors: Array) -> Array:
        """C V for vectors (n, p)."""
        if self.lattice is not None:
            return self.lattice.times(vectors)
        points, digits = (self.points_mm, None) if self.count <= MOST else (self._turned, DIGITS)
        return weights_product(points, np.ascontiguousarray(vectors), self.exponent, self.nearest_mm, digits)

    def products(self, vectors: Array) -> Array:
        """Σ c vᵢ vⱼ of each column of vectors (n, p)."""
        if self.lattice is not None:
            return self.lattice.products(vectors)
        return np.asarray(np.sum(vectors * self.times(vectors), axis=0))

    def sums(self, values: Array) -> tuple[float, float]:
        """S0 = Σ c, and Σ c zᵢ zⱼ of values (n,)."""
        if self.lattice is None and self.count <= MOST:
            return pair_sums(self.points_mm, np.ascontiguousarray(values), self.exponent, self.nearest_mm)
        both = self.products(np.stack([np.ones(self.count), values], axis=1))
        return float(both[0]), float(both[1])

    @cached_property
    def total(self) -> float:
        """Returns S0, the sum of all weights."""
        return self.sums(np.zeros(self.count))[0]

    @cached_property
    def squares(self) -> float:
        """Σ c²."""
        return Weights(self.points_mm, 2 * self.exponent, self.nearest_mm).total

    def measured_error(self, vectors: Array, product: Array) -> float:
        """Largest error of a product C V at places drawn by chance, as a share of Σ c |v| there."""
        rows = np.random.default_rng(0).choice(self.count, min(CHECKED, self.count), replace=False)
        both = np.ascontiguousarray(np.concatenate([vectors, np.abs(vectors)], axis=1))
        exact = weights_product_rows(self.points_mm, both, self.exponent, self.nearest_mm, rows.tolist())
        columns = vectors.shape[1]
        return float(np.max(np.abs(product[rows] - exact[:, :columns]) / exact[:, columns:]))

    @cached_property
    def _turned(self) -> Array:
        """The places along their principal axes: a patch is then thin along one, and cells of it need few nodes."""
        centred = self.points_mm - np.mean(self.points_mm, axis=0)
        _, axes = np.linalg.eigh(centred.T @ centred)
        return np.ascontiguousarray(centred @ axes)


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
        """Returns the probability of an I at least as large, from the normal law that I approaches."""
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
