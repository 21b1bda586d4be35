"""Loops that never end are refused soon, at a line of theirs, in every dialect and every command."""

import shutil
import time
from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop import example
from trueloop.errors import Code, TrueloopError
from trueloop.nc.check.check import check
from trueloop.nc.program.program import read_program

MOST = 10_000
"""Moves of a loop that repeats itself until it is refused; without a comparison of states it makes millions."""
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


@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_whose_values_never_change_is_refused_with_its_line(name: str) -> None:
    dialect, text = LOOPS[name]
    parameter = {"siemens": "R500", "heidenhain": "Q500"}.get(dialect, "#500")
    program = read_program(text.encode(), dialect, "part.nc")
    path = program.run({parameter: 0.0}, strict=False)
    (refused,) = [found for found in path.findings if found.code is Code.NC_LIMIT]
    assert len(path) < MOST and 2 < (refused.place.line or 0) < len(text.splitlines())
    assert "a loop without an end: all is as it was" in refused.message


ENDLESS = {
    "goto with a tool": (
        "fanuc-mill",
        "O1\nG21 G90 G94\nN1 T1 M6\nG54 G43 H1 G0 Z5.\nG1 X1. F9.\nG0 X0.\nGOTO 1\nM30\n",
    ),
    "subprogram": ("fanuc-mill", "O1\nG21 G90 G94\nN1 M98 P2 L3\nGOTO 1\nM30\nO2\nG1 X1. F9.\nG0 X0.\nM99\n"),
    "macro": ("fanuc-mill", "O1\nG21 G90 G94\nN1 G65 P2 A1.\nGOTO 1\nM30\nO2\n#2=#1+1.\nG1 X#2 F9.\nG0 X0.\nM99\n"),
    "long turn": ("fanuc-mill", "O1\nG21 G90 G94\nN1 M98 P2 L9000\nGOTO 1\nM30\nO2\nG1 X1. F9.\nG0 X0.\nM99\n"),
    "call": (
        "linuxcnc",
        "G21 G90 G94\no1 sub\n#<_b>=[#1+1]\n#<_a>=2\n#<c>=#1\nG1 X#1 F1\no1 endsub\n"
        "o2 while [1]\no1 call [1]\no1 call [2]\no2 endwhile\nM2\n",
    ),
    "section": (
        "heidenhain",
        "0 BEGIN PGM A MM\n1 LBL 1\n2 CALL LBL 2\n3 FN 9: IF +1 EQU +1 GOTO LBL 1\n4 M30\n"
        "5 LBL 2\n6 L X+1 F100\n7 L X+2\n8 LBL 0\n9 END PGM A MM\n",
    ),
}


@pytest.mark.parametrize("name", ENDLESS)
def test_tools_and_calls_in_an_endless_loop_hide_nothing(name: str) -> None:
    dialect, text = ENDLESS[name]
    path = read_program(text.encode(), dialect, "part.nc").run(strict=False)
    (refused,) = [found for found in path.findings if found.code is Code.NC_LIMIT]
    assert "all is as it was" in refused.message and len(path) < 100_000


def test_a_loop_that_only_counts_runs_to_its_end_or_to_the_limit() -> None:
    text = "O1\nG21 G90 G94\n#1=0\nWHILE[#1 LT {}]DO1\n#1=#1+1\nEND1\nG1 X#1 F9.\nM30\n"
    path = read_program(text.format("200000").encode(), "fanuc-mill").run()
    assert path.end_mm[:, 0].tolist() == [200_000.0]
    with pytest.raises(TrueloopError, match=r"stopped after 30000\d\d blocks") as refused:
        read_program(text.format("-#1").replace("LT", "GE").encode(), "fanuc-mill").run()
    assert refused.value.code is Code.NC_LIMIT and refused.value.place.line in (4, 5, 6)


def test_parameters_that_a_loop_leaves_alone_take_no_time() -> None:
    """The states differ by a name that counts: with 5000 numbers to compare at each turn it took many times as long."""

    def seconds(number: int) -> float:
        text = f"#{number}=1\n#<n>=0\no1 while [#<n> lt 300000]\n#<n>=[#<n>+1]\no1 endwhile\nM2\n"
        program, began = read_program(text.encode(), "linuxcnc"), time.process_time()
        assert not program.run().findings
        return time.process_time() - began

    assert seconds(5000) < 3 * max(seconds(1), seconds(2))


LEGAL = {
    "counted by a variable": (
        "linuxcnc",
        "G21 G90 G94\n#5=0\no1 while [#5 lt 100000]\nG1 X1 F1\nX0\n#5=[#5+1]\no1 endwhile\nM2\n",
    ),
    "repeated": ("linuxcnc", "G21 G90 G94\no1 repeat [100000]\nG1 X1 F1\nX0\no1 endrepeat\nM2\n"),
    "called": ("fanuc-mill", "O1\nG21 G90 G94\nM98 P2 L100000\nM30\nO2\nG1 X1. F9.\nG0 X0.\nM99\n"),
    "increments": ("haas-mill", "%\nO1\nG21 G90 G94\nM98 P2 L100000\nM30\nO2\nG91 G1 X.001 F9.\nX.001\nM99\n%\n"),
    "section": (
        "heidenhain",
        "0 BEGIN PGM A MM\n1 LBL 1\n2 L X+1 F100\n3 L X+0\n4 CALL LBL 1 REP 99999\n5 END PGM A MM\n",
    ),
    "for": ("siemens", "G710 G90 G95\nFOR R1=1 TO 100000\nG1 X1 F.1\nX0\nENDFOR\nM30\n"),
    "a name counts": (
        "siemens",
        "DEF INT COUNT=0\nG710 G90 G95\nAA: G1 X1 F.1\nX0\nCOUNT=COUNT+1\nIF COUNT<100000 GOTOB AA\nM30\n",
    ),
}


@pytest.mark.parametrize("name", LEGAL)
def test_a_long_loop_that_ends_is_run_to_its_end(name: str) -> None:
    dialect, text = LEGAL[name]
    path = read_program(text.encode(), dialect, "part.nc").run(strict=False)
    assert len(path) == 200_000 and Code.NC_LIMIT not in {found.code for found in path.findings}


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
