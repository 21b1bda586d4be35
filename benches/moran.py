"""Moran's I with weights d⁻³ between all pairs of scattered points, beside esda; where its memory ends, alone."""

import warnings
from collections.abc import Callable

import numpy as np

from benches.ratio import Contender, compare, verdict
from trueloop.error_surface.moran import spatial_statistics

BOTH, ALONE = (625, 2_500), (10_000, 40_000)
"""esda takes 13 s at 2,500 points and more than 12 GB at 10,000."""


def main() -> None:
    """Compare where all can, then ours alone."""
    for n in (*BOTH, *ALONE):
        points, values = np.random.default_rng(n).uniform(0, 50, (n, 3)), np.random.default_rng(n).normal(size=n)
        contenders = [Contender("trueloop", ours(points, values))]
        if n in BOTH:
            contenders.append(Contender("numpy, dense matrix", dense(points, values)))
            contenders.append(Contender("esda", by_esda(points, values)))
        samples = compare(f"{n} points", contenders, rounds=5 if n not in BOTH[1:] else 2)
        if n == BOTH[-1]:
            verdict(samples, "trueloop", to="esda", at_most=1 / 5000)


def ours(points: np.ndarray, values: np.ndarray) -> Callable[[], object]:
    """The Rust kernel: I, C and the sums for their moments."""
    return lambda: spatial_statistics(points, values)


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


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
