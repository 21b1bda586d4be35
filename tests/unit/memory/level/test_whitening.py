"""Weights that follow the signs of what is left."""

import numpy as np
import pytest

from trueloop.memory.level.step import PartReading
from trueloop.memory.level.whitening import monitor, next_weight, whitened_steps


def test_signs_that_alternate_lower_the_weight_and_signs_that_persist_raise_it() -> None:
    signs = np.array([[1, -1, 1], [1, 1, 1], [1, 1, -1], [-1, 1, 1], [-1, -1, -1]], float)
    assert next_weight(np.full(5, 0.5), signs) == pytest.approx([0.4, 0.625, 0.5, 0.5, 0.625])
    assert next_weight(np.full(5, 0.9), signs)[1] == 1.0
    assert next_weight(np.full(5, 0.1), signs)[0] == 0.1
    assert next_weight(np.array([0.5]), signs[:1, :2]) == 0.5


def test_the_correction_moves_by_the_weight_as_in_the_report() -> None:
    """[4773 Fig. 9]: a radius 0.04 mm too large and w = 0.75 take 0.03 mm more off."""
    step = whitened_steps([PartReading(0.040, 0.010)])[0]
    assert step.change_mm == pytest.approx(0.030)
    assert step.correction_mm == pytest.approx(0.040)
    assert step.predicted_mm == pytest.approx(0.010)


def test_reasons_name_what_the_signs_did() -> None:
    over = whitened_steps([PartReading(e) for e in (0.01, -0.01, 0.01, -0.01)])
    assert [step.weight.value for step in over] == pytest.approx([0.75, 0.75, 0.6, 0.48])
    assert "overshoots" in over[2].weight.reason
    short = whitened_steps([PartReading(0.01)] * 3)
    assert short[2].weight.value == pytest.approx(0.9375)
    assert "falls short" in short[2].weight.reason


def test_a_setting_forgets_signs_and_quarantine_moves_nothing() -> None:
    readings = [PartReading(0.01), PartReading(-0.01), PartReading(0.01, set_before=True)]
    assert whitened_steps(readings)[2].weight.value == 0.75
    held = whitened_steps([*readings[:2], PartReading(0.01, 0.005, counts=False)])[2]
    assert (held.correction_mm, held.change_mm, held.weight.value) == (0.005, 0.0, 0.0)


def test_what_is_left_comes_near_white_whatever_the_actuator_does() -> None:
    """Scatter 3 µm about a level that stands still: a right weight is small, and a fixed 0.75 leaves 2.3 µm."""
    rng = np.random.default_rng(8)
    series = 400
    weight, signs, correction, left = np.full(series, 0.75), np.empty((series, 0)), np.zeros(series), []
    for _ in range(100):
        left.append(0.010 - correction)
        error = left[-1] + 0.003 * rng.normal(size=series)
        signs = np.column_stack([signs, np.sign(error)])
        weight = next_weight(weight, signs)
        correction = correction + weight * error
    assert np.sqrt(np.mean(np.array(left)[60:] ** 2)) < 0.0014


def test_the_monitor_speaks_where_chance_would_hardly_do_it() -> None:
    assert monitor(np.tile([1.0, -1.0], 7)).says.startswith("what is left changes its sign")
    assert monitor(np.ones(13)).says.startswith("what is left keeps its sign")
    assert monitor(np.tile([1.0, -1.0], 6)).probability == 1.0  # eleven pairs are too few
    agreeing = monitor(np.ones(13))
    assert (agreeing.pairs, agreeing.agreeing) == (12, 12)
    assert agreeing.probability == pytest.approx(2 / 2**12)


def test_the_monitor_seldom_speaks_by_chance() -> None:
    drawn = np.random.default_rng(3).normal(size=(2000, 13))
    assert np.mean([bool(monitor(row).says) for row in drawn]) <= 0.01
