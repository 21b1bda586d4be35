"""Places that form a regular lattice in a plane, holes allowed: sums over all pairs by Fourier transforms, exactly."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from trueloop.arrays import Array

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
