"""How far two tool paths lie apart: known offsets, other orders and splittings, programs that cannot be compared."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.difference_reference import chords_of, distance_mm, largest_distance_mm
from trueloop.arrays import Integers
from trueloop.errors import Code, TrueloopError
from trueloop.nc.match.difference import path_difference
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

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


def test_a_point_that_only_seems_furthest_does_not_hide_the_one_that_is() -> None:
    """Short moves 4 µm from a point, whose line passes it at 1 µm with its middle further off; a cut lies 3 µm off."""
    moves = "\n".join(f"G1 X{0.4999 + k * 1e-5:.5f}" for k in range(-10, 11))
    other = f"G0 X0 Y0\nG1 X1 F100\nG0 X0.4998 Y0.005\n{moves}\n"
    one = f"{other}G0 X0.4999 Y0.001\nG1 X0.49991\nG0 X0.1 Y0.003\nG1 X0.2\n"
    assert path_difference(path(one), path(other)).distance_mm == pytest.approx(0.003, abs=1e-12)


short = st.integers(-40, 40).map(lambda k: k / 200)
lines = st.builds("G1 X{:.3f} Y{:.3f} Z{:.3f}".format, short, short, short)
arcs = st.builds("G{} X{:.3f} Y{:.3f} R1 F50".format, st.sampled_from([2, 3]), short, short)
cuts = st.lists(lines | arcs, min_size=1, max_size=12)


@settings(max_examples=60)
@given(cuts, cuts, st.integers(0, 12))
def test_the_distance_is_that_of_every_point_from_every_piece(one: list[str], more: list[str], kept: int) -> None:
    """Paths that begin alike, cross, double back, with moves without length and arcs of a few chords."""
    head = "G21 G17 G90 G94 F100\n"
    first, second = (path("\n".join(blocks), head) for blocks in (one, [*one[:kept], *more]))
    found = path_difference(first, second)
    assert found.distance_mm == pytest.approx(largest_distance_mm(first, second, found.spacing_mm), abs=1e-12)
    here, there = (first, second) if found.first else (second, first)
    at, nearest = np.array(found.position_mm), np.array(found.nearest_mm)
    assert np.linalg.norm(at - nearest) == pytest.approx(found.distance_mm, abs=1e-12)
    for point, of, move in ((at, here, found.move), (nearest, there, found.nearest_move)):
        chords = chords_of(dataclasses.replace(of, motion=only(of, move)), found.spacing_mm)
        assert distance_mm(point, chords) < 1e-9


def only(of: ToolPath, move: int) -> Integers:
    """Every motion but that one a rapid move."""
    return np.where(np.arange(len(of)) == move, of.motion, Motion.RAPID)


def test_a_path_of_more_points_than_are_looked_at_at_once() -> None:
    """One tooth of a comb of 30,000 moves is a hundredth of a millimetre longer."""
    teeth = [f"G1 X{k / 50:.2f} Y{(k % 2) * 0.02:.3f}" for k in range(30_000)]
    longer = [*teeth[:20_001], "G1 X400.02 Y0.03", *teeth[20_002:]]
    one, other = (path("\n".join(blocks)) for blocks in (teeth, longer))
    found = path_difference(one, other)
    assert not found.first and found.position_mm == pytest.approx((400.02, 0.03, 0.0), abs=1e-12)
    assert found.distance_mm == pytest.approx(0.01, abs=1e-12)
    assert path_difference(one, one).distance_mm == 0.0


def test_paths_that_lie_far_apart_everywhere() -> None:
    """Two waves 5 mm apart, of more points than are looked at first: most are judged by the way to a known one."""
    one, other = (
        path("\n".join(f"G1 X{k / 50:.2f} Y{math.sin(k / 9) + (k == 333) * 0.1:.6f} Z{z}" for k in range(600)))
        for z in (0, 5)
    )
    found = path_difference(one, other)
    assert found.distance_mm == pytest.approx(largest_distance_mm(one, other, found.spacing_mm), abs=1e-12)
