"""The matrix of weights c = d^-k between places, never formed: its products with vectors, and sums over all pairs.

On a regular lattice in a plane Fourier transforms do it, exactly. Elsewhere every pair is worked off, up to `MOST`
places; beyond, pairs far from each other are worked off together.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from trueloop._core import pair_sums, weights_product, weights_product_rows
from trueloop.arrays import Array
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
        """Number of places."""
        return len(self.points_mm)

    @cached_property
    def lattice(self) -> Lattice | None:
        """The lattice that the places stand on."""
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
        """S0, the sum of all weights."""
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
