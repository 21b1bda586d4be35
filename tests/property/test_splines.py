"""Splines of LinuxCNC (G5, G5.1, G5.2): its own interpreter hands on the same chords."""

import tempfile
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import interpret
from tests.support.nc_judge import assert_same_moves
from tests.support.splines import splines
from trueloop.nc.program.program import read_program


@given(splines, st.sampled_from(["G20", "G21"]), st.sampled_from(["G90", "G91"]))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_linuxcnc_makes_the_same_moves(drawn: list[list[str]], unit: str, mode: str) -> None:
    blocks = [f"G17 {unit} {mode} F100", "G0 X1 Y2 Z3", *(block for spline in drawn for block in spline)]
    text = "\n".join([*blocks, "G1 X1 Y1", "M2", ""])
    path = read_program(text.encode(), "linuxcnc").run(inch=False)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.ngc")
        file.write_text(text)
        assert_same_moves(path, interpret(file, startup="G17 G21 G40 G90 G94"))
    assert path.findings == ()
