"""Where the shift of the tool-offset variant is written."""

from trueloop.compensation.offsets import offset_edits
from trueloop.nc.edit import apply_edits
from trueloop.nc.program import read_program

CYCLE = b"G21 G00 X90. Z5.\nG71 U1. R1.\nG71 P10 Q20 U0.5 W0.2 F0.2\nN10 G00 X20.\nN20 G01 Z-30. F0.1\n%sM30\n"


def test_the_finishing_cycle_is_shifted_whatever_else_stands_in_its_block() -> None:
    """The contour's own blocks stand before it: a shift there would not hold while G70 runs them."""
    program = read_program(CYCLE % b"G70 P10 Q20 ?\n", "fanuc-lathe")
    path = program.run()
    contour = [k for k in range(len(path)) if program.block(int(path.block[k])).number == 20]
    edits = offset_edits(program, path, (contour[-1], contour[-1]), (0.01, 0.0), 1, None)
    written = apply_edits(program, edits)
    assert b"G52 X0.020 Z0.000\nG70 P10 Q20 ?\nG52 X0. Z0.\n" in written
