"""The null of Moran's I for regression residuals: residuals of a fit resemble each other even where errors do not.

For residuals r = Mε of a least-squares fit with the projector M = 1 − H of rank f and independent normal ε, I is a
ratio that is independent of its denominator, so its moments are exact (Cliff & Ord 1981):

    E[I] = (n/S0) tr(MC)/f,   E[I²] = (n/S0)² ((tr MC)² + 2 tr(MCMC)) / (f (f + 2)).

With H = Q Qᵀ the traces are −tr(QᵀCQ) and tr(C²) − 2 ‖CQ‖² + ‖QᵀCQ‖². Where Q has many columns on many places, they are
estimated from a few random vectors of its span, whose products have the same expectations (Hutchinson 1989).
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Final

import numpy as np

from trueloop.arrays import Array, for_kernel
from trueloop.surface.separation.moran import EXPONENT, Null, Weights, geary_of
from trueloop.surface.separation.spline_surface import Places, Projector, Size, projector

DENSE: Final = 2500
"""Most places for which the matrix of weights is formed, and the moments are exact whatever the size."""
EXACT: Final = 64
"""Control points up to which the moments are exact on more places."""
PROBES: Final = 3200.0
"""Random vectors a control point and place: I's expectation is then known to a twentieth of its standard deviation."""
FEWEST: Final = 16
MOST: Final = 512
EXACTLY: Final = 12_800_000
"""Columns times places up to which they are exact so: beyond, random vectors are many times quicker."""
SHUFFLED: Final = 10_000_000
"""Values shuffled at once."""
DRAWN: Final = 10_000_000
"""Values shuffled in all, on many places."""
DRAWS: Final = (19, 199, 999)
"""Least and most shuffles on more than `DENSE` places, and those on fewer."""


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """Places with their weights c = d^-exponent.

    Scattered points come arbitrarily close to each other, and a power of a distance near zero would leave the whole
    statistic to a few pairs: there, distances below the median one to the nearest neighbour count as that one.
    """

    places: Places
    exponent: float = EXPONENT

    @property
    def count(self) -> int:
        """Returns the number of places."""
        return len(self.places.u)

    @cached_property
    def weights(self) -> Weights:
        """The weights between the places."""
        points = for_kernel(self.places.points_mm)
        if self.places.rows is not None:
            return Weights(points, self.exponent)
        from scipy.spatial import KDTree  # slow to import

        distance, _ = KDTree(points).query(points, k=[2])
        return Weights(points, self.exponent, float(np.median(distance)))

    @cached_property
    def matrix(self) -> Array | None:
        """The weights as a matrix (n, n), where that fits."""
        return self.weights.times(np.eye(self.count)) if self.count <= DENSE else None

    def times(self, vectors: Array) -> Array:
        """The weights times vectors (n, k)."""
        return self.weights.times(vectors) if self.matrix is None else np.asarray(self.matrix @ vectors)

    def moran_i(self, residuals: Array) -> Array:
        """Moran's I of each column of residuals (n, k) about zero: a fitted spline leaves no mean."""
        if self.matrix is None:
            products = self.weights.products(residuals)
        else:
            products = np.sum(residuals * (self.matrix @ residuals), axis=0)
        return np.asarray(self.count / self.weights.total * products / np.sum(residuals**2, axis=0))

    def geary_c(self, residuals: Array) -> float:
        """Geary's C of residuals (n,) about zero; less than `expected_geary_c` where neighbours are alike."""
        return geary_of(self.times, residuals)


@lru_cache(maxsize=256)
def residual_null(near: Neighbourhood, size: Size) -> Null:
    """Moments of I for the residuals of a spline of that size.

    Exact up to `DENSE` places, and up to `EXACT` control points on `EXACTLY` / `EXACT`; else with a standard error.
    """
    span = projector(near.places, size)
    free = near.count - span.rank
    first, error, second = _traces(near, span)
    scale = near.count / near.weights.total
    expected = scale * first / free
    square = scale**2 * (first**2 + 2 * second) / (free * (free + 2.0))
    return Null(expected, float(np.sqrt(square - expected**2)), scale * error / free)


def expected_geary_c(near: Neighbourhood, size: Size) -> float:
    """Expectation of C for the residuals of a spline of that size: above 1, for the fit makes neighbours unlike.

    C is z'(D − W)z over z'z, D the weights' row sums; each quadratic form of residuals has the trace of its own.
    """
    span = projector(near.places, size)
    rows = near.times(np.ones((near.count, 1)))[:, 0]
    own = float(rows @ (1.0 - span.leverages)) / (near.weights.total * (near.count - span.rank))
    return (near.count - 1) * (own - residual_null(near, size).expected / near.count)


def _traces(near: Neighbourhood, span: Projector) -> tuple[float, float, float]:
    """tr(MC), its standard error, and tr(MCMC)."""
    probes = int(np.clip(PROBES * span.rank / near.count, FEWEST, MOST))
    few = span.rank <= EXACT and span.rank * near.count <= EXACTLY
    if near.count <= DENSE or few or span.rank <= probes:
        factors, each = np.eye(span.rank), 1.0
    else:
        factors, each = np.random.default_rng(20170601).standard_normal((span.rank, probes)), 1.0 / probes
    q = span.combined(factors)
    cq = near.times(q)
    within = np.sum(q * cq, axis=0)
    error = 0.0 if each == 1.0 else float(np.std(within, ddof=1)) / np.sqrt(probes)
    second = near.weights.squares - each * (2 * np.sum(cq**2) - np.sum(span.coordinates(cq) ** 2))
    return -each * float(np.sum(within)), error, float(second)


def permutation_p_value(
    near: Neighbourhood, residuals: Array, size: Size, draws: int | None = None, seed: int = 1
) -> float:
    """Share of shuffled residuals whose I is at least as large, the unshuffled among them: needs no normal law.

    Residuals of a fit are not exchangeable: the fit makes neighbours unlike. What was shuffled is therefore fitted
    again, and the I of what that leaves is compared (after Freedman & Lane, 1983). `draws`: how many shuffles; 999, on
    more than `DENSE` places 199 or as many as shuffle `DRAWN` values, but 19 at least.
    """
    rng = np.random.default_rng(seed)
    least, most, all_of_few = DRAWS
    draws = draws or (all_of_few if near.count <= DENSE else int(np.clip(DRAWN / near.count, least, most)))
    span = projector(near.places, size)
    own = float(near.moran_i(span.residuals(residuals[:, None]))[0])
    at_once, larger = max(1, SHUFFLED // near.count), 0
    for start in range(0, draws, at_once):
        shuffled = rng.permuted(np.tile(residuals, (min(at_once, draws - start), 1)), axis=1)
        larger += int(np.count_nonzero(near.moran_i(span.residuals(shuffled.T)) >= own))
    return (1 + larger) / (draws + 1)
