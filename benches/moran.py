"""Moran's I with weights d⁻³ between all pairs, beside esda and numba; where their memory or time ends, alone."""

import warnings
from collections.abc import Callable

import numpy as np

from benches.ratio import Contender, compare, verdict
from tests.support.surfaces import error_of_products, moran_i
from trueloop.surface.separation.moran import Weights

SCATTERED = (625, 2_500, 10_000, 40_000)
ESDA_MOST, DENSE_MOST, MANY = 2_500, 10_000, 1_000_000
"""esda takes 13 s at 2,500 points and more than 12 GB at 10,000."""
GRIDS = (25, 1000)


def main() -> None:
    """Compare where all can; then a million scattered points and regular grids, ours alone."""
    for n in SCATTERED:
        points, values = np.random.default_rng(n).uniform(0, 50, (n, 3)), np.random.default_rng(n).normal(size=n)
        samples = compare(f"{n} points", contenders(points, values), rounds=2 if n == ESDA_MOST else 5)
        verdict(samples, "trueloop", to="numba", at_most=1 / 4)
        if n <= ESDA_MOST:
            verdict(samples, "trueloop", to="esda", at_most=1 / 5000)
    points, values = on_a_sheet(MANY)
    note = f"error {measured_error(points, values):.1g}"
    compare(f"{MANY} points on a sheet", [Contender("trueloop", ours(points, values), note)], 3, "measured")
    for side in GRIDS:
        x, y = (a.ravel() for a in np.meshgrid(np.arange(float(side)), np.arange(float(side))))
        values = np.random.default_rng(side).normal(size=side**2)
        plane = np.stack([x, y, 0 * x], axis=1)
        compare(f"{side} × {side} grid in a plane", [Contender("trueloop", ours(plane, values))], rounds=5)


def contenders(points: np.ndarray, values: np.ndarray) -> list[Contender]:
    """Ours first; the others where they come to an end."""
    listed = [Contender("trueloop", ours(points, values)), Contender("numba", by_numba(points, values))]
    if len(points) <= DENSE_MOST:
        listed.append(Contender("numpy, dense matrix", dense(points, values)))
    if len(points) <= ESDA_MOST:
        listed.append(Contender("esda", by_esda(points, values)))
    return listed


def ours(points: np.ndarray, values: np.ndarray) -> Callable[[], object]:
    """As the package computes it: it finds out by itself what the points are like."""
    return lambda: moran_i(points, values)


def by_numba(points: np.ndarray, values: np.ndarray) -> Callable[[], object]:
    """A loop over all pairs, each once, compiled, on all cores, fast arithmetic allowed."""
    from numba import njit, prange

    def sums(x: np.ndarray, y: np.ndarray, z: np.ndarray, v: np.ndarray) -> tuple[float, float]:
        weights = products = 0.0
        for i in prange(len(v)):
            own = cross = 0.0
            for j in range(i + 1, len(v)):
                square = (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 + (z[i] - z[j]) ** 2
                c = 1.0 / (square * np.sqrt(square))
                own += c
                cross += c * v[j]
            weights += own
            products += cross * v[i]
        return weights, products

    compiled = njit(parallel=True, fastmath=True)(sums)

    def run() -> object:
        v = values - values.mean()
        weights, products = compiled(*np.ascontiguousarray(points.T), v)
        return len(v) * products / (weights * (v @ v))

    return run


def dense(points: np.ndarray, values: np.ndarray) -> Callable[[], object]:
    """What a numpy user writes."""
    from scipy.spatial.distance import pdist, squareform

    def run() -> object:
        c = squareform(pdist(points) ** -3.0)
        z = values - values.mean()
        return len(z) / c.sum() * (z @ c @ z) / (z @ z)

    return run


def by_esda(points: np.ndarray, values: np.ndarray) -> Callable[[], object]:
    """The weights are made each time: they belong to the job."""
    from esda import Moran
    from libpysal.weights import full2W
    from scipy.spatial.distance import cdist

    def run() -> object:
        distance = cdist(points, points)
        np.fill_diagonal(distance, np.inf)
        return Moran(values, full2W(distance**-3.0), transformation="O", permutations=0).I

    return run


def on_a_sheet(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Scattered points on a bent surface, and noise."""
    rng = np.random.default_rng(count)
    x, y = rng.uniform(0, 50, (2, count))
    return np.stack([x, y, 4 * np.sin(x / 14) * np.cos(y / 17)], axis=1), rng.normal(size=count)


def measured_error(points: np.ndarray, values: np.ndarray) -> float:
    """Of a product C z, at places drawn by chance, as a share of Σ c |z|."""
    weights, column = Weights(points, 3.0), values[:, None] - values.mean()
    return error_of_products(weights, column, weights.times(column))


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
