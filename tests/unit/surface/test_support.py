"""Where no point was measured: the pattern fades, its band says so, and nothing else changes. Truths are no splines."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.surface.on_face import SUPPORT
from trueloop.surface.pattern.kriging import Process
from trueloop.surface.pattern.pattern import Pattern, pattern_of
from trueloop.surface.pattern.support import _support
from trueloop.surface.separation.neighbourhood import Neighbourhood
from trueloop.surface.separation.separate import of_size, separate
from trueloop.surface.separation.spline_surface import Places, Size

A, B = 60.0, 40.0
GRID = np.stack(np.meshgrid(np.arange(0, A + 1, 2.0), np.arange(0, B + 1, 2.0), indexing="ij"), axis=2).reshape(-1, 2)


def sines(at: Array) -> Array:
    """A sum of sines, waves of 19 to 38 mm, in µm."""
    x, y = at.T
    return np.asarray(9 * np.sin(x / 3.6 + y / 5) + 7 * np.cos(x / 6 - y / 3.4) + 6 * np.sin(y / 3 + 1) * np.cos(x / 5))


def deflection(at: Array) -> Array:
    """A tool that bends more and more along x, and chatters a little, in µm."""
    x, y = at.T
    return np.asarray(40 * (x / A) ** 2 + 10 * y / B - 12 + 2 * np.sin(y / 1.9))


def ridge(at: Array, turned_deg: float = 37.0) -> Array:
    """A ridge across the middle of the window, over a tilt, in µm."""
    x, y = (at - [27.0, 19.0]).T
    turn = np.deg2rad(turned_deg)
    return np.asarray(18 * np.exp(-0.5 * ((np.cos(turn) * x + np.sin(turn) * y) / 4) ** 2) + 0.2 * x)


def window(side_mm: float, at: Array = GRID) -> np.ndarray:
    return np.asarray(np.all(np.abs(at - [27.0, 19.0]) < side_mm / 2, axis=1))


def corner(side_mm: float, at: Array = GRID) -> np.ndarray:
    return np.asarray(np.all(at < side_mm, axis=1))


def places(at: Array) -> Places:
    return Places(np.column_stack([at, np.zeros(len(at))]), at[:, 0] / A, at[:, 1] / B)


Field = Callable[[Array, Array], Array]


def found(truth: Callable[[Array], Array], measured: list[Array], seed: int = 1) -> tuple[Pattern, Field]:
    """The pattern of parts measured at places (n, 2) each; and beside it the mean of their splines alone."""
    rng, parts = np.random.default_rng(seed), []
    near = {id(at): Neighbourhood(places(at)) for at in measured}
    for at in measured:
        x, y = at.T
        own = rng.normal() * np.sin(x / 9 + rng.uniform(0, 6)) + rng.normal() * np.cos(y / 8 + rng.uniform(0, 6))
        parts.append((near[id(at)], 1e-3 * (truth(at) + own + rng.normal(size=len(at)))))
    size = separate(parts[0][0].places, parts[0][1], near=parts[0][0]).chosen.size
    apart = [of_size(own.places, errors, size, own) for own, errors in parts]

    def splines(u: Array, v: Array) -> Array:
        return np.asarray(np.mean([part.deterministic.value_mm(u, v) for part in apart], axis=0))

    return pattern_of(apart, [f"S{k}" for k in range(len(apart))], size=size), splines


def judged(pattern: Pattern, truth: Callable[[Array], Array], at: Array) -> tuple[Array, Array]:
    """How far the pattern is off at places (n, 2), and its half-width there, both in µm."""
    u, v = at[:, 0] / A, at[:, 1] / B
    stack = np.stack([model.value_mm(u, v) for model in pattern.models])
    half = pattern.uncertainty_mm(np.std(stack, axis=0, ddof=1), u, v)
    return np.abs(1e3 * pattern.mean.value_mm(u, v) - truth(at)), 1e3 * half


def dense(low: Array, high: Array) -> Array:
    x, y = (np.linspace(a, b, 15) for a, b in zip(low, high, strict=True))
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=2).reshape(-1, 2)


SCATTERED = np.random.default_rng(3).uniform(0, 1, (600, 2)) * [A, B]


@pytest.mark.parametrize("at", [GRID, SCATTERED], ids=["grid", "scattered"])
@pytest.mark.parametrize("truth", [sines, deflection])
def test_a_window_without_points_is_corrected_within_its_band(truth: Callable[[Array], Array], at: Array) -> None:
    pattern, _ = found(truth, [at[~window(15, at)]] * 3)
    off, half = judged(pattern, truth, dense(np.array([18.0, 10.0]), np.array([36.0, 28.0])))
    assert np.mean(off <= half) > 0.9
    assert np.max(off) < 8
    if truth is not deflection:  # which its surroundings tell
        assert np.max(half) > 2 * np.median(half)


def test_ridges_through_a_window_are_corrected_within_their_band_on_average() -> None:
    """No draw of one process: most of the face knows nothing of a ridge, and one ridge may leave the band (0.73)."""
    at, inside = dense(np.array([18.0, 10.0]), np.array([36.0, 28.0])), []
    for turned_deg in (0.0, 37.0, 90.0, 120.0, 155.0):
        truth = partial(ridge, turned_deg=turned_deg)
        off, half = judged(found(truth, [GRID[~window(15)]] * 3, seed=int(turned_deg))[0], truth, at)
        assert np.max(off) < 12
        inside.append(np.mean(off <= half))
    assert np.mean(inside) > 0.85


@pytest.mark.parametrize("truth", [sines, deflection, ridge])
def test_corners_beyond_the_last_points_are_corrected_within_their_band(truth: Callable[[Array], Array]) -> None:
    """Splines alone run away there, where the pattern needs more than a few of them."""
    pattern, splines = found(truth, [GRID[~corner(10)]] * 3)
    at = dense(np.zeros(2), np.full(2, 10.0))
    off, half = judged(pattern, truth, at)
    alone = np.abs(1e3 * splines(at[:, 0] / A, at[:, 1] / B) - truth(at))
    assert np.mean(off <= half) > 0.9
    assert np.max(off) < max(2.0, 0.3 * np.max(alone))
    assert np.max(off) < 0.6 * np.max(np.abs(truth(GRID)))


def test_what_fades_is_no_steeper_than_the_pattern() -> None:
    pattern, _ = found(sines, [GRID[~window(15)]] * 3)
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, 61), np.linspace(0, 1, 41), indexing="ij"))

    def steepest(values: Array) -> float:
        field = values.reshape(61, 41)
        return float(max(np.max(np.abs(np.diff(field, axis=0))), np.max(np.abs(np.diff(field, axis=1)))))

    truth = sines(np.stack([u * A, v * B], axis=1))
    assert steepest(1e3 * pattern.mean.value_mm(u, v)) < 1.2 * steepest(truth)


def test_far_from_all_points_the_correction_is_none_and_the_band_as_wide_as_the_pattern() -> None:
    """Short waves measured on a third of the face: two of their lengths on, nothing is corrected."""

    def short(at: Array) -> Array:
        return np.asarray(8 * np.sin(at[:, 0] / 1.8 + 1) * np.cos(at[:, 1] / 2.1))

    pattern, splines = found(short, [GRID[GRID[:, 0] <= 24]] * 3)
    at = dense(np.array([40.0, 4.0]), np.array([58.0, 36.0]))
    u, v = at[:, 0] / A, at[:, 1] / B
    assert np.max(np.abs(1e3 * pattern.mean.value_mm(u, v))) < 2.5
    assert np.max(np.abs(1e3 * splines(u, v))) > 10
    off, half = judged(pattern, short, at)
    assert np.mean(off <= half) > 0.9
    assert pattern.support is not None
    assert 0.4 < np.mean(~pattern.support.supported) < 0.65


def test_what_is_known_of_three_places_by_hand() -> None:
    """Of a variance of 3 + 1 µm² 1, 3 and 4 are left at three places by all points, by those of two parts 1 and 3, 4
    and 5, 4 and 4; at the second the first part's spline is taken by half.
    """
    process = Process(3e-6, 0.0, 1e-6, (1.0, 1.0), (2.0, 2.0))
    share, bare = np.ones((2, SUPPORT**2)), np.array([0, 1, 2])
    share[:, bare] = [[0.0, 0.5, 0.0], [0.0, 0.0, 0.0]]
    own_mm2 = 1e-6 * np.array([[1.0, 4.0, 4.0], [3.0, 5.0, 4.0]])
    found = _support(process, 1.5, share, bare, (own_mm2, 1e-6 * np.array([1.0, 3.0, 4.0])))
    rest = [1.0, 0.0, 2.0]
    for values, wanted in (
        (found.known, [0.75, 0.5, 0.0]),
        (1e3 * found.deviation_mm, [1.5, 1.5 * 1.5**0.5, 3.0]),
        (found.parts, [4 / 3, 1.0, 2.0]),
    ):
        assert values.ravel()[:3] == pytest.approx(wanted)
        assert np.all(values.ravel()[3:] == rest.pop(0))


def test_a_window_of_one_part_alone_is_told_by_the_others_less_surely() -> None:
    pattern, _ = found(sines, [GRID[~window(15)], GRID[~window(15)].copy(), *[GRID.copy()] * 2], seed=4)
    whole, _ = found(sines, [GRID] * 4, seed=4)
    at = dense(np.array([22.0, 14.0]), np.array([32.0, 24.0]))
    off, half = judged(pattern, sines, at)
    assert np.max(off) < 4
    assert np.mean(off <= half) > 0.9
    assert np.mean(half) > 1.15 * np.mean(judged(whole, sines, at)[1])
    assert pattern.support is not None
    assert 2 <= pattern.support.parts[54, 57] < 3.9
    assert np.all(pattern.support.supported)


def test_a_full_grid_is_left_as_it_was() -> None:
    pattern, splines = found(sines, [GRID] * 3)
    u, v = np.random.default_rng(1).uniform(0, 1, (2, 200))
    assert pattern.support is None
    np.testing.assert_allclose(pattern.mean.value_mm(u, v), splines(u, v), atol=1e-12)


def test_a_full_grid_whose_rows_leave_a_stripe_open_is_not_supported_there() -> None:
    """A grid without holes is not one without gaps."""
    pattern, _ = found(sines, [GRID[(GRID[:, 0] < 20) | (GRID[:, 0] > 32)]] * 3)
    assert pattern.support is not None
    off, half = judged(pattern, sines, dense(np.array([20.0, 2.0]), np.array([32.0, 38.0])))
    assert np.mean(off <= half) > 0.9


def test_parts_touched_at_places_of_their_own_do_not_run_away_where_only_others_were_touched() -> None:
    """The truth stays below 22 µm; splines, taken where a part's own points do not determine them, had up to 127."""
    rng, parts = np.random.default_rng(2), []
    for _ in range(4):
        at = rng.uniform([0.0, 0.0], [A, B], (220, 2))
        near = Neighbourhood(places(at))
        parts.append(of_size(near.places, 1e-3 * (sines(at) + rng.normal(size=len(at))), Size(12, 9), near))
    pattern = pattern_of(parts, [f"S{k}" for k in range(4)], size=Size(12, 9))
    side = np.linspace(0.0, 1.0, 61)
    assert np.max(np.abs(sines(dense(np.zeros(2), np.array([A, B]))))) < 22
    for model in pattern.models:
        assert np.max(np.abs(1e3 * model.grid_mm(side, side))) < 30
