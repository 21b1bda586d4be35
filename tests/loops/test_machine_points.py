"""A corrected drilling program is read again before it is written."""

from pathlib import Path

import pytest

from tests.support.refusals import refused
from trueloop.errors import Code
from trueloop.jobs.machine.mapped_program import write_corrected_points
from trueloop.loops.machine import program as machine_points
from trueloop.machine.standards import QuadrupoleField
from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.program.program import Program, read_program

HOLES = b"G21 G90\nG81 X100. Y0. Z-5. R2. F100\nX0. Y200.\nG80\nM30\n"


def test_a_point_that_is_not_where_it_was_to_be_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program, field = read_program(HOLES, "fanuc-mill"), QuadrupoleField(1e-4, 0.0)
    good = write_corrected_points(program, tmp_path / "good.nc", field, {})
    assert good.points == 2 and b"X99.990 " in (tmp_path / "good.nc").read_bytes()

    def wrong_sign(program: Program, edits: list[Edit]) -> bytes:
        return apply_edits(program, edits).replace(b"X99.990", b"X100.010")

    monkeypatch.setattr(machine_points, "apply_edits", wrong_sign)
    refusal = refused(write_corrected_points, program, tmp_path / "bad.nc", field, {})
    assert refusal.code is Code.CMP_READ_BACK and "20.00 µm" in refusal.message
    assert not (tmp_path / "bad.nc").exists()


@pytest.mark.parametrize("word", ["X500", "X50000"])
def test_a_number_without_a_point_is_not_taken_for_millimetres(tmp_path: Path, word: str) -> None:
    """3401#0 decides whether X500 is 500 mm or 0.5 mm: written with a point it would move the hole."""
    program = read_program(HOLES.replace(b"X100.", word.encode()), "fanuc-mill")
    refusal = refused(write_corrected_points, program, tmp_path / "out.nc", QuadrupoleField(1e-6, 0.0), {})
    assert refusal.code is Code.NC_PARAMETER and "3401#0" in refusal.message
    assert not (tmp_path / "out.nc").exists()
