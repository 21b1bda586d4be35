"""Tests on innovations: their arithmetic, their false alarms on draws with known seeds, and what they say."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from trueloop.arrays import Array
from trueloop.estimate.weights import plain
from trueloop.memory.noticing import What, White, gain_of, kept, level_and_shape, notice

ANGLES = np.linspace(0.1, 1.5, 20)
NAMES = [f"P{k + 1}" for k in range(20)]


def directions(angles: Array) -> Array:
    return np.column_stack([np.sin(angles), np.cos(angles)])


def covariance_of(angles: Array, noise_mm: float = 0.0015) -> Array:
    """Clamping 2.5 µm, a form that scatters by 1.5 µm over 23°, and noise."""
    h, apart = directions(angles), angles[:, None] - angles
    return np.asarray(
        0.0025**2 * h @ h.T + 0.0015**2 * np.exp(-0.5 * (apart / 0.4) ** 2) + noise_mm**2 * np.eye(len(angles))
    )


V = covariance_of(ANGLES)


def test_level_by_hand() -> None:
    """Two touches on a cylinder, 3 and 5 µm, standard deviation 2 each: mean 4, variance 2, χ² = 8 with one degree."""
    white = White.of(np.array([0.003, 0.005]), np.diag([0.002**2, 0.002**2]))
    shift, level, shape = level_and_shape(white, np.full(2, np.pi / 2))
    assert shift == pytest.approx([0.004, 0.0], abs=1e-9)
    assert level == pytest.approx(stats.chi2.sf(8.0, 1))
    assert shape == pytest.approx(stats.chi2.sf(0.5, 1))  # (±1/2)² twice


def test_level_and_shape_are_generalised_least_squares() -> None:
    error, h, weights = np.random.default_rng(2).normal(size=20) * 0.004, directions(ANGLES), np.linalg.inv(V)
    best = np.linalg.solve(h.T @ weights @ h, h.T @ weights @ error)
    rest = error - h @ best
    shift, level, shape = level_and_shape(White.of(error, V), ANGLES)
    assert shift == pytest.approx(best, rel=1e-8)
    assert level == pytest.approx(stats.chi2.sf(error @ weights @ error - rest @ weights @ rest, 2), rel=1e-6)
    assert shape == pytest.approx(stats.chi2.sf(rest @ weights @ rest, 18), rel=1e-6)


def test_gain_by_hand() -> None:
    """Of corrections 10 and 20 µm, half arrived: E = F + C counts 5 and 10 µm too much. √(100 + 400)/2 = 11.2 σ."""
    white = White.of(np.array([0.005, 0.010]), np.diag([0.002**2, 0.002**2]))
    gain = gain_of(white, np.array([0.010, 0.020]))
    assert gain.share == pytest.approx(0.5)
    assert gain.u == pytest.approx(2 / np.sqrt(500))
    assert gain.by_chance == pytest.approx(2 * stats.norm.sf(0.5 * np.sqrt(500) / 2))
    assert gain.rest == pytest.approx(1.0)
    assert gain_of(white, np.zeros(2)).share == 1.0
    assert gain_of(white, np.zeros(2)).rest == pytest.approx(stats.chi2.sf((5**2 + 10**2) / 4, 2))


def test_each_touch_is_compared_with_all_others() -> None:
    """By prediction from the others, one touch at a time."""
    error = np.random.default_rng(3).normal(size=20) * 0.003
    found = plain(V, error)
    for i, z in enumerate(found.left_out_mm / found.left_out_u_mm):
        others = np.delete(np.arange(20), i)
        by_others = V[i, others] @ np.linalg.inv(V[np.ix_(others, others)])
        variance = V[i, i] - by_others @ V[others, i]
        assert z == pytest.approx((error[i] - by_others @ error[others]) / np.sqrt(variance), rel=1e-6)


def test_a_gross_touch_is_left_out_and_named() -> None:
    error = np.zeros(20)
    error[[4, 11]] = 0.030, -0.020
    found = notice(error, V, ANGLES, parts=9, points=NAMES)
    assert [(touch.index, touch.point) for touch in found.left_out] == [(4, "P5"), (11, "P12")]
    assert found.left_out[0].deviations > 3
    assert found.left_out[1].deviations < -3
    assert found.alarms == ()
    assert found.notes[0].startswith("touch P5 was left out: it differs by +")


@pytest.mark.parametrize(("touches", "most"), [(2, 0), (3, 1), (5, 1), (6, 2), (20, 3)])
def test_of_few_touches_few_are_left_out(touches: int, most: int) -> None:
    error = 0.05 * np.cos(np.arange(touches) ** 2)
    stay, left = kept(error, 0.001**2 * np.eye(touches), [""] * touches)
    assert len(left) == most
    assert len(stay) == touches - most
    assert all(abs(a.deviations) >= abs(b.deviations) for a, b in pairwise(left))


CORRECTION = 0.020 * np.sin(ANGLES) + 0.015 * np.cos(3 * ANGLES)
BY_MEMORY = 0.008 * np.cos(2 * ANGLES)


@pytest.mark.parametrize(
    ("event", "what", "says"),
    [
        (directions(ANGLES) @ [0.015, 0.0], What.LEVEL, "+15.0 µm in X"),
        (directions(ANGLES) @ [0.0, -0.015], What.LEVEL, "−15.0 µm in Z"),
        (0.010 * np.cos(6 * ANGLES), What.SHAPE, "chipped"),
        (CORRECTION, What.GAIN, "not run"),
        (-CORRECTION, What.GAIN, "twice, or a diameter was entered as a radius"),  # 20 µm for 10: twice as much
        (0.5 * CORRECTION, What.GAIN, "a radius was entered as a diameter"),
        (2.0 * CORRECTION, What.GAIN, "wrong sign"),
        (1.3 * CORRECTION, What.GAIN, "−0.30"),
        (BY_MEMORY, What.MEMORY_GAIN, "not applied"),
        (-BY_MEMORY, What.MEMORY_GAIN, "applied twice"),
    ],
)
def test_what_happened_is_said_first(event: Array, what: What, says: str) -> None:
    found = notice(event, V, ANGLES, 9, CORRECTION, BY_MEMORY)
    assert found.alarms[0].what is what
    assert says in found.alarms[0].says
    assert found.own_fit
    assert found.quarantine == (what in (What.GAIN, What.MEMORY_GAIN) or not 0.8 <= (found.gain or 1) <= 1.2)


def test_before_the_finish_cut_there_is_no_gain() -> None:
    found = notice(directions(ANGLES) @ [0.02, 0.01], V, ANGLES, 9)
    assert (found.gain, found.gain_u, found.memory_gain, found.quarantine) == (None, None, None, False)
    assert found.level_mm == pytest.approx((0.02, 0.01))
    assert "the tool was set" in found.alarms[0].says
    assert "turned" in notice(0.010 * np.cos(6 * ANGLES), V, ANGLES, 9).alarms[0].says


def test_with_few_parts_the_limits_are_wider() -> None:
    """One in a thousand: χ² of 10.83 with one degree; 2.5 times that with one part, 1.25 with six, 1.05 with 30."""
    for parts, limit in ((1, 27.07), (6, 13.53), (30, 11.37)):
        for chi2, alarms in ((0.99 * limit, False), (1.01 * limit, True)):
            error = np.array([0.001 * np.sqrt(chi2)])
            assert notice(error, np.array([[0.001**2]]), np.array([np.pi / 2]), parts).own_fit == alarms


def noise(kind: str, rng: np.random.Generator, n: int, parts: int) -> Array:
    """What V describes, with its noise as it may be in a shop: variance 1.5² µm², more at gross touches."""
    angles = np.linspace(0.1, 1.5, n)
    smooth = np.linalg.cholesky(covariance_of(angles, noise_mm=1e-6))
    drawn = rng.standard_t(4, (parts, n)) / np.sqrt(2) if kind == "t4" else rng.normal(size=(parts, n))
    gross = (rng.random((parts, n)) < 0.02) * rng.normal(0, 0.020, (parts, n)) if kind == "gross" else 0.0
    return np.asarray(rng.normal(size=(parts, n)) @ smooth.T + 0.0015 * drawn + gross)


@pytest.mark.parametrize("kind", ["normal", "t4", "gross"])
@pytest.mark.parametrize("touches", [3, 20])
def test_false_alarms_are_rare(kind: str, touches: int) -> None:
    """At most 0.3 % of parts where V is known: of 4,000, more than 20 would be alarmed in one of a hundred draws."""
    angles = np.linspace(0.1, 1.5, touches)
    covariance = covariance_of(angles)
    drawn = noise(kind, np.random.default_rng(17), touches, 4000)
    correction = 0.020 * np.sin(angles) + 0.005 * np.cos(3 * angles)
    assert sum(notice(error, covariance, angles, 10**6, correction).own_fit for error in drawn) <= 20


def test_nothing_touched_is_nothing_noticed() -> None:
    assert not notice(np.empty(0), np.empty((0, 0)), np.empty(0), 3).own_fit
