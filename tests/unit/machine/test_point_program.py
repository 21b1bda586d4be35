"""Programs of points: what moves, what stays."""

import numpy as np

from trueloop.machine.planar_field import QuadrupoleField
from trueloop.machine.point_program import displace_points
from trueloop.nc.edit import apply_edits
from trueloop.nc.program import read_program

FIELD = QuadrupoleField(1e-4, 0.0)


def _corrected(text: str) -> str:
    program = read_program(text.encode(), "linuxcnc")
    return apply_edits(program, displace_points(program, FIELD)).decode()


def test_a_point_on_the_x_axis_is_pulled_in_and_one_on_the_y_axis_pushed_out() -> None:
    assert _corrected("G90 G21\nX200. Y0.\nX0. Y200.\n") == "G90 G21\nX199.98000 Y0.\nX0. Y200.02000\n"


def test_a_coordinate_left_out_is_written_in_when_its_correction_changes() -> None:
    """At (100, 100) the field vanishes; at (50, 100) it does not."""
    assert (
        _corrected("G90\nG0 X100. Y100.\nX50. ( drill )\n") == "G90\nG0 X100. Y100.\nX50.00300 Y100.00600 ( drill )\n"
    )


def test_inches_and_coordinate_systems() -> None:
    assert (
        _corrected("G20\nG52 X1. Y0.\nG0 X4. Y0.\nG53 X1. Y0.\n") == "G20\nG52 X1. Y0.\nG0 X3.999600 Y0.\nG53 X1. Y0.\n"
    )


def test_quadrupole_is_what_it_says() -> None:
    at = np.array([[3.0, 4.0]])
    angle = np.arctan2(4.0, 3.0)
    expected = 2e-5 * np.cos(2 * (angle - 0.3)) * at
    np.testing.assert_allclose(QuadrupoleField(2e-5, 0.3).error_mm(at), expected, rtol=1e-14)
