"""The filter of a series of one number, beside plain conditioning of normal variables and beside known best gains."""

import doctest
import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.arrays import Array
from trueloop.memory.level import kalman
from trueloop.memory.level.kalman import (
    TURNING,
    LevelPrior,
    PartReading,
    best_correction,
    cautious,
    learned,
    moved_on,
    predicted,
    steps,
    unknown,
)

CERTAIN = LevelPrior(0.020, 0.003, 0.0005, log_sd=1e-9)
"""Scatter and drift known: one filter, whatever the grid."""


def conditioned(
    readings: list[PartReading], prior: LevelPrior, scatter: float, drift: float, gain: float, gain_sd: float
) -> tuple[Array, Array, float]:
    """Mean and covariance of (level now, gain), and the log density of the errors: by the joint normal distribution of
    all levels and the gain, built entry by entry.
    """
    n = len(readings)
    joint = np.zeros((n + 1, n + 1))
    for j, k in itertools.product(range(n), repeat=2):
        joint[j, k] = prior.setting_mm**2 + drift**2 * (min(j, k) + 1)
    joint[n, n] = gain_sd**2
    mean = np.append(np.zeros(n), gain)
    see = np.hstack([np.eye(n), -np.array([[r.correction_mm] for r in readings])])
    spread = see @ joint @ see.T + scatter**2 * np.eye(n)
    beyond = np.array([r.error_mm for r in readings]) - see @ mean
    after = mean + joint @ see.T @ np.linalg.solve(spread, beyond)
    left = joint - joint @ see.T @ np.linalg.solve(spread, see @ joint)
    density = -0.5 * (beyond @ np.linalg.solve(spread, beyond) + np.linalg.slogdet(spread)[1])
    return after[[n - 1, n]], left[np.ix_([n - 1, n], [n - 1, n])], density


def averaged(readings: list[PartReading], prior: LevelPrior) -> dict[str, float]:
    """The same for every scatter and drift, and for corrections that act as meant (98 %), not at all (gain 0 ± 0.09)
    and the wrong way (−1 ± 0.3), averaged by prior and likelihood.
    """
    rows, logs, meant = [], [], []
    steps_of_log, cases = np.arange(-3, 3.01, 0.5), ((1.0, 0.3, 0.98), (0.0, 0.09, 0.01), (-1.0, 0.3, 0.01))
    for a, b, (gain, gain_sd, probability) in itertools.product(steps_of_log, steps_of_log, cases):
        scatter, drift = prior.scatter_mm * np.exp(a), prior.drift_mm * np.exp(b)
        mean, left, density = conditioned(readings, prior, scatter, drift, gain, gain_sd)
        rows.append([*mean, left[0, 0] + mean[0] ** 2, mean[0] * mean[1] + left[0, 1], mean[1] ** 2 + left[1, 1]])
        logs.append(density - a**2 / 2 - b**2 / 2 + np.log(probability))
        meant.append(gain == 1.0)
    share = np.exp(np.array(logs) - max(logs))
    level, gain, square, _, gain_square = share / share.sum() @ np.array(rows)
    acting = (share * meant) @ np.array(rows)
    return {
        "level_mm": level,
        "level_u_mm": float(np.sqrt(square - level**2)),
        "gain": gain,
        "gain_u": float(np.sqrt(gain_square - gain**2)),
        "whole_mm": acting[3] / acting[4],
    }


def test_it_is_the_conditional_distribution() -> None:
    readings = [PartReading(0.018), PartReading(0.007, 0.012), PartReading(-0.004, 0.021), PartReading(0.001, 0.019)]
    step, reference = steps(readings)[-1], averaged(readings, TURNING)
    for name in ("level_mm", "level_u_mm", "gain", "gain_u"):
        assert getattr(step, name) == pytest.approx(reference[name], rel=1e-9)
    assert step.correction_mm == pytest.approx(reference["whole_mm"], rel=1e-9)


def test_the_first_part_by_hand() -> None:
    """Level 20 ± 20 µm drifted by 0.5, scatter 3: K = 400.25/409.25; gain 1 ± 0.3: C = 0.75 K · 20/1.09. One case in a
    hundred each that it arrives not at all or mirrored: 0.97 C is expected to arrive."""
    step = steps([PartReading(0.020)], CERTAIN)[0]
    share = 400.25 / 409.25
    assert step.weight.value == pytest.approx(0.75 * share, rel=1e-6)
    assert step.level_mm == pytest.approx(0.020 * share, rel=1e-6)
    assert step.correction_mm == pytest.approx(0.75 * share * 0.020 / 1.09, rel=1e-6)
    assert step.change_mm == step.correction_mm > 0  # material left on: take off more
    assert step.predicted_mm == pytest.approx(0.020 * share - 0.97 * step.correction_mm, rel=1e-6)
    assert step.innovation_sd_mm == pytest.approx(np.sqrt(409.25) / 1000, rel=1e-6)


def test_the_weight_without_corrections_is_the_textbook_gain() -> None:
    """Gain and correction drop out where nothing is corrected: P ← P + q; K = P/(P + r); P ← (1 − K) P."""
    p = 0.020**2
    for step in steps([PartReading(0.001 * (-1) ** k) for k in range(12)], CERTAIN):
        p += 0.0005**2
        gain = p / (p + 0.003**2)
        p *= 1 - gain
        assert step.weight.value == pytest.approx(0.75 * gain, rel=1e-5)


def test_an_unconfirmed_correction_is_applied_in_part() -> None:
    ahead = replace(unknown(CERTAIN), level=0.040 * np.ones(3 * 169))
    whole = best_correction(ahead)
    assert cautious(whole, 0.0, 0.75) == pytest.approx(0.75 * whole)
    assert cautious(whole, whole, 0.75) == pytest.approx(whole)
    assert cautious(-whole, 0.45 * whole, 0.75) == pytest.approx(-0.9 * whole)


def test_the_example_in_the_docstring() -> None:
    assert doctest.testmod(kalman).failed == 0


def test_a_setting_makes_the_level_unknown_and_keeps_the_gain() -> None:
    known = [PartReading(0.02 - 0.02 * (k > 0), 0.02 * (k > 0)) for k in range(8)]
    before, after = steps([*known, PartReading(-0.015, 0.0, set_before=True)])[-2:]
    assert after.level_mm == pytest.approx(-0.015, abs=0.002)
    assert after.correction_mm < 0
    assert after.gain == pytest.approx(before.gain, abs=1e-3)
    assert "set before" in after.weight.reason


def test_a_part_in_quarantine_teaches_nothing() -> None:
    readings = [PartReading(0.02), PartReading(0.005, 0.014), PartReading(0.001, 0.019)]
    spoiled = [*readings, PartReading(0.1, 0.02, counts=False)]
    trusted, kept = steps(readings)[-1], steps(spoiled)[-1]
    assert (kept.level_mm, kept.gain) == (trusted.level_mm, trusted.gain)
    assert kept.weight.value == 0.0
    assert steps([*readings, PartReading(0.1, 0.02)])[-1].level_mm != trusted.level_mm


def test_a_correction_that_acts_the_wrong_way_is_held() -> None:
    rng, readings = np.random.default_rng(4), [PartReading(0.020)]
    for _ in range(5):
        correction = steps(readings)[-1].correction_mm
        readings.append(PartReading(0.020 + correction + 0.001 * rng.normal(), correction))
    done = steps(readings)
    first = next(k for k, step in enumerate(done) if step.held)
    assert first <= 3
    assert done[first].change_mm == 0.0
    assert "do not act as meant" in done[first].weight.reason


def loop(gain: float, drift: float, series: int = 200, parts: int = 30) -> tuple[Array, Array]:
    """Errors without scatter and corrections of many series in closed loop; scatter 3 µm, setting 20 µm."""
    rng = np.random.default_rng(77)
    level = 0.020 * rng.normal(size=(series, 1)) + np.cumsum(drift * rng.normal(size=(series, parts)), axis=1)
    scatter = 0.003 * rng.normal(size=(series, parts))
    known, largest, left, z = unknown(TURNING, (series,)), np.zeros(series), [], []
    correction = np.zeros(series)
    for k in range(parts):
        ahead = moved_on(known, 1.0, False, TURNING)
        mean, variance = predicted(ahead, correction)
        left.append(level[:, k] - gain * correction)
        z.append((left[-1] + scatter[:, k] - ahead.mean(mean)) / ahead.total_u(mean, variance))
        known, _ = learned(ahead, left[-1] + scatter[:, k], correction)
        largest = np.maximum(largest, np.abs(correction))
        correction = cautious(best_correction(moved_on(known, 1.0, False, TURNING)), largest, 0.75)
    return np.array(left), np.array(z)


def root_mean_square_um(values: Array) -> float:
    return float(1e3 * np.sqrt(np.mean(values**2)))


def best_known_um(drift: float, parts: range) -> float:
    """What the Kalman gain leaves where scatter, drift and gain are known: its own variance."""
    p, left = 20.0**2 + drift**2, []
    for _ in range(parts.stop):
        left.append(p)
        p = p * 9 / (p + 9) + drift**2
    return float(np.sqrt(np.mean(left[parts.start :])))


def test_a_series_comes_near_the_best_gain_once_five_parts_are_in() -> None:
    """What an inspection finds, scatter of 3 µm included: within 5 % of what the gain known beforehand leaves."""
    for drift in (0.1, 0.5, 2.0):
        left, _ = loop(1.0, drift / 1e3)
        ours = np.hypot(root_mean_square_um(left[5:30]), 3.0)
        assert ours <= 1.05 * np.hypot(best_known_um(drift, range(5, 30)), 3.0)


def test_an_actuator_that_acts_too_much_is_found_out() -> None:
    """RMS of parts 2–11 and 31–60, acting 2.2 times: the design's own simulation left 4.5 and 1.3 µm."""
    left, _ = loop(2.2, 0.0005, parts=60)
    assert root_mean_square_um(left[1:11]) <= 4.5
    assert root_mean_square_um(left[30:]) <= 1.4


def test_bands_hold_what_they_promise() -> None:
    _, z = loop(1.0, 0.0005)
    assert 0.93 <= np.mean(np.abs(z[5:30]) < 1.96) <= 0.97
    assert 0.93 <= np.mean(np.abs(z[1:5]) < 1.96) <= 0.985  # wide while scatter and drift are hardly known


@given(st.lists(st.floats(-0.05, 0.05), min_size=1, max_size=12))
def test_a_mirrored_series_is_corrected_the_other_way(errors: list[float]) -> None:
    ours = steps([PartReading(e, 0.3 * e) for e in errors])[-1]
    mirrored = steps([PartReading(-e, -0.3 * e) for e in errors])[-1]
    assert mirrored.correction_mm == pytest.approx(-ours.correction_mm, abs=1e-12)
    assert mirrored.weight.value == pytest.approx(ours.weight.value, abs=1e-12)
