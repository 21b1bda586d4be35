"""Student's factor against scipy's own."""

import math

import pytest
from scipy import stats

from trueloop.turned.error_curve.curve import student_t_factor


@pytest.mark.parametrize("degrees_of_freedom", [1, 2, 3, 4, 7, 20, 21, 101, 1000])
@pytest.mark.parametrize("coverage", [0.1, 0.6827, 0.95, 0.9999])
def test_agrees_with_scipy(coverage: float, degrees_of_freedom: int) -> None:
    expected = stats.t.ppf((1.0 + coverage) / 2.0, degrees_of_freedom)
    assert student_t_factor(coverage, degrees_of_freedom) == pytest.approx(expected, rel=1e-9)


def test_without_a_number_of_degrees_it_is_the_normal_distribution_s() -> None:
    assert student_t_factor(0.95, None) == pytest.approx(1.959963984540054, rel=1e-12)
    assert student_t_factor(0.95, 1001) == pytest.approx(stats.t.ppf(0.975, 1001), rel=2e-3)


@pytest.mark.parametrize("coverage", [0.0, 1.0, -0.5, math.nan])
def test_a_coverage_is_a_probability(coverage: float) -> None:
    with pytest.raises(ValueError, match="probability"):
        student_t_factor(coverage, 5)
