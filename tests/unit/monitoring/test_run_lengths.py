"""How long charts run before they alarm, in control and after a shift, beside what was published."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from trueloop.arrays import Array, Flags
from trueloop.monitoring.charts import (
    CUSUM_ALLOWANCE,
    CUSUM_INTERVAL,
    EWMA_WEIGHT,
    EWMA_WIDTH,
    RULES,
    cusum_sums,
    ewma_sigma,
    moving_average,
)

RUNS = 8000
"""The mean run length of as many runs has a standard deviation of 1.1 % of itself."""
CLOSE = 0.05


@dataclass(frozen=True)
class Published:
    """Mean run length at a shift in σ."""

    source: str
    marks: Callable[[Array], Flags]
    lengths: dict[float, float]


def _ewma(weight: float, width: float) -> Callable[[Array], Flags]:
    """With the limits that hold after many values, as in the tables."""
    return lambda z: np.abs(moving_average(z, weight)) > width * ewma_sigma(weight, 10_000)[-1]


def _cusum(allowance: float, interval: float) -> Callable[[Array], Flags]:
    return lambda z: np.maximum(*cusum_sums(z, allowance)) > interval


def _nelson(*numbers: int) -> Callable[[Array], Flags]:
    return lambda z: np.any([rule.marks(z) for rule in RULES if rule.number in numbers], axis=0)


PUBLISHED = (
    Published("3 σ, by the normal distribution", _nelson(1), {0.0: 370.4, 1.0: 43.89, 2.0: 6.30, 3.0: 2.00}),
    Published("Lucas, Saccucci 1990, table 3", _ewma(0.1, 2.814), {0.0: 500.0, 1.0: 10.3, 2.0: 4.36, 3.0: 2.87}),
    Published("Montgomery, 7th ed., table 9.3, h = 4", _cusum(0.5, 4.0), {0.0: 168.0, 1.0: 8.38, 2.0: 3.34, 3.0: 2.19}),
    Published("Montgomery, table 9.3, h = 5", _cusum(0.5, 5.0), {0.0: 465.0, 1.0: 10.4, 2.0: 4.01, 3.0: 2.57}),
    Published("Champ, Woodall 1987: C1 with C2", _nelson(1, 5), {0.0: 225.44}),
    Published("Champ, Woodall 1987: C1 with C2 and C3", _nelson(1, 5, 6), {0.0: 132.89}),
)


def mean_run_length(marks: Callable[[Array], Flags], shift: float, expected: float) -> float:
    """Over series so long that one in ten thousand ends without an alarm."""
    rng, length = np.random.default_rng(7870), int(10 * expected) + 20
    firsts = []
    for _ in range(RUNS // 500):
        alarmed = marks(rng.normal(shift, 1.0, (500, length)))
        firsts.append(np.where(alarmed.any(-1), alarmed.argmax(-1) + 1, length))
    return float(np.mean(firsts))


@pytest.mark.parametrize(
    ("published", "shift"),
    [(published, shift) for published in PUBLISHED for shift in published.lengths],
    ids=lambda value: value.source if isinstance(value, Published) else f"{value:g} σ",
)
def test_run_lengths_are_those_published(published: Published, shift: float) -> None:
    expected = published.lengths[shift]
    assert mean_run_length(published.marks, shift, expected) == pytest.approx(expected, rel=CLOSE)


def test_the_charts_as_they_are_set_run_as_long_as_shewharts() -> None:
    def sensitive(z: Array) -> Flags:
        return np.abs(moving_average(z, EWMA_WEIGHT)) > EWMA_WIDTH * ewma_sigma(EWMA_WEIGHT, z.shape[-1])

    for marks in (sensitive, _cusum(CUSUM_ALLOWANCE, CUSUM_INTERVAL)):
        assert mean_run_length(marks, 0.0, 370.4) == pytest.approx(370.4, rel=CLOSE)
        assert mean_run_length(marks, 1.0, 10.0) < 11.0  # where Shewhart's takes 44
