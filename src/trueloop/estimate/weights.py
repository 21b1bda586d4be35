"""Values weighed by how probably each is a gross error, and scales of coefficients with heavy tails.

A value is good, with the noise's variance r, or with probability `gross` a gross error of `gross_factor`² times that.
How probably follows from what all others expect of it: with the left-out difference d of variance v,

    P / (1 − P) = gross / (1 − gross) · N(d; 0, v + (k² − 1) r) / N(d; 0, v)

and a value then has the noise r / (1 − P + P/k²). Coefficients b (m,) of a term with `tail` ν have the variance s·σ²
each, s = (ν + E[b²]/σ² summed) / (ν + m): the expectation step of Student's distribution as a mixture of normal ones.
Weights and scales depend on each other: repeated until they stand.

Sizes on a grid, weighed by Bayes' rule; and how well hypotheses explain values: marginal likelihoods, so that a
hypothesis with more parameters has to earn them.

A hypothesis states that the values are sums of columns with normal coefficients of unknown size, beside noise of
unknown variance. Sizes are tried on a grid, the noise's variance is integrated out (Student's t), all in units of what
one value scatters by to begin with.
"""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final, TypeVar

import numpy as np
from scipy.linalg import lapack

from trueloop.arrays import Array, Integers
from trueloop.estimate.catalogue import Catalogue

H = TypeVar("H", bound=Hashable)
SIZES: Final = (0.3, 2.0, 10.0, 60.0, 400.0)
"""Variances of what a cause leaves, in variances of the noise: what is tried."""


def log_student(
    gram: Array, right: Array, squares: Array | float, count: int, variances: Array, stated: float = 2.0
) -> Array:
    """Logarithms of the likelihood of `count` values with covariance v (1 + rows · diag(variances) · rowsᵀ), (...,).

    v has `stated` observations of 1 beforehand. `gram` (..., k, k) is rowsᵀ · rows, `right` (..., k) rowsᵀ · values,
    `squares` (...) values · values, `variances` (..., k). So rows are gone through once for all hypotheses on them.
    """
    root = np.sqrt(variances)
    size = root.shape[-1]
    inside = np.empty((*np.broadcast_shapes(root.shape[:-1], right.shape[:-1]), size + 1, size + 1))
    inside[..., :size, :size] = root[..., :, None] * gram * root[..., None, :] + np.eye(size)
    inside[..., size, :size] = inside[..., :size, size] = root * right
    inside[..., size, size] = stated + np.asarray(squares)
    # the last element of the factor is what is left of the values: one factor gives volume and squares
    diagonal = np.diagonal(np.linalg.cholesky(inside), axis1=-2, axis2=-1)
    logs: Array = -np.log(diagonal[..., :size]).sum(axis=-1)
    logs -= (stated + count) / 2 * np.log(diagonal[..., size] ** 2 / stated)
    return logs


def probabilities(log_weight: Array, axis: int | None = -1) -> Array:
    """Returns weights, whose logarithms are known but for a constant, with the sum 1 along an axis; None: of all."""
    weight = np.exp(log_weight - log_weight.max(axis=axis, keepdims=True))
    return np.asarray(weight / weight.sum(axis=axis, keepdims=True))


def tried(sizes: Sequence[Sequence[float]], of: Integers) -> Array:
    """Returns all combinations of the blocks' sizes, as sizes of columns; `of` (...): each one's block, (m, ...)."""
    return np.asarray(np.array(list(product(*sizes)))[:, of])


def shares(log_weights: Mapping[H, float]) -> dict[H, float]:
    """Probabilities of hypotheses from the logarithms of their weights (prior times likelihood), likeliest first."""
    found = dict(zip(log_weights, probabilities(np.array([*log_weights.values()])).tolist(), strict=True))
    return dict(sorted(found.items(), key=lambda item: -item[1]))


ROUNDS: Final = 25
STANDS: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Heavy:
    """Coefficients with heavy tails: what the values follow them by (n, m), their variances (m,), their `tail`."""

    design: Array
    variance: Array
    tail: float


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Some of them side by side; `block` (m,) is which of them each coefficient is of, `tail` (k,) is of each."""

    design: Array
    variance: Array
    block: Integers
    tail: Array

    @classmethod
    def of(cls, heavy: Sequence[Heavy]) -> "_Blocks":
        sizes = [len(one.variance) for one in heavy]
        return cls(
            np.hstack([one.design for one in heavy]),
            np.concatenate([one.variance for one in heavy]),
            np.repeat(np.arange(len(heavy)), sizes),
            np.array([one.tail for one in heavy]),
        )

    def more_mm2(self, scales: Array) -> Array:
        """Returns by how much the covariance of the values grows with scales (k,), (n, n)."""
        return np.asarray((self.design * ((scales[self.block] - 1.0) * self.variance)) @ self.design.T)

    def next_scales(self, scales: Array, solved: Array, inverse: Array) -> Array:
        """Returns the next ones, from what coefficients of the variance scale·σ² are given the values, (k,)."""
        variance = scales[self.block] * self.variance
        mean = variance * (self.design.T @ solved)
        left = variance - variance**2 * np.einsum("ij,ij->j", self.design, inverse @ self.design)
        squares = np.bincount(self.block, (mean**2 + left) / self.variance)
        return np.asarray((self.tail + squares) / (self.tail + np.bincount(self.block)))


@dataclass(frozen=True, eq=False)
class Weighted:
    """`factor`: lower Cholesky factor (n, n) of the weighted values' covariance; `scales`: of heavy-tailed terms."""

    factor: Array
    scales: Array
    gross: Array
    left_out_mm: Array
    left_out_u_mm: Array


def plain(covariance_mm2: Array, off_mm: Array) -> Weighted:
    """Returns weights of n good values: by P = V⁻¹ the others miss value i by (P e)_i / P_ii, variance 1 / P_ii."""
    factor, inverse = _inverted(covariance_mm2)
    precision = np.diag(inverse)
    left_out = (inverse @ off_mm) / precision
    return Weighted(factor, np.zeros(0), np.zeros(len(off_mm)), left_out, 1.0 / np.sqrt(precision))


def weighted(
    covariance_mm2: Array, noise_mm2: Array, off_mm: Array, catalogue: Catalogue, heavy: Sequence[Heavy]
) -> Weighted:
    """Of n values that are `off_mm` (n,) from what is expected, with the noise (n,) in their covariance (n, n)."""
    gross, scales = np.zeros(len(off_mm)), np.ones(len(heavy))
    blocks = _Blocks.of(heavy) if heavy else None
    more, bad_mm2 = np.zeros(len(off_mm)), (catalogue.gross_factor**2 - 1.0) * noise_mm2
    prior = np.log(catalogue.gross / (1.0 - catalogue.gross))
    for k in range(ROUNDS):
        covariance = covariance_mm2.copy() if blocks is None else covariance_mm2 + blocks.more_mm2(scales)
        np.einsum("ii->i", covariance)[:] += more
        factor, inverse = _inverted(covariance)
        solved, precision = inverse @ off_mm, np.diag(inverse)
        left_out, good = solved / precision, np.maximum(1.0 / precision - more, noise_mm2)
        squared, bad = left_out**2, good + bad_mm2
        odds = prior + 0.5 * (np.log(good / bad) + squared / good - squared / bad)
        new = 1.0 / (1.0 + np.exp(-np.clip(odds, -50.0, 50.0)))
        wider = scales if blocks is None else blocks.next_scales(scales, solved, inverse)
        stands = np.max(np.abs(new - gross), initial=0.0) < STANDS
        stands = stands and np.max(np.abs(wider / scales - 1.0), initial=0.0) < STANDS
        if stands or k == ROUNDS - 1:  # scales and weights that stay are those of the factor
            break
        gross, scales = 0.5 * (gross + new), wider
        more = more_noise(noise_mm2, gross, catalogue)
    return Weighted(factor, scales, gross, left_out, np.sqrt(good))


def more_noise(noise_mm2: Array, gross: Array, catalogue: Catalogue) -> Array:
    """Returns by how much the variance of values that may be gross errors is larger than the noise, (n,)."""
    return np.asarray(noise_mm2 * (1.0 / (1.0 - gross + gross / catalogue.gross_factor**2) - 1.0))


def _inverted(covariance: Array) -> tuple[Array, Array]:
    """Lower Cholesky factor and inverse, (n, n) each."""
    if not len(covariance):  # LAPACK takes no empty matrix and prints that on stderr
        return covariance, covariance
    factor, failed = lapack.dpotrf(covariance, lower=True, clean=True)
    if failed:
        raise np.linalg.LinAlgError("a covariance is not positive definite")
    inverse = lapack.dpotri(factor, lower=True)[0]
    inverse += inverse.T
    np.einsum("ii->i", inverse)[:] *= 0.5
    return factor, inverse
