"""Lags and log together, over restarts, on a clock that the test moves."""

import math
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.support.signals import Kept
from trueloop.controllers.linuxcnc.realtime.signals.readings import Board, Clock, Past, Replay
from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.realtime.samples_csv import SignalLog
from trueloop.machine.model.history import History, Lag, signals_at_end
from trueloop.realtime.image import LagRules, from_history

LAG = Lag("screw", "T1", 20.0)
RULES = LagRules(settle=5.0, gap=0.2)


def _later(start: float, now_s: float) -> float:
    return warming(start + now_s)


class Component:
    """One run of the component, its clock on the wall at `log_s` when it starts."""

    def __init__(self, folder: Path, log_s: float, rules: LagRules = RULES, speed: float = 1.0) -> None:
        self.board, self.said = Board(), list[str]()
        log = SignalLog(folder / "signals.csv", ("T1_degC", "T2_degC"), 8 * LAG.constant_s, 1000)
        history = log.begin(log_s)
        states = {"screw": from_history(LAG, rules, history) if history else None}
        self.past = Past(
            (LAG,),
            rules,
            states,
            self.board,
            Clock(log_s, 0.0, speed),
            threading.Event(),
            self.said.append,
            log=log,
            sensors=("T1", "T2"),
        )

    def run(self, seconds: int, temperature: Callable[[float], float] = lambda _: 20.0, *, second: bool = True) -> None:
        """One turn a second."""
        for now_s in range(seconds):
            self.board.put("T1", temperature(float(now_s)), float(now_s))
            if second:
                self.board.put("T2", 18.0, float(now_s))
            self.past.turn(float(now_s))


def warming(now_s: float) -> float:
    return 20.0 + 10 * (1 - math.exp(-now_s / 40))


def test_a_lag_is_given_once_it_is_known(tmp_path: Path) -> None:
    component = Component(tmp_path, 1e9)
    component.run(100, warming)
    assert "screw" not in component.past.readings()
    component = Component(tmp_path, 1e9 + 100)
    component.run(2, lambda _: warming(100.0))
    assert component.past.readings()["screw"].time_s == 1.0


def test_the_lag_is_that_of_the_whole_log_over_restarts(tmp_path: Path) -> None:
    """As `trueloop machine compensate -t signals.csv` computes it."""
    for start in (0, 60, 120):
        component = Component(tmp_path, 1e9 + start)
        component.run(60, partial(_later, start))
    history = read_history(tmp_path / "signals.csv")
    assert len(history.time_s) == 180
    expected = signals_at_end(history, [LAG])["screw"]
    given = component.past.readings()["screw"].value
    assert given == pytest.approx(expected, abs=1e-4)
    assert abs(given - warming(179.0)) > 0.1


def test_a_restart_after_a_pause_begins_the_lag_anew(tmp_path: Path) -> None:
    Component(tmp_path, 1e9).run(120)
    short = Component(tmp_path, 1e9 + 119 + 4)
    short.run(1)
    assert "screw" in short.past.readings()
    long = Component(tmp_path, 1e9 + 123 + 4.1)
    long.run(1)
    assert "screw" not in long.past.readings()


def test_equilibrium_stated_makes_it_known(tmp_path: Path) -> None:
    component = Component(tmp_path, 1e9, LagRules(equilibrium_s=1e9 - 3))
    component.run(1, lambda _: 23.0)
    assert component.past.readings()["screw"].value == 23.0


def test_a_sensor_that_is_old_goes_into_no_lag_and_no_row(tmp_path: Path) -> None:
    component = Component(tmp_path, 1e9, LagRules(equilibrium_s=1e9))
    component.run(3)
    for now_s in range(3, 30):
        component.board.put("T2", 18.0, float(now_s))
        component.past.turn(float(now_s))
    read = component.past.readings()["screw"]
    assert read.age_s(29.0) == 27.0
    assert read_history(tmp_path / "signals.csv").time_s[-1] - 1e9 == 12.0


def test_another_sensor_that_fails_leaves_a_lag_alone(tmp_path: Path) -> None:
    component = Component(tmp_path, 1e9, LagRules(equilibrium_s=1e9))
    component.run(30, warming, second=False)
    assert component.past.readings()["screw"].time_s == 29.0
    assert len((tmp_path / "signals.csv").read_text().splitlines()) == 1


def test_lags_run_as_fast_as_a_replay(tmp_path: Path) -> None:
    slow = Component(tmp_path / "slow", 1e9)
    fast = Component(tmp_path / "fast", 1e9, LagRules(least_gap_s=30.0), speed=10.0)
    slow.run(61, warming)
    fast.run(7, lambda now_s: warming(10 * now_s))
    assert slow.past.states["screw"].value == pytest.approx(fast.past.states["screw"].value, abs=0.2)  # type: ignore[union-attr]
    assert abs(warming(60) - slow.past.states["screw"].value) > 0.4  # type: ignore[union-attr]


def test_a_log_that_cannot_be_written_is_said_once_and_lags_go_on(tmp_path: Path) -> None:
    component = Component(tmp_path, 1e9, LagRules(equilibrium_s=1e9))
    (tmp_path / "signals.csv").unlink()
    (tmp_path / "signals.csv").mkdir()
    component.run(30, warming)
    assert len(component.said) == 1
    assert "is not written" in component.said[0]
    assert component.past.readings()["screw"].time_s == 29.0


def test_a_replay_is_the_log_at_its_pace_and_ends_with_it() -> None:
    log = History(np.array([0.0, 100.0, 200.0]), {"T1": np.array([20.0, 30.0, 25.0])}, {"T1": "°C"})
    kept, stop = Kept(), threading.Event()
    replay = Replay(log, {"warm": "T1"}, time.monotonic(), 50.0, speed=200.0, every_s=0.01)
    thread = threading.Thread(target=replay, args=(kept, stop), daemon=True)
    thread.start()
    while "warm" not in kept.refused:
        assert thread.is_alive()
        time.sleep(0.01)
    stop.set()
    thread.join(10)
    assert "ended at 200 s" in kept.refused["warm"]
    for name, value, time_s in kept.given:
        row_s = 50.0 + 200.0 * (time_s - replay.began_s)
        assert name == "warm"
        assert value == pytest.approx(20 + row_s / 10 if row_s < 100 else 35 - row_s / 20, abs=1e-6)
    assert len(kept.given) > 5
