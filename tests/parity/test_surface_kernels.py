"""Fast kernels beside their slow references: splines over a grid, sums over pairs of points."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from trueloop._core import ScatteredSplines, fit_surface_grid, pair_sums, weights_product
from trueloop.geometry.surface import basis_matrix, clamped_knots

RNG = np.random.default_rng(3)


@pytest.mark.parametrize(
    ("points", "controls", "degree"), [((25, 25), (15, 15), 3), ((30, 12), (7, 9), 2), ((9, 40), (9, 4), 1)]
)
def test_a_grid_fit_is_the_dense_least_squares_solution(
    points: tuple[int, int], controls: tuple[int, int], degree: int
) -> None:
    at = tuple(np.sort(np.append(RNG.uniform(0, 1, n - 2), [0.0, 1.0])) for n in points)
    if controls[0] == points[0]:
        at = (np.linspace(0, 1, points[0]), at[1])
    knots = tuple(clamped_knots(n, degree) for n in controls)
    values = RNG.normal(0, 0.01, points)
    dense = np.kron(basis_matrix(knots[0], degree, at[0]), basis_matrix(knots[1], degree, at[1]))
    wanted = np.linalg.lstsq(dense, values.ravel(), rcond=None)[0].reshape(controls)
    inner = tuple(np.ascontiguousarray(k[degree + 1 : -degree - 1]) for k in knots)
    found = fit_surface_grid((inner[0], inner[1]), (degree, degree), (at[0], at[1]), values)
    np.testing.assert_allclose(found, wanted, atol=1e-9 * np.max(np.abs(wanted)))


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_products_at_scattered_points_are_those_of_the_dense_design_matrix(degree: int) -> None:
    u, v = RNG.uniform(0, 1, (2, 400))
    u[:2] = 0.0, 1.0
    knots = clamped_knots(7, degree), clamped_knots(5, degree)
    inner = [np.ascontiguousarray(k[degree + 1 : -degree - 1]) for k in knots]
    along, across = basis_matrix(knots[0], degree, u), basis_matrix(knots[1], degree, v)
    design = np.einsum("ni,nj->nij", along, across).reshape(400, 35)
    found = ScatteredSplines((inner[0], inner[1]), (degree, degree), (u, v))
    values, factors, matrix = (RNG.normal(size=shape) for shape in ((400, 3), (35, 2), (35, 35)))
    np.testing.assert_allclose(found.normal(), design.T @ design, atol=1e-12)
    np.testing.assert_allclose(found.sums(values), design.T @ values, atol=1e-12)
    np.testing.assert_allclose(found.combined(factors), design @ factors, atol=1e-13)
    np.testing.assert_allclose(found.squares(matrix), np.sum((design @ matrix) * design, axis=1), atol=1e-12)
    with pytest.raises(ValueError, match="3 values for a grid of"):
        found.sums(values[:1])


def dense(points: np.ndarray, exponent: float, nearest: float = 0.0) -> np.ndarray:
    distance = np.maximum(cdist(points, points), nearest)
    np.fill_diagonal(distance, np.inf)
    return distance**-exponent


@pytest.mark.parametrize("nearest", [0.0, 4.0])
@pytest.mark.parametrize("exponent", [1.0, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0])
@pytest.mark.parametrize("n", [5, 513, 1100])
def test_pair_sums_are_the_double_loop(n: int, exponent: float, nearest: float) -> None:
    points, z = RNG.uniform(-30, 30, (n, 3)), RNG.normal(size=n)
    c = dense(points, exponent, nearest)
    weights, products = pair_sums(points, z, exponent, nearest)
    assert abs(weights - c.sum()) < 1e-12 * c.sum()
    assert abs(products - z @ c @ z) < 1e-12 * (np.abs(z) @ c @ np.abs(z))
    vectors = RNG.normal(size=(n, 5))
    found = weights_product(points, vectors, exponent, nearest)
    # What a point would weigh with itself is counted and taken away again: it leaves its rounding.
    own = nearest**-exponent if nearest else 0.0
    size = c @ np.abs(vectors) + own * np.abs(vectors)
    np.testing.assert_array_less(np.abs(found - c @ vectors), 1e-12 * size)


def on_sheet(n: int) -> np.ndarray:
    x, y = RNG.uniform(0, 50, (2, n))
    return np.stack([x, y, 4 * np.sin(x / 14) * np.cos(y / 17)], axis=1)


@pytest.mark.parametrize("place", [on_sheet, lambda n: RNG.uniform(0, 50, (n, 3))])
@pytest.mark.parametrize("digits", [2.0, 3.0, 5.0])
def test_far_pairs_worked_off_together_are_right_to_the_digits_asked_for(
    digits: float, place: Callable[[int], np.ndarray]
) -> None:
    """10⁴ points: the error anywhere is below 10^-digits Σ c |v|; of the statistic, a hundred times less."""
    points, vectors = place(10_000), RNG.normal(size=(10_000, 2))
    exact = weights_product(points, vectors, 3.0, 0.1)
    size = weights_product(points, np.abs(vectors), 3.0, 0.1)
    found = weights_product(points, vectors, 3.0, 0.1, digits)
    assert np.max(np.abs(found - exact) / size) < 10.0**-digits
    off = np.sum(vectors * (found - exact), axis=0) / np.sum(np.abs(vectors) * size, axis=0)
    assert np.max(np.abs(off)) < 0.01 * 10.0**-digits


def test_sums_do_not_depend_on_the_number_of_threads() -> None:
    points, z = RNG.uniform(0, 50, (3000, 3)), RNG.normal(size=3000)
    first, far = pair_sums(points, z, 3.0, 0.0), weights_product(points, z[:, None], 3.0, 0.0, 3.0)
    for _ in range(5):
        assert pair_sums(points, z, 3.0, 0.0) == first
        assert np.array_equal(weights_product(points, z[:, None], 3.0, 0.0, 3.0), far)


def test_kernels_refuse_what_they_cannot_sum() -> None:
    with pytest.raises(ValueError, match="finite"):
        pair_sums(np.full((3, 3), np.nan), np.zeros(3), 3.0, 0.0)
    with pytest.raises(ValueError, match="2 values for 3 points"):
        pair_sums(np.zeros((3, 3)), np.zeros(2), 3.0, 0.0)
    with pytest.raises(ValueError, match="positive"):
        weights_product(np.zeros((3, 3)), np.zeros((3, 1)), -1.0, 0.0)
    with pytest.raises(ValueError, match="negative"):
        weights_product(np.zeros((3, 3)), np.zeros((3, 1)), 3.0, -1.0)
    with pytest.raises(ValueError, match="3 columns"):
        pair_sums(np.zeros((3, 2)), np.zeros(3), 3.0, 0.0)
