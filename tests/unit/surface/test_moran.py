"""Moran's I and Geary's C beside esda, and p-values that are what they say."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from tests.support.surfaces import NEAR, SQUARE, moran_i, on_grid, random_surface
from trueloop.surface.separation.moran import EXPONENT, Null, Weights, geary_of
from trueloop.surface.separation.neighbourhood import (
    Neighbourhood,
    expected_geary_c,
    permutation_p_value,
    residual_null,
)
from trueloop.surface.separation.spline_surface import Places, Size, projector

SIZE = Size(12, 12)


@pytest.mark.filterwarnings("ignore")  # of esda's and its libraries' own making
@pytest.mark.parametrize("exponent", [1.0, 3.0, 4.0])
def test_statistics_are_those_of_esda(exponent: float) -> None:
    from esda import Geary, Moran
    from libpysal.weights import full2W

    rng = np.random.default_rng(5)
    points = rng.uniform(0, 50, (200, 3))
    values = rng.normal(size=200) + np.sin(points[:, 0] / 9)
    distance = cdist(points, points)
    np.fill_diagonal(distance, np.inf)
    w = full2W(distance**-exponent)
    theirs = Moran(values, w, transformation="O", permutations=0)
    geary = Geary(values, w, transformation="O", permutations=0)
    assert moran_i(points, values, exponent) == pytest.approx(theirs.I, abs=1e-12)
    assert geary_of(Weights(points, exponent).times, values - np.mean(values)) == pytest.approx(geary.C, abs=1e-12)


def simulated_residuals(draws: int, seed: int) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(size=(625, draws))
    return projector(SQUARE, SIZE).residuals(noise)


def test_geary_s_c_of_residuals_is_that_of_their_values_and_as_expected() -> None:
    """Residuals of a spline have no mean; neighbours that are alike bring C below what is expected of residuals."""
    draws = simulated_residuals(400, 3).T
    assert NEAR.geary_c(draws[0]) == pytest.approx(
        geary_of(Weights(SQUARE.points_mm, EXPONENT).times, draws[0] - np.mean(draws[0])), rel=1e-9
    )
    found, expected = np.array([NEAR.geary_c(z) for z in draws]), expected_geary_c(NEAR, SIZE)
    assert expected > 1.05
    assert abs(np.mean(found) - expected) < 4 * np.std(found) / np.sqrt(len(found))
    waves = np.sin(SQUARE.points_mm[:, 0] / 5)
    assert NEAR.geary_c(waves - np.mean(waves)) < 0.6


def test_p_values_of_residuals_are_uniform_and_those_of_the_raw_null_are_not() -> None:
    """Kolmogorov's distance of 2000 p-values from the uniform law: 0.043 is exceeded once in a thousand.

    The expectation for independent values, −1/(n − 1), misses residuals by far.
    """
    found = NEAR.moran_i(simulated_residuals(2000, 1))

    def distance(null: Null) -> float:
        p = np.sort([null.p_value(i) for i in found])
        return float(np.max(np.abs(p - (np.arange(2000) + 0.5) / 2000)))

    null = residual_null(NEAR, SIZE)
    assert distance(null) < 0.043
    assert distance(Null(-1 / 624, null.deviation)) > 0.5


def test_moments_are_those_of_simulated_residuals() -> None:
    found, null = NEAR.moran_i(simulated_residuals(2000, 2)), residual_null(NEAR, SIZE)
    assert np.mean(found) == pytest.approx(null.expected, abs=4 * null.deviation / np.sqrt(2000))
    assert np.std(found) == pytest.approx(null.deviation, rel=0.07)


def test_a_pattern_left_in_the_residuals_is_found() -> None:
    rng = np.random.default_rng(4)
    noise = rng.normal(0, 0.002, 625)
    waves = on_grid(random_surface(rng, 15, 0.003))
    clean, left = (projector(SQUARE, Size(6, 6)).residuals(e) for e in (noise, noise + waves))
    null = residual_null(NEAR, Size(6, 6))
    assert null.p_value(float(NEAR.moran_i(left[:, None])[0])) < 1e-6
    assert permutation_p_value(NEAR, left, Size(6, 6)) == 0.001  # the least that 999 shuffles can say
    assert permutation_p_value(NEAR, clean, Size(6, 6)) > 0.02


def test_p_values_by_shuffling_are_about_those_of_the_moments() -> None:
    null, differences = residual_null(NEAR, SIZE), []
    for residuals in simulated_residuals(12, 3).T:
        exact = null.p_value(float(NEAR.moran_i(residuals[:, None])[0]))
        differences.append(permutation_p_value(NEAR, residuals, SIZE, draws=399) - exact)
    assert np.max(np.abs(differences)) < 0.08
    assert abs(np.mean(differences)) < 0.03


def test_scattered_places_have_the_moments_of_the_same_grid() -> None:
    scattered = Places(SQUARE.points_mm, SQUARE.u, SQUARE.v)
    ours, theirs = residual_null(Neighbourhood(scattered), Size(7, 7)), residual_null(NEAR, Size(7, 7))
    assert ours.expected == pytest.approx(theirs.expected, abs=1e-12)
    assert ours.deviation == pytest.approx(theirs.deviation, abs=1e-12)


def test_four_values_at_a_square_s_corners_by_hand() -> None:
    """1, −1, −1, 1 around a square of 2 mm, c = 1/d: sides 8 · ½ hold unlike and diagonals 4 / √8 like neighbours."""
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [2.0, 2.0, 0.0]])
    sides, diagonals = 8 * 0.5, 4 / np.sqrt(8.0)
    expected = (diagonals - sides) / (diagonals + sides)
    assert moran_i(points, np.array([1.0, -1.0, -1.0, 1.0]), 1.0) == pytest.approx(expected)
