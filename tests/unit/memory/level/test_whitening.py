"""A test of the signs of the latest innovations."""

import numpy as np
import pytest

from trueloop.memory.level.kalman import monitor


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
