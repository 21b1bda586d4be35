"""Places along moves lie on their lines, arcs and helices, and an axis stands only where the program said."""

import math

import numpy as np
import pytest

from trueloop.nc.program.along import lengths_mm, points_along, said_ends
from trueloop.nc.program.program import read_program

HALF = math.sqrt(0.5)


@pytest.mark.parametrize(
    ("block", "start", "middle"),
    [
        ("G17 G2 X10 Y0 I0 J-10", (0, 10, 0), (10 * HALF, 10 * HALF, 0)),
        ("G17 G3 X10 Y0 I10 J0", (0, 10, 0), (10 - 10 * HALF, 10 - 10 * HALF, 0)),
        ("G18 G2 Z10 X0 I-10 K0", (10, 0, 0), (10 * HALF, 0, 10 * HALF)),
        ("G19 G2 Y10 Z0 J0 K-10", (0, 0, 10), (0, 10 * HALF, 10 * HALF)),
        ("G17 G2 X10 Y0 Z4 I0 J-10", (0, 10, 0), (10 * HALF, 10 * HALF, 2)),
        ("G1 X4 Y10 Z2", (0, 10, 0), (2, 10, 1)),
    ],
)
def test_the_middle_of_a_move_is_where_it_is_by_hand(block: str, start: tuple[float, ...], middle: object) -> None:
    x, y, z = start
    path = read_program(f"G21 G90\nG0 X{x} Y{y} Z{z}\n{block} F100\n".encode(), "linuxcnc").run()
    last = np.full(3, len(path) - 1)
    points = points_along(path, last, np.array([0.0, 0.5, 1.0]))
    assert points[0] == pytest.approx(path.start_mm[-1]) and points[2] == pytest.approx(path.end_mm[-1])
    assert points[1] == pytest.approx(middle)
    many = points_along(path, np.intp(last[0]), np.linspace(0, 1, 10_001))
    assert lengths_mm(path, last)[0] == pytest.approx(np.linalg.norm(np.diff(many, axis=0), axis=1).sum(), rel=1e-7)


def test_an_axis_stands_where_a_position_said_and_no_longer_after_a_way_home() -> None:
    source = b"G21 G90\nG0 X1.\nG91 Y2.\nG90 Z3.\nY4.\nG28 Z9.\nG1 X5. F99\nZ1.\nM30\n"
    program = read_program(source, "fanuc-mill")
    path = program.run()
    before, after = said_ends(program, path)
    told = {int(line): "".join(np.array([*"XYZ"])[row]) for line, row in zip(path.line, after, strict=True)}
    assert told == {2: "X", 3: "X", 4: "XZ", 5: "XYZ", 6: "XY", 7: "XY", 8: "XYZ"}
    assert not before[0].any() and np.array_equal(before[1:], after[:-1])
