"""Weights between places: by Fourier transforms, pair by pair and far pairs together, all the same sums."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from tests.support.surfaces import error_of_products, moran_i, square_places
from trueloop.arrays import Array
from trueloop.surface.separation import moran as module
from trueloop.surface.separation.moran import Weights, lattice_of
from trueloop.surface.separation.neighbourhood import Neighbourhood, permutation_p_value, residual_null
from trueloop.surface.separation.spline_surface import Places, Size, projector

RNG = np.random.default_rng(17)


def grid(rows: int, columns: int, steps: Array) -> Array:
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    return np.asarray(np.stack([i.ravel(), j.ravel()], axis=1) @ steps + np.array([3.0, -70.0, 11.0]))


SQUARE = np.array([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
SKEW = np.array([[1.1, 0.3, 0.2], [-0.4, 0.9, 0.1]])


@pytest.mark.parametrize("steps", [SQUARE, SKEW])
@pytest.mark.parametrize("exponent", [1.0, 2.5, 3.0])
@pytest.mark.parametrize("holes", [0.0, 0.3])
def test_on_a_lattice_in_a_plane_transforms_give_the_sums_over_all_pairs(
    steps: Array, exponent: float, holes: float
) -> None:
    """Turned in space, skew, in any order, with holes: to 1e-13 of what the sums could be."""
    points = grid(23, 30, steps)
    points = np.ascontiguousarray(RNG.permutation(points[RNG.random(len(points)) >= holes]))
    found = Weights(points, exponent)
    assert found.lattice is not None
    distance = cdist(points, points)
    np.fill_diagonal(distance, np.inf)
    c, vectors = distance**-exponent, RNG.normal(size=(len(points), 3))
    np.testing.assert_allclose(found.times(vectors), c @ vectors, atol=1e-13 * np.max(c @ np.abs(vectors)))
    wanted = np.sum(vectors * (c @ vectors), axis=0)
    np.testing.assert_allclose(found.products(vectors), wanted, atol=1e-13 * np.sum(c))
    assert found.total == pytest.approx(np.sum(c), rel=1e-13)
    assert found.squares == pytest.approx(np.sum(c**2), rel=1e-13)


def test_what_is_nearly_a_lattice_is_worked_off_pair_by_pair() -> None:
    points = grid(20, 20, SQUARE)
    bent = points + np.array([0.0, 0.0, 1e-6]) * np.sin(points[:, :1])
    assert lattice_of(points, 3.0) is not None
    assert lattice_of(bent, 3.0) is None
    stray = points.copy()
    stray[1, 0] += 1e-6  # one of those that are not looked at first
    assert lattice_of(stray, 3.0) is None
    # 42 places of 8 rows, and of 9: 160 and 180 places, to four times as many as there are points
    assert lattice_of(points[np.r_[0:40, 140:142]], 3.0) is not None
    assert lattice_of(points[np.r_[0:40, 160:162]], 3.0) is None
    assert lattice_of(np.concatenate([points, points[:1]]), 3.0) is None  # one place twice
    assert lattice_of(RNG.uniform(0, 50, (400, 3)), 3.0) is None
    assert lattice_of(np.linspace(0, 1, 30)[:, None] * np.ones(3), 3.0) is None  # a line
    assert lattice_of(np.zeros((30, 3)), 3.0) is None


def test_a_million_places_on_a_lattice_need_no_pairs() -> None:
    """Moran's I of a wave along the rows of a large lattice is nearly that of an endless one; of noise nearly none."""
    points = grid(1000, 1000, SQUARE)
    wave = np.cos(2 * np.pi * points[:, 0] / 100)
    assert moran_i(points, wave) > 0.8
    assert abs(moran_i(points, RNG.normal(size=len(points)))) < 5 / 1000


def test_the_error_of_far_pairs_worked_off_together_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    x, y = RNG.uniform(0, 50, (2, 12_000))
    points, values = np.stack([x, y, 0.01 * x * y], axis=1), RNG.normal(size=12_000) + np.sin(x)
    exact = moran_i(points, values)
    monkeypatch.setattr(module, "MOST", 1000)
    assert abs(moran_i(points, values) - exact) < 1e-5
    weights, columns = Weights(points, 3.0), values[:, None]
    measured = error_of_products(weights, columns, weights.times(columns))
    assert 0.0 < measured < 10.0**-module.DIGITS
    assert error_of_products(weights, columns, weights.times(columns) * 1.01) > measured


def large(count: int) -> tuple[Places, Places]:
    """A square grid of more places than a matrix is formed for, as one and as scattered points."""
    square = square_places(count)
    return square, Places(square.points_mm, square.u, square.v)


def test_estimated_moments_on_many_places_are_those_of_simulated_residuals() -> None:
    """3600 places: expectation to the standard errors of both, deviation to 4 standard errors of 600 draws."""
    size = Size(30, 30)
    near = Neighbourhood(large(60)[0])
    null = residual_null(near, size)
    assert 0 < null.expected_error < 0.1 * null.deviation
    found = near.moran_i(projector(near.places, size).residuals(RNG.normal(size=(3600, 600))))
    assert np.mean(found) == pytest.approx(null.expected, abs=4 * np.hypot(null.expected_error, null.deviation / 24.5))
    assert np.std(found) == pytest.approx(null.deviation, rel=4 / np.sqrt(1200))


def test_many_scattered_places_are_judged_as_the_grid_they_are() -> None:
    size, noise = Size(7, 7), RNG.normal(size=3600)
    square, scattered = (Neighbourhood(places) for places in large(60))
    ours, theirs = residual_null(scattered, size), residual_null(square, size)
    assert ours.expected_error == theirs.expected_error == 0.0
    assert ours.expected == pytest.approx(theirs.expected, rel=1e-9)
    assert ours.deviation == pytest.approx(theirs.deviation, rel=1e-9)
    residuals = projector(scattered.places, size).residuals(noise)
    assert scattered.moran_i(residuals[:, None]) == pytest.approx(square.moran_i(residuals[:, None]), rel=1e-9)
    exact = ours.p_value(float(scattered.moran_i(residuals[:, None])[0]))
    assert permutation_p_value(scattered, residuals, size) == pytest.approx(exact, abs=0.15)
