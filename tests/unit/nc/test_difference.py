"""How far two tool paths lie apart: known offsets, other orders and splittings, programs that cannot be compared."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trueloop.errors import Code, TrueloopError
from trueloop.nc.difference import path_difference
from trueloop.nc.program import read_program
from trueloop.nc.tool_path import ToolPath

HEAD = "G21 G18 G8 G90 G94 F100\n"


def path(text: str, head: str = HEAD) -> ToolPath:
    return read_program((head + text).encode(), "linuxcnc").run()


def test_a_program_and_itself() -> None:
    shape = path("G0 X10 Z0\nG1 Z20\nG2 X15 Z25 I5 K0\nG3 X20 Z30 R5\nG1 X30")
    assert path_difference(shape, shape).distance_mm == 0.0


def test_a_line_displaced_says_where() -> None:
    one, other = path("G0 X10 Z0\nG1 Z20\nG0 X50"), path("G0 X10 Z0\nG1 X10.5 Z20\nG0 X50")
    found = path_difference(one, other)
    # From (10, 20) to the line through (10, 0) and (10.5, 20); from (10.5, 20) it is 0.5 to the end of the other.
    assert found.distance_mm == pytest.approx(0.5, abs=1e-12)
    assert (found.first, other.line[found.move], one.line[found.nearest_move]) == (False, 3, 3)
    assert found.position_mm == pytest.approx((10.5, 0.0, 20.0), abs=1e-12)
    assert found.nearest_mm == pytest.approx((10.0, 0.0, 20.0), abs=1e-12)


@settings(max_examples=25)  # everywhere equally far apart: the search has to look at every chord
@given(st.floats(0.5, 200.0), st.floats(-0.3, 0.3))
def test_circles_about_one_centre_lie_apart_by_the_difference_of_radii(radius_mm: float, more_mm: float) -> None:
    def circle(radius_mm: float) -> ToolPath:
        return path(f"G0 X{radius_mm:.9f} Z0\nG2 X{radius_mm:.9f} Z0 I-{radius_mm:.9f} K0")

    found = path_difference(circle(radius_mm), circle(radius_mm + more_mm))
    assert found.distance_mm == pytest.approx(abs(more_mm), abs=2.1e-6)  # two sagittas


def test_order_direction_and_splitting_play_no_part() -> None:
    one = path("G0 X5 Z0\nG1 Z10\nG3 X10 Z15 I5 K0")
    half = 5 * math.sqrt(0.5)
    other = path(f"G0 X10 Z15\nG2 X{10 - half:.12f} Z{10 + half:.12f} I0 K-5\nG2 X5 Z10 R5\nG1 Z3\nZ0")
    assert path_difference(one, other).distance_mm < 1e-5


def test_helices_in_all_planes() -> None:
    for plane, start, centre, end in (
        ("G17", "X10 Y0 Z0", "I-10", "X-10 Y0 Z{}"),
        ("G19", "Y10 Z0 X0", "J-10", "Y-10 Z0 X{}"),
        ("G18", "Z10 X0 Y0", "K-10", "Z-10 X0 Y{}"),
    ):
        one, other = (path(f"{plane} G0 {start}\nG3 {centre} {end.format(rise)}") for rise in (5, 5.25))
        assert path_difference(one, other).distance_mm == pytest.approx(0.25, abs=0.01), plane


def test_rapid_moves_count_when_asked_for() -> None:
    one, other = path("G0 X10 Z0\nG1 Z20\nG0 X50"), path("G0 X10 Z0\nG1 Z20\nG0 X60")
    assert path_difference(one, other).distance_mm == 0.0
    assert path_difference(one, other, rapids=True).distance_mm == pytest.approx(10.0)


def test_what_cannot_be_compared() -> None:
    cut = path("G1 X1")
    with pytest.raises(TrueloopError) as none:
        path_difference(cut, path("G0 X1"))
    assert none.value.code is Code.NC_NO_CONTOUR
    unknown = read_program(b"G21 G1 X#<a>", "linuxcnc").run(strict=False)
    with pytest.raises(TrueloopError, match="line 1 begins or ends") as refused:
        path_difference(unknown, cut)
    assert refused.value.code is Code.NC_EXPRESSION


def test_many_short_moves_do_not_hide_a_longer_one_that_is_nearer() -> None:
    """Twenty moves of a hundredth of a micrometre pass a micrometre beside the middle of a line."""
    short = "\n".join(f"G1 X{0.5 + k * 1e-5:.5f}" for k in range(-10, 11))
    beside = path(f"G0 X0 Y0\nG1 X1 F100\nG0 X0.4999 Y0.001\n{short}\n")
    assert path_difference(beside, beside).distance_mm < 1e-12
