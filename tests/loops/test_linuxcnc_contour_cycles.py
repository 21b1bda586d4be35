"""A contour of LinuxCNC that G70 finishes, and G71 may rough: corrected where that is safe. LinuxCNC judges."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.test_contour_under_g42 import touches_on
from tests.support.correction import NOW
from tests.support.linuxcnc import interpret
from trueloop.domain.part import PartType
from trueloop.errors import Code, TrueloopError
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import read_program
from trueloop.turned.options import Options

NOSE_MM = 0.4
ROUGHING = "G71 Q100 D0.5 I1 R0.3\n"
PROGRAM = (
    "G21 G90 G18 G8 G40 G61 F100\nO100 sub\n{first}\nG1 Z-20\nX8 Z-30\nG1 X10\nO100 endsub\n"
    "G0 X12 Z2\n{roughing}G0 X12 Z1\nG70 Q100\nG40\nM2\n"
)
"""G71 comes to the contour at Z2, G70 at Z1."""


def corrected(first: str, roughing: str, slope: float) -> Correction:
    """By errors that a tool offset takes out but for `slope` along Z."""
    program = read_program(PROGRAM.format(first=first, roughing=roughing).encode(), "linuxcnc")
    profile = contour_of_program(feed_moves(program.run(roughing=False)), NOSE_MM).profile
    touches = touches_on(profile)
    error_mm = 0.02 + slope * touches.nominal_mm[:, 1]
    return compensate(
        Inputs(PartType("part"), profile, NOSE_MM, program, replace(touches, error_mm=error_mm), Options(tool=1), NOW)
    )


@pytest.mark.parametrize("first", ["G0 X5", "G1 X5"])
def test_the_place_from_which_finishing_begins_is_not_written_where_roughing_reads_it(first: str) -> None:
    with pytest.raises(TrueloopError, match="Z is displaced on the contour before it names Z") as refused:
        corrected(first, ROUGHING, 8e-4)
    assert (refused.value.code, refused.value.place.line) == (Code.NC_EDIT, 3)
    assert b"Z1.00000" in corrected(first, "", 8e-4).corrected_program


@pytest.mark.parametrize(("first", "roughing"), [("G0 X5 Z2", ROUGHING), ("G0 X5 Z2", ""), ("G0 X5", "")])
def test_a_contour_that_says_where_it_begins_is_corrected(first: str, roughing: str, tmp_path: Path) -> None:
    correction = corrected(first, roughing, 8e-4)
    file = tmp_path / "corrected.ngc"
    file.write_bytes(correction.corrected_program)
    cuts = [move for move in interpret(file) if move.kind != "rapid"]
    own = read_program(correction.corrected_program, "linuxcnc").run()
    finish_mm = own.end_mm[own.line > 0][-3:]
    assert np.allclose([move.end_mm for move in cuts[-3:]], finish_mm, atol=1e-5)
    assert not np.allclose(finish_mm[0], [5.0, 0.0, -20.0], atol=1e-3)


@pytest.mark.parametrize("first", ["G0 X5 Z2", "G0 X5"])
def test_an_offset_is_put_around_the_cycle_and_not_into_its_contour(first: str, tmp_path: Path) -> None:
    offsets = corrected(first, ROUGHING, 0.0).offsets_program
    assert offsets is not None
    lines = offsets.decode().splitlines()
    assert not [line for line in lines[lines.index("O100 sub") : lines.index("O100 endsub")] if "G52" in line]
    assert lines[lines.index("G70 Q100") + 1].startswith("G52 X0.00000 Z0.00000")
    file = tmp_path / "offsets.ngc"
    file.write_bytes(offsets)
    shifted = [move.machine_mm for move in interpret(file) if move.kind != "rapid"][-3:]
    file.write_text(PROGRAM.format(first=first, roughing=ROUGHING))
    plain = [move.machine_mm for move in interpret(file) if move.kind != "rapid"][-3:]
    away_mm = np.array(shifted) - np.array(plain)
    assert np.allclose(away_mm, away_mm[0], atol=1e-5)
    assert away_mm[0, 0] < -0.005
