"""Segments have their own centres and one standard deviation; no moving range crosses a boundary."""

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.monitoring.charts import RULES, baseline
from trueloop.monitoring.segments import charted

RNG = np.random.default_rng(4773)
SCATTER = RNG.normal(0.0, 2.0, 24)
ALL = np.ones(24, dtype=bool)
STEP = SCATTER + 50.0 * (np.arange(24) >= 12)


def test_one_segment_is_the_chart_of_its_baseline() -> None:
    found, base = charted(SCATTER, ALL), baseline(SCATTER)
    assert found.sigma == pytest.approx(base.sigma)
    assert found.segments[0].base == base
    assert found.z == pytest.approx((SCATTER - base.centre) / base.sigma)


def test_a_step_between_segments_is_neither_scatter_nor_an_alarm() -> None:
    found = charted(STEP, ALL, [12], RULES[:1])
    halves = [np.abs(np.diff(SCATTER[:12])), np.abs(np.diff(SCATTER[12:]))]
    assert found.sigma == pytest.approx(np.concatenate(halves).mean() * np.sqrt(np.pi) / 2.0)
    centres = [one.base.centre for one in found.segments if one.base is not None]
    assert centres == pytest.approx([STEP[:12].mean(), STEP[12:].mean()])
    assert found.z == pytest.approx(charted(SCATTER, ALL, [12]).z)
    assert found.alarms == charted(SCATTER, ALL, [12], RULES[:1]).alarms
    assert any(alarm.index == 12 for alarm in charted(STEP, np.arange(24) < 12, (), RULES[:1]).alarms)


def test_alarms_count_in_the_whole_series() -> None:
    values = STEP.copy()
    values[20] += 30.0
    base = ALL.copy()
    base[20] = False
    assert 20 in {alarm.index for alarm in charted(values, base, [12], RULES[:1]).alarms}


def test_a_segment_of_two_parts_has_no_chart_and_no_z() -> None:
    found = charted(SCATTER, ALL, [22])
    assert found.segments[1].base is None and found.segments[1].charts == ()
    assert np.isnan(found.z[22:]).all() and np.isfinite(found.z[:22]).all()


def test_three_values_of_its_own_are_a_segment_s_centre_and_the_ends_begin_none() -> None:
    found = charted(SCATTER, ALL, [0, 21, 24])
    assert [(one.first, one.stop) for one in found.segments] == [(0, 21), (21, 24)]
    last = found.segments[1].base
    assert last is not None and last.centre == pytest.approx(SCATTER[21:].mean())


@pytest.mark.parametrize("values", [SCATTER[:7], np.full(24, 3.0)])
def test_too_few_or_equal_values_say_no_standard_deviation(values: np.ndarray) -> None:
    with pytest.raises(TrueloopError) as refused:
        charted(values, ALL[: len(values)])
    assert refused.value.code is Code.MON_FEW


def test_what_is_left_out_of_the_baseline_is_in_no_limit() -> None:
    base = np.arange(24) < 12
    assert charted(STEP, base).sigma == pytest.approx(baseline(STEP[:12]).sigma)


def test_eight_values_make_a_baseline_and_a_segment_may_begin_with_the_second() -> None:
    found = charted(SCATTER[:9], ALL[:9], [1])
    assert [(one.first, one.stop) for one in found.segments] == [(0, 1), (1, 9)]
    assert found.sigma == pytest.approx(np.abs(np.diff(SCATTER[1:9])).mean() * np.sqrt(np.pi) / 2.0)
    with pytest.raises(TrueloopError) as refusal:
        charted(SCATTER[:7], ALL[:7])
    assert refusal.value.code is Code.MON_FEW
