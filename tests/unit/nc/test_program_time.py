"""A program timed in parts takes what it takes as a whole, and the same is noticed in it."""

import tomllib
from collections.abc import Mapping
from pathlib import Path

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import Unit, read_program
from trueloop.nc.program.program_time import program_time, time_in_parts

PROGRAMS = Path(__file__).parents[2] / "programs"
IN_PARTS = (
    *("haas-mill", "linuxcnc-diameter", "linuxcnc-expressions", "linuxcnc-frames", "linuxcnc-planes"),
    *("linuxcnc-splines", "metric-increments", "position-register"),
)
KLARTEXT = b"""0 BEGIN PGM PLATE MM
1 TOOL CALL 1 Z S3000
2 L X+0 Y+0 Z+10 R0 FMAX M3
3 L Z-2 F200
4 L IX+25.5 F900
5 C1 X+5
6 CYCL DEF 9.0 DWELL TIME
7 CYCL DEF 9.1 DWELL 1.5
8 TOOL CALL 2 Z S2000
9 L Y+30 F500
10 L X+0 A+15
11 L Z+50 FMAX M30
12 END PGM PLATE MM
"""


def compare(source: bytes, dialect: str, size: int, parameters: Mapping[str, float], unit: Unit | None = None) -> None:
    program = read_program(source, dialect, "part.nc", unit)
    whole = program_time(program, program.run(parameters), 8000.0, 3000.0)
    in_parts = time_in_parts(source, dialect, "part.nc", unit, parameters, 8000.0, 3000.0, size=size)
    assert in_parts is not None
    for of in ("cutting_s", "rapid_s", "dwell_s", "total_s"):
        assert getattr(in_parts, of) == pytest.approx(getattr(whole, of), rel=1e-12)
    assert in_parts.by_tool_s == whole.by_tool_s
    assert sorted(in_parts.findings, key=str) == sorted(whole.findings, key=str)


@pytest.mark.parametrize("size", [1, 40])
@pytest.mark.parametrize("name", IN_PARTS)
def test_parts_take_as_long_as_the_whole(name: str, size: int) -> None:
    case = tomllib.loads((PROGRAMS / name / "case.toml").read_text())
    source = next((PROGRAMS / name).glob("program.*")).read_bytes()
    compare(source, case["dialect"], size, case.get("parameters", {}))


@pytest.mark.parametrize("size", [1, 40, 200])
def test_modes_tools_and_findings_go_on_from_part_to_part(size: int) -> None:
    compare(KLARTEXT, "heidenhain", size, {})
    compare(b"G90\nG01 X1. F10.\nX2.\nX3.\nS400 M03\nT2 M06\nX4. F20.\nM30\nX5.\n" * 2, "fanuc-mill", 20, {}, "inch")


@pytest.mark.parametrize(
    "source",
    [
        "G21 G90\nG01 X10. F100.\nM98 P2000\nM30\nO2000\nG01 X20.\nM99\n",
        "G21 G90\nG01 X10.\nG01 X20. F100.\nM30\n",
        "G21 G90\nG01 X10. F-5.\nG01 X20. F100.\nM30\n",
        "G90\nG01 X10. F100.\nG01 X20.\nM30\n",
        "G21 G90\nG01 X10. F100.\nG04 P#5\nG01 X20.\nM30\n",
    ],
    ids=["a call", "no feed", "a feed below zero", "no unit", "a parameter without a value"],
)
def test_what_only_the_whole_program_tells_has_no_time_in_parts(source: str) -> None:
    assert time_in_parts(source.encode(), "fanuc-mill", None, None, {}, 8000.0, size=10) is None


def test_a_unit_given_and_a_wrong_parameter_are_left_to_the_whole_program() -> None:
    source = b"G21 G90\nG01 X10. F100.\nG01 X20.\nM30\n"
    assert time_in_parts(source, "fanuc-mill", None, "inch", {}, 8000.0, size=10) is None
    assert time_in_parts(source, "fanuc-mill", None, None, {"LENGTH": 1.0}, 8000.0, size=10) is None
    with pytest.raises(TrueloopError) as refused:
        read_program(source, "fanuc-mill", None, "inch").run()
    assert refused.value.code is Code.NC_UNIT
