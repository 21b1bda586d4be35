"""The closest point in Rust beside a slow, readable search: every sample of a dense grid, then scipy's minimizer."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.support.surfaces import sphere, wavy_surface
from trueloop._core import NurbsPatch
from trueloop.arrays import Array
from trueloop.geometry.surface import Surface, clamped_knots, closest, fit_grid

RNG = np.random.default_rng(29)
STARTS = 4


def slow_distance_mm(surface: Surface, point: Array) -> float:
    """The least of the local minima downhill from the nearest samples, those next to each other among them."""
    (u0, u1), (v0, v1) = surface.domain
    us, vs = np.linspace(u0, u1, 121), np.linspace(v0, v1, 121)
    samples = np.linalg.norm(surface.grid_mm(us, vs) - point, axis=2)
    around = np.pad(samples, 1, constant_values=np.inf)
    lower = [around[1 + i : 122 + i, 1 + j : 122 + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    lowest = np.argwhere(samples <= np.min(lower, axis=0))
    starts = sorted(lowest.tolist(), key=lambda k: float(samples[k[0], k[1]]))[:STARTS]

    def square(at: Array) -> tuple[float, Array]:
        here = surface.partials(at[:1], at[1:])
        off = here.point_mm[0] - point
        return float(off @ off), 2 * np.array([off @ here.du[0], off @ here.dv[0]])

    bounds = [(u0, u1), (v0, v1)]
    found = [
        minimize(square, np.array([us[i], vs[j]]), jac=True, bounds=bounds, tol=1e-16, method="L-BFGS-B").fun
        for i, j in starts
    ]
    return float(np.sqrt(min(*found, float(np.min(samples)) ** 2)))


def bumpy(degrees: tuple[int, int], rational: bool) -> Surface:
    """Control points and weights by chance, knots unevenly spaced."""
    counts = (9, 8)
    knots = [clamped_knots(n, p) ** 1.5 for n, p in zip(counts, degrees, strict=True)]
    x, y = np.meshgrid(np.arange(9.0) * 4, np.arange(8.0) * 5, indexing="ij")
    control = np.stack([x, y, RNG.normal(0, 2.0, counts)], axis=2) + RNG.normal(0, 0.5, (*counts, 3))
    return Surface(degrees, knots[0], knots[1], control, RNG.uniform(0.4, 2.5, counts) if rational else None)


def folded() -> Surface:
    """A sheet bent into an S, so that a point has several local minima, far apart along the sheet."""
    t, y = np.meshgrid(np.linspace(-1.4, 1.4, 33), np.linspace(0, 20, 7), indexing="ij")
    return fit_grid(np.stack([10 * np.sin(3 * t), y, 10 * t], axis=2)).surface


def tube() -> Surface:
    """Three quarters of a cylinder by exact arcs, an edge of the knots between one and the next."""
    h = np.sqrt(0.5)
    corners = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1]], float)
    weights = np.outer([1, h, 1, h, 1, h, 1], [1.0, 1.0])
    control = np.stack([np.column_stack([12 * corners, np.full(7, z)]) for z in (0.0, 30.0)], axis=1)
    return Surface((2, 1), np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 3.0]), np.array([0, 0, 1, 1.0]), control, weights)


SURFACES = {
    "wavy": wavy_surface(),
    "ball": sphere(),
    "folded": folded(),
    "tube": tube(),
    "creased": bumpy((1, 1), rational=False),
    "degrees 2 and 3": bumpy((2, 3), rational=False),
    "degrees 5 and 1, rational": bumpy((5, 1), rational=True),
    "degrees 3 and 4, rational": bumpy((3, 4), rational=True),
}


@pytest.mark.parametrize("name", SURFACES)
def test_no_foot_is_farther_than_the_slow_search_finds_it(name: str) -> None:
    """Points in a box twice as large as the patch, so that many feet are on its border and at its corners."""
    surface = SURFACES[name]
    corners = surface.control_mm.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = (low + high) / 2 + RNG.uniform(-1, 1, (60, 3)) * (high - low)
    if name == "ball":  # its pole, where it has no normal, is the foot of no point before it
        points = np.abs(points) + 0.1
    feet = closest(surface, points)
    found = np.linalg.norm(points - feet.point_mm, axis=1)
    slow = np.array([slow_distance_mm(surface, point) for point in points])
    np.testing.assert_array_less(found, slow + 1e-9)
    np.testing.assert_allclose(feet.point_mm, surface.point_mm(feet.u, feet.v), atol=1e-11)
    if min(surface.degrees) > 1:  # at a crease either side's normal will do
        np.testing.assert_allclose(feet.normal, surface.normal(feet.u, feet.v), atol=1e-9)
    outside = feet.beyond_mm > 0
    np.testing.assert_allclose(np.hypot(feet.distance_mm, feet.beyond_mm)[outside], found[outside])


@pytest.mark.parametrize("name", ["wavy", "ball", "tube", "degrees 3 and 4, rational"])
def test_corners_and_border_are_their_own_feet(name: str) -> None:
    surface = SURFACES[name]
    (u0, u1), (v0, v1) = surface.domain
    v1 = v0 + 0.9 * (v1 - v0) if name == "ball" else v1  # at its pole a ball has no normal
    u = np.array([u0, u0, u1, u1, u0, u1, u0 + 0.3 * (u1 - u0)])
    v = np.array([v0, v1, v0, v1, v0 + 0.6 * (v1 - v0), v0 + 0.2 * (v1 - v0), v0])
    feet = closest(surface, surface.point_mm(u, v))
    np.testing.assert_allclose(feet.point_mm, surface.point_mm(u, v), atol=1e-11)
    np.testing.assert_allclose(feet.distance_mm, 0.0, atol=1e-11)
    np.testing.assert_allclose(feet.beyond_mm, 0.0, atol=1e-11)


def test_feet_do_not_depend_on_what_else_is_asked_nor_on_threads() -> None:
    surface = SURFACES["degrees 2 and 3"]
    points = surface.point_mm(*RNG.uniform(0, 1, (2, 5000))) + RNG.normal(0, 1, (5000, 3))
    feet = closest(surface, points)
    single = closest(surface, points[4321:4322])
    assert np.array_equal(feet.point_mm[4321:4322], single.point_mm)


def test_arrays_as_another_process_hands_them_over_need_not_be_aligned() -> None:
    ours = wavy_surface()
    points = RNG.uniform(0, 50, (9, 3))

    def shifted(values: Array) -> Array:
        odd = np.frombuffer(b"x" + values.tobytes(), np.uint8)[1:].view(np.float64).reshape(values.shape)
        assert not odd.flags.aligned
        return odd

    theirs = replace(ours, knots_u=shifted(ours.knots_u), knots_v=shifted(ours.knots_v))
    assert np.array_equal(closest(theirs, shifted(points)).point_mm, closest(ours, points).point_mm)


def test_from_a_place_given_the_search_goes_downhill() -> None:
    """Between two legs of the S a start on either leg keeps to it."""
    surface = SURFACES["folded"]
    legs = [closest(surface, np.array([[1.0, 10.0, z]])) for z in (-10.5, 10.5)]
    middle = np.array([[0.0, 10.0, 0.5]])
    (u0, u1), _ = surface.domain
    feet = [closest(surface, middle, (leg.u, leg.v)) for leg in legs]
    assert not np.isclose(feet[0].u, feet[1].u, atol=0.1 * (u1 - u0))


def test_the_kernel_refuses_what_is_no_patch_and_no_point() -> None:
    line, square = np.array([0, 0, 1, 1.0]), np.ones((2, 2, 4))
    with pytest.raises(ValueError, match="knots"):
        NurbsPatch((3, 1), (line, line), square)
    with pytest.raises(ValueError, match="weight"):
        NurbsPatch((1, 1), (line, line), square * np.array([1, 1, 1, 0.0]))
    patch = NurbsPatch((1, 1), (line, line), square)
    with pytest.raises(ValueError, match="point 1"):
        patch.feet(np.array([[0, 0, 0], [np.nan, 0, 0]]))
    with pytest.raises(ValueError, match="0 places"):
        patch.feet(np.zeros((1, 3)), np.zeros((0, 2)))
    with pytest.raises(ValueError, match="3 columns"):
        patch.feet(np.zeros((1, 2)))
