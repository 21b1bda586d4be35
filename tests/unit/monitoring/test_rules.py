"""Each of Nelson's tests on the shortest series that it means, and on one that misses it by one value."""

import numpy as np
import pytest

from trueloop.monitoring.charts import RULES, Rule

SHORTEST: dict[int, list[float]] = {
    1: [3.1],
    2: [0.1] * 9,
    3: [-0.5, -0.3, -0.1, 0.1, 0.3, 0.5],
    4: [0.2, -0.2] * 7,
    5: [2.1, 0.0, 2.1],
    6: [1.1, 1.1, -0.1, 1.1, 1.1],
    7: [0.9, -0.9] * 7 + [0.9],
    8: [1.1, -1.1, -1.1, 1.1, 1.1, 1.1, -1.1, -1.1],
}


def marked(values: list[float], number: int) -> list[int]:
    rule = next(rule for rule in RULES if rule.number == number)
    return np.flatnonzero(rule.marks(np.array(values))).tolist()


@pytest.mark.parametrize("number", SHORTEST)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_marks_the_value_at_which_the_pattern_is_complete(number: int, side: float) -> None:
    values = [side * value for value in SHORTEST[number]]
    assert marked(values, number) == [len(values) - 1]
    assert marked(values[1:], number) == []


def test_equal_values_neither_rise_nor_alternate() -> None:
    assert marked([0.5] * 20, 3) == marked([0.5] * 20, 4) == []


def test_both_sides_together_are_no_side() -> None:
    assert marked([2.1, 0.0, -2.1], 5) == marked([1.1, 1.1, -1.1, -1.1, 1.1], 6) == []


@pytest.mark.parametrize(
    ("number", "values"),
    [
        (1, [3.0, -3.0]),
        (2, [0.1] * 8 + [0.0]),
        (2, [-0.1] * 8 + [0.0]),
        (5, [2.0, 2.0, 2.0, 0.0, -2.0, -2.0, -2.0]),
        (6, [1.0] * 5 + [0.0] * 5 + [-1.0] * 5),
        (7, [0.9] * 14 + [1.0]),
        (7, [1.5, -1.5] * 10),
        (8, [1.0, -1.0] * 8),
    ],
)
def test_a_value_on_a_line_is_not_beyond_it(number: int, values: list[float]) -> None:
    series = np.array(values)
    rule = next(rule for rule in RULES if rule.number == number)
    assert not rule.marks(series).any() and not rule.marks(-series).any()


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: str(rule.number))
def test_many_series_at_once_are_marked_as_each_alone(rule: Rule) -> None:
    """Random ones, and one that rises and one that goes up and down all the way: every rule marks some."""
    z = np.random.default_rng(237).normal(size=(40, 60))
    z[:, 20:40] *= np.linspace(0.0, 4.0, 40)[:, None]
    z[1], z[2] = np.linspace(-4.0, 4.0, 60), np.resize([0.4, -0.5], 60)
    alone = np.array([rule.marks(row) for row in z])
    assert alone.any() and not alone.all()
    np.testing.assert_array_equal(rule.marks(z), alone)
