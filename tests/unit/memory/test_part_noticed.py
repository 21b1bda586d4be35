"""Changes noticed of whole parts."""

from dataclasses import replace

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.domain.life import Stage
from trueloop.memory.made_part import CutErrors, MadePart
from trueloop.memory.noticing import What, notice_part

ANGLES = np.radians(np.linspace(10, 85, 12))
CORRECTION = 0.018 + 0.006 * np.cos(4 * ANGLES)


def seen(error: Array) -> CutErrors:
    names = tuple(f"P{k + 1}" for k in range(len(error)))
    return CutErrors(("dome",) * len(error), names, ANGLES, error, np.full(len(error), 0.001))


def made(k: int, rng: np.random.Generator, arrived: float = 1.0, gross: float = 0.0) -> MadePart:
    """A worn nose of 12 µm, a setting of 15 µm, one µm of clamping and of noise: all by formula."""
    edge = 0.012 * np.exp(-((ANGLES - 0.6) ** 2) / 0.1) + 0.015 * np.sin(ANGLES) + 0.001 * rng.normal() * np.sin(ANGLES)
    before, after = edge + 0.001 * rng.normal(size=12), edge - arrived * CORRECTION + 0.001 * rng.normal(size=12)
    before[4] += gross
    return MadePart("dome", f"{k}", "s1", k, seen(before), seen(after), CORRECTION, 0 * CORRECTION)


@pytest.fixture(scope="module")
def history() -> tuple[MadePart, ...]:
    rng = np.random.default_rng(5)
    return tuple(made(k, rng) for k in range(6))


def test_a_part_like_the_others_is_not_noticed(history: tuple[MadePart, ...]) -> None:
    found = notice_part(history, made(6, np.random.default_rng(9)))
    assert set(found) == {Stage.SEMIFINISH, Stage.FINISH}
    assert not any(one.own_fit for one in found.values())
    assert found[Stage.FINISH].gain == pytest.approx(1.0, abs=0.15)


def test_a_correction_not_run_is_found_after_the_finish_cut(history: tuple[MadePart, ...]) -> None:
    found = notice_part(history, made(6, np.random.default_rng(9), arrived=0.0))
    assert not found[Stage.SEMIFINISH].own_fit
    assert found[Stage.FINISH].alarms[0].what is What.GAIN
    assert "not run" in found[Stage.FINISH].alarms[0].says
    assert found[Stage.FINISH].quarantine


def test_a_correction_run_twice(history: tuple[MadePart, ...]) -> None:
    found = notice_part(history, made(6, np.random.default_rng(9), arrived=2.0))[Stage.FINISH]
    assert "twice" in found.alarms[0].says
    assert found.gain == pytest.approx(2.0, abs=0.15)


def test_a_gross_touch_is_named(history: tuple[MadePart, ...]) -> None:
    found = notice_part(history, made(6, np.random.default_rng(9), gross=0.030))[Stage.SEMIFINISH]
    assert [touch.point for touch in found.left_out] == ["P5"]
    assert not found.own_fit


def test_a_turned_edge_is_noticed_before_the_finish_cut(history: tuple[MadePart, ...]) -> None:
    part = made(6, np.random.default_rng(9))
    error = part.semifinish.error_mm - 0.024 * np.exp(-((ANGLES - 0.6) ** 2) / 0.1) + 0.012 * np.cos(8 * ANGLES)
    found = notice_part(history, replace(part, semifinish=seen(error)))[Stage.SEMIFINISH]
    assert found.own_fit
    assert any("turned" in alarm.says for alarm in found.alarms)
