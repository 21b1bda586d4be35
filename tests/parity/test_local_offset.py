"""LinuxCNC's G52 and G92 against its own interpreter: what positions are called, the tool staying where it is."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import interpret
from trueloop.nc.program.program import read_program

PROGRAMS = {
    "offset, one axis moved, taken back": "G52 X0.1 Z0.2\nG0 Z0.5\nG52 X0 Z0\nG0 Z0.6\nG0 X2\n",
    "one axis alone": "G52 Z0.2\nG0 X0.5\nG0 Z0.5\nG52 Z0\nG0 X0.6\n",
    "offset twice: the second stands": "G52 X0.1\nG0 Z2\nG52 X0.3\nG0 Z3\nG0 X1\n",
    "position register": "G92 X0.1 Z0.2\nG0 Z0.5\nG0 X0.7\n",
    "offset over the position register": "G92 X0.1 Z0.2\nG0 X0.5\nG52 X0.3\nG0 Z0.4\nG0 X1\n",
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_positions_after_an_offset(name: str, tmp_path: Path) -> None:
    program = tmp_path / "offset.ngc"
    program.write_text(f"G18 G20 G7 G90\nG0 X1 Z1\n{PROGRAMS[name]}M2\n")
    judged = interpret(program)
    path = read_program(program.read_bytes(), "linuxcnc").run()
    assert np.allclose(path.start_mm, [move.start_mm for move in judged], rtol=0, atol=1e-9)
    assert np.allclose(path.end_mm, [move.end_mm for move in judged], rtol=0, atol=1e-9)
