"""Sizes on a grid, weighed by Bayes' rule; and how well hypotheses explain values: marginal likelihoods, so that a
hypothesis with more parameters has to earn them.

A hypothesis states that the values are sums of columns with normal coefficients of unknown size, beside noise of
unknown variance. Sizes are tried on a grid, the noise's variance is integrated out (Student's t), all in units of what
one value scatters by to begin with.
"""

from collections.abc import Hashable, Mapping, Sequence
from itertools import product
from typing import Final, TypeVar

import numpy as np

from trueloop.arrays import Array, Integers

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
    """Returns every combination of the sizes of blocks, as sizes of the columns: `of` (...) is the block of each, (m,
    ...).
    """
    return np.asarray(np.array(list(product(*sizes)))[:, of])


def shares(log_weights: Mapping[H, float]) -> dict[H, float]:
    """Probabilities of hypotheses from the logarithms of their weights (prior times likelihood), likeliest first."""
    found = dict(zip(log_weights, probabilities(np.array([*log_weights.values()])).tolist(), strict=True))
    return dict(sorted(found.items(), key=lambda item: -item[1]))
