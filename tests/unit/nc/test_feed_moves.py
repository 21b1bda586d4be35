"""Feed moves of a tool path: shapes, chains, and what breaks a chain."""

import math

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Line
from trueloop.nc.program.along import FeedMove, feed_moves, nose_centre_moves
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import ToolPath


def moves_of(text: str, dialect: str = "linuxcnc") -> tuple[FeedMove, ...]:
    return feed_moves(path_of(text, dialect))


def path_of(text: str, dialect: str = "linuxcnc") -> ToolPath:
    return read_program(text.encode(), dialect).run()


def test_lines_and_arcs_in_the_profile_plane() -> None:
    """G2 seen with z to the right and x up is clockwise: the dome's normal turns from x to z."""
    line, dome = moves_of("G21 G18 G8 G90 F100\nG0 X20 Z-30\nG1 Z-10\nG2 X0 Z10 I-20 K0\n")
    assert isinstance(line.path, Line) and isinstance(dome.path, Arc)
    assert (line.line, dome.line, line.chain) == (3, 4, dome.chain)
    assert dome.path.sweep_rad == pytest.approx(math.pi / 2)
    assert dome.path.centre_mm == pytest.approx((0, -10))
    np.testing.assert_allclose(dome.path.outward_normal([0.0, dome.path.length_mm]), [[1, 0], [0, 1]], atol=1e-12)


def test_fillet_is_concave() -> None:
    (fillet,) = moves_of("G21 G18 G8 G90 F100\nG0 X10 Z-10\nG3 X10 Z0 R5\n")
    assert isinstance(fillet.path, Arc) and fillet.path.sweep_rad == pytest.approx(-math.pi)


def test_diameter_and_inch_programs() -> None:
    (diameter,) = moves_of("G20 G18 G7 G90 F1\nG0 X2 Z0\nG1 X4 Z1\n")
    assert diameter.path == Line("", (25.4, 0.0), (50.8, 25.4))


def test_rapids_break_chains_and_standing_moves_do_not() -> None:
    text = "G21 G18 G8 G90 F100\nG0 X10 Z0\nG1 Z1\nG1 Z1\nG1 Z2\nG0 X11\nG1 X10\nG1 Z3\nG0 X10 Z3\nG1 Z4\n"
    assert [(m.line, m.chain - moves_of(text)[0].chain > 0) for m in moves_of(text)] == [
        (3, False), (5, False), (7, True), (8, True), (10, True)
    ]  # fmt: skip
    chains = [m.chain for m in moves_of(text)]
    assert chains[0] == chains[1] != chains[2] == chains[3] == chains[4], "a rapid that goes nowhere breaks nothing"


def test_change_of_frame_breaks_a_chain() -> None:
    first, second = moves_of("G21 G18 G8 G90 F100\nG0 X10 Z0\nG1 Z1\nG92 Z5\nG1 Z6\n")
    assert first.chain != second.chain
    assert second.path == Line("", (10.0, 5.0), (10.0, 6.0))


def test_compensation_is_refused_with_its_line() -> None:
    with pytest.raises(TrueloopError) as refusal:
        nose_centre_moves(path_of("G21 G18 G8 G90 F100\nG0 X30 Z5\nG42 G1 X20 Z5\nG1 Z-10\n"))
    assert refusal.value.code is Code.NC_COMPENSATED and refusal.value.place.line == 3
    assert nose_centre_moves(path_of("G21 G18 G8 G90 F100\nG0 X30 Z5\nG42\nG40\nG1 X20\n"))


def test_compensation_breaks_a_chain_and_is_known_of_each_move() -> None:
    before, on = moves_of("G21 G18 G8 G90 F100\nG0 X30 Z5\nG1 X20\nG42 G1 X10 Z5\n")
    assert (before.on_contour, on.on_contour, on.compensation) == (False, True, 42)
    assert before.chain != on.chain


def test_program_without_cuts() -> None:
    assert moves_of("G21 G18 G8 G90\nG0 X10 Z0\nM2\n") == ()
    assert moves_of("") == ()
