"""Values as a sum of blocks of columns with normal coefficients: sizes by evidence, outliers counting less.

    y = Σ_b scale_b · rows_b · z_b + noise,    z_b ~ N(0, 1),   noise ~ σ · t_6

The sizes that the data ask for are those of greatest marginal likelihood on a grid. The noise has heavy tails, so
that a point far off loses its weight (6 + 1) / (6 + r²/σ²) (Lange, Little & Taylor 1989).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from trueloop.arrays import Array, Flags, Integers

FREEDOM: Final = 6.0
ROUNDS: Final = 4
SWEEPS: Final = 8
OUTLIER: Final = 5.0
NOISE_LN: Final = 0.7
"""The uncertainty of the noise beforehand: standard deviation of its logarithm."""


@dataclass(frozen=True)
class Block:
    """Columns (n, k) with the scales that are tried of their coefficients; one scale is not sought."""

    rows: Array
    tried: tuple[float, ...] = (1.0,)


@dataclass(frozen=True)
class Mixed:
    """The result: scale of each block, standard deviation of the noise, posterior of all z in the blocks' order.

    `fisher` (q, q) is the information of the values alone on z. `outlier` (n,) are values more than five deviations
    off.
    """

    scales: Mapping[str, float]
    noise: float
    mean: Mapping[str, Array]
    covariance: Array
    fisher: Array
    outlier: Flags


def mixed(values: Array, blocks: Mapping[str, Block], weight: Array, noise: float, start: Mixed | None = None) -> Mixed:
    """Fits values (n,) whose noise is expected to be `noise`; a value of weight 1/2 counts as half a value.

    All lengths are in the same unit. `start` is an earlier fit of the same blocks from which the sizes are sought.
    """
    rows = np.hstack([np.zeros((len(values), 0)), *(block.rows for block in blocks.values())])
    own = np.repeat(np.arange(len(blocks)), [block.rows.shape[1] for block in blocks.values()])
    grids = [block.tried for block in blocks.values()] + [tuple(noise * 2.0 ** np.arange(-3, 4.5, 0.5))]
    at = [len(grid) // 2 for grid in grids]
    if start is not None:
        known = [*(start.scales[name] for name in blocks), start.noise]
        at = [int(np.argmin(np.abs(np.asarray(grid) - k))) for grid, k in zip(grids, known, strict=True)]
    tail = np.ones(len(values))
    for _ in range(ROUNDS if start is None else 2):
        gram = _Gram(rows, values, weight * tail, float(weight.sum()), noise)
        at = _climbed(gram, own, grids, at)
        sizes = [grid[k] for grid, k in zip(grids, at, strict=True)]
        scale, sigma = np.asarray(sizes[:-1])[own], sizes[-1]
        fisher = gram.normal * np.outer(scale, scale) / sigma**2
        covariance = np.linalg.inv(np.eye(len(scale)) + fisher)
        z = covariance @ (scale * gram.right) / sigma**2
        scaled = rows * scale
        rest = values - scaled @ z
        squares = rest**2 + np.einsum("nj,jk,nk->n", scaled, covariance, scaled)
        tail = (FREEDOM + 1) / (FREEDOM + squares / sigma**2)
    ends = np.cumsum([0, *(block.rows.shape[1] for block in blocks.values())])
    mean = {name: z[a:b] for name, a, b in zip(blocks, ends, ends[1:], strict=False)}
    found = dict(zip(blocks, sizes[:-1], strict=True))
    return Mixed(found, sigma, mean, covariance, fisher, np.abs(rest) > OUTLIER * sigma)


class _Gram:
    """The sums of rows and values that the evidence needs, once for all sizes."""

    def __init__(self, rows: Array, values: Array, weight: Array, count: float, noise: float) -> None:
        self.normal = rows.T @ (rows * weight[:, None])
        self.right = rows.T @ (weight * values)
        self.squares = float(values @ (weight * values))
        self.count, self.noise = count, noise

    def log_evidence(self, scale: Array, sigma: float) -> float:
        used = scale > 0
        scale = scale[used]
        whole = np.eye(len(scale)) + self.normal[np.ix_(used, used)] * np.outer(scale, scale) / sigma**2
        lower = cholesky(whole, lower=True, check_finite=False)
        inside = solve_triangular(lower, scale * self.right[used] / sigma**2, lower=True, check_finite=False)
        explained = self.squares / sigma**2 - float(inside @ inside)
        expected = (np.log(sigma / self.noise) / NOISE_LN) ** 2
        return -float(np.log(np.diag(lower)).sum() + self.count * np.log(sigma) + 0.5 * (explained + expected))


def _climbed(gram: _Gram, own: Integers, grids: Sequence[tuple[float, ...]], at: Sequence[int]) -> list[int]:
    """Indices in the grids of greatest evidence, from `at` on: each size in turn, to its neighbours or the least."""
    at, known = list(at), dict[tuple[int, ...], float]()

    def evidence(tried: list[int]) -> float:
        key = tuple(tried)
        if key not in known:
            sizes = [grid[k] for grid, k in zip(grids, tried, strict=True)]
            known[key] = gram.log_evidence(np.asarray(sizes[:-1])[own], sizes[-1])
        return known[key]

    for _ in range(SWEEPS):
        before = list(at)
        for k, grid in enumerate(grids):
            near = sorted({0, *range(max(at[k] - 1, 0), min(at[k] + 2, len(grid)))})
            at[k] = near[int(np.argmax([evidence([*at[:k], j, *at[k + 1 :]]) for j in near]))]
        if at == before:
            break
    return at
