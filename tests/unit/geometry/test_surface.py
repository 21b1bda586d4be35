"""The nominal surface: points, derivatives, normals, curvature, closest points, fits."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from tests.support.surfaces import sphere, wavy_surface
from trueloop.geometry.surface import basis_matrix, basis_rows, clamped_knots, closest, fit_grid

RNG = np.random.default_rng(7)


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_basis_and_its_derivatives_are_those_of_scipy(degree: int) -> None:
    knots = np.concatenate([np.zeros(degree + 1), [0.2, 0.5, 0.5, 0.7], np.ones(degree + 1)])
    if degree == 1:
        knots = np.concatenate([np.zeros(2), [0.2, 0.5, 0.7], np.ones(2)])
    at = np.append(RNG.uniform(0, 1, 50), [0.0, 1.0])
    count = len(knots) - degree - 1
    rows = basis_rows(knots, degree, at)
    for derivative, found in ((0, rows.values), (1, rows.slopes), (2, rows.bends)):
        wanted = np.stack([BSpline(knots, np.eye(count)[k], degree)(at, nu=derivative) for k in range(count)], axis=1)
        got = np.zeros((len(at), count))
        np.put_along_axis(got, rows.first[:, None] + np.arange(degree + 1), found, axis=1)
        np.testing.assert_allclose(got, wanted, atol=1e-9 * 30**derivative)


def test_a_rational_sphere_is_round() -> None:
    ball = sphere(20.0)
    u, v = RNG.uniform(0, 1, 200), RNG.uniform(0, 0.95, 200)
    points = ball.point_mm(u, v)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 20.0, atol=1e-13)
    np.testing.assert_allclose(ball.normal(u, v), points / 20.0, atol=1e-13)
    np.testing.assert_allclose(ball.curvatures_per_mm(u, v), 1 / 20.0, atol=1e-12)
    np.testing.assert_allclose(ball.turned_over().curvatures_per_mm(u, v), -1 / 20.0, atol=1e-12)


def test_a_pole_has_the_normal_of_its_axis_and_is_a_foot() -> None:
    ball, at = sphere(20.0), np.linspace(0, 1, 5)
    np.testing.assert_allclose(ball.normal(at, np.ones(5)), np.tile([0.0, 0.0, 1.0], (5, 1)), atol=2e-6)
    feet = closest(ball, np.array([[0.0, 0.0, 23.0], [0.0, 23.0, 0.0]]))
    np.testing.assert_allclose(feet.distance_mm, 3.0, atol=1e-9)
    np.testing.assert_allclose(feet.normal, [[0, 0, 1], [0, 1, 0]], atol=2e-6)


def test_derivatives_are_differences_of_points() -> None:
    surface, step = sphere(20.0), 1e-5
    u, v = RNG.uniform(0.1, 0.9, 20), RNG.uniform(0.1, 0.9, 20)
    at, more, less = (surface.partials(u + d, v) for d in (0.0, step, -step))
    up, down = (surface.partials(u, v + d) for d in (step, -step))
    np.testing.assert_allclose(at.du, (more.point_mm - less.point_mm) / (2 * step), atol=1e-6)
    np.testing.assert_allclose(at.dv, (up.point_mm - down.point_mm) / (2 * step), atol=1e-6)
    np.testing.assert_allclose(at.duu, (more.du - less.du) / (2 * step), atol=1e-6)
    np.testing.assert_allclose(at.duv, (more.dv - less.dv) / (2 * step), atol=1e-6)
    np.testing.assert_allclose(at.dvv, (up.dv - down.dv) / (2 * step), atol=1e-6)


def test_grid_and_single_places_agree() -> None:
    for surface in (wavy_surface(), sphere()):
        u, v = np.linspace(0, 1, 7), np.linspace(0, 0.9, 5)
        grid = surface.grid_mm(u, v).reshape(-1, 3)
        np.testing.assert_allclose(grid, surface.point_mm(np.repeat(u, 5), np.tile(v, 7)), atol=1e-13)


def test_no_places_have_no_points_and_no_feet() -> None:
    none = np.empty(0)
    for surface in (wavy_surface(), sphere()):
        assert surface.point_mm(none, none).shape == surface.normal(none, none).shape == (0, 3)
        assert closest(surface, np.empty((0, 3))).distance_mm.shape == (0,)


def test_the_foot_of_a_point_lifted_along_the_normal_is_where_it_came_from() -> None:
    surface = wavy_surface()
    u, v = RNG.uniform(0, 1, 5000), RNG.uniform(0, 1, 5000)
    lift = RNG.uniform(-3.0, 5.0, 5000)
    feet = closest(surface, surface.point_mm(u, v) + lift[:, None] * surface.normal(u, v))
    np.testing.assert_allclose(feet.distance_mm, lift, atol=1e-12)
    np.testing.assert_allclose(feet.u, u, atol=1e-10)
    assert np.all(feet.beyond_mm == 0)


def test_beyond_the_edge_the_foot_is_on_the_edge() -> None:
    flat = fit_grid(
        np.stack([*np.meshgrid(np.arange(5.0), np.arange(6.0), indexing="ij"), np.zeros((5, 6))], 2)
    ).surface
    feet = closest(flat, np.array([[-3.0, 2.5, 1.0], [4.5, 7.0, -2.0], [2.2, 3.3, 0.5]]))
    np.testing.assert_allclose(feet.point_mm, np.array([[0, 2.5, 0], [4, 5, 0], [2.2, 3.3, 0]]), atol=1e-12)
    np.testing.assert_allclose(feet.distance_mm, [1, -2, 0.5], atol=1e-12)
    np.testing.assert_allclose(feet.beyond_mm, np.array([3.0, np.hypot(0.5, 2), 0.0]), atol=1e-12)


def test_a_fit_through_every_point_meets_them_and_a_coarser_one_says_by_how_much_not() -> None:
    x, y = np.meshgrid(np.linspace(0, 9, 19), np.linspace(0, 12, 24), indexing="ij")
    points = np.stack([x, y, np.sin(x) * np.cos(y / 2)], axis=2)
    assert fit_grid(points).worst_mm < 1e-12
    coarse = fit_grid(points, (9, 8))
    off = coarse.surface.grid_mm(coarse.u, coarse.v) - points
    assert coarse.worst_mm == pytest.approx(np.max(np.linalg.norm(off, axis=2)))
    assert 1e-4 < coarse.worst_mm < 0.3


def test_matrix_rows_sum_to_one() -> None:
    matrix = basis_matrix(clamped_knots(9, 3), 3, np.linspace(0, 1, 30))
    np.testing.assert_allclose(matrix.sum(axis=1), 1.0, atol=1e-14)
