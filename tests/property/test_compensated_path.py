"""Cutter compensation: LinuxCNC's own interpreter drives the controlled point along the same path.

Where LinuxCNC refuses a program, so does trueloop. It refuses more: a line cut back beyond its beginning before an arc,
which LinuxCNC drives backwards.
"""

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import LATHE_STARTUP, Move, ProgramRefusedError, Tool, interpret
from tests.support.nc_judge import assert_same_moves
from trueloop.errors import Code, Severity
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import ToolPath

MILL_STARTUP = "G17 G21 G40 G90 G94"
REFUSALS = {Code.NC_GOUGE, Code.NC_ENTRY}


@dataclass(frozen=True)
class Case:
    text: str
    plane: int
    radius_mm: float
    tip: int


@st.composite
def cases(draw: st.DrawFn) -> Case:
    plane = draw(st.sampled_from([17, 18]))
    first, second, third = ("Z", "X", "Y") if plane == 18 else ("X", "Y", "Z")
    steps = st.floats(-20, 20).map(lambda value: round(value, 3))
    here, blocks = (0.0, 0.0), ["F100 S100 M3 T1 M6", draw(st.sampled_from(["G41", "G42", "G41 D1", "G42 D1"]))]
    for k in range(draw(st.integers(2, 6))):
        there = (round(here[0] + draw(steps), 3), round(here[1] + draw(steps), 3))
        ends = f"{first}{there[0]:.3f} {second}{there[1]:.3f}"
        chord = math.dist(here, there)
        if k and chord > 0.5 and draw(st.booleans()):
            radius = round(chord * draw(st.floats(0.51, 2)), 3) * draw(st.sampled_from([1, 1, -1]))
            blocks.append(f"{draw(st.sampled_from(['G2', 'G3']))} {ends} R{radius:.3f}")
        else:
            blocks.append(f"{draw(st.sampled_from(['G1', 'G1', 'G0']))} {ends}")
        if draw(st.integers(0, 9)) == 0:
            blocks.append(f"G1 {third}{k + 1}")
        here = there
    text = "\n".join([*blocks, "G40", f"G1 {first}90 {second}90", "M2", ""])
    tip = draw(st.integers(0, 9)) if plane == 18 else 0
    return Case(text, plane, round(draw(st.floats(0.2, 3)), 3), tip)


def judged(case: Case) -> tuple[ToolPath, list[Move] | ProgramRefusedError]:
    startup = LATHE_STARTUP if case.plane == 18 else MILL_STARTUP
    tools = [CutterTool(case.radius_mm, case.tip)]
    program = read_program(case.text.encode(), "linuxcnc")
    path = program.run(inch=False, diameter=False, plane=case.plane, strict=False, tools=tools)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.ngc")
        file.write_text(case.text)
        try:
            return path, interpret(file, tools=[Tool(1, case.radius_mm, case.tip)], startup=startup)
        except ProgramRefusedError as refused:
            return path, refused


@given(case=cases())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_the_controlled_point_takes_linuxcncs_path(case: Case) -> None:
    path, moves = judged(case)
    refusals = {found.code for found in path.findings if found.severity == Severity.ERROR}
    if isinstance(moves, ProgramRefusedError):
        assert refusals & REFUSALS, f"{moves}\n{case.text}"
    else:
        assert refusals <= {Code.NC_GOUGE}
        assert_same_moves(path, moves)


ENTRY_BY_ARC = "F100 T1 M6\nG0 Z0 X0\nG42\nG2 Z5 X5 I5\nG1 X15\nG3 Z0 X20 R5\nG40\nG1 Z90 X90\nM2\n"


@pytest.mark.parametrize("tip", [0, 9])
@pytest.mark.parametrize("side", ["G41", "G42"])
def test_an_arc_may_lead_in(side: str, tip: int) -> None:
    """Not judged with other tips: LinuxCNC 2.9 then takes the arc's end for its start and turns a full circle."""
    path, moves = judged(Case(ENTRY_BY_ARC.replace("G42", side), 18, 0.8, tip))
    assert not isinstance(moves, ProgramRefusedError)
    assert_same_moves(path, moves)


GIVEN = "G21 F100\nG18 G42.1 D1.6 L2\nG1 X5 Z-3\nZ-20\nG2 X10 Z-25 R5\nG1 X20\nZ-30\nG40\nG1 X40\nM2\n"


def test_the_program_may_give_diameter_and_tip_itself() -> None:
    path, moves = judged(Case(GIVEN, 18, 3.0, 7))
    assert not isinstance(moves, ProgramRefusedError)
    assert_same_moves(path, moves)


# Convex corners under 0.05 rad get no arc about them, so that a move by an arc inside becomes longer than programmed:
# LinuxCNC bears 0.0254 rad in a program in mm, 0.001 rad in inch.
LONGER = """F100 T1 M6
G42
G1 X{line:.6f} Y0
G2 X{end[0]:.6f} Y{end[1]:.6f} I{arm[0]:.6f} J{arm[1]:.6f}
G40
G1 X{line:.6f} Y-{line:.6f}
M2
"""


@pytest.mark.parametrize(("scale", "turn_rad", "refused"), [
    (1.0, 0.0211, False), (1.0, 0.0213, True), (25.4, 0.00082, False), (25.4, 0.00085, True)
])  # fmt: skip
def test_an_arc_grows_by_as_much_as_linuxcnc_bears(scale: float, turn_rad: float, refused: bool) -> None:
    """A tool of radius 1.5 mm inside an arc of 2.75 mm: the arc's centre path grows by 1.2 times the corner's turn."""
    centre = (10 + 2.75 * math.sin(turn_rad), -2.75 * math.cos(turn_rad))
    ends_at = math.pi / 2 + turn_rad - math.pi / 3
    end = (centre[0] + 2.75 * math.cos(ends_at), centre[1] + 2.75 * math.sin(ends_at))
    lengths = {"line": 10.0, "end": end, "arm": (centre[0] - 10, centre[1])}
    program = LONGER.format(**{k: np.asarray(v) / scale for k, v in lengths.items()})
    path, moves = judged(Case(("G20\n" if scale > 1 else "G21\n") + program, 17, 1.5, 0))
    assert isinstance(moves, ProgramRefusedError) == refused
    assert {found.code for found in path.findings} == ({Code.NC_GOUGE} if refused else set())


@pytest.mark.parametrize("scale", [1.0, 25.4])
@pytest.mark.parametrize(("corner_rad", "refused"), [(0.0, False), (0.01, False), (0.06, True)])
def test_an_arc_is_not_bounded_where_a_line_goes_on_without_a_corner(
    scale: float, corner_rad: float, refused: bool
) -> None:
    """As above, the arc 0.036 rad longer: LinuxCNC compares it before an outside corner, not before a tangent line."""
    centre = (10 + 2.75 * math.sin(0.03), -2.75 * math.cos(0.03))
    ends_at = math.pi / 2 + 0.03 - math.pi / 3
    end = (centre[0] + 2.75 * math.cos(ends_at), centre[1] + 2.75 * math.sin(ends_at))
    lengths = {"line": 10.0, "end": end, "arm": (centre[0] - 10, centre[1])}
    way = ends_at - math.pi / 2 + corner_rad  # the tool is on the right: an outside corner turns left
    on = [f"G1 X{(end[0] + 8 * math.cos(way)) / scale:.6f} Y{(end[1] + 8 * math.sin(way)) / scale:.6f}", "G40"]
    program = LONGER.format(**{k: np.asarray(v) / scale for k, v in lengths.items()}).replace("G40", "\n".join(on))
    text = ("G20\n" if scale > 1 else "G21\n") + program
    path, moves = judged(Case(text, 17, 1.5, 0))
    assert {found.code for found in path.findings} == ({Code.NC_GOUGE} if refused else set())
    assert isinstance(moves, ProgramRefusedError) == refused
    if not isinstance(moves, ProgramRefusedError):
        assert_same_moves(path, moves)
    fanuc = "G17 G90 " + text.replace("F100 T1 M6", "F100. T1 M6 D1").replace("G42\n", "G42 ")
    siemens = fanuc.replace("G20\n", "G70\n").replace("G21\n", "G71\n")
    for dialect, other in (("fanuc-mill", fanuc), ("siemens", siemens)):
        driven = read_program(other.encode(), dialect).run(strict=False, tools=[CutterTool(1.5, 0)])
        assert not [found for found in driven.findings if found.severity == Severity.ERROR], "a rule of LinuxCNC alone"


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-mill", "siemens"])
def test_an_arc_cut_back_beyond_its_beginning_is_refused_on_every_control(dialect: str) -> None:
    """A tool of radius 3 mm inside an arc of 10 mm by 0.05 rad, then a corner to its side: the way to there is 3 mm."""
    ends = f"X{10 + 10 * math.sin(0.05):.6f} Y{10 * math.cos(0.05) - 10:.6f}"
    unit = "G71" if dialect == "siemens" else "G21"
    text = f"{unit} G17 G90 F100. T1 M6 D1\nG42 G1 X10. Y0\nG2 {ends} I0 J-10.\nG1 Y-40.\nG40 G1 X-90.\nM2\n"
    text = text.replace(" D1", "" if dialect == "linuxcnc" else " D1")
    path = read_program(text.encode(), dialect).run(strict=False, tools=[CutterTool(3.0, 0)])
    assert Code.NC_GOUGE in {found.code for found in path.findings}
