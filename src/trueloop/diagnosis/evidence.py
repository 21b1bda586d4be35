"""How well hypotheses explain values: marginal likelihoods, so that one with more parameters has to earn them.

A hypothesis says that the values are sums of columns with normal coefficients of unknown size, beside noise of
unknown variance. Sizes are tried on a grid, the noise's variance is integrated out (Student's t), all in units of what
one value scatters by to begin with.
"""

from collections.abc import Hashable, Mapping, Sequence
from itertools import product
from typing import Final, TypeVar

import numpy as np

from trueloop.arrays import Array

H = TypeVar("H", bound=Hashable)
SIZES: Final = (0.3, 2.0, 10.0, 60.0, 400.0)
"""Variances of what a cause leaves, in variances of the noise: what is tried."""


def evidence(values: Array, blocks: Sequence[tuple[Array, Sequence[float]]]) -> float:
    """Logarithm of the marginal likelihood of values (n,), in units of their noise.

    `blocks` are columns (n, k), each with the variances that are tried of its coefficients; all pairs of variances are
    tried, each as probable as any other.
    """
    found = []
    for sizes in product(*[tried for _, tried in blocks]):
        scaled = [np.sqrt(size) * rows for size, (rows, _) in zip(sizes, blocks, strict=True)]
        found.append(_log_student(values, np.hstack([np.zeros((len(values), 0)), *scaled])))
    return float(np.logaddexp.reduce(found) - np.log(len(found)))


def shares(log_weights: Mapping[H, float]) -> dict[H, float]:
    """Probabilities of hypotheses from the logarithms of their weights (prior times likelihood), likeliest first."""
    total = np.logaddexp.reduce(list(log_weights.values()))
    found = {one: float(np.exp(weight - total)) for one, weight in log_weights.items()}
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def _log_student(values: Array, rows: Array) -> float:
    """Of values with covariance v (1 + rows · rowsᵀ), v with two observations of 1 beforehand."""
    lower = np.linalg.cholesky(np.eye(rows.shape[1]) + rows.T @ rows)
    inside = np.linalg.solve(lower, rows.T @ values)
    squares = float(values @ values - inside @ inside)
    return -float(np.log(np.diag(lower)).sum()) - (1.0 + len(values) / 2) * float(np.log1p(squares / 2))
