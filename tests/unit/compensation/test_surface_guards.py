"""What keeps a corrected surface program from being written where it would not cut what was meant."""

import pytest

from tests.support.surfaces import wavy_surface
from trueloop.compensation import surface_program
from trueloop.compensation.cutter import Cutter
from trueloop.compensation.surface_program import SurfaceJob, corrected_program
from trueloop.compensation.surface_zigzag import ZigzagOptions, zigzag
from trueloop.compensation.tool_axis import tool_axes
from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit import Edit, apply_edits
from trueloop.nc.program import Program, read_program

FLAT = wavy_surface(20.0, 0.0)
BALL = SurfaceJob(Cutter(3.0, 3.0))


def test_a_frame_that_the_path_does_not_follow_is_refused() -> None:
    turned = b"G21 G90 G94 G17\nG68 X0 Y0 R90\nG0 X2 Y10 Z5\nG1 Z0 F100\nX18\nG0 Z5\nM30\n"
    with pytest.raises(TrueloopError, match="G68") as told:
        corrected_program(read_program(turned, "fanuc-mill"), FLAT, FLAT, BALL, "0123456789abcdef")
    assert told.value.code is Code.NC_OPAQUE and told.value.place.line == 2


def test_the_read_back_of_an_inch_program_allows_two_steps_of_an_inch_program(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step is 0.0001 in there, 2.54 µm: an end that is 0.0010 in off is not what was intended."""

    def written_wrongly(program: Program, edits: list[Edit]) -> bytes:
        return apply_edits(program, edits).replace(b"Y0.4000", b"Y0.4010")

    monkeypatch.setattr(surface_program, "apply_edits", written_wrongly)
    inch = read_program(b"G20 G90 G94 G17\nG0 X0.1 Y0.4000 Z0.2\nG1 Z0 F4.\nX0.7\nG0 Z0.2\nM30\n", "fanuc-mill")
    with pytest.raises(TrueloopError, match=r"a move ends 25\.40 µm from") as told:
        corrected_program(inch, FLAT, FLAT, BALL, "0123456789abcdef")
    assert told.value.code is Code.CMP_READ_BACK


def test_a_name_is_no_rotary_word() -> None:
    program = read_program(b"G71 G90 G94 G17\nORIWKS\nG0 X1 Y2 Z5 A3=1 B3=0 C3=0\nM30\n", "siemens")
    found = tool_axes(program, program.run(), "CA", (0.0, 0.0, 1.0))
    assert not found.end.any()


def test_a_wide_plane_needs_few_points_and_is_not_refused_for_its_size() -> None:
    passes = zigzag(wavy_surface(200.0, 0.0), ZigzagOptions(3.0, scallop_mm=0.002, chord_mm=0.001))
    assert len(passes) == pytest.approx(200.0 / (8 * 3.0 * 0.002) ** 0.5, abs=2)
    assert max(map(len, passes)) <= 4


def test_too_many_points_are_refused_before_one_is_made() -> None:
    with pytest.raises(TrueloopError, match="passes of") as told:
        zigzag(wavy_surface(200.0, 4.0), ZigzagOptions(3.0, scallop_mm=1e-12, chord_mm=1e-9))
    assert told.value.code is Code.SRF_PATH
