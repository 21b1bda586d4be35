"""Repeats at one point: what holds is rarely called unstable, and what does not is named."""

from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.diagnosis.features.fixturing import Instability, fixturing, unstable
from trueloop.errors import Code, TrueloopError

U = 0.001


def shown(made: Callable[[np.random.Generator], Array], times: int, seed: int = 3) -> Counter[Instability]:
    rng = np.random.default_rng(seed)
    return Counter(fixturing(made(rng), U).shows for _ in range(times))


@pytest.mark.parametrize("count", [5, 8, 20])
def test_what_holds_is_called_unstable_in_one_of_a_hundred_at_most(count: int) -> None:
    found = shown(lambda rng: rng.normal(0.3, U, count), 2000)
    assert 1 - found[Instability.NONE] / 2000 < 0.01 + 2.5 * np.sqrt(0.01 * 0.99 / 2000)
    assert found[Instability.NONE] < 2000


N = 12
TIME = np.linspace(0, 1, N)


@pytest.mark.parametrize(
    ("pattern", "scatter", "named", "share"),
    [
        (8 * U * TIME, 1.0, Instability.DRIFT, 0.95),
        (-8 * U * TIME, 1.0, Instability.DRIFT, 0.95),
        (8 * U * (TIME > 0.5), 1.0, Instability.STEP, 0.95),
        (12 * U * (1 - np.exp(-TIME / 0.2)), 1.0, Instability.WARM_UP, 0.95),
        (0 * TIME, 4.0, Instability.SPREAD, 0.8),
    ],
)
def test_instability_is_named(pattern: Array, scatter: float, named: Instability, share: float) -> None:
    found = shown(lambda rng: pattern + rng.normal(0.0, scatter * U, N), 300)
    assert found[named] / 300 > share


def test_sizes_are_those_of_polyfit_and_of_the_means() -> None:
    rng = np.random.default_rng(8)
    drift = 20 * U * TIME + rng.normal(0, U, N)
    (slope, _), covariance = np.polyfit(TIME, drift, 1, cov="unscaled")
    found = fixturing(drift, U).drift
    assert found.significant
    assert found.value_mm == pytest.approx(slope)
    scatter = np.sqrt(np.sum((drift - np.polyval(np.polyfit(TIME, drift, 1), TIME)) ** 2) / (N - 2))
    assert found.standard_u_mm == pytest.approx(max(scatter, U) * np.sqrt(covariance[0, 0]))
    stepped = rng.normal(0, U, N) - 15 * U * (np.arange(N) >= 4)
    step = fixturing(stepped, U)
    assert (step.shows, step.step_at) == (Instability.STEP, 4)
    assert step.step.value_mm == pytest.approx(stepped[4:].mean() - stepped[:4].mean())


def test_a_warm_up_settles() -> None:
    rng, time = np.random.default_rng(9), np.arange(20)
    found = fixturing(0.02 * (1 - np.exp(-time / 3.8)) + rng.normal(0, U, 20), U)
    assert found.shows is Instability.WARM_UP
    assert found.settles_after == pytest.approx(3 * 3.8, rel=0.35)
    assert found.drift.value_mm == pytest.approx(0.02, abs=0.004)


def test_what_is_significant_and_below_the_limit_is_stable() -> None:
    rng = np.random.default_rng(10)
    values = 10 * U * (TIME > 0.5) + rng.normal(0, U, N)
    small, large = fixturing(values, U, limit_mm=0.05), fixturing(values, U, limit_mm=0.002)
    assert small.stable
    assert small.step.significant
    assert unstable("part probe", small) is None
    finding = unstable("part probe", large)
    assert finding is not None
    assert finding.code is Code.DIA_UNSTABLE
    assert finding.values["limit_um"] == pytest.approx(2.0)
    assert finding.values["size_um"] == pytest.approx(large.step.value_mm * 1000)


def test_too_few_repeats_are_refused() -> None:
    with pytest.raises(TrueloopError) as refused:
        fixturing(np.array([0.1, 0.1, np.nan, 0.1, 0.1]), U)
    assert refused.value.code is Code.DIA_FEW
    assert refused.value.values == {"count": 4, "needed": 5}
