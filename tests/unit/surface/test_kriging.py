"""Kriging beside the conditional normal law written out, and its band on draws of the stated process."""

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.geometry.surface import fit_grid
from trueloop.surface.pattern.field import FaceParts, fields_of
from trueloop.surface.pattern.kriging import Kriging, Process, fitted_process
from trueloop.surface.pattern.support import between
from trueloop.surface.separation.places import Places
from trueloop.surface.separation.separate import separate

SIDES = (60.0, 40.0)
PROCESS = Process(4.0, 9.0, 0.04, (9.0, 6.0), (120.0, 80.0))


FACE = fit_grid(
    np.stack([*np.meshgrid(*(np.linspace(0, side, 7) for side in SIDES), indexing="ij"), np.zeros((7, 7))], 2)
)


def correlation(r: Array) -> Array:
    """Matérn's with ν = 5/2, as its half-integer formula is printed."""
    return np.asarray((1 + 5**0.5 * r + 5 / 3 * r * r) * np.exp(-(5**0.5) * r))


def covariance(a: Array, b: Array, p: Process = PROCESS) -> Array:
    """Place by place, apart from the product under test."""
    found = np.empty((len(a), len(b)))
    for i, (x, y) in enumerate(a):
        for j, (s, t) in enumerate(b):
            waves = correlation(abs(x - s) / p.waves_mm[0]) * correlation(abs(y - t) / p.waves_mm[1])
            form = correlation(abs(x - s) / p.form_mm[0]) * correlation(abs(y - t) / p.form_mm[1])
            found[i, j] = p.waves_mm2 * waves + p.form_mm2 * form
    return found


def test_expectation_and_variance_are_those_of_the_conditional_normal_law() -> None:
    rng = np.random.default_rng(1)
    at, where, values = rng.uniform(0, 40, (30, 2)), rng.uniform(0, 60, (12, 2)), rng.normal(size=(30, 2))
    inverse = np.linalg.inv(covariance(at, at) + PROCESS.noise_mm2 * np.eye(30))
    beside = covariance(where, at)
    found = Kriging(PROCESS, at)
    np.testing.assert_allclose(found.expected_mm(values, where), beside @ inverse @ values, atol=1e-9)
    wanted = np.diag(covariance(where, where) - beside @ inverse @ beside.T)
    np.testing.assert_allclose(found.variance_mm2(where), wanted, atol=1e-9)


def test_far_from_every_point_nothing_is_expected_and_all_is_open() -> None:
    process = Process(4.0, 0.0, 0.04, (5.0, 5.0), (120.0, 80.0))
    found = Kriging(process, np.random.default_rng(1).uniform(0, 10, (40, 2)))
    assert abs(found.expected_mm(np.full((40, 1), 8.0), np.array([[60.0, 60.0]]))[0, 0]) < 1e-6
    assert found.variance_mm2(np.array([[60.0, 60.0]]))[0] == pytest.approx(4.0)


def test_the_band_holds_draws_of_the_process_in_a_window_and_beyond_the_last_points() -> None:
    """A hundred draws with other lengths each, the process estimated anew from the noisy points around: 95 % inside."""
    grid = np.stack(np.meshgrid(np.linspace(6, 54, 17), np.linspace(4, 36, 11), indexing="ij"), axis=2).reshape(-1, 2)
    at = grid[np.any(np.abs(grid - [27.0, 20.0]) > 6.5, axis=1)]
    window = np.stack(np.meshgrid(np.linspace(20, 34, 8), np.linspace(13, 27, 8), indexing="ij"), axis=2).reshape(-1, 2)
    where = np.concatenate([window, np.array([[0.0, 0.0], [0.0, 20.0], [57.0, 40.0], [30.0, 0.0]])])
    inside, shorter = [], []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        process = Process(25.0, 25.0, 0.0, (rng.uniform(6, 15), rng.uniform(6, 15)), (120.0, 80.0))
        both = np.concatenate([at, where])
        drawn = np.linalg.cholesky(process.covariance_mm2(both, both) + 1e-8 * np.eye(len(both)))
        values = drawn @ rng.normal(size=len(both))
        measured = values[: len(at)] + 0.3 * rng.normal(size=len(at))
        likeliest = fitted_process(at, measured, SIDES, 3.1)
        found = Kriging(likeliest, at)
        off = np.abs(found.expected_mm(measured[:, None], where)[:, 0] - values[len(at) :])
        half = 1.96 * likeliest.widening(SIDES) * np.sqrt(found.variance_mm2(where))
        inside.append(np.mean(off <= half))
        shorter.append(np.mean(off <= 0.5 * half))
    assert 0.925 < np.mean(inside) < 0.98
    assert np.mean(shorter) < 0.85


@pytest.mark.parametrize("noise_um", [0.7, 4.0])
def test_one_part_tells_the_pattern_nearly_as_well_as_the_known_truth_would(noise_um: float) -> None:
    """Waves of 4 µm over a form of 2 µm, a fifth of them the part's own: beside the best linear estimate, for which
    lengths, variances and noise are known. It leaves at most 1.1 times as much, and no part is made worse.
    """
    ours, best, before, inside = [], [], [], []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        u, v = rng.random((2, 1000))
        at, few = np.column_stack([u * SIDES[0], v * SIDES[1], 0 * u]), 500
        apart = np.linalg.norm(at[:, None] - at[None], axis=2)
        size = float(np.hypot(*SIDES))
        covariance_um2 = 16 * correlation(apart / 12) + 4 * correlation(apart / (2 * size))
        factor = np.linalg.cholesky(covariance_um2 + 1e-9 * np.eye(len(at)))
        pattern, own = factor @ rng.normal(size=len(at)), 0.2 * factor @ rng.normal(size=len(at))
        measured = (pattern + own)[:few] + noise_um * rng.normal(size=few)
        part = separate(Places(at[:few], u[:few], v[:few]), 1e-3 * measured)
        (field,) = fields_of([FaceParts(FACE.surface, [part])], None, seen=False)
        found = 1e3 * field.models[0].value_mm(u[few:], v[few:])
        half = 1.96e3 * between(field.support.deviation_mm, u[few:], v[few:])
        known = 1.04 * covariance_um2[:few, :few] + noise_um**2 * np.eye(few)
        left = pattern[few:] - found
        ours.append(np.mean(left**2))
        best.append(np.mean((pattern[few:] - covariance_um2[few:, :few] @ np.linalg.solve(known, measured)) ** 2))
        before.append(np.mean(pattern[few:] ** 2))
        inside.append(np.mean(np.abs(left) <= half))
    assert np.mean(ours) ** 0.5 < 1.1 * np.mean(best) ** 0.5
    assert np.all(np.array(ours) < before)
    assert 0.93 < np.mean(inside) < 0.995


def test_one_part_that_shows_noise_alone_is_left_as_it_is() -> None:
    rng = np.random.default_rng(4)
    u, v = rng.random((2, 600))
    places = Places(np.column_stack([u * SIDES[0], v * SIDES[1], 0 * u]), u, v)
    part = separate(places, 3e-3 * rng.normal(size=len(u)))
    (field,) = fields_of([FaceParts(FACE.surface, [part])], None, seen=False)
    assert np.sqrt(np.mean(field.models[0].value_mm(u, v) ** 2)) < 0.3e-3
