"""Loops that wait for a parameter without a value end soon, at a line of theirs, in every dialect and every command."""

import shutil
from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop import example
from trueloop.errors import Code, TrueloopError
from trueloop.nc.check.check import check
from trueloop.nc.program.program import read_program

MOST = 600_000
"""Moves that a loop makes before it is given up; without a bound of its own it makes millions."""
LOOPS = {
    "fanuc while": ("fanuc-lathe", "O1\nG21 G90 G99\nWHILE [#500 LT 10] DO1\nG1 X1. F.1\nX2.\nEND1\nM30\n"),
    "fanuc while not": ("fanuc-mill", "O1\nG21 G90 G94\n#1=#500\nWHILE [#1 NE 10] DO1\nG1 X1. F.1\nX2.\nEND1\nM30\n"),
    "fanuc goto": ("fanuc-lathe", "O1\nG21 G90 G99\nN10 G1 X1. F.1\nX2.\nIF [#500 NE 10] GOTO 10\nM30\n"),
    "haas goto": ("haas-mill", "%\nO1\nG21 G90 G94\nN10 G1 X1. F.1\nX2.\nIF [#500 NE 10] GOTO 10\nM30\n%\n"),
    "siemens loop": ("siemens", "G710 G90 G95\nLOOP\nG1 X1 F.1\nX2\nIF R500>1 GOTOF ENDE\nENDLOOP\nENDE: M30\n"),
    "siemens while": ("siemens", "G710 G90 G95\nWHILE R500<>1\nG1 X1 F.1\nX2\nENDWHILE\nM30\n"),
    "siemens repeat": ("siemens", "G710 G90 G95\nREPEAT\nG1 X1 F.1\nX2\nUNTIL R500>1\nM30\n"),
    "siemens gotob": ("siemens", "G710 G90 G95\nAA: G1 X1 F.1\nX2\nIF R500<>1 GOTOB AA\nM30\n"),
    "heidenhain": (
        "heidenhain",
        "0 BEGIN PGM A MM\n1 LBL 1\n2 L X+1 F100\n3 L X+2\n4 FN 10: IF +Q500 NE +1 GOTO LBL 1\n5 END PGM A MM\n",
    ),
    "linuxcnc while": ("linuxcnc", "G21 G90 G94\no1 while [#500 lt 10]\nG1 X1 F1\nX2\no1 endwhile\nM2\n"),
    "linuxcnc do": ("linuxcnc", "G21 G90 G94\no1 do\nG1 X1 F1\nX2\no1 while [#500 lt 10]\nM2\n"),
    "linuxcnc break": (
        "linuxcnc",
        "G21 G90 G94\no1 while [1]\nG1 X1 F1\nX2\no2 if [#500]\no1 break\no2 endif\no1 endwhile\nM2\n",
    ),
}


@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_that_waits_for_a_parameter_without_a_value_ends(name: str) -> None:
    dialect, text = LOOPS[name]
    program = read_program(text.encode(), dialect, "part.nc")
    path = program.run(strict=False)
    assert len(path) < MOST
    with pytest.raises(TrueloopError) as refused:
        program.run()
    assert refused.value.code in (Code.NC_PARAMETER, Code.NC_LIMIT)
    assert 1 < (refused.value.place.line or 0) < len(text.splitlines())
    assert {Code.NC_PARAMETER} <= {one.code for one in check(program)}


def test_a_value_lets_the_loop_run_as_long_as_it_may() -> None:
    text = "G21 G90 G94\no1 while [#500 lt 700000]\n#500=[#500+1]\nG1 X#500 F1\no1 endwhile\nM2\n"
    program = read_program(text.encode(), "linuxcnc", "part.ngc")
    assert len(program.run({"#500": 0.0}, strict=False)) == 700_000
    with pytest.raises(TrueloopError, match="--set '#500=") as refused:
        program.run()
    assert refused.value.code is Code.NC_LIMIT and "#500 has no value" in refused.value.message


@pytest.mark.parametrize("command", ["check", "map", "compensate"])
def test_every_command_names_the_line(tmp_path: Path, command: str) -> None:
    for folder in ("linuxcnc", "modbas2"):
        shutil.copytree(example(f"{folder}/job.toml").parent, tmp_path / folder)
    program = tmp_path / "linuxcnc" / "finish.ngc"
    lines = program.read_text(encoding="utf-8").splitlines()
    loop = ["o900 while [#500 lt 10]", "#2=[#2+0]", "o900 endwhile"]
    program.write_text("\n".join([*lines[:-2], *loop, *lines[-2:], ""]), encoding="utf-8")
    given: dict[str, list[object]] = {
        "check": ["nc", "check", program],
        "map": ["nc", "map", program, "-o", tmp_path / "out.ngc", "--shift", "0.01,0,0"],
        "compensate": ["compensate", tmp_path / "linuxcnc" / "job.toml"],
    }
    told = invoke(*given[command])
    said = told.stdout + told.stderr
    assert told.exit_code != 0
    assert any(f"finish.ngc:{line}" in said for line in range(len(lines) - 1, len(lines) + 2)), said
    assert "#500" in said and not (tmp_path / "out.ngc").exists()
