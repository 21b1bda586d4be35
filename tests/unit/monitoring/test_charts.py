"""Limits and alarms of the charts by hand arithmetic, for a centre of 10 and σ = 2: neither is 0 or 1."""

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.monitoring.charts import Baseline, baseline, cusum, ewma, individuals, moving_range

BASE = Baseline(10.0, 2.0, 20)


def test_a_baseline_is_the_mean_and_the_mean_moving_range_over_d2() -> None:
    """Ranges 2, 4, 2, 4, 2, 4, 2: their mean 20/7 over 2/√π."""
    found = baseline([10.0, 12.0, 8.0, 10.0, 14.0, 12.0, 8.0, 10.0])
    assert (found.centre, found.count) == (10.5, 8)
    assert found.sigma == pytest.approx(20.0 / 7.0 / 1.1283792, rel=1e-7)


@pytest.mark.parametrize("values", [[5.0], [1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0], [3.0] * 8])
def test_too_few_or_equal_values_make_no_baseline(values: list[float]) -> None:
    with pytest.raises(TrueloopError) as refusal:
        baseline(values)
    assert refusal.value.code is Code.MON_FEW and refusal.value.values == {"count": len(values)}


def test_a_range_an_average_or_a_sum_on_its_limit_is_no_alarm() -> None:
    """16 is 3 σ off, half of it 1.5 σ: with weight 0.5 the first average has a σ of 0.5. 12 adds 0.5 σ to the sum."""
    limit = float(moving_range(np.array([0.0, 0.0]), BASE).high[1])
    assert moving_range(np.array([0.0, limit]), BASE).alarms == ()
    assert ewma(np.array([16.0]), BASE, 0.5, 3.0).alarms == ()
    assert [chart.alarms for chart in cusum(np.array([12.0, 12.0]), BASE, 0.5, 1.0)] == [(), ()]
    assert ewma(np.array([16.01]), BASE, 0.5, 3.0).alarms != ()


def test_individuals_are_marked_beyond_three_sigma() -> None:
    chart = individuals(np.array([10.0, 15.9, 16.1, 3.9, 4.1]), BASE)
    assert chart.low.tolist() == [4.0] * 5 and chart.high.tolist() == [16.0] * 5 and chart.centre == 10.0
    assert [alarm.index for alarm in chart.alarms] == [2, 3]


def test_the_moving_range_has_its_own_centre_and_limit() -> None:
    """d2 σ = 2.256758, (d2 + 3 d3) σ = 7.371772 with d2 = 1.128379, d3 = 0.852502."""
    chart = moving_range(np.array([10.0, 17.3, 9.9, 10.0]), BASE)
    assert chart.centre == pytest.approx(2.256758, abs=1e-6)
    assert chart.high[0] == pytest.approx(7.371772, abs=2e-6) and chart.low.tolist() == [0.0] * 4
    assert np.isnan(chart.plotted[0]) and chart.plotted[1:] == pytest.approx([7.3, 7.4, 0.1])
    assert [alarm.index for alarm in chart.alarms] == [2]


def test_the_weighted_average_follows_its_own_sigma() -> None:
    """Weight 0.2: σ of the average 0.2 σ, then 0.2 √1.64 σ; 17 moves it by 0.2 · 3.5 σ, 10 leaves 0.8 of that."""
    chart = ewma(np.array([17.0, 10.0]), BASE, 0.2, 3.0)
    assert chart.plotted == pytest.approx([11.4, 11.12])
    assert chart.high == pytest.approx([11.2, 10.0 + 1.2 * np.sqrt(1.64)])
    assert chart.low == pytest.approx([8.8, 10.0 - 1.2 * np.sqrt(1.64)])
    assert [alarm.index for alarm in chart.alarms] == [0]
    assert [alarm.index for alarm in ewma(np.array([3.0, 10.0]), BASE, 0.2, 3.0).alarms] == [0]


def test_sums_grow_by_what_is_beyond_the_allowance() -> None:
    """14 is 2 σ above: 1.5 σ a value remain. Beyond 4 σ = 8 from the third on, until 8 takes 1.5 σ away."""
    up, down = cusum(np.array([14.0, 14.0, 14.0, 8.0, 8.0]), BASE, 0.5, 4.0)
    assert up.plotted == pytest.approx([3.0, 6.0, 9.0, 6.0, 3.0])
    assert down.plotted == pytest.approx([0.0, 0.0, 0.0, 1.0, 2.0])
    assert up.high.tolist() == [8.0] * 5 and up.centre == 0.0
    assert ([alarm.index for alarm in up.alarms], down.alarms) == ([2], ())
