"""A program with its witness is the same program: LinuxCNC's interpreter makes the same moves of both."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.support.linuxcnc import Move, interpret
from trueloop.errors import Code, TrueloopError
from trueloop.nc.witness import log_lines, witnessed

KEY = "O1.3.2.1"
PROGRAMS = {
    "plain": b"G21 G90 G94 F100\nG1 X1 Z2\nG3 X2 Z1 K-1\nM2\n",
    "percent": b"%\n(M30 in a comment)\nG21 G90 F100\nG1 X1 ; M2\nN90 M30\n%\n",
    "percent alone": b"%\nG21 G90 F100\nG1 X1\n%\n",
    "windows": b"G21 G90 F100\r\nG1 X1\r\nM30\r\n",
    "sub": b"o<m2> sub\nG1 X3\no<m2> endsub\nG21 G90 F100\no<m2> call\nG1 Z1\nM2\n",
    "branch": b"G21 G90 F100\no1 if [1 EQ 2]\nG1 X1\nM2\no1 endif\nG1 X2\nM 0 2\n",
    "last line": b"G21 G90 F100\nG1 X1\nM2",
}


def moves(folder: Path, text: bytes) -> list[Move]:
    file = folder / "program.ngc"
    file.write_bytes(text)
    return [replace(one, line=0) for one in interpret(file)]


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_interpreter_makes_the_same_moves_of_it(tmp_path: Path, name: str) -> None:
    text = PROGRAMS[name]
    found = moves(tmp_path, witnessed(text, KEY))
    assert found == moves(tmp_path, text) and found


@pytest.mark.parametrize("name", PROGRAMS)
def test_its_own_lines_are_as_they_were(name: str) -> None:
    text = PROGRAMS[name]
    head, tail = log_lines(KEY)
    own = [line for line in witnessed(text, KEY).splitlines(True) if line.strip() not in [*head, *tail]]
    assert b"".join(own) == text


@pytest.mark.parametrize(
    "text", [b"G1 X1\n", b"", b"G1 X1 M2\n", b"/M2\n", b"G1 X1\nM99\nM2\n", b"M[1+1]\nM2\n", b"M#1\nM2\n"]
)
def test_a_program_whose_end_is_not_sure_is_refused(text: bytes) -> None:
    with pytest.raises(TrueloopError, match=Code.CEL_WITNESS.value):
        witnessed(text, KEY)
