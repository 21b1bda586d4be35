"""Cycles, polar words and tool lengths of LinuxCNC: the moves its own interpreter makes."""

from pathlib import Path

import pytest

from tests.support.linuxcnc import Tool, interpret
from tests.support.nc_judge import assert_same_moves
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import read_program

LATHE, MILL = "G18 G21 G8 G40 G90 G94", "G17 G21 G40 G90 G94"
TURNS = "S100 M3 G0 X20 Z5\n"

THREADS = [
    "G76 P1.5 Z-20 I-2 J0.5 K1",
    "G76 P1.5 Z-20 I-2 J0.3 K1 Q29.5 H2 R1.5 E3 L2",
    "G76 P1.5 Z-20 I-2 J0.3 K1 Q29.5 H2 R2 E3 L3",
    "G76 P1.5 Z-20 I2 J0.4 K1 Q10 E2 L1",
    "G76 P1 Z30 I-2 J0.3 K1 Q29.5 E1 L3",
    "G7 G0 X20\nG76 P1.5 Z-20 I2 J0.5 K1 E3 L3 Q10",
    "G76 P1.5 Z-20 I-2 J0.25 K1 H3\nG0 X30",
]
DRILLED = [
    "G84 X2 Y1 Z-3 R1 F100\nX9\nG80",
    "G98 G84 X2 Y1 Z-3 R1 F100\nX9",
    "G85 X2 Y1 Z-3 R1 F100\nX9",
    "G91 G81 X2 Y1 Z-3 R-1 L3 F100",
]
POLAR = [
    "G0 @5 ^30\nG1 ^60 F100\n@8\nG3 X0 Y8 R8",
    "G0 X5 Y0\nG91 G1 @-.5 ^10 F100\n@1\n^[360/17]",
    "G0 X5 Y0\nG91 G81 ^60 R-1 Z-5 L6 F10",
    "G0 X2 Y3\nG81 R1 Z-5 F60\n^120\n@4 ^240",
]


def same(text: str, tmp_path: Path, startup: str, plane: int) -> None:
    file = tmp_path / "program.ngc"
    file.write_text(text + "\nM2\n")
    path = read_program(file.read_bytes(), "linuxcnc").run(inch=False, plane=plane)
    assert path.findings == ()
    assert_same_moves(path, interpret(file, startup=startup))


@pytest.mark.parametrize("text", THREADS)
def test_threads_in_passes(text: str, tmp_path: Path) -> None:
    same(TURNS + text, tmp_path, LATHE, 18)


@pytest.mark.parametrize("text", DRILLED)
def test_tapping_and_drilling(text: str, tmp_path: Path) -> None:
    same(TURNS + text, tmp_path, MILL, 17)


@pytest.mark.parametrize("text", ["G81 Y1 X2 Z3 R4 F100", "G83 Y-9 X2 Z3 R4 Q3 F100\nX5"])
def test_drilling_in_the_plane_of_a_lathe(text: str, tmp_path: Path) -> None:
    same(TURNS + text, tmp_path, LATHE, 18)


@pytest.mark.parametrize("text", POLAR)
def test_polar_words(text: str, tmp_path: Path) -> None:
    same(TURNS + text, tmp_path, MILL, 17)


def test_a_thread_in_step_has_its_lead_as_feed() -> None:
    path = read_program(b"G21 G18 S100 M3 F7\nG33 Z-5 K1.5\nG1 Z-6\nG76 P2 Z-9 I-1 J1 K1", "linuxcnc").run()
    thread = path.motion == 4
    assert path.feed[thread].tolist() == [1.5, 2.0]
    assert path.feed_mode[thread].tolist() == [95, 95]
    assert (path.feed[1], path.feed_mode[1]) == (7, 94)


def test_the_length_of_a_tool_is_added_along_z(tmp_path: Path) -> None:
    """The machine stands where it was: with a tool 50 mm long the program calls that place 50 mm lower."""
    text = "T2 M6\nG0 X1 Z10\nG43\nG0 X2\nG1 Z3 F100\nG49\nG0 X3\nG43 H2\nZ5\nM2\n"
    file = tmp_path / "program.ngc"
    file.write_text(text)
    judged = interpret(file, tools=[Tool(2, 0.5, 9, z_offset_mm=50.0)], startup=MILL)
    path = read_program(text.encode(), "linuxcnc").run(inch=False, plane=17, tools=[CutterTool(0.5, 9, 2, 50.0)])
    assert_same_moves(path, judged)
    assert path.start_mm[1, 2] == -40.0
