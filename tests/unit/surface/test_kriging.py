"""Kriging beside the conditional normal law written out, and its band on draws of the stated process."""

from dataclasses import replace

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.geometry.surface import fit_grid
from trueloop.surface.pattern.field import FaceParts, _own, fields_of
from trueloop.surface.pattern.kriging import FieldProcess, Kriging, Process, fitted_process
from trueloop.surface.pattern.support import between, expectations
from trueloop.surface.separation.separate import separate
from trueloop.surface.separation.spline_surface import Places

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


def test_where_a_part_has_no_value_the_mean_of_the_others_stands_with_what_it_differs_from_it() -> None:
    """Written out: the mean of all, kriged, and what the second part differs from that where it was touched."""
    rng = np.random.default_rng(2)
    at, where, values = rng.uniform(0, 40, (20, 2)), rng.uniform(0, 60, (7, 2)), rng.normal(size=(2, 20))
    values[1, 12:] = np.nan

    def kriged(places: Array, of: Array, to: Array) -> Array:
        measured = covariance(places, places) + PROCESS.noise_mm2 * np.eye(len(places))
        return np.asarray(covariance(to, places) @ np.linalg.solve(measured, of))

    mean = np.concatenate([values[:, :12].mean(axis=0), values[0, 12:]])
    wanted = [
        kriged(at, mean, where) + kriged(at[:n], part[:n] - kriged(at, mean, at[:n]), where)
        for part, n in zip(values, (20, 12), strict=True)
    ]
    np.testing.assert_allclose(expectations(PROCESS, at, values, where), wanted, atol=1e-9)


def test_a_band_is_wider_by_as_few_waves_as_the_patch_holds() -> None:
    """Waves of 3 × 2 mm: 10 on 60 mm², of which t = 2.2281 for 1.9600; on 6 mm² three are taken, t = 3.1824."""
    process = replace(PROCESS, waves_mm=(3.0, 2.0))
    found = [process.widening(area_mm2) for area_mm2 in (60.0, 6.0)]
    assert found == pytest.approx([2.22814 / 1.95996, 3.18245 / 1.95996], rel=2e-5)


def test_the_band_of_a_part_is_what_is_open_of_the_field_and_what_may_be_its_own() -> None:
    """At every place (1 − φ)² V + φ (1 − φ) S², widened: φ = 0.3 or 0.6 of S² stated, beside next to nothing."""
    rng = np.random.default_rng(5)
    u, v = rng.random((2, 150))
    form = 4e-3 * np.sin(7 * u) * np.cos(5 * v)
    part = separate(
        Places(np.column_stack([u * SIDES[0], v * SIDES[1], 0 * u]), u, v), form + 3e-4 * rng.normal(size=150)
    )
    face = FaceParts(FACE.surface, [part])
    (whole,) = fields_of([face], 1e-9, seen=False)
    process, (at, values) = whole.support.process, face.values(1500.0)
    size_mm2, widening = float(np.mean(values**2)) - process.noise_mm2, process.widening(SIDES[0] * SIDES[1])
    coarse = np.linspace(0.0, 1.0, 41)  # every third place of the support
    variance_mm2 = Kriging(process, at).variance_mm2(face.places(np.repeat(coarse, 41), np.tile(coarse, 41)))
    deviation_mm = whole.support.deviation_mm[::3, ::3].ravel()
    np.testing.assert_allclose(deviation_mm**2, widening**2 * variance_mm2, rtol=1e-6)
    for share in (0.3, 0.6):
        (found,) = fields_of([face], float(np.sqrt(share * size_mm2)), seen=False)
        open_mm2 = (1 - share) ** 2 * whole.support.deviation_mm**2
        wanted_mm2 = open_mm2 + widening**2 * share * (1 - share) * size_mm2
        np.testing.assert_allclose(found.support.deviation_mm**2, wanted_mm2, rtol=1e-6)
        assert np.median(open_mm2 / wanted_mm2) > 1e-3


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
        half = 1.96 * likeliest.widening(SIDES[0] * SIDES[1]) * np.sqrt(found.variance_mm2(where))
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


def test_the_field_of_several_faces_has_thirds_that_go_by_place_direction_and_edge() -> None:
    """By hand, 5 mm apart on top of a block: all of it between places that run on into each other, 2/3 beyond a sharp
    edge; 2/3 and 1/3 towards a side, 1/3 and 0 towards the bottom.
    """
    process = FieldProcess(4.0, 9.0, 0.04, (12.0,), (150.0,))
    top, side, bottom = [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]
    others = [[3.0, 4.0, 0.0, *normal, group] for normal in (top, side, bottom) for group in (1.0, 2.0)]
    found = process.covariance_mm2(np.array([[0.0, 0.0, 0.0, *top, 1.0]]), np.array(others))[0]
    whole = 4.0 * correlation(np.array(5 / 12)) + 9.0 * correlation(np.array(5 / 150))
    assert found == pytest.approx(np.array([3, 2, 2, 1, 1, 0]) / 3 * whole, abs=1e-12)


def test_places_of_the_field_are_at_shares_of_the_parameters() -> None:
    """Parameters from 2 to 4 and from −3 to 3: 1/4 and 2/3 of them are 15 and 26.7 mm on a face of 60 × 40 mm."""
    face = replace(FACE.surface, knots_u=2 + 2 * FACE.surface.knots_u, knots_v=6 * FACE.surface.knots_v - 3)
    (place,) = FaceParts(face, [], 2).places(np.array([0.25]), np.array([2 / 3]))
    assert place == pytest.approx([15.0, 80 / 3, 0.0, *face.normal(np.array([3.0]), np.array([0.0]))[0], 2.0])


@pytest.mark.parametrize(
    ("count", "own_mm", "share", "each_um"),
    [
        (1, None, 0.04, 1.0),
        (2, None, 0.02 / 0.98, 1.0),
        (1, 0.002, 0.16, 2.0),
        (2, 0.002, 2 / 24.5, 2.0),
        (1, 0.009, 1.0, 9.0),
    ],
)
def test_the_mean_of_parts_has_their_own_form_over_their_count(
    count: int, own_mm: float | None, share: float, each_um: float
) -> None:
    """A form of 5 µm of which 1 µm, 4 % of its variance, is a part's own: the mean of two has 24 + 1/2 µm²."""
    size_um2 = {1: 25.0, 2: 24.5}[count]
    assert _own(1e-6 * size_um2, count, own_mm) == pytest.approx((share, 1e-3 * each_um))


@pytest.mark.parametrize("count", [1, 2])
def test_what_is_stated_of_parts_own_form_is_taken_off_the_pattern_and_is_in_its_band(count: int) -> None:
    """A form of size S and noise of as much again. Of what parts show 2 S²/3 is said to be each one's own: of the mean
    of n parts φ = 2/(3n) is, which leaves 1 − φ of it, known to √(φ (1 − φ)) S amid many points.
    """
    rng = np.random.default_rng(8)
    u, v = rng.random((2, 900))
    at = np.column_stack([u * SIDES[0], v * SIDES[1], 0 * u])
    apart = np.linalg.norm(at[:, None] - at[None], axis=2)
    form = np.linalg.cholesky(16 * correlation(apart / 15) + 1e-9 * np.eye(len(at))) @ rng.normal(size=len(at))
    size_um = float(np.sqrt(np.mean(form**2)))
    noisy = [separate(Places(at, u, v), 1e-3 * (form + size_um * rng.normal(size=len(at)))) for _ in range(count)]
    found, whole = (
        fields_of([FaceParts(FACE.surface, noisy)], own_um * 1e-3, seen=False)[0]
        for own_um in (np.sqrt(2 / 3) * size_um, 1e-6)
    )
    share = 2 / (3 * count)
    inner = np.linspace(0.2, 0.8, 31)
    kept, all_of_it = (
        np.mean([model.grid_mm(inner, inner) for model in field.models], axis=0) for field in (found, whole)
    )
    assert np.sum(kept * all_of_it) / np.sum(all_of_it**2) == pytest.approx(1 - share, abs=0.06)
    area = SIDES[0] * SIDES[1]
    of_form = (
        1e3
        * np.sqrt(np.maximum(found.support.deviation_mm**2 - ((1 - share) * whole.support.deviation_mm) ** 2, 0.0))
        / found.support.process.widening(area)
    )
    assert np.median(of_form) == pytest.approx(np.sqrt(share * (1 - share)) * size_um, rel=0.1)
