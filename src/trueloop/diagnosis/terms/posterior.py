"""What a hypothesis makes of the residuals: sizes of what it leaves, and what it does not explain."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.evidence import SIZES
from trueloop.diagnosis.terms.question import Hypothesis, Question, log_grid
from trueloop.diagnosis.terms.set_ups import TakenOut


@dataclass(frozen=True)
class Posterior:
    """Coefficients of the columns of a hypothesis, `mean` (k,) and `covariance` (k, k), units of `NOISE_MM`.

    `noise` is the variance of one value, `setting` (ways,) those of set-ups, `left` (n,) what is not explained.
    """

    hypothesis: Hypothesis
    mean: Array
    covariance: Array
    noise: float
    setting: Array
    left: Array


def posterior(asked: Question, products: TakenOut, hypothesis: Hypothesis) -> Posterior:
    """At the likeliest sizes."""
    grid = log_grid(asked, products, [hypothesis])[0]
    setting, sizes = np.unravel_index(int(np.argmax(grid)), grid.shape)
    index, of = asked.index(hypothesis, asked.count(hypothesis))
    tried = list(product(SIZES, repeat=max(len(hypothesis), 1)))[int(sizes)]
    own = [tried[k] for k in of]
    rows = np.hstack([asked.rows[:, index], asked.set_up.rows])
    set_up = products.variances[int(setting)]
    before = np.array([*own, *set_up[asked.set_up.way]])
    weighted = rows / asked.scatter[:, None]
    spread: Array = np.asarray(np.linalg.inv(weighted.T @ weighted + np.diag(1 / before)), np.float64)
    mean = spread @ weighted.T @ (asked.values / asked.scatter)
    left = asked.values - rows @ mean
    noise = (2.0 + float(np.sum((left / asked.scatter) ** 2) + np.sum(mean**2 / before))) / (2.0 + len(left))
    k = len(index)
    return Posterior(hypothesis, mean[:k], noise * spread[:k, :k], noise, noise * set_up, left)
