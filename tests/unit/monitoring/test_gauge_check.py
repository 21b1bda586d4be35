"""Bias, repeatability and drift beside formulas worked by hand, and their intervals by simulation."""

import numpy as np
import pytest

from trueloop.monitoring.capability import Drift, Slope, drift, e_n

RNG = np.random.default_rng(20)


def daily(deviations: np.ndarray, u: float = 0.0) -> Drift:
    return drift([np.array([one]) for one in deviations], np.arange(len(deviations), dtype=float), u)


def test_bias_repeatability_and_uncertainty_by_hand() -> None:
    found = drift([np.array([1.0, 3.0]), np.array([4.0, 8.0]), np.array([1.0, 1.0])], None, 0.3)
    assert (found.count, found.bias, found.freedom, found.slope) == (3, 3.0, 3, None)
    assert found.repeatability == pytest.approx(np.sqrt((1 + 1 + 4 + 4) / 3))
    between = np.sqrt((1 + 9 + 4) / 2)
    assert found.between == pytest.approx(between)
    assert found.bias_u == pytest.approx(np.sqrt(between**2 / 3 + 0.09))


def test_one_check_has_the_uncertainty_of_its_repeats_and_without_them_none() -> None:
    of_repeats = drift([np.array([1.0, 2.0, 3.0])], None, 0.3)
    assert of_repeats.bias_u == pytest.approx(np.sqrt(1.0 / 3 + 0.09)) and of_repeats.between is None
    two = drift([np.array([1.0]), np.array([3.0])], None, 0.3)
    assert two.between == pytest.approx(np.sqrt(2.0)) and two.bias_u == pytest.approx(np.sqrt(1.0 + 0.09))
    alone = drift([np.array([5.0])], None, 0.3)
    assert (alone.bias, alone.bias_u, alone.biased, alone.repeatability) == (5.0, None, False, None)


def test_the_calibration_does_not_average_out() -> None:
    assert daily(RNG.normal(size=4000), u=0.5).bias_u == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(("mean", "biased"), [(0.0, False), (1.2, True), (-1.2, True)])
def test_a_bias_beyond_its_uncertainty_is_said(mean: float, biased: bool) -> None:
    values = mean + np.array([0.4, -0.4, 0.2, -0.2, 0.3, -0.3])
    assert daily(values, u=0.1).biased is biased


def test_the_interval_of_the_drift_holds_it_as_often_as_said() -> None:
    held = []
    for _ in range(800):
        slope = daily(0.2 * np.arange(12) + RNG.normal(size=12)).slope
        assert slope is not None
        held.append(abs(slope.per_day - 0.2) <= slope.half_width)
    assert 0.925 < np.mean(held) < 0.975


def test_a_fall_is_negative_and_two_times_say_no_drift() -> None:
    slope = daily(-0.5 * np.arange(10) + 0.01 * RNG.normal(size=10)).slope
    assert slope is not None and slope.significant and slope.per_day == pytest.approx(-0.5, abs=0.01)
    assert drift([np.array([1.0])] * 4, np.array([0.0, 0.0, 1.0, 1.0]), 0.1).slope is None


def test_e_n_is_of_both_expanded_uncertainties() -> None:
    assert e_n(-2.0, 0.3, 0.4) == pytest.approx(-2.0)
    assert e_n(6.0, 1.2, 0.9) == pytest.approx(2.0)


def test_the_interval_of_three_checks_is_by_student_with_one_degree_of_freedom() -> None:
    """0, 3, 0 on three days: slope 0, residuals −1, 2, −1, so √(6 / 2) · 12.7062; three different days suffice."""
    slope = daily(np.array([0.0, 3.0, 0.0])).slope
    assert slope is not None and (slope.per_day, slope.half_width) == pytest.approx((0.0, 22.0078), abs=1e-4)


def test_a_gauge_that_never_deviates_is_neither_biased_nor_drifting() -> None:
    """As a gauge that resolves no more than its deviations: all checks read alike."""
    found = daily(np.zeros(4))
    assert found.bias_u == 0.0 and not found.biased
    assert found.slope == Slope(0.0, 0.0) and not found.slope.significant
