"""End mills: cusps by their closed forms, and a free-form surface by brute force."""

import math

import numpy as np
import pytest

from tests.support.surfaces import ball_end
from trueloop.arrays import Array
from trueloop.surface.compensation.cutter import Cutter
from trueloop_lab.simulator.mill import EndMill, MilledStock, turn_rad

CUTTER = ball_end(3.0)
UP = np.array([0.0, 0.0, 1.0])


def raster(contact_mm: Array, normal: Array, cutter: EndMill) -> list[Array]:
    """Passes along the rows of a grid of contacts and normals, (rows, n, 3) each, every other one backwards."""
    return [row if k % 2 == 0 else row[::-1] for k, row in enumerate(cutter.centres_mm(contact_mm, normal))]


def cusp_height_mm(step_over_mm: float, cutter_radius_mm: float, curvature_per_mm: float = 0.0) -> float:
    """Height of the cusp between two passes that touch the surface `step_over_mm` of chord apart.

    `curvature_per_mm` is that of the surface across the passes, positive where it is convex. Both contacts lie on a
    circle of the surface, the cusp where the two balls' outlines meet in the plane between them. Valid for a step-over
    below the cutter's diameter, and in a hollow for a cutter smaller than its radius.
    """
    half, radius = step_over_mm / 2, cutter_radius_mm
    if curvature_per_mm == 0.0:
        return float(radius - np.sqrt(radius**2 - half**2))
    surface = 1.0 / curvature_per_mm  # signed: negative in a hollow
    along = np.sqrt(surface**2 - half**2) * np.sign(surface)
    centre_height = along * (1.0 + radius / surface)
    centre_aside = half * (1.0 + radius / surface)
    return float(centre_height - np.sqrt(radius**2 - centre_aside**2) - surface)


def wavy(x: Array, y: Array) -> tuple[Array, Array]:
    """z = 0.5 sin(x/8) cos(y/10) with its normals."""
    z = 0.5 * np.sin(x / 8) * np.cos(y / 10)
    slope_x, slope_y = np.cos(x / 8) * np.cos(y / 10) / 16, -np.sin(x / 8) * np.sin(y / 10) / 20
    normal = np.stack([-slope_x, -slope_y, np.ones_like(x)], axis=-1)
    return np.stack([x, y, z], axis=-1), normal / np.linalg.norm(normal, axis=-1, keepdims=True)


def plane_passes(step_over: float) -> list[Array]:
    x = np.linspace(-10.0, 10.0, 21)
    return [np.column_stack([x, np.full(21, y), np.full(21, 3.0)]) for y in np.arange(-2, 3) * step_over]


@pytest.mark.parametrize("step_over", [0.2, 0.5, 1.5])
def test_between_two_passes_on_a_plane_stands_the_cusp(step_over: float) -> None:
    stock = MilledStock().cut_by(CUTTER, plane_passes(step_over))
    y = np.array([0.0, 0.25, 0.5, 0.75, 1.0]) * step_over
    points = np.column_stack([np.linspace(-3, 3, 5), y, np.zeros(5)])
    height = stock.height_mm(points, np.tile(UP, (5, 1)))
    expected = 3.0 - np.sqrt(9.0 - np.minimum(y, step_over - y) ** 2)
    assert np.allclose(height, expected, atol=1e-12)
    assert math.isclose(height[2], cusp_height_mm(step_over, 3.0), abs_tol=1e-12)


@pytest.mark.parametrize("radius", [40.0, -40.0])
def test_on_a_cylinder_and_in_a_trough_the_cusp_is_that_of_the_curvature(radius: float) -> None:
    angle = np.arange(-2, 3) * 0.02
    normal = np.column_stack([np.zeros(5), np.sin(angle), np.cos(angle)]) * math.copysign(1.0, radius)
    normal = normal if radius > 0 else np.column_stack([np.zeros(5), -np.sin(angle), np.cos(angle)])
    contact = np.column_stack([np.zeros(5), abs(radius) * np.sin(angle), radius * np.cos(angle) - radius])
    passes = [
        CUTTER.centres_mm(c + np.array([[x, 0, 0] for x in (-5.0, 5.0)]), n)
        for c, n in zip(contact, normal, strict=True)
    ]
    middle = 0.01
    point = np.array([[0.0, abs(radius) * math.sin(middle), radius * math.cos(middle) - radius]])
    out = np.array([[0.0, math.copysign(math.sin(middle), radius), math.cos(middle)]])
    height = MilledStock().cut_by(CUTTER, passes).height_mm(point, out)
    step_over = 2 * abs(radius) * math.sin(middle)
    assert math.isclose(height[0], cusp_height_mm(step_over, 3.0, 1.0 / radius), abs_tol=1e-10)


def test_a_free_form_surface_is_what_the_nearest_ball_position_leaves() -> None:
    """Dense positions of the ball, looked at one by one, give the same heights to their chords' 0.1 µm."""
    x, y = np.meshgrid(np.linspace(-6, 6, 121), np.linspace(-3, 3, 13))
    contact, normal = wavy(x, y)
    passes = raster(contact, normal, CUTTER)
    rng = np.random.default_rng(4)
    points, out = wavy(rng.uniform(-4, 4, 40), rng.uniform(-2, 2, 40))
    found = MilledStock().cut_by(CUTTER, passes).height_mm(points, out)
    dense = np.concatenate([_dense(p, 4801) for p in passes])
    for point, direction, height in zip(points, out, found, strict=True):
        from_point = dense - point
        along = from_point @ direction
        square = 9.0 - (np.sum(from_point**2, axis=1) - along**2)
        brute = np.min(along[square > 0] - np.sqrt(square[square > 0]))
        assert abs(brute - height) < 1e-6
    assert np.all(found > -2e-4) and found.max() < 1.3 * cusp_height_mm(0.5, 3.0)


LEAD = math.radians(12.0)


@pytest.mark.parametrize("along", [True, False], ids=["lead", "tilt"])
def test_a_flat_end_that_leans_leaves_an_ellipse_or_a_slope(along: bool) -> None:
    """Leaning along its way it leaves half an ellipse R wide and R sin α high; aside, a slope of tan α."""
    axis = (math.sin(LEAD), 0.0, math.cos(LEAD)) if along else (0.0, math.sin(LEAD), math.cos(LEAD))
    flat = EndMill(Cutter(2.0, 0.0), axis)
    bottom = 2.0 * math.sin(LEAD)
    ends = np.array([[-20.0, 0.0, bottom], [20.0, 0.0, bottom]])
    y = np.linspace(-1.8, 1.8, 13)
    points = np.column_stack([np.linspace(-3, 3, 13), y, np.zeros(13)])
    found = MilledStock().cut_by(flat, [ends]).height_mm(points, np.tile(UP, (13, 1)))
    expected = bottom - math.sin(LEAD) * np.sqrt(4.0 - y**2) if along else bottom - y * math.tan(LEAD)
    np.testing.assert_allclose(found, expected, atol=1e-10)


@pytest.mark.parametrize("corner", [1.0, 0.25])
def test_a_bull_nose_that_leans_leaves_what_the_nearest_ball_of_its_ring_leaves(corner: float) -> None:
    """Dense balls around the ring, at dense places of every pass: above by less than 0.4 µm, never below."""
    axis = np.array([math.sin(LEAD), 0.1, math.cos(LEAD)])
    axis /= np.linalg.norm(axis)
    cutter = EndMill(Cutter(3.0, corner), (float(axis[0]), float(axis[1]), float(axis[2])))
    x, y = np.meshgrid(np.linspace(-4, 4, 41), np.linspace(-1, 1, 5))
    passes = raster(*wavy(x, y), cutter)
    points, out = wavy(np.random.default_rng(4).uniform(-2, 2, 12), np.random.default_rng(5).uniform(-0.6, 0.6, 12))
    found = MilledStock().cut_by(cutter, passes).height_mm(points, out)
    aside = np.cross(axis, [0.0, 1.0, 0.0])
    aside /= np.linalg.norm(aside)
    turn = np.linspace(0, 2 * np.pi, 1200, endpoint=False)
    ring = cutter.cutter.ring_mm * (np.cos(turn)[:, None] * aside + np.sin(turn)[:, None] * np.cross(axis, aside))
    centres = np.concatenate([_dense(p, 401) for p in passes])
    for point, direction, height in zip(points, out, found, strict=True):
        near = centres[np.linalg.norm(centres - point, axis=1) < 3.4]
        from_point = (near[:, None] + ring[None]).reshape(-1, 3) - point
        along = from_point @ direction
        square = corner**2 - (np.sum(from_point**2, axis=1) - along**2)
        assert -1e-9 < np.min(along[square > 0] - np.sqrt(square[square > 0])) - height < 4e-4
    assert np.all(np.abs(found) < 0.03)


def test_a_flat_end_that_tilts_where_it_stands_leaves_a_slope_and_the_circle_of_its_edge() -> None:
    """About its tip, from upright to θ: below the disc at θ a slope of tan θ, and beyond its edge the edge's circle."""
    most, radius = math.radians(40.0), 2.0
    flat = EndMill(Cutter(radius, 0.0))
    tilt = np.linspace(0.0, most, math.ceil(most / turn_rad(flat.cutter)) + 1)
    axes = np.column_stack([np.sin(tilt), 0 * tilt, np.cos(tilt)])
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(0.1, 1.9, 19), [0.0, 0.4]))
    inside = x**2 + y**2 < radius**2 - 1e-9
    points = np.column_stack([x, y, 0 * x])[inside]
    stock = MilledStock().cut_by(flat, [np.zeros(axes.shape)], axes=[axes])
    x, edge = points[:, 0], np.sqrt(radius**2 - points[:, 1] ** 2)
    expected = np.where(x <= edge * math.cos(most), -x * math.tan(most), -np.sqrt(edge**2 - x**2))
    assert 4 < np.count_nonzero(x > edge * math.cos(most)) < len(x) - 4
    np.testing.assert_allclose(stock.height_mm(points, np.tile(UP, (len(x), 1))), expected, atol=5e-5)


def test_between_two_places_the_edge_of_a_turning_cutter_keeps_its_circle_to_a_hundredth_of_a_micrometre() -> None:
    cutter = Cutter(3.0, 0.0)
    off_mm = cutter.radius_mm * (1.0 - math.cos(turn_rad(cutter) / 2))
    assert off_mm == pytest.approx(1e-5, rel=1e-3)


def test_a_ball_that_turns_about_its_centre_leaves_what_it_leaves_upright() -> None:
    x = np.linspace(-5.0, 5.0, 201)
    axes = np.column_stack([np.sin(0.1 * x), np.cos(3 * x) * 0.2, np.cos(0.1 * x)])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    centres = np.column_stack([x, 0 * x, np.full(201, 3.0)])
    points = np.column_stack([np.linspace(-3, 3, 9), np.linspace(-1, 1, 9), np.zeros(9)])
    upright, turning = (
        MilledStock().cut_by(CUTTER, [centres], axes=[given]).height_mm(points, np.tile(UP, (9, 1)))
        for given in (None, axes)
    )
    np.testing.assert_array_equal(turning, upright)


def _dense(centres: Array, count: int) -> Array:
    at = np.linspace(0, len(centres) - 1, count)
    return np.column_stack([np.interp(at, np.arange(len(centres)), centres[:, k]) for k in range(3)])


def test_a_worn_corner_leaves_material_on_and_a_worn_flat_end_is_narrower() -> None:
    y = np.array([0.0, 2.985, 2.995])
    points, normal = np.column_stack([0 * y, y, 0 * y]), np.tile(UP, (3, 1))
    for corner, expected in ((1.0, [0.010, 1 - math.sqrt(0.99**2 - 0.985**2), 0.5]), (0.0, [0.0, 0.0, 0.5])):
        worn = EndMill(Cutter(3.0, corner), radius_error_mm=-0.010)
        stock = MilledStock().cut_by(worn, [np.array([[-5.0, 0.0, corner], [5.0, 0.0, corner]])])
        np.testing.assert_allclose(stock.height_mm(points, normal, 0.5 + corner)[:2], expected[:2], atol=1e-10)
        assert stock.height_mm(points, normal, 0.5)[2] == expected[2]


def test_a_worn_cutter_and_a_machine_error_stay_on_the_part() -> None:
    """10 µm less radius leaves 10 µm on; a machine 5 µm too high leaves 5 µm more."""
    worn = ball_end(3.0, -0.010)
    stock = MilledStock().cut_by(worn, plane_passes(0.5), lambda p: np.tile([0.0, 0.0, 0.005], (len(p), 1)))
    height = stock.height_mm(np.zeros((1, 3)), UP[None])
    assert math.isclose(height[0], 0.015, abs_tol=1e-12)


def test_what_no_pass_came_near_is_uncut() -> None:
    stock = MilledStock().cut_by(CUTTER, plane_passes(0.5))
    assert stock.height_mm(np.array([[0.0, 30.0, 0.0]]), UP[None], 1.5)[0] == 1.5
