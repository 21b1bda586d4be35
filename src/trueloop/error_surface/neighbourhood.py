"""The null of Moran's I for regression residuals: residuals of a fit resemble each other even where errors do not.

For residuals r = Mε of a least-squares fit with the projector M = 1 − H of rank f and independent normal ε, I is a
ratio that is independent of its denominator, so its moments are exact (Cliff & Ord 1981):

    E[I] = (n/S0) tr(MC)/f,   E[I²] = (n/S0)² ((tr MC)² + 2 tr(MCMC)) / (f (f + 2)).
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Final

import numpy as np

from trueloop._core import weights_product
from trueloop.error_surface.moran import EXPONENT, Null
from trueloop.error_surface.places import Places, Projector, projector
from trueloop.error_surface.spline_surface import Size
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array

DENSE: Final = 2500
"""Most points for which the matrix of weights is formed; beyond, the moments are those of simulated residuals."""
DRAWS: Final = 200


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
        """Number of places."""
        return len(self.places.u)

    def __post_init__(self) -> None:
        if self.count > DENSE and self.places.rows is None:
            raise TrueloopError(
                Code.SRF_MODEL,
                f"{self.count} scattered points are too many to judge their randomness; {DENSE} are the most",
                hint="average a scan over the cells of a grid: model.cells in the job",
            )

    @cached_property
    def weights(self) -> Array:
        """The matrix of weights (n, n), zeros on its diagonal: for as many places as fit."""
        from scipy.spatial.distance import pdist, squareform  # slow to import

        distance = squareform(pdist(self.places.points_mm))
        np.fill_diagonal(distance, np.inf)
        if self.places.rows is None:
            distance = np.maximum(distance, np.median(np.min(distance, axis=1)))
        return np.asarray(distance**-self.exponent)

    @cached_property
    def total(self) -> float:
        """S0, the sum of all weights."""
        if self.count <= DENSE:
            return float(np.sum(self.weights))
        rows, _ = weights_product(self.places.points_mm, np.empty((self.count, 0)), self.exponent)
        return float(np.sum(rows))

    @cached_property
    def squared(self) -> Array:
        """C²."""
        return np.asarray(self.weights @ self.weights)

    def moran_i(self, residuals: Array) -> Array:
        """Moran's I of each column of residuals (n, k) about zero: a fitted spline leaves no mean."""
        if self.count <= DENSE:
            products = self.weights @ residuals
        else:
            _, products = weights_product(self.places.points_mm, np.ascontiguousarray(residuals), self.exponent)
        ratio = np.sum(residuals * products, axis=0) / np.sum(residuals**2, axis=0)
        return np.asarray(self.count / self.total * ratio)


@lru_cache(maxsize=256)
def residual_null(near: Neighbourhood, size: Size) -> Null:
    """Moments of I for the residuals of a spline of that size: exact up to `DENSE` places, simulated beyond."""
    span = projector(near.places, size)
    if near.count > DENSE:
        return _simulated(near, span)
    free = near.count - span.rank
    first, second = _traces(near, span)
    scale = near.count / near.total
    expected = scale * first / free
    square = scale**2 * (first**2 + 2 * second) / (free * (free + 2.0))
    return Null(expected, float(np.sqrt(square - expected**2)))


def _traces(near: Neighbourhood, span: Projector) -> tuple[float, float]:
    """tr(MC) and tr(MCMC), by H = Q Qᵀ: −tr(HC) and tr(C²) − 2 tr(HC²) + ‖QᵀCQ‖²."""
    q = span.whole if span.whole is not None else np.kron(_sure(span.along), _sure(span.across))
    cq = near.weights @ q
    inner = q.T @ cq
    return -float(np.trace(inner)), float(np.sum(near.weights**2) - 2 * np.sum(cq**2) + np.sum(inner**2))


def _simulated(near: Neighbourhood, span: Projector) -> Null:
    draws = np.random.default_rng(20170601).standard_normal((near.count, DRAWS))
    residuals = np.stack([span.residuals(draw) for draw in draws.T], axis=1)
    values = near.moran_i(residuals)
    return Null(float(np.mean(values)), float(np.std(values, ddof=1)))


def permutation_p_value(near: Neighbourhood, residuals: Array, size: Size, draws: int = 999, seed: int = 1) -> float:
    """Share of shuffled residuals whose I is at least as large, the unshuffled among them: needs no normal law.

    Residuals of a fit are not exchangeable: the fit makes neighbours unlike. What was shuffled is therefore fitted
    again, and the I of what that leaves is compared (after Freedman & Lane, 1983).
    """
    rng = np.random.default_rng(seed)
    span = projector(near.places, size)
    shuffled = rng.permuted(np.tile(residuals, (draws, 1)), axis=1)
    left = np.stack([residuals, *(span.residuals(values) for values in shuffled)], axis=1)
    moran_i = near.moran_i(left)
    return float((1 + np.count_nonzero(moran_i[1:] >= moran_i[0])) / (draws + 1))


def _sure(matrix: Array | None) -> Array:
    assert matrix is not None
    return matrix
