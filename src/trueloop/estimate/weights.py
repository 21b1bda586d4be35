"""Values weighed by how probably each is a gross error, and scales of coefficients with heavy tails.

A value is good, with the noise's variance r, or with probability `gross` a gross error of `gross_factor`² times that.
How probably follows from what all others expect of it: with the left-out difference d of variance v,

    P / (1 − P) = gross / (1 − gross) · N(d; 0, v + (k² − 1) r) / N(d; 0, v)

and a value then has the noise r / (1 − P + P/k²). Coefficients b (m,) of a term with `tail` ν have the variance s·σ²
each, s = (ν + E[b²]/σ² summed) / (ν + m): the expectation step of Student's distribution as a mixture of normal ones.
Weights and scales depend on each other: repeated until they stand.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.linalg import cholesky, lapack

from trueloop.arrays import Array
from trueloop.estimate.term import Catalogue

ROUNDS: Final = 25
STANDS: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Heavy:
    """Coefficients with heavy tails: what the values follow them by (n, m), their variances (m,), their `tail`."""

    design: Array
    variance: Array
    tail: float


@dataclass(frozen=True, eq=False)
class Weighted:
    """`factor`: the lower Cholesky factor (n, n) of the values' covariance with weights and scales in it.

    `scales` are those of the coefficients with heavy tails, in their order.
    """

    factor: Array
    scales: Array
    gross: Array
    left_out_mm: Array
    left_out_u_mm: Array


def plain(covariance_mm2: Array, off_mm: Array, heavy: int = 0) -> Weighted:
    """Returns weights for all n values good and all scales 1.

    With P = V⁻¹ the prediction of value i from all others misses by (P e)_i / P_ii, with the variance 1 / P_ii.
    """
    factor, inverse = _inverted(covariance_mm2)
    precision = np.diag(inverse)
    left_out = (inverse @ off_mm) / precision
    return Weighted(factor, np.ones(heavy), np.zeros(len(off_mm)), left_out, 1.0 / np.sqrt(precision))


def weighted(
    covariance_mm2: Array, noise_mm2: Array, off_mm: Array, catalogue: Catalogue, heavy: Sequence[Heavy]
) -> Weighted:
    """Of n values that are `off_mm` (n,) from what is expected, with the noise (n,) in their covariance (n, n)."""
    gross, scales = np.zeros(len(off_mm)), np.ones(len(heavy))
    for k in range(ROUNDS):
        more = more_noise(noise_mm2, gross, catalogue)
        covariance = covariance_mm2 + np.diag(more)
        for one, scale in zip(heavy, scales, strict=True):
            covariance += (one.design * ((scale - 1.0) * one.variance)) @ one.design.T
        factor, inverse = _inverted(covariance)
        solved, precision = inverse @ off_mm, np.diag(inverse)
        left_out, good = solved / precision, np.maximum(1.0 / precision - more, noise_mm2)
        squared = left_out**2
        bad = good + (catalogue.gross_factor**2 - 1.0) * noise_mm2
        odds = np.log(catalogue.gross / (1.0 - catalogue.gross))
        odds = odds + 0.5 * (np.log(good / bad) + squared / good - squared / bad)
        new = np.asarray(1.0 / (1.0 + np.exp(-np.clip(odds, -50.0, 50.0))))
        wider = np.array([_scale(one, scale, solved, inverse) for one, scale in zip(heavy, scales, strict=True)])
        stands = np.max(np.abs(new - gross), initial=0.0) < STANDS
        stands = stands and np.max(np.abs(wider / scales - 1.0), initial=0.0) < STANDS
        if stands or k == ROUNDS - 1:  # scales and weights that stay are those of the factor
            break
        gross, scales = 0.5 * (gross + new), wider
    return Weighted(factor, scales, gross, left_out, np.sqrt(good))


def more_noise(noise_mm2: Array, gross: Array, catalogue: Catalogue) -> Array:
    """Returns by how much the variance of values that may be gross errors is larger than the noise, (n,)."""
    return np.asarray(noise_mm2 * (1.0 / (1.0 - gross + gross / catalogue.gross_factor**2) - 1.0))


def _scale(heavy: Heavy, scale: float, solved: Array, inverse: Array) -> float:
    """The next scale, from what coefficients of the variance scale·σ² are given the values."""
    variance = scale * heavy.variance
    mean = variance * (heavy.design.T @ solved)
    left = variance - variance**2 * np.einsum("ij,ij->j", heavy.design, inverse @ heavy.design)
    return float((heavy.tail + np.sum((mean**2 + left) / heavy.variance)) / (heavy.tail + len(variance)))


def _inverted(covariance: Array) -> tuple[Array, Array]:
    """Lower Cholesky factor and inverse, (n, n) each."""
    if not len(covariance):  # LAPACK takes no empty matrix and prints that on stderr
        return covariance, covariance
    factor = cholesky(covariance, lower=True, check_finite=False)
    inverse = lapack.dpotri(factor, lower=True)[0]
    inverse = np.tril(inverse) + np.tril(inverse, -1).T
    return factor, inverse
