"""Crossings and distances of lines and circles in whole numbers."""

import math
from itertools import pairwise

import numpy as np
import pytest

from trueloop.geometry.curve_kinds import b_spline, ellipse, power_series
from trueloop.geometry.feature import Arc, Line, distance_mm
from trueloop.geometry.intersection import beyond_end, crossings, intersections, sign_changes


def circle(x: float, z: float, radius: float) -> Arc:
    """Half of it, which stands for the whole."""
    return Arc("circle", (x, z - radius), (x, z + radius), (x, z), math.pi)


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (circle(0, 0, 13), circle(14, 0, 15), [(5, -12), (5, 12)]),
        (circle(14, 0, 15), circle(0, 0, 13), [(5, -12), (5, 12)]),
        (circle(0, 0, 5), circle(0, 8, 5), [(-3, 4), (3, 4)]),
        (circle(1, 2, 5), Line("line", (-10, 5), (10, 5)), [(-3, 5), (5, 5)]),
        (circle(0, 0, 3), circle(5, 0, 2), [(3, 0), (3, 0)]),
        (circle(0, 0, 3), circle(5.1, 0, 2), []),
        (Line("a", (0, 0), (4, 0)), Line("b", (1, -1), (3, 1)), [(2, 0)]),
    ],
)
def test_crossings_in_whole_numbers(first: Arc | Line, second: Arc | Line, expected: list[tuple[float, float]]) -> None:
    found = sorted(intersections(first, second))
    assert [pytest.approx(point, abs=1e-12) for point in expected] == found


def test_distance_beyond_an_end_is_that_to_the_nearer_end() -> None:
    line = Line("line", (0.0, 0.0), (0.0, 10.0))
    assert [distance_mm(line, point) for point in ((3.0, -4.0), (3.0, 14.0), (3.0, 5.0))] == pytest.approx([5, 5, 3])


def test_a_chain_that_ends_on_itself_touches_what_meets_there() -> None:
    """The third line ends on the first, and the fourth begins there: both touch the first, at (10, 4)."""
    corners = [(10.0, 0.0), (10.0, 10.0), (16.0, 7.0), (10.0, 4.0), (4.0, 2.0)]
    chain = [Line(str(k), a, b) for k, (a, b) in enumerate(pairwise(corners))]
    found = crossings(chain, 1e-3)
    assert sorted((i, j) for i, j, _ in found) == [(0, 2), (0, 3)]
    assert all(point == pytest.approx((10.0, 4.0), abs=1e-12) for _, _, point in found)


@pytest.mark.parametrize("convex", [True, False])
@pytest.mark.parametrize("at_end", [True, False])
def test_beyond_its_end_an_ellipse_goes_on_along_half_of_its_circle_of_curvature(at_end: bool, convex: bool) -> None:
    """Of semi-axes 24 and 30 mm: radius 30² / 24 = 37.5 mm at (24, 0), 24² / 30 = 19.2 mm at (0, 30)."""
    ends = ((24.0, 0.0), (0.0, 30.0)) if convex else ((0.0, 30.0), (24.0, 0.0))
    egg = ellipse("egg", ends, (0.0, 0.0), (24.0, 30.0), convex=convex)
    beyond = beyond_end(egg, at_end)
    at_vertex = at_end is not convex
    assert isinstance(beyond, Arc)
    assert beyond.start_mm == pytest.approx((24.0, 0.0) if at_vertex else (0.0, 30.0), abs=1e-7)
    assert beyond.centre_mm == pytest.approx((24.0 - 37.5, 0.0) if at_vertex else (0.0, 30.0 - 19.2), abs=1e-5)
    assert abs(beyond.sweep_rad) == pytest.approx(math.pi)
    away = (0.0, -1.0) if at_vertex else (-1.0, 0.0)
    assert beyond.tangent(0.0) == pytest.approx(away, abs=1e-7)
    np.testing.assert_allclose(beyond.point_mm(beyond.length_mm), beyond.end_mm, atol=1e-9)


def test_beyond_a_straight_end_a_curve_goes_on_straight() -> None:
    straight = b_spline("s", [(20.0, 10.0 * k) for k in range(5)], [0.0] * 5 + [1.0] * 5, 4)
    for at_end, start, away in ((True, (20.0, 40.0), 1.0), (False, (20.0, 0.0), -1.0)):
        beyond = beyond_end(straight, at_end)
        assert isinstance(beyond, Line) and beyond.start_mm == pytest.approx(start, abs=1e-9)
        assert beyond.tangent(0.0) == pytest.approx((0.0, away), abs=1e-9)


def test_a_curve_s_loop_is_found_where_it_crosses_itself() -> None:
    """By hand, q = t (1 − t): x = 20 + 120 q, z = 10 + 20 (t − ½)(1 − 16 q), which is 10 twice where q = 1/16."""
    knots = [0.0] * 4 + [1.0] * 4
    loop = b_spline("loop", [(20.0, 0.0), (60.0, 60.0), (60.0, -40.0), (20.0, 20.0)], knots, 3)
    ((first, second, point),) = crossings([loop], 1e-3)
    assert (first, second) == (0, 0) and math.dist(point, (27.5, 10.0)) < 1.0  # the beginning of a chord
    arch = b_spline("arch", [(20.0, 0.0), (80.0, -20.0), (80.0, 40.0), (20.0, 20.0)], knots, 3)
    assert crossings([arch], 1e-3) == []


@pytest.mark.parametrize(
    ("off_mm", "expected"), [(0.9e-12, [0.0]), (-0.9e-12, [0.0]), (1.5e-12, []), (-1.5e-12, [1.5e-12])]
)
def test_an_end_within_rounding_of_a_line_is_on_it(off_mm: float, expected: list[float]) -> None:
    """The curve is x = 1 mm from z = 0 up: beyond 1e-12 mm its start is on one side, and only below does it cross."""
    straight = power_series("straight", ((1.0, 0.0), (1.0, 2.0)), (1.0,))
    found = sign_changes(straight, lambda points: points[..., 1] + off_mm)
    assert found.tolist() == pytest.approx(expected, abs=2e-13)
