"""Programs of points: what moves, what stays, what is refused."""

import numpy as np
import pytest

from trueloop.errors import TrueloopError
from trueloop.machine.correct import TableField, displace_points
from trueloop.machine.standards import QuadrupoleField
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.field import table_field
from trueloop.nc.program.program import read_program

FIELD = QuadrupoleField(1e-4, 0.0)


def _corrected(text: str, dialect: str = "linuxcnc") -> str:
    program = read_program(text.encode(), dialect)
    return apply_edits(program, displace_points(program, FIELD).edits).decode()


def test_a_point_on_the_x_axis_is_pulled_in_and_one_on_the_y_axis_pushed_out() -> None:
    assert _corrected("G90 G21\nX200. Y0.\nX0. Y200.\n") == "G90 G21\nX199.98000 Y0.\nX0. Y200.02000\n"


def test_a_coordinate_left_out_is_written_in_when_its_correction_changes() -> None:
    """At (100, 100) the field vanishes; at (50, 100) it does not."""
    assert (
        _corrected("G90 G21\nG0 X100. Y100.\nX50. ( drill )\n")
        == "G90 G21\nG0 X100. Y100.\nX50.00300 Y100.00600 ( drill )\n"
    )


def test_inches_and_coordinate_systems() -> None:
    assert (
        _corrected("G20\nG52 X1. Y0.\nG0 X4. Y0.\nG53 X1. Y0.\n") == "G20\nG52 X1. Y0.\nG0 X3.999600 Y0.\nG53 X1. Y0.\n"
    )


def test_words_stay_as_fine_as_the_program_writes_them() -> None:
    """A control of 0.001 mm takes a program with five decimals: they are not rounded off."""
    assert _corrected("G90 G21\nX20. Y0.\n", "fanuc-mill") == "G90 G21\nX19.998 Y0.\n"
    assert _corrected("G90 G21\nX20.12345 Y0.\n", "fanuc-mill") == "G90 G21\nX20.12144 Y0.\n"
    written = _corrected("G90 G21\nX20.123456789012345678 Y0.\n", "fanuc-mill")
    assert written == "G90 G21\nX20.121444443000000000 Y0.\n"


def test_a_table_says_where_to_go_not_what_is_wrong() -> None:
    at = np.array([0.0, 100.0])
    moved = np.tile([0.002, -0.001, 0.0], (4, 1))
    program = read_program(b"G90 G21\nX50. Y50.\n", "linuxcnc")
    edits = displace_points(program, TableField(table_field(at, at, np.zeros(1), moved))).edits
    assert apply_edits(program, edits) == b"G90 G21\nX50.00200 Y49.99900\n"


@pytest.mark.parametrize(
    ("text", "dialect", "why"),
    [
        ("G21 G91\nX1. Y1.\n", "linuxcnc", "an increment"),
        ("G21\nX1. Y1.\nG2 X2. Y2. I1.\n", "linuxcnc", "an arc"),
        ("G7\nX1. Y1.\n", "linuxcnc", "diameter"),
        ("G51.1 X0.\nX1. Y1.\n", "fanuc-mill", "mirrored"),
        ("G21\nG68 X0. Y0. R30.\nX1. Y1.\n", "fanuc-mill", "under G68"),
        ("G21 G54\nX1. Y1.\nG55\nX1. Y1.\n", "linuxcnc", r"another zero \(G55\) than the first point \(G54\)"),
        ("G21\nX1. Y1.\nG54.1 P3\nX1. Y1.\n", "fanuc-mill", r"another zero \(G54.1 P3\)"),
        ("G21\nX1. Y1.\nG52 X50. Y0.\nX1. Y1.\n", "fanuc-mill", r"another zero \(G54 G52 X50.\)"),
        ("G21\nG52 X50.\nX1. Y1.\nG52 X0. Y0.\nX1. Y1.\n", "haas-mill", "another zero"),
        ("G21\nX1. Y1.\nG92 X0. Y0.\nX1. Y1.\n", "linuxcnc", "another zero"),
        ("G21\nX1. Y1.\nG10 L2 P1 X9. Y0.\nX1. Y1.\n", "fanuc-mill", "another zero"),
        ("G21\nG54 X1. Y1.\nG10 L2 P1 X9. Y0.\nG54 X1. Y1.\n", "fanuc-mill", "another zero"),
        ("G21\nX1.\n", "linuxcnc", "no position yet"),
        ("G21\nX[#1] Y1.\n", "linuxcnc", "computed"),
        ("X1. Z1.\n", "fanuc-lathe", "fanuc-lathe"),
        ("L X+1 Y+1\n", "heidenhain", "heidenhain"),
    ],
)
def test_what_is_no_program_of_points_is_refused(text: str, dialect: str, why: str) -> None:
    with pytest.raises(TrueloopError, match=f"MCH-PROGRAM: .*{why}"):
        displace_points(read_program(text.encode(), dialect), FIELD)


def test_one_zero_throughout_is_the_tables() -> None:
    """Shifted or set before the first point, turned back before the next: all points count from one zero."""
    program = "G21 G55\nG52 X5.\nX200. Y0.\nG68 X0. Y0. R9.\nG69\nG55 G52 X5.\nG10 L10 P1 R3.\nX0. Y200.\nG52 X0.\n"
    assert _corrected(program, "fanuc-mill") == program.replace("X200.", "X199.980").replace("Y200.", "Y200.020")


def test_a_point_outside_of_the_table_is_named_by_its_line() -> None:
    at = np.array([0.0, 100.0])
    table = TableField(table_field(at, at, np.zeros(1), np.zeros((4, 3))))
    with pytest.raises(TrueloopError, match=r"p.nc:3: NC-FIELD: .*150"):
        displace_points(read_program(b"G90 G21\nX1. Y1.\nX150. Y1.\n", "linuxcnc", "p.nc"), table)


@pytest.mark.parametrize(("z", "why"), [(np.zeros(1), "displaces Z by 5.0 µm"), (np.arange(2.0), "2 values of z_mm")])
def test_a_table_with_z_is_no_plane(z: np.ndarray, why: str) -> None:
    at = np.array([0.0, 100.0])
    moved = np.tile([0.0, 0.0, 0.005], (4 * len(z), 1))
    with pytest.raises(TrueloopError, match=why):
        TableField(table_field(at, at, z, moved)).error_mm(np.ones((1, 2)))


def test_quadrupole_is_what_it_says() -> None:
    at = np.array([[3.0, 4.0]])
    angle = np.arctan2(4.0, 3.0)
    expected = 2e-5 * np.cos(2 * (angle - 0.3)) * at
    np.testing.assert_allclose(QuadrupoleField(2e-5, 0.3).error_mm(at), expected, rtol=1e-14)
