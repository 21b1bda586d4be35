"""The correlation of neighbours in a series: with it, limits from moving ranges are too narrow."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.statistics import NORMAL_95


@dataclass(frozen=True)
class Correlation:
    """That of neighbours, `lag_1` of `count` values; `limit` is what independent ones stay below with 95 %."""

    lag_1: float
    limit: float
    count: int

    @property
    def significant(self) -> bool:
        """Returns whether it is more than chance."""
        return abs(self.lag_1) > self.limit

    @property
    def width(self) -> float:
        """Returns the share of their right width that limits from the moving range have: E|x₂ − x₁| = d2 σ √(1 − ρ)."""
        return float(np.sqrt(max(1.0 - self.lag_1, 0.0)))


def correlation(values: Array) -> Correlation:
    """Estimates the correlation of values (n,) in the order in which they came, n ≥ 3; without its bias of −1/n [Box,
    Jenkins 1976].
    """
    about, n = values - values.mean(), len(values)
    lag_1 = float(about[1:] @ about[:-1] / (about @ about)) + 1.0 / n if np.any(about) else 0.0
    return Correlation(lag_1, NORMAL_95 / float(np.sqrt(n)), n)
