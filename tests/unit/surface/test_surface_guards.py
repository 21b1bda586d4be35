"""What keeps a corrected surface program from being written where it would not cut what was meant."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.surfaces import wavy_surface
from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.program.program import Program, read_program
from trueloop.surface.compensation import program as surface_program
from trueloop.surface.compensation.cutter import Cutter, tool_axes
from trueloop.surface.compensation.program import corrected_program
from trueloop.surface.compensation.shift import SurfaceJob
from trueloop_lab.simulator.zigzag import ZigzagOptions, zigzag

FLAT = wavy_surface(20.0, 0.0)
BALL = SurfaceJob(Cutter(3.0, 3.0))


def test_a_frame_that_the_path_does_not_follow_is_refused() -> None:
    turned = b"G21 G90 G94 G17\nG68 X10. Y10. R90.\nG0 X2. Y10. Z5.\nG1 Z0. F100.\nX18.\nG0 Z5.\nM30\n"
    with pytest.raises(TrueloopError, match="coordinates are turned") as told:
        corrected_program(read_program(turned, "fanuc-mill"), FLAT, FLAT, BALL, "0123456789abcdef")
    assert told.value.code is Code.NC_MAP and told.value.place.line == 4


def test_the_read_back_of_an_inch_program_allows_two_steps_of_an_inch_program(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step is 0.0001 in there, 2.54 µm: an end that is 0.0003 in off is not what was intended."""

    def written_wrongly(program: Program, edits: list[Edit]) -> bytes:
        return apply_edits(program, edits).replace(b"Y0.4000", b"Y0.4003")

    monkeypatch.setattr(surface_program, "apply_edits", written_wrongly)
    inch = read_program(b"G20 G90 G94 G17\nG0 X0.1 Y0.4000 Z0.2\nG1 Z0 F4.\nX0.7\nG0 Z0.2\nM30\n", "fanuc-mill")
    with pytest.raises(TrueloopError, match=r"of the written program ends 7\.62 µm from") as told:
        corrected_program(inch, FLAT, FLAT, BALL, "0123456789abcdef")
    assert told.value.code is Code.CMP_READ_BACK


def test_no_block_is_put_before_one_that_switches() -> None:
    """Chords of a pass onto waves of 20 µm need blocks between: before coolant is switched on, they would cut dry."""
    source = "G21 G90 G94 G17\nG0 X2. Y10. Z5.\nG1 Z0. F100.\nX18.{switch}\nG0 Z5.\nM30\n"
    waves = wavy_surface(20.0, 0.02)
    plain, wet = (read_program(source.format(switch=word).encode(), "fanuc-mill") for word in ("", " M8"))
    assert corrected_program(plain, FLAT, waves, BALL, "0123456789abcdef").new_blocks > 0
    with pytest.raises(TrueloopError, match="which also switches or is the first") as told:
        corrected_program(wet, FLAT, waves, BALL, "0123456789abcdef")
    assert told.value.code is Code.SRF_PROGRAM and told.value.place.line == 4


RAISED = replace(FLAT, control_mm=FLAT.control_mm + np.array([0.0, 0.0, 0.1]))
"""The corrected surface stands 0.1 mm higher everywhere."""

PASS = "G21 G90 G94 G17\n{before}\nG0 X2. Y10. Z5.\nG1 Z0. F100.\nX18.\nG0 Z5.\n{after}\nM30\n"


def _raised(before: str = "", after: str = "") -> bytes:
    program = read_program(PASS.format(before=before, after=after).encode(), "fanuc-mill")
    return corrected_program(program, FLAT, RAISED, BALL, "0123456789abcdef").source


@pytest.mark.parametrize(
    ("after", "what"),
    [
        ("G0 Z0.06\nG0 X2.\nG0 Z5.", "a rapid move would cut 40.0 µm into"),
        ("G1 Z0.06\nG1 X2.\nG0 Z5.", "the cutter would cut 40.0 µm into"),
        ("G18 G3 X2. Z5. I-8. K4.0077 F99.\nG17", r"the cutter would cut (3[6-9]|40)\.\d µm into"),
    ],
)
def test_what_does_not_cut_may_not_cut_the_corrected_surface(after: str, what: str) -> None:
    """Clear of the nominal surface by 0.06 mm and more than a pass, it stays where it is; an arc swings through."""
    with pytest.raises(TrueloopError, match=what) as told:
        _raised(after=after)
    assert told.value.code is Code.SRF_GOUGE


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("G0 X5. Y5.", ""),  # z has no position yet: where a run takes it to be is inside the surface
        ("G28 G91 Z0.\nG90 G0 X5. Y5.", ""),  # z is at home
        ("T2 M6\nG0 X5. Y5. Z0.05\nG0 Z9.\nT1 M6", ""),  # another tool
        ("", "G0 Z0.12\nX2.\nZ5."),  # clear of the corrected surface too
        ("", "G0 X-9.\nZ-2.\nX-12.\nZ5."),  # beside the patch
        ("", "G0 X-9.\nZ-20.\nX9.\nX-9.\nZ5."),  # under it: another side of the part
    ],
)
def test_only_moves_that_are_known_to_come_too_near_are_refused(before: str, after: str) -> None:
    assert b"Z0.1" in _raised(before, after)


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


SLOPE = replace(FLAT, control_mm=FLAT.control_mm + FLAT.control_mm[..., :1] * np.array([0.0, 0.0, 0.75]))
"""A plane that rises by 3 in 4: a tip is at R (1/0.8 − 1) = R/4 above the plane's height under it."""
HIGHER = replace(SLOPE, control_mm=SLOPE.control_mm + 0.02 * np.array([-0.6, 0.0, 0.8]))
TWO_TOOLS = (
    "G21 G90 G94 G17\nT1 M6\nG0 X4. Y6. Z20.\nG1 Z3.75 F100.\nX8. Z6.75\nG0 Z20.\n"
    "T2 M6\nG0 X4. Y12.\nG1 Z3.5\nX8. Z6.5\nG0 Z20.\nM30\n"
)


def _cut_by(job: SurfaceJob) -> list[str]:
    program = read_program(TWO_TOOLS.encode(), "fanuc-mill")
    written = corrected_program(program, SLOPE, HIGHER, job, "0123456789abcdef").source.decode()
    return [line for line in written.splitlines() if line.startswith(("G1", "X7.", "X8."))]


def test_each_tool_is_moved_by_its_own_cutter_and_tools_that_are_not_stated_stay() -> None:
    """By hand: balls of 3 and 2 mm touch the slope with tips 0.75 and 0.5 mm above it; 20 µm more along the normal are
    (−12, 0, 16) µm for both.
    """
    first, second = replace(BALL, tool=1), SurfaceJob(Cutter(2.0, 2.0), tool=2)
    moved = [["G1 X3.988 Z3.766 F100.", "X7.988 Z6.766"], ["G1 X3.988 Z3.516", "X7.988 Z6.516"]]
    stays = [["G1 Z3.75 F100.", "X8. Z6.75"], ["G1 Z3.5", "X8. Z6.5"]]
    assert _cut_by(replace(first, further=(second,))) == moved[0] + moved[1]
    assert _cut_by(first) == moved[0] + stays[1]
    assert _cut_by(second) == stays[0] + moved[1]


def test_a_tool_that_no_cutter_is_stated_for_and_one_that_is_not_called_are_refused() -> None:
    level = (
        TWO_TOOLS.replace("X8. Z6.75", "X8. Z3.75").replace("Z6.5", "Z3.5").replace("Z3.75", "Z0").replace("Z3.5", "Z0")
    )
    with pytest.raises(TrueloopError, match=r"2 tools .* within 3 mm of it, T1, T2, and the job states one") as told:
        corrected_program(read_program(level.encode(), "fanuc-mill"), FLAT, FLAT, BALL, "0123456789abcdef")
    assert told.value.code is Code.SRF_PROGRAM and told.value.place.line == 9
    with pytest.raises(TrueloopError, match=r"2 tools .* within 3 mm of it, T1, T2, and the job states one"):
        _cut_by(BALL)  # the ball of 2 mm would cut 0.2 mm deep with 3 mm: taken for one that passes by
    with pytest.raises(TrueloopError, match="0 moves of tool T7; its tools: T1, T2"):
        _cut_by(replace(BALL, tool=7))
