"""nc check and nc path of a program run in parts: what goes on from part to part, and what only the whole one tells."""

import tomllib
from pathlib import Path

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.check.check import check, check_in_parts
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.parts import stretches
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import csv_text

PROGRAMS = Path(__file__).parents[2] / "programs"
IN_PARTS = (
    *("haas-mill", "linuxcnc-diameter", "linuxcnc-expressions", "linuxcnc-frames", "linuxcnc-planes"),
    *("linuxcnc-splines", "metric-increments", "position-register"),
)
LATHE = "G21 G18 G8 G90 F100\n"
TANGENT = f"{LATHE}G0 X9.5 Z-10\nG1 X10 Z0\nM8\nG2 X5 Z5 I-5 K0\n"
BRIDGED = f"{LATHE}G0 X20 Z5\nG1 X10 Z0\nG1 Z-10\nG0 Z-20\nG1 Z-30\nG0 X30\nG0 Z5\n"
HOMED = "G21 G18 G8 G90 F100\nG0 X20 Z5\nG1 X10 Z0\nG1 Z-10\nG28 Z0\nG1 Z-30\nG0 X30\nG0 Z5\n"


def compare(source: str, code: Code, size: int = 1, dialect: str = "linuxcnc") -> list[int | None]:
    """The lines of the findings of that code, which parts have as the whole has them."""
    checked = check_in_parts(source.encode(), dialect, "part.nc", None, {}, size=size)
    assert checked is not None
    assert checked.findings == check(read_program(source.encode(), dialect, "part.nc"))
    return [found.place.line for found in checked.findings if found.code is code]


@pytest.mark.parametrize("size", [1, 40])
@pytest.mark.parametrize("name", IN_PARTS)
def test_the_findings_of_parts_are_those_of_the_whole(name: str, size: int) -> None:
    case = tomllib.loads((PROGRAMS / name / "case.toml").read_text())
    source = next((PROGRAMS / name).glob("program.*")).read_bytes()
    parameters = case.get("parameters", {})
    program = read_program(source, case["dialect"], "part.nc")
    checked = check_in_parts(source, case["dialect"], "part.nc", None, parameters, size=size)
    assert checked is not None
    assert (checked.findings, checked.block_count) == (check(program, parameters), program.block_count)
    rows = [
        row for of in stretches(source, case["dialect"], None, None, parameters, size=size) for row in csv_text(of.path)
    ]
    assert "".join(rows) == "".join(csv_text(program.run(parameters)))


@pytest.mark.parametrize("size", [1, 20, 50])
def test_a_joint_between_two_parts(size: int) -> None:
    assert compare(TANGENT, Code.NC_TANGENT, size) == [5]


@pytest.mark.parametrize("size", [1, 20, 50, 70])
def test_a_rapid_move_is_judged_by_cuts_of_other_parts(size: int) -> None:
    assert compare(BRIDGED, Code.NC_RAPID, size) == [5]
    assert compare(BRIDGED + "T2 M6\n" + BRIDGED, Code.NC_RAPID, size) == [5, 14]
    assert compare(HOMED, Code.NC_RAPID, size) == []


def test_a_run_that_milled_in_an_earlier_part_is_not_judged() -> None:
    milled = BRIDGED.replace("G1 X10 Z0\n", "G1 X10 Y1 Z0\nG1 Y0\n")
    assert compare(milled, Code.NC_RAPID) == []
    assert compare(f"{milled}G0 X20 Y1\nT2 M6\n{BRIDGED}", Code.NC_RAPID) == [16]


def test_the_first_cut_without_feed_counts_those_of_all_parts() -> None:
    source = "G21 G18\nG0 X1.\nG1 X2.\nG1 X3.\nF100.\nG1 X4.\n"
    assert compare(source, Code.NC_FEED, dialect="fanuc-lathe") == [3]


@pytest.mark.parametrize(
    ("modes", "line"), [("", 4), ("G64\n", 2), ("G61\nG64\n", 3), ("G64\nG61\n", None), ("G64 P0.1\n", None)]
)
def test_the_path_mode_of_an_earlier_part(modes: str, line: int | None) -> None:
    found = compare(f"G21 F100\n{modes}M8\nG0 X1\nG1 X2\nG64\nG1 X3\n", Code.NC_BLEND)
    assert found == ([] if line is None else [line])


def test_decimals_are_those_of_the_whole_program() -> None:
    """0.7 µm off its circle: not explained where the last line has four decimals."""
    arc = "G21 G17 G90 F100.\nG0 X7.07 Y7.071\nG2 X10. Y0. I-7.07 J-7.071\n"
    assert compare(arc, Code.NC_ARC_FIT, dialect="fanuc-mill") == []
    assert compare(f"{arc}G1 X10.0001\n", Code.NC_ARC_FIT, dialect="fanuc-mill") == [3]


@pytest.mark.parametrize("cut", ["M98 P2000", "G1 X#5", "G1 X20. F-5."], ids=["call", "no value", "feed below zero"])
def test_rows_go_on_where_only_the_whole_program_tells(cut: str) -> None:
    source = f"G21 G90\nG1 X10. F100.\nX11.\n{cut}\nX12.\nM30\nO2000\nG1 X20.\nM99\n".encode()
    path = read_program(source, "fanuc-mill").run(strict=False)
    assert check_in_parts(source, "fanuc-mill", None, None, {}, size=1) is None
    every = list(stretches(source, "fanuc-mill", None, None, {}, size=1))
    assert [row for of in every for row in "".join(csv_text(of.path, of.first)).splitlines()] == [
        *"".join(csv_text(path)).splitlines()
    ]
    assert every[-1].of_run == path.findings


def test_tools_and_a_missing_unit_are_left_to_the_whole_program() -> None:
    source = b"G21 G90\nG1 X10. F100.\nG41 D1 X20.\nG1 Y20.\nG40 X0.\nM30\n"
    tools = [CutterTool(2.0)]
    (only,) = stretches(source, "fanuc-mill", None, None, {}, tools=tools, size=1)
    whole = read_program(source, "fanuc-mill").run(tools=tools, strict=False)
    assert "".join(csv_text(only.path, only.first)) == "".join(csv_text(whole))
    with pytest.raises(TrueloopError) as refused:
        list(stretches(b"G90\nG1 X10. F100.\nX20.\nM30\n", "fanuc-mill", None, None, {}, size=1))
    assert refused.value.code is Code.NC_UNIT
