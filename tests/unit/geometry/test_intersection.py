"""Crossings and distances of lines and circles in whole numbers."""

import math

import pytest

from trueloop.geometry.feature import Arc, Line, distance_mm
from trueloop.geometry.intersection import intersections


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
