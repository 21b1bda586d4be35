"""Lines of LinuxCNC that are written in unusual ways, judged by its own interpreter."""

import math
from pathlib import Path

import pytest

from tests.support.cli import invoke
from tests.support.linuxcnc import ProgramRefusedError, interpret
from tests.support.nc_judge import assert_same_moves
from trueloop.errors import Code, Severity
from trueloop.nc.check.check import check
from trueloop.nc.program.program import read_program

MILL = "G17 G21 G40 G90 G94"
HEAD = "G21 G90 G17 F100\nG0 X0 Y0 Z1\n"
SUB = "o100 sub\nG1 X#1 Y#2\no100 endsub\n"
CONTOUR = "o100 sub\n{first}\nG1 X8 Z-5\nX10 Z-9\no100 endsub\n"


@pytest.mark.parametrize(
    "text",
    [
        SUB + "o100 call (first) [3] [4]\no100 call [5] (and) [6]\no100 call [7][8](end)\no100 call (b)(c) [1] ; [9]\n",
        "#1=0\no7 while [#1 lt 2] (as long as)\nG1 X#1\n#1=[#1+1]\no7 endwhile (done)\n",
        "o100 sub\nG1 X1\no100 end sub\no100 call\n",
        "#1=0\no1 while [#1 lt 2]\nG1 X#1\n#1=[#1+1]\no1 end while\nG1 Y3\n",
        "o1 if [1]\nG1 X1\no1 else if [2]\nG1 X5\no1 end if\nG1 Y3\n",
        "o1 if [0]\nG1 X1\no1 e lse\nG1 X6\no1 en dif\nG1 Y3\n",
        "o1 repeat [2]\nG91 G1 X1\no1 end repeat\n",
        "o 100 s u b\nG1 X1\no100 e n d sub\no100 c all\n",
        "o1 if [EXISTS[#99999]]\nG1 X1\no1 else\nG1 X2\no1 endif\n",
        "G1 X[EXISTS[#5601]] Y[EXISTS[#5602]]\n",
        "G1 X[EXISTS[#1]] Y[EXISTS[#<_nowhere>]]\n",
        "G1 X-0 Y-0.0\nG1 X5\nG2 X-0. Y0 I-2.5 J-0.\n",
        "G0 X10\nG2 X10 Y0 Z-1 I-10 J0 P3\n",
        "G0 X10\nG2 X10 Y0 Z-1 I-10 J0 P1.00001\n",
    ],
)
def test_what_linuxcnc_runs_is_run_alike(text: str, tmp_path: Path) -> None:
    source = tmp_path / "program.ngc"
    source.write_text(f"{HEAD}{text}M2\n")
    program = read_program(source.read_bytes(), "linuxcnc")
    path = program.run()
    assert_same_moves(path, interpret(source, startup=MILL))
    assert all(found.code not in (Code.NC_WORD, Code.NC_FLOW) for found in check(program))


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("#1=0\no7 while (as long as) [#1 lt 2]\n#1=[#1+1]\no7 endwhile\n", Code.NC_EXPRESSION),
        (SUB + "o100 (so) call [1]\n", Code.NC_FLOW),
        ("G1 X#99999\n", Code.NC_PARAMETER),
        ("#99999=1\nG1 X1\n", Code.NC_PARAMETER),
        ("#5602=1\nG1 X1\n", Code.NC_PARAMETER),
        ("G0 X10\nG2 X10 Y0 Z-1 I-10 J0 P1.5\n", Code.NC_ARC),
        ("G0 X10\nG2 X10 Y0 Z-1 I-10 J0 P0\n", Code.NC_ARC),
        ("G0 X10\nG2 X10 Y0 Z-1 I-10 J0 P-2\n", Code.NC_ARC),
    ],
)
def test_what_linuxcnc_refuses_is_an_error(text: str, code: Code, tmp_path: Path) -> None:
    source = tmp_path / "program.ngc"
    source.write_text(f"{HEAD}{text}M2\n")
    with pytest.raises(ProgramRefusedError):
        interpret(source, startup=MILL)
    errors = [
        found for found in check(read_program(source.read_bytes(), "linuxcnc")) if found.severity is Severity.ERROR
    ]
    assert [found.code for found in errors] == [code]


@pytest.mark.parametrize(
    "before", ["", "G80\n", "G1 X12 Z3 F50\n", "G71 Q100 I1 D.2\n", "G2 X12 Z2 I-1 K0\n", "S100 M3\nG33 K1 Z1\n"]
)
@pytest.mark.parametrize("first", ["X5 Z0", "G0 X5 Z0", "G1 X5 Z0", "Z0"])
def test_the_first_block_of_a_contour_may_have_no_code(before: str, first: str, tmp_path: Path) -> None:
    source = tmp_path / "program.ngc"
    contour = CONTOUR.format(first=first)
    source.write_text(f"G21 G18 G8 G90 F100\n{contour}G0 X12 Z2\n{before}G70 Q100\nM2\n")
    path = read_program(source.read_bytes(), "linuxcnc").run()
    assert_same_moves(path, interpret(source))


DIGITS = "1" * 400


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        (f"N{DIGITS} G21 G90 F100\nG1 X1\nM2\n", "linuxcnc"),
        (f"G21 G90 F100\nG1 X{DIGITS}\nM2\n", "linuxcnc"),
        (f"G21 G90 F100\nG1 X-{'9' * 10_000}\nM2\n", "linuxcnc"),
        (f"O{DIGITS}\nG21 G90 F100\nT{DIGITS} M{DIGITS}\nG1 X1. H{DIGITS}\nM30\n", "fanuc-mill"),
        (f"G71 G90\nT{DIGITS} D{DIGITS}\nG1 X={DIGITS} F100\nM30\n", "siemens"),
        (f"0 BEGIN PGM A MM\n{DIGITS} L X+1 F100\nTOOL CALL {DIGITS}\n2 END PGM A MM\n", "heidenhain"),
        (f"G21\nG10 L2 P{DIGITS} X1.\nG{DIGITS} X1.\nM98 P{DIGITS}\nM30\n", "haas-lathe"),
    ],
)
def test_numbers_that_no_control_takes_are_no_fault_of_ours(text: str, dialect: str, tmp_path: Path) -> None:
    source, out = tmp_path / "program.nc", tmp_path / "out.nc"
    source.write_text(text)
    commands = [
        ["nc", "check", source],
        ["nc", "path", source],
        ["nc", "map", source, "-o", out, "--shift", "0.01,0,0"],
        ["nc", "diff", source, source],
        ["machine", "points", source, "-o", out, "--quadrupole", "1e-5,0"],
    ]
    for command in commands:
        assert invoke(*command, "-d", dialect).exit_code in (0, 1, 3), command
    assert not out.exists()
    told = [found.code for found in check(read_program(text.encode(), dialect))]
    assert Code.NC_WORD in told


def test_long_numbers_have_their_value() -> None:
    text = f"G21 G90 F100\nG1 X{'0' * 10_000}5 Y1.{'0' * 10_000}5 Z-0\nM2\n"
    path = read_program(text.encode(), "linuxcnc").run()
    assert path.end_mm[-1].tolist() == [5.0, 1.0, 0.0]


@pytest.mark.parametrize("turns", ["2000000000", "1000001"])
def test_more_turns_than_are_followed_are_refused(turns: str, tmp_path: Path) -> None:
    source, out = tmp_path / "program.ngc", tmp_path / "out.ngc"
    source.write_text(f"{HEAD}G0 X10\nG2 X10 Y0 Z-1 I-10 J0 P{turns}\nM2\n")
    told = invoke("nc", "map", source, "-o", out, "-d", "linuxcnc", "--shift", "0.01,0,0", status=3).stderr
    assert f"{source}:4:" in told and "NC-LIMIT" in told and not out.exists()
    path = read_program(source.read_bytes().replace(turns.encode(), b"1000000"), "linuxcnc").run()
    assert math.isclose(path.sweep_rad[-1], 1e6 * math.tau)
