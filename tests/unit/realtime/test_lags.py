"""Lags stepped while the machine runs, against the solution over the whole history and a solver of its own."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from trueloop.machine.model.history import History, Lag, lagged, signals_at_end
from trueloop.realtime.image import LagRules, LagState, advanced, from_history

NO_GAPS = LagRules(gap=math.inf)
steps = st.lists(st.floats(0.01, 500.0), min_size=1, max_size=40)
readings = st.floats(-50.0, 150.0)


@given(steps, st.data(), st.floats(0.5, 5000.0), st.sampled_from([1, 2]))
def test_steps_end_where_the_whole_history_does(
    step_s: list[float], data: st.DataObject, tau: float, power: int
) -> None:
    time_s = np.concatenate([[0.0], np.cumsum(step_s)])
    values = np.array(data.draw(st.lists(readings, min_size=len(time_s), max_size=len(time_s))))
    lag = Lag("slow", "T1", tau, power)
    state = from_history(lag, NO_GAPS, History(time_s, {"T1": values}))
    whole = lagged(time_s, values[:, None] ** power, np.array([tau]))[-1, 0, 0]
    assert state is not None
    assert state.value == pytest.approx(whole, rel=1e-9, abs=1e-6)


def test_a_lag_solves_its_differential_equation() -> None:
    """By `solve_ivp`, which knows nothing of exponentials."""
    time_s = np.linspace(0.0, 3600.0, 361)
    values = 20.0 + 8.0 * (1 - np.exp(-time_s / 900.0)) + 0.5 * np.sin(time_s / 60.0)
    lag = Lag("slow", "T1", 700.0)
    solved = solve_ivp(
        lambda t, y: (np.interp(t, time_s, values) - y) / 700.0,
        (0.0, 3600.0),
        values[:1],
        rtol=1e-9,
        atol=1e-10,
        max_step=5.0,
    )
    state = from_history(lag, NO_GAPS, History(time_s, {"T1": values}))
    assert state is not None
    assert state.value == pytest.approx(solved.y[0, -1], abs=2e-5)
    assert abs(state.value - values[-1]) > 0.1


def test_the_lag_is_that_of_the_model_at_the_end_of_a_history() -> None:
    time_s = np.arange(0.0, 600.0, 7.0)
    history = History(time_s, {"rpm": np.where(time_s > 100, 3000.0, 0.0)})
    lag = Lag("bearing", "rpm", 150.0, power=2)
    state = from_history(lag, NO_GAPS, history)
    assert state is not None
    assert state.value == pytest.approx(signals_at_end(history, [lag])["bearing"], rel=1e-12)


@given(st.floats(1.0, 1000.0), st.floats(3.0, 10.0), readings, readings, readings)
def test_when_a_lag_is_known_little_is_left_of_what_was_before(
    tau: float, settle: float, before: float, start: float, end: float
) -> None:
    """Two machines, one of them warm when the readings began: what is taken for known differs by e^−settle of that."""
    lag, rules = Lag("slow", "T1", tau), LagRules(settle=settle, gap=1.0)
    cold = advanced(None, lag, rules, 0.0, start)
    warm = replace(cold, value=before)
    time_s = 0.0
    while not cold.known(lag, rules):
        time_s += tau / 4
        cold, warm = (advanced(state, lag, rules, time_s, end) for state in (cold, warm))
    assert abs(cold.value - warm.value) <= abs(before - start) * math.exp(-settle) * (1 + 1e-9) + 1e-9
    assert time_s >= settle * tau * (1 - 1e-9)
    assert cold.known_in_s(lag, rules) <= 0


LAG = Lag("slow", "T1", 100.0)
RULES = LagRules(settle=5.0, gap=0.2, least_gap_s=3.0)


def _run(rules: LagRules, times: list[float], value: float = 20.0) -> LagState:
    state = from_history(LAG, rules, History(np.array(times), {"T1": np.full(len(times), value)}))
    assert state is not None
    return state


def _every(start: float, end: float) -> list[float]:
    return list(np.arange(start, end + 1.0, 10.0))


def test_a_pause_longer_than_a_share_of_the_time_constant_begins_the_lag_anew() -> None:
    assert _run(RULES, _every(0, 600)).known(LAG, RULES)
    assert _run(RULES, [*_every(0, 600), *_every(619, 700)]).known(LAG, RULES)
    late = _run(RULES, [*_every(0, 600), *_every(622, 700)])
    assert not late.known(LAG, RULES)
    assert late.since_s == 622
    assert late.known_in_s(LAG, RULES) == pytest.approx(622 + 500 - 692)


def test_a_fast_lag_outlasts_what_the_readings_themselves_leave_out() -> None:
    fast = Lag("fast", "T1", 1.0)
    state = from_history(fast, RULES, History(np.arange(0.0, 10.0, 2.5), {"T1": np.ones(4)}))
    assert state is not None
    assert state.since_s == 0


def test_a_stated_equilibrium_makes_a_lag_known_at_once() -> None:
    stated = replace(RULES, equilibrium_s=-5.0)
    assert advanced(None, LAG, stated, 0.0, 21.0).known(LAG, stated)
    too_long_ago = replace(RULES, equilibrium_s=-25.0)
    assert not advanced(None, LAG, too_long_ago, 0.0, 21.0).known(LAG, too_long_ago)


def test_a_stated_equilibrium_overrides_what_was_before_it_and_a_later_pause_undoes_it() -> None:
    stated = replace(RULES, equilibrium_s=55.0)
    warm = advanced(None, LAG, stated, 0.0, 90.0)
    for time_s in (10.0, 20.0, 30.0, 40.0, 50.0):
        warm = advanced(warm, LAG, stated, time_s, 21.0)
    assert warm.value > 40
    still = advanced(warm, LAG, stated, 60.0, 21.0)
    assert still.value == 21.0
    assert still.known(LAG, stated)
    assert advanced(still, LAG, stated, 70.0, 22.0).known(LAG, stated)
    assert not advanced(still, LAG, stated, 90.0, 22.0).known(LAG, stated)


@given(readings, readings, st.floats(-100.0, 0.0))
def test_a_reading_that_is_not_later_changes_nothing(first: float, second: float, step: float) -> None:
    state = advanced(None, LAG, RULES, 0.0, first)
    assert advanced(state, LAG, RULES, step, second) == state


@given(st.floats(0.1, 19.9), readings, readings)
def test_a_lag_stays_between_its_readings(step: float, first: float, second: float) -> None:
    assume(abs(first - second) > 1e-6)
    state = advanced(advanced(None, LAG, RULES, 0.0, first), LAG, RULES, step, second)
    assert min(first, second) - 1e-9 <= state.value <= max(first, second) + 1e-9
    assert abs(state.value - first) < abs(second - first)


def test_a_sensor_that_was_not_recorded_has_no_lag() -> None:
    assert from_history(LAG, RULES, History(np.arange(3.0), {"T2": np.ones(3)})) is None
