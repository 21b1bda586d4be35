"""Values as a sum of blocks of columns with normal coefficients, their sizes by evidence, outliers counting less.

    y = Σ_b scale_b · rows_b · z_b + noise,    z_b ~ N(0, 1),   noise ~ σ · t_6

The sizes are those of greatest marginal likelihood, by gradient: with γ_b, by how many of its coefficients the values
determine a block, ∂(−log p)/∂ log scale_b = γ_b − |z_b|² (MacKay 1992). The noise has heavy tails, so that a point far
off loses its weight (6 + 1) / (6 + r²/σ²) (Lange, Little & Taylor 1989). The normal equations are of the coefficients:
many values cost little.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import minimize

from trueloop.arrays import Array, Flags, Integers
from trueloop.estimate.sizes import Row

FREEDOM: Final = 6.0
OUTLIER: Final = 5.0
ROUNDS: Final = 4
"""Most rounds in which weights and sizes are fitted in turn."""
NOISE_LN: Final = 0.7
"""The uncertainty of the noise beforehand: standard deviation of its logarithm."""
NOISE_REACH: Final = (1 / 8, 16.0)
"""The noise lies between so many times the expected."""


@dataclass(frozen=True)
class Block:
    """Columns (n, k), and the least and the largest scale of their coefficients; both alike: the scale is known."""

    rows: Array
    least: float = 1.0
    most: float = 1.0


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


def mixed(values: Array, blocks: Mapping[str, Block], weight: Array, noise: float) -> Mixed:
    """Fits values (n,) with expected noise `noise`; a value of weight 1/2 counts half. One unit for all lengths."""
    rows = np.hstack([np.zeros((len(values), 0)), *(block.rows for block in blocks.values())])
    ends = np.cumsum([0, *(block.rows.shape[1] for block in blocks.values())])
    own, reach = np.repeat(np.arange(len(blocks)), np.diff(ends)), [noise * end for end in NOISE_REACH]
    bounds = np.log([*((block.least, block.most) for block in blocks.values()), reach]).tolist()
    sizes = np.array([*(0.5 * (low + high) for low, high in bounds[:-1]), np.log(noise)])
    tail = np.ones(len(values))
    for _ in range(ROUNDS):
        badness = _Badness(rows, values, weight * tail, (float(weight.sum()), noise), own)
        found = minimize(badness.of, sizes, jac=True, method="L-BFGS-B", bounds=bounds, options={"ftol": 1e-7})
        sizes = np.asarray(found.x, dtype=np.float64)
        scale, sigma = np.exp(sizes[:-1]), float(np.exp(sizes[-1]))
        z, covariance, fisher = badness.posterior(sizes)
        scaled = rows * scale[own]
        rest = values - scaled @ z
        squares = rest**2 + np.sum((scaled @ covariance) * scaled, axis=1)
        tail = (FREEDOM + 1) / (FREEDOM + squares / sigma**2)
    mean = {name: z[a:b] for name, a, b in zip(blocks, ends, ends[1:], strict=False)}
    scales = dict(zip(blocks, scale.tolist(), strict=True))
    return Mixed(
        scales=scales,
        noise=sigma,
        mean=mean,
        covariance=covariance,
        fisher=fisher,
        outlier=np.abs(rest) > OUTLIER * sigma,
    )


class _Badness:
    """The negative logarithm of the marginal likelihood of all sizes, from sums over the values that serve all sizes.

    `count` values are expected to scatter by `noise`; `own` (q,) is the block of each column. Sizes are logarithms: of
    the blocks' scales, then of the noise.
    """

    def __init__(self, rows: Array, values: Array, weight: Array, expected: tuple[float, float], own: Integers) -> None:
        self.normal, self.right = rows.T @ (rows * weight[:, None]), rows.T @ (weight * values)
        self.squares, (self.count, self.noise), self.own = float(values @ (weight * values)), expected, own

    def posterior(self, sizes: Array) -> tuple[Array, Array, Array]:
        """Returns mean (q,) and covariance (q, q) of z, and the information of the values alone."""
        scale, sigma = np.exp(sizes[:-1])[self.own], float(np.exp(sizes[-1]))
        fisher = self.normal * np.outer(scale, scale) / sigma**2
        covariance = np.linalg.inv(np.eye(len(scale)) + fisher)
        return covariance @ (scale * self.right) / sigma**2, covariance, fisher

    def of(self, sizes: Row) -> tuple[float, Row]:
        """Returns value and gradient, (blocks + 1,)."""
        (z, covariance, fisher), sigma = self.posterior(sizes), np.exp(sizes[-1])
        along = np.exp(sizes[:-1])[self.own] * self.right @ z / sigma**2
        of_all, off = self.squares / sigma**2, sizes[-1] - np.log(self.noise)
        known = np.bincount(self.own, 1.0 - np.diag(covariance), len(sizes) - 1)
        value = -0.5 * np.linalg.slogdet(covariance)[1] + self.count * sizes[-1] + 0.5 * (of_all - along)
        left = of_all - 2.0 * along + z @ fisher @ z
        of_noise = self.count - known.sum() - left + off / NOISE_LN**2
        slopes = known - np.bincount(self.own, z**2, len(sizes) - 1)
        return float(value + 0.5 * (off / NOISE_LN) ** 2), np.array([*slopes, of_noise])
