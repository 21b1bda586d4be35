"""Turning cycles of LinuxCNC (G70 to G72.2): its own interpreter makes the same moves of them."""

import re
import tempfile
from pathlib import Path
from typing import Final

import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import ProgramRefusedError, interpret
from tests.support.nc_judge import TOLERANCE_MM, assert_same_moves
from trueloop.errors import Code, Severity
from trueloop.nc.check.check import check
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import ToolPath

STARTUP: Final = "G18 G21 G40 G90 G94"
ROUGHING: Final = ["G71", "G71.1", "G71.2", "G72", "G72.1", "G72.2"]
ARCS_THAT_PART: Final = """G20
F100
o100 sub
G0 X0 Z0
G3 X-.5 Z-.5 R4.5
G2 X0 Z-1 R4.5
G1 X.5 Z-1.5
G1 X1.001 Z-2
o100 endsub
G0 X6 Z2
G71 D.1 I.3 R.05 Q100
M2
"""
CONTOUR: Final = "G0 X2 Z0\nG1 X3 Z-5\nG1 X6 Z-6\nG1 X7 Z-9"


def places(low: float, high: float) -> st.SearchStrategy[float]:
    return st.integers(round(low * 1000), round(high * 1000)).map(lambda micrometres: micrometres / 1000)


@st.composite
def contours(draw: st.DrawFn) -> tuple[list[str], float]:
    """Lines that run towards lower Z, pockets among them, arcs of less than half a turn, and corners between lines;
    what they reach in X."""
    x, z, widest = draw(places(0, 6)), draw(places(-2, 2)), 0.0
    lines = [f"G0 X{x:.3f} Z{z:.3f}"]
    for _ in range(draw(st.integers(2, 5))):
        kind = draw(st.sampled_from(["line", "level", "wall", "arc"]))
        z -= 0.0 if kind == "wall" else draw(places(0.5, 4))
        x += 0.0 if kind == "level" else draw(places(0.5, 4)) * (-1 if kind != "wall" and draw(st.booleans()) else 1)
        if kind == "arc":
            lines.append(f"G{draw(st.sampled_from([2, 3]))} X{x:.3f} Z{z:.3f} R{draw(places(4.5, 20))}")
        else:
            lines.append(f"G1 X{x:.3f} Z{z:.3f}")
        widest = max(widest, x)
    return lines, widest


@st.composite
def programs(draw: st.DrawFn, *, beside_arcs: bool) -> str:
    """A cycle on such a contour; on one with arcs it leaves nothing unless `beside_arcs`."""
    lines, widest = draw(contours())
    leaves = beside_arcs or not any(line[:2] in ("G2", "G3") for line in lines)
    x, z = max(widest, 6.0) + draw(places(0, 5)), 2.0 + draw(places(0, 3))
    off, last = draw(st.sampled_from([0, 0.1, 0.3])) * leaves, draw(st.sampled_from([0, 0.1])) * leaves
    finishing = f"G70 D{off} E{last} P{draw(st.integers(1, 3))}"
    depth, lift = draw(places(0.3, 2)), draw(places(0.05, 0.6))
    roughing = f"{draw(st.sampled_from(ROUGHING))} D{off} I{depth} R{lift}"
    cycle = draw(st.sampled_from([finishing, roughing]))
    there = f" X{x:.3f} Z{z:.3f}" if draw(st.booleans()) else ""
    unit = draw(st.sampled_from(["G20", "G21", "G21 G7"]))
    blocks = [unit, "F100", "o100 sub", *lines, "o100 endsub", f"G0 X{x:.3f} Z{z:.3f}", f"{cycle} Q100{there}"]
    return "\n".join([*blocks, "G1 X30", "M2", ""])


def assert_as_linuxcnc(path: ToolPath, text: str, within_mm: float = TOLERANCE_MM) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.ngc")
        file.write_text(text)
        assert_same_moves(path, interpret(file, startup=STARTUP), within_mm=within_mm)


def run(text: str) -> ToolPath:
    return read_program(text.encode(), "linuxcnc").run(inch=False, plane=18)


def rounding_decides(text: str) -> bool:
    """Returns whether a tilt of 2e-6 of a line along an axis changes LinuxCNC's moves of a contour displaced by D or E.

    It compares the heights of such a line's ends without a tolerance, and leaves the line out where the last bit of the
    second is lower: whether it is follows from the order of its own arithmetic.
    """
    kinds = set()
    for off in (-2e-6, 2e-6):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "tilted.ngc")
            file.write_text(tilted(text, off))
            kinds.add(tuple(move.kind for move in interpret(file, startup=STARTUP)))
    return len(kinds) > 1 and re.search(r"[DE]0\.[1-9]", text) is not None


def tilted(text: str, off: float) -> str:
    """The program with the end of each line along X or Z moved across it."""
    lines, before = [], {"X": "", "Z": ""}
    for line in text.splitlines():
        words = dict(re.findall(r"([XZ])(-?[\d.]+)", line)) if line[:2] in ("G0", "G1") else {}
        same = [axis + value for axis, value in words.items() if before.get(axis) == value]
        pattern = "|".join(map(re.escape, same)) or "(?!)"
        lines.append(re.sub(pattern, lambda word: f"{word[0][0]}{float(word[0][1:]) + off:.6f}", line))
        before = words
    return "\n".join([*lines, ""])


SLOW: Final = [HealthCheck.too_slow, HealthCheck.filter_too_much]


@given(text=programs(beside_arcs=False))
@settings(max_examples=50, deadline=None, suppress_health_check=SLOW)
def test_linuxcnc_makes_the_same_moves(text: str) -> None:
    path = run(text)
    assume(not path.findings)
    try:
        assert_as_linuxcnc(path, text)
    except AssertionError:
        if not rounding_decides(text):
            raise


@given(text=programs(beside_arcs=True))
@settings(max_examples=50, deadline=None, suppress_health_check=SLOW)
@example(text=ARCS_THAT_PART)
def test_beside_arcs_that_touch_the_last_bit_becomes_nanometres(text: str) -> None:
    """Where a circle all but touches its neighbour, a root makes 1e-8 of the radius of the last bit.

    Circles that no longer meet are cut with ends off them: LinuxCNC refuses its own moves then, and the check does.
    """
    path = run(text)
    assume(not path.findings)
    try:
        assert_as_linuxcnc(path, text, within_mm=1e-5)
    except ProgramRefusedError as refused:
        assert "Radius to end of arc differs" in str(refused)
        program = read_program(f"G18\n{text}".encode(), "linuxcnc")
        assert Code.NC_ARC_FIT in [found.code for found in check(program)]


@pytest.mark.parametrize("cycle", ["G70", "G70 D.5 P3", *(f"{rough} D.3 I.7 R.2" for rough in ROUGHING)])
@pytest.mark.parametrize(
    "contour",
    [
        CONTOUR,
        "G0 X2 Z0\nG1 Z-4 A.5\nX5 C.4\nZ-8\nX8",
        "G0 X1 Z0\nG3 X3 Z-2 K-2\nG1 Z-4\nG2 X5 Z-6 I2\nG1 X6",
        "G0 X2 Z0\no101 repeat [3]\nG1 X[#<_x>*1.5+1] Z[#<_z>-2]\no101 endrepeat",
        "#1=2\nG0 X#1 Z0\nG1 W-5 U1\nX7 Z-9",
    ],
)
def test_cycles_on_contours_with_corners_loops_and_parameters(cycle: str, contour: str) -> None:
    text = f"G21\nF100\no100 sub\n{contour}\no100 endsub\nG0 X10 Z3\n{cycle} Q100\nM2\n"
    path = run(text)
    assert path.findings == ()
    assert_as_linuxcnc(path, text)


@pytest.mark.parametrize("cycle", ["G70", "G70 D.5 P2", *ROUGHING])
@pytest.mark.parametrize(
    ("modes", "contour"),
    [
        ("G7", "G0 X4 Z0\nG1 W-5 U2\nG3 X8 Z-6 I0 K-1\nG1 X10\nZ-9"),
        ("G7", "G0 X4 Z0\nG1 Z-3\nG2 X8 Z-5 I2 K0\nG1 X10 A.3\nZ-9"),
        ("G20", "G0 X.4 Z0\nG1 Z-.3\nG2 X.6 Z-.5 I.2 K0\nG1 X.8 C.04\nZ-.9"),
        ("G7 G90.1", "G0 X4 Z0\nG1 Z-3\nG3 X8 Z-5 I2 K-5\nG1 X10\nZ-9"),
        ("G90.1", "G0 X2 Z0\nG1 Z-3\nG2 X4 Z-5 I4 K-3\nG1 X5\nZ-9"),
        ("G91", "G0 X-18 Z-3\nG1 X1 Z-4\nX2 Z-1\nX3"),
    ],
)
def test_depth_and_lift_left_out_and_words_of_the_contour_under_other_modes(
    cycle: str, modes: str, contour: str
) -> None:
    text = f"G0 X20 Z3\n{modes}\nF100\no100 sub\n{contour}\no100 endsub\n{cycle} Q100\nM2\n"
    path = run(text)
    assert path.findings == ()
    assert_as_linuxcnc(path, text)


@pytest.mark.parametrize(
    ("line", "contour", "why"),
    [
        ("G71 Q100 I0", CONTOUR, "give I, the depth of cut"),
        ("G42.1 D.1 L2\nG71 Q100", CONTOUR, "it wants G40"),
        ("G17\nG71 Q100", CONTOUR, "it wants G18"),
        ("G71", CONTOUR, "it wants Q"),
        ("G71 Q7", CONTOUR, "the subroutine that Q names"),
        ("G71 Q100", "G0 X2 Z0\nG1 X3 Z-5\nG1 X4 Z-3\nZ-9", "turns back along its cuts"),
        ("G71 Q100 D1", "G0 X2 Z0\nG1 X3 Z-3\nG1 X4 Z-6\nX6 Z-6", "two of its lines lie in one"),
        ("G70 Q100", "G0 X2 Z0\nG3 X5 Z-5\nG1 Z-9", "an arc of its contour has no centre"),
        ("G70 Q100", "G0 X2 Z0\nG3 X5 Z-5 R1\nG1 Z-9", "wider than its diameter"),
        ("G70 Q100", "G0 X2 Z0\nG1 X3 Z-5 A1 C1\nX9", "both A and C"),
        ("G70 Q100", "G0 X2 Z0\nG1 X3 Z-5 U1\nX9", "an increment beside a position"),
    ],
)
def test_what_linuxcnc_refuses_is_said_and_not_in_the_path(line: str, contour: str, why: str) -> None:
    text = f"G21 G0 X10 Z3\nF100\no100 sub\n{contour}\no100 endsub\n{line}\nM2\n"
    (found,) = [one for one in run(text).findings if one.code is Code.NC_OPAQUE and "not in the path:" in one.message]
    assert why in found.message
    assert found.severity is Severity.WARNING
    with tempfile.TemporaryDirectory() as folder, pytest.raises(ProgramRefusedError):
        file = Path(folder, "case.ngc")
        file.write_text(text)
        interpret(file, startup=STARTUP)


def test_after_a_cycle_that_is_not_made_the_program_has_its_own_parameters_and_no_motion() -> None:
    contour = "G0 X2 Z0\nG1 X3 Z-5 A1 C1\nX9"
    text = f"G21 G0 X10 Z3\nF100\n#<depth>=2\no100 sub\n{contour}\no100 endsub\nG70 Q100\nG1 X#<depth>\nM2\n"
    path = run(text)
    assert [found.code for found in path.findings] == [Code.NC_OPAQUE]
    assert path.end_mm[-1, 0] == 2.0
    assert len(run(text.replace("G1 X#<depth>", "X20"))) < len(path)


def test_after_a_cycle_its_last_motion_is_in_force() -> None:
    contour = "G0 X2 Z0\nG1 Z-4\nG2 X4 Z-6 I2"
    text = f"G21 G0 X10 Z3\nF100\no100 sub\n{contour}\no100 endsub\nG70 Q100\nX6 Z-8 I2\nM2\n"
    path = run(text)
    assert path.findings == ()
    assert_as_linuxcnc(path, text)


def test_moves_of_the_finishing_cycle_are_those_of_the_contours_blocks() -> None:
    text = f"G21 G0 X10 Z3\nF100\no100 sub\n{CONTOUR}\no100 endsub\nG70 Q100\nM2\n"
    assert run(text).line.tolist() == [1, 4, 5, 6, 7]
    off = run(text.replace("G70 Q100", "G70 Q100 E.1")).line.tolist()
    assert off == [1, 9, 9, 9, 9, 9]


def test_without_its_roughing_the_tool_stands_where_that_ends() -> None:
    text = f"G21 G0 X10 Z3\nF100\no100 sub\n{CONTOUR}\no100 endsub\nG71 Q100 I2\nG1 X20\nM2\n"
    roughed = run(text)
    (*_, last) = roughed.end_mm
    path = read_program(text.encode(), "linuxcnc").run(inch=False, plane=18, roughing=False)
    assert path.line.tolist() == [1, 10]
    assert path.end_mm[-1].tolist() == last.tolist()
    assert [found.code for found in path.findings] == [Code.NC_OPAQUE]
