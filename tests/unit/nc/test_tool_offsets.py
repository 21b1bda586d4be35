"""Offsets that tools bring along: T and D of a Sinumerik, TOOL CALL of Klartext, G43 of a LinuxCNC lathe."""

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import ToolPath

WORK = {1: (5.0, -3.0, -120.0)}
TURNING = CutterTool(0.8, 3, 1, offset_mm=(11.0, 33.0, 22.0), edge=1)
"""Lengths 1, 2, 3 are 11, 22 and 33 mm: X, Z and Y in G18."""
WORN = CutterTool(0.4, 3, 1, offset_mm=(10.5, 33.0, 22.0), edge=2)
MILL = CutterTool(5.0, None, 7, length_mm=90.0)


def run(text: str, dialect: str, *tools: CutterTool) -> ToolPath:
    return read_program(text.encode(), dialect).run(tools=tools, work_offsets_mm=WORK, strict=False)


def tool_offsets(path: ToolPath) -> Array:
    """What the tool adds, at each move."""
    offsets: Array = path.origin_mm - path.register_mm - WORK[1]
    return offsets


@pytest.mark.parametrize(
    ("plane", "turning", "milling"),
    [("G17", (22, 11, 33), (0, 0, 90)), ("G18", (11, 33, 22), (0, 90, 0)), ("G19", (33, 22, 11), (90, 0, 0))],
)
def test_the_plane_says_which_axes_the_lengths_of_sinumerik_go_to(
    plane: str, turning: tuple[float, ...], milling: tuple[float, ...]
) -> None:
    """As the tables of SD42940 have it (SINUMERIK 802D sl Function Manual 11/2012, page 432)."""
    path = run(f"G71 DIAMOF {plane}\nT1 D1\nG0 X1 Y2 Z3\nT7\nG0 X1 Y2 Z3\n", "siemens", TURNING, MILL)
    assert tool_offsets(path) == pytest.approx(np.array([turning, milling]))
    assert path.findings == ()


def test_an_edge_comes_with_its_tool_and_goes_with_d0() -> None:
    """D1 without a word for it, D2, D0, the other plane under the edge, and M6 for tools made ready."""
    text = (
        "G71 DIAMOF G18\nG0 X9\nT1\nG0 X9\nD2\nG0 X9\nD0\nG0 X9\nD1\nG17\nG0 X9\nM6 T7\nG0 X9\nT1\nG0 X9\nM6\nG0 X9\n"
    )
    path = run(text, "siemens", TURNING, WORN, MILL)
    edge, turned, none = (11, 33, 22), (22, 11, 33), (0, 0, 0)
    expected = [none, edge, (10.5, 33, 22), none, turned, (0, 0, 90), (0, 0, 90), turned]
    assert tool_offsets(path) == pytest.approx(np.array(expected))


def test_a_tool_that_is_not_told_of_adds_nothing_and_is_said() -> None:
    path = run('G71 G17\nT3\nG0 X9\nT="MILL 10" D1\nG0 X9\nT1 D3\nG0 X9\n', "siemens", TURNING)
    assert tool_offsets(path) == pytest.approx(np.zeros((3, 3)))
    assert [(found.code, found.place.line) for found in path.findings] == [(Code.NC_OPAQUE, line) for line in (2, 4, 6)]


def test_places_of_the_machine_are_those_of_the_tool_s_point_on_sinumerik() -> None:
    """G53 and SUPA leave the tool's offset in force (840D sl ISO Milling 04.07, page 3-42); D0 takes it away."""
    path = run("G71 DIAMOF G18\nT1 D1\nSUPA G0 X0 Z0\nSUPA D0 G0 X0 Z0\n", "siemens", TURNING)
    machine = path.end_mm + path.origin_mm
    assert machine[:, [0, 2]] == pytest.approx(np.array([[11, 22], [0, 0]]))


def test_the_radius_is_that_of_the_edge() -> None:
    """G42 along Z at radius 10: the nose's centre (tip 0) runs outside of that by its radius, under D0 on it."""
    nose = CutterTool(0.8, 0, 1, offset_mm=(0.0, 0.0, 0.0), edge=1)
    worn = CutterTool(0.4, 0, 1, offset_mm=(0.0, 0.0, 0.0), edge=2)
    text = "G71 DIAMOF G18 F1\nT1 {}\nG0 X20 Z10\nG1 G42 X10 Z5\nZ-20\nG40 X20\n"
    for edge, radius in (("", 0.8), ("D1", 0.8), ("D2", 0.4), ("D0", 0.0)):
        path = run(text.format(edge), "siemens", nose, worn)
        assert path.end_mm[2, 0] == pytest.approx(10 + radius)


def test_tool_call_adds_length_and_delta_along_its_axis() -> None:
    """L + DL (TNC 128 manual 5/2014, page 163); TOOL CALL 0 takes it away; M91 is the machine's own position."""
    text = (
        "BEGIN PGM A MM\nTOOL CALL 7 Z S100 DL+0,5\nL Z+10 F MAX\nL Z+0 F MAX M91\nTOOL CALL 7 Y DL-1\nL Z+10 F MAX\n"
    )
    path = run(f"{text}TOOL CALL 0 Z\nL Z+10 F MAX\nTOOL CALL 8 Z\nL Z+9 F MAX\n", "heidenhain", MILL)
    expected = [(0, 0, 90.5), (0, 0, 90.5), (0, 89, 0), (0, 0, 0), (0, 0, 0)]
    assert tool_offsets(path) == pytest.approx(np.array(expected))
    assert (path.end_mm + path.origin_mm)[1, 2] == pytest.approx(0)
    assert [(found.code, found.place.line) for found in path.findings] == [(Code.NC_OPAQUE, 9)]


@pytest.mark.parametrize(("delta", "radius"), [("", 5.0), (" DR+0,25", 5.25), (" DR-0,25", 4.75)])
def test_tool_call_adds_delta_to_the_radius(delta: str, radius: float) -> None:
    """Left of a line along X: the centre runs above it by R + DR (iTNC 530 manual 6/2010, page 183)."""
    text = f"BEGIN PGM A MM\nTOOL CALL 7 Z S100{delta}\nL X-20 Y-20 R0 F100\nL X+0 Y+0 RL\nL X+50\nL X+60 Y+20 R0\n"
    path = run(text, "heidenhain", MILL)
    assert path.end_mm[2, 1] == pytest.approx(radius)


def test_a_linuxcnc_lathe_adds_x_and_z_by_g43() -> None:
    tool = CutterTool(0.4, 2, 1, offset_mm=(-150.0, 0.0, -80.0))
    path = run("G21 G18 G8\nT1 M6 G43\nG0 X10 Z5\nG49\nG0 X10 Z5\n", "linuxcnc", tool)
    assert tool_offsets(path) == pytest.approx(np.array([(-150, 0, -80), (0, 0, 0)]))
