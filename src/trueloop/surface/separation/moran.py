"""Moran's I and Geary's C: whether values scatter without regard to where they are.

Weights fall with distance, c = d^-k [MPM Eq. 3], none for a point with itself. I near its expectation means spatial
randomness; above it, neighbours resemble each other.

Tests whether residuals follow a normal law: Kolmogorov–Smirnov as published, and Lilliefors, which is the right form
here.

The Kolmogorov–Smirnov test asks for a law known beforehand. With mean and scatter taken from the residuals themselves
its p-values are far too large, and it hardly ever rejects; Lilliefors (1967) is the same distance judged rightly.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import exp, sqrt
from typing import Final

import numpy as np

from trueloop._core import pair_sums, weights_product
from trueloop.arrays import Array
from trueloop.errors import Code

STRAY: Final = 1e-10
"""Points belong to a lattice when they stray from it by less than this share of a step: weights keep ten digits."""
FEWEST: Final = 16
ROUGHLY: Final = 1e-7
FLAT: Final = 1e-12
"""Far above the rounding of a determinant, far below what a bent sheet has."""


@dataclass(frozen=True, eq=False)
class Lattice:
    """Point k stands at `at[k]` (n, 2) steps along the two `steps_mm` (2, 3); the lattice has `shape` places."""

    at: np.ndarray
    steps_mm: Array
    shape: tuple[int, int]
    exponent: float

    def times(self, vectors: Array) -> Array:
        """Returns the matrix of the weights times vectors (n, p)."""
        from scipy.fft import irfft2  # slow to import

        product = np.empty_like(vectors)
        for column, values in enumerate(vectors.T):
            whole = irfft2(self._spectrum * self._transformed(values), s=self._padded)
            product[:, column] = whole[self.at[:, 0], self.at[:, 1]]
        return product

    def products(self, vectors: Array) -> Array:
        """Σ c vᵢ vⱼ of each column (n, p): by Parseval's theorem, without the way back."""
        twice = np.full(self._spectrum.shape[1], 2.0)
        twice[0] = 1.0
        if self._padded[1] % 2 == 0:
            twice[-1] = 1.0
        power = [np.abs(self._transformed(values)) ** 2 for values in vectors.T]
        return np.array([np.einsum("ij,ij,j->", p, self._spectrum, twice) for p in power]) / np.prod(self._padded)

    @cached_property
    def _padded(self) -> tuple[int, int]:
        """So large that what leaves on one side does not come in on the other."""
        from scipy.fft import next_fast_len  # slow to import

        return next_fast_len(2 * self.shape[0] - 1, True), next_fast_len(2 * self.shape[1] - 1, True)

    @cached_property
    def _spectrum(self) -> Array:
        """The transform of the weights of all displacements; real, because c(−d) = c(d)."""
        from scipy.fft import rfft2  # slow to import

        along, across = (np.fft.fftfreq(size, 1 / size)[:, None] for size in self._padded)
        i, j = along * self.steps_mm[0], across * self.steps_mm[1]
        aa, ab, bb = np.sum(i * i, axis=1), i @ j.T, np.sum(j * j, axis=1)
        square = aa[:, None] + 2 * ab + bb
        square[0, 0] = np.inf
        return np.ascontiguousarray(rfft2(inverse_power(square, self.exponent)).real)

    def _transformed(self, values: Array) -> np.ndarray:
        from scipy.fft import rfft2  # slow to import

        grid = np.zeros(self.shape)
        grid[self.at[:, 0], self.at[:, 1]] = values
        return np.asarray(rfft2(grid, s=self._padded))


def lattice_of(points_mm: Array, exponent: float) -> Lattice | None:
    """The lattice that the points (n, 3) stand on, in any order, with holes; None where they do not.

    Its steps are looked for at the first point and at the middle one. A lattice that is so full of holes that its
    steps are not seen there is not found.
    """
    if len(points_mm) < FEWEST or not _may_be_flat(points_mm):
        return None
    middle = np.argmin(np.sum((points_mm - np.mean(points_mm, axis=0)) ** 2, axis=1))
    for corner in (0, int(middle)):
        steps = _steps(points_mm, points_mm[corner])
        found = None if steps is None else _on(points_mm, points_mm[corner], steps, exponent)
        if found is not None:
            return found
    return None


def inverse_power(square: Array, exponent: float) -> Array:
    """d^-k from d²; whole k by multiplication, which is faster."""
    if exponent != int(exponent) or exponent > 8:
        return np.asarray(square ** (-exponent / 2))
    near = 1 / np.sqrt(square)
    power = near.copy()
    for _ in range(int(exponent) - 1):
        power *= near
    return power


def _may_be_flat(points: Array) -> bool:
    """Returns whether some of the points stand in a plane, as nearly as the product of their three spreads tells."""
    some = points[:: max(1, len(points) // FEWEST)] - points[0]
    spread = some.T @ some
    return not np.linalg.det(spread) > FLAT * np.trace(spread) ** 3


def _steps(points: Array, corner: Array) -> Array | None:
    """The shortest way to another point, and the shortest that does not go along with it."""
    ways = points - corner
    square = np.einsum("ij,ij->i", ways, ways)
    square[square == 0] = np.inf
    near = np.argpartition(square, FEWEST // 2)[: FEWEST // 2]
    near = near[np.argsort(square[near])]
    ways, square = ways[near], square[near]
    if square[-1] == np.inf:
        return None
    aside = (ways @ ways[0]) ** 2 < 0.99 * square * square[0]
    return ways[[0, int(np.argmax(aside))]] if np.any(aside) else None


def _on(points: Array, corner: Array, steps: Array, exponent: float) -> Lattice | None:
    inverse = np.linalg.solve(steps @ steps.T, steps).T
    some = points[:: max(1, len(points) // FEWEST)] - corner
    if np.max(np.abs(np.rint(some @ inverse) @ steps - some)) > ROUGHLY * np.max(np.abs(some)):
        return None  # as most that are none are found out quickly
    at = np.rint((points - corner) @ inverse)
    # The steps come from two pairs of points and carry their rounding: they are fitted to all points.
    centred, from_mean = at - np.mean(at, axis=0), points - np.mean(points, axis=0)
    fitted = np.linalg.solve(centred.T @ centred, centred.T @ from_mean)
    stray = np.max(np.abs(centred @ fitted - from_mean))
    whole = (at - np.min(at, axis=0)).astype(int)
    rows, columns = (np.max(whole, axis=0) + 1).tolist()
    if stray > STRAY * np.sqrt(np.min(np.sum(steps**2, axis=1))) or rows * columns > 4 * len(points):
        return None
    if np.max(np.bincount(whole[:, 0] * columns + whole[:, 1])) > 1:
        return None
    return Lattice(whole, fitted, (rows, columns), exponent)


MOST: Final = 40_000
DIGITS: Final = 3.0
"""Beyond `MOST` places a product C v is off by less than 10^-DIGITS Σ c |v| anywhere, usually by a hundredth of it."""


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


def geary_of(weighted: Callable[[Array], Array], z: Array) -> float:
    """Geary's C of values (n,) about zero, from what multiplies the weights with vectors (n, k)."""
    rows, products = weighted(np.stack([np.ones_like(z), z], axis=1)).T
    return float((len(z) - 1) * (rows @ z**2 - z @ products) / (np.sum(rows) * (z @ z)))


@dataclass(frozen=True)
class Normality:
    """The largest distance between the two distribution functions, and what it means under either test."""

    distance: float
    ks_p: float
    lilliefors_p: float


def normality(values: Array) -> Normality:
    """Both tests on values (n,), n ≥ 5, mean and scatter estimated. Raises SRF-MODEL for values all alike."""
    from scipy.special import kolmogorov, ndtr  # slow to import

    n, scatter = len(values), float(np.std(values, ddof=1))
    if n < 5 or not scatter > 0:
        raise Code.SRF_MODEL.refusal(
            f"{n} residuals that scatter by {scatter:g} mm follow no law",
            hint="the model goes through every point: ask for fewer control points, or measure more",
        )
    law = ndtr(np.sort((values - np.mean(values)) / scatter))
    steps = np.arange(n + 1) / n
    distance = float(max(np.max(steps[1:] - law), np.max(law - steps[:-1])))
    return Normality(distance, float(kolmogorov(sqrt(n) * distance)), lilliefors_p(distance, n))


def lilliefors_p(distance: float, n: int) -> float:
    """p-value: the formula of Dallal & Wilkinson (1986) up to 0.1, beyond it polynomials to Stephens' modified
    statistic (1974), as statistics packages use them; good to a tenth of itself in the range where decisions fall.
    """
    d, m = (distance, float(n)) if n <= 100 else (distance * (n / 100) ** 0.49, 100.0)
    p = exp(
        -7.01256 * d * d * (m + 2.78019) + 2.99587 * d * sqrt(m + 2.78019) - 0.122119 + 0.974598 / sqrt(m) + 1.67997 / m
    )
    if p <= 0.1:
        return p
    k = (sqrt(n) - 0.01 + 0.85 / sqrt(n)) * distance
    for upper, coefficients in (
        (0.302, (1.0,)),
        (0.5, (2.76773, -19.828315, 80.709644, -138.55152, 81.218052)),
        (0.9, (-4.901232, 40.662806, -97.490286, 94.029866, -32.355711)),
        (1.31, (6.198765, -19.558097, 23.186922, -12.234627, 2.423045)),
    ):
        if k <= upper:
            return min(1.0, max(0.0, sum(c * k**power for power, c in enumerate(coefficients))))
    return 0.0
