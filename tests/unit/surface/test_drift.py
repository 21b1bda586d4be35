"""The test for a pattern that changes from part to part, against a regression, and on parts that do not change."""

import numpy as np
import pytest
from scipy.stats import linregress

from tests.support.surfaces import random_surface
from trueloop.surface.pattern.pattern import drift_of
from trueloop.surface.separation.spline_surface import Size, SplineSurface


def constant(value: float) -> SplineSurface:
    return SplineSurface(Size(5, 5, 3), np.full((5, 5), value))


@pytest.mark.parametrize("slope", [0.0, 0.3, -2.0])
def test_parts_that_differ_in_one_shape_are_a_straight_line_fit(slope: float) -> None:
    """Constant surfaces differ by one number: the F test is then the t test of a regression's slope."""
    values = slope * np.arange(8) + np.random.default_rng(3).normal(0, 1.0, 8)
    found, expected = drift_of([constant(value) for value in values]), linregress(np.arange(8), values)
    assert found is not None
    assert found.p_value == pytest.approx(expected.pvalue, rel=1e-9)
    assert found.per_part_mm == pytest.approx(abs(expected.slope), rel=1e-9)


@pytest.mark.parametrize(("controls", "parts"), [(5, 5), (5, 12), (9, 6)])
def test_parts_that_do_not_change_seldom_raise_an_alarm(controls: int, parts: int) -> None:
    random = np.random.default_rng(controls + parts)
    small = 0
    for _ in range(200):
        found = drift_of([random_surface(random, controls, 1e-3) for _ in range(parts)])
        assert found is not None
        small += found.p_value < 0.01
    assert small <= 7  # 2 are expected; more than 7 come by chance once in a thousand times


def test_a_change_in_every_part_is_found() -> None:
    random = np.random.default_rng(1)
    change = random_surface(random, 7, 5e-4).coefficients_mm
    size = Size(7, 7, 3)
    parts = [SplineSurface(size, random_surface(random, 7, 1e-3).coefficients_mm + k * change) for k in range(8)]
    found = drift_of(parts)
    assert found is not None and found.p_value < 1e-3
    backwards = drift_of(parts[::-1])
    assert backwards is not None and backwards.p_value == pytest.approx(found.p_value, rel=1e-9)


def test_few_parts_tell_nothing_and_equal_parts_do_not_change() -> None:
    assert drift_of([constant(float(k)) for k in range(4)]) is None
    same = drift_of([constant(1.0)] * 6)
    assert same is not None and same.p_value == 1.0
