"""Fast kernels beside their slow references: splines over a grid, sums over pairs of points."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from trueloop._core import fit_surface_grid, pair_sums, weights_product
from trueloop.geometry.surface_basis import basis_matrix, clamped_knots

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


@pytest.mark.parametrize("exponent", [1.0, 2.0, 2.5, 3.0, 4.0])
@pytest.mark.parametrize("n", [5, 513, 1100])
def test_pair_sums_are_the_double_loop(n: int, exponent: float) -> None:
    points, z = RNG.uniform(-30, 30, (n, 3)), RNG.normal(size=n)
    distance = cdist(points, points)
    np.fill_diagonal(distance, np.inf)
    c = distance**-exponent
    wanted = (c.sum(), (c**2).sum(), z @ c @ z, (c * (z[:, None] - z) ** 2).sum())
    found = pair_sums(points, z, exponent)
    scale = (c.sum(), (c**2).sum(), np.abs(z) @ c @ np.abs(z), wanted[3])
    for f, w, s in zip(found, wanted, scale, strict=True):
        assert abs(f - w) < 1e-12 * s
    rows, product = weights_product(points, np.ascontiguousarray(np.stack([z, z**2], 1)), exponent)
    np.testing.assert_allclose(rows, c.sum(axis=1), rtol=1e-12)
    np.testing.assert_allclose(product[:, 1], c @ z**2, rtol=1e-12)


def test_sums_do_not_depend_on_the_number_of_threads() -> None:
    points, z = RNG.uniform(0, 50, (3000, 3)), RNG.normal(size=3000)
    first = pair_sums(points, z, 3.0)
    assert all(pair_sums(points, z, 3.0) == first for _ in range(5))


def test_kernels_refuse_what_they_cannot_sum() -> None:
    with pytest.raises(ValueError, match="finite"):
        pair_sums(np.full((3, 3), np.nan), np.zeros(3), 3.0)
    with pytest.raises(ValueError, match="2 values for 3 points"):
        pair_sums(np.zeros((3, 3)), np.zeros(2), 3.0)
    with pytest.raises(ValueError, match="positive"):
        weights_product(np.zeros((3, 3)), np.zeros((3, 1)), -1.0)
    with pytest.raises(ValueError, match="three columns"):
        pair_sums(np.zeros((3, 2)), np.zeros(3), 3.0)
