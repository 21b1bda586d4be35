"""`trueloop nc` with files that may not be read, options that are no numbers and bytes that are no text."""

import json
import os
from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus
from trueloop.nc.program.program import Program, read_program

SQUARE = "G21 G90\nG0 X0 Y0 Z5\nG1 Z-1 F100\nX10\nY10\nM30\n"


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "part.ngc"
    path.write_text(SQUARE)
    return path


def _denied(*_: object, **__: object) -> bytes:
    raise PermissionError(13, "Permission denied")


@pytest.mark.parametrize("command", [("path",), ("check",), ("features",)])
def test_a_file_that_may_not_be_read_is_refused_with_a_code(
    program: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...]
) -> None:
    monkeypatch.setattr(os, "access", lambda *_, **__: False)
    monkeypatch.setattr(Path, "read_bytes", _denied)
    said = invoke("nc", command[0], program, *command[1:], "--json" if command[0] != "path" else "-fjson", status=3)
    if command[0] == "path":
        assert f"{program}: NC-FILE: '{program}' cannot be read: Permission denied" in said.stderr
        return
    error = json.loads(said.stderr)["error"]
    assert error["code"] in ("NC-FILE", "JOB-MISSING") and error["hint"]
    assert error["message"] == f"'{program}' cannot be read: Permission denied"


def test_a_result_may_take_the_place_of_one_that_may_not_be_read(
    program: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = program.with_name("out.ngc")
    out.write_text("old")
    readable = os.access
    monkeypatch.setattr(os, "access", lambda path, mode, **more: Path(path) != out and readable(path, mode, **more))
    invoke("nc", "map", program, "--shift", "0.01,0,0", "-o", out, status=0)
    assert "X0.01" in out.read_text()


@pytest.mark.parametrize("given", ["nan", "inf", "-inf", "0", "-5"])
@pytest.mark.parametrize(
    "command",
    [
        ("map", "--shift=0.01,0,0", "--tolerance-um={}", "-o", "out.ngc"),
        ("map", "--shift={},0,0,", "-o", "out.ngc"),
        ("map", "--shift=", "-o", "out.ngc"),
        ("map", "--scale={}", "-o", "out.ngc"),
    ],
)
def test_what_is_no_such_number_is_a_fault_of_the_command_line(
    program: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], given: str
) -> None:
    monkeypatch.chdir(program.parent)
    name, *options = command
    invoke("nc", name, program, *(option.format(given) for option in options), status=ExitStatus.USAGE)
    assert not Path("out.ngc").exists()


@pytest.mark.parametrize("field", ["--shift=1e300,0,0", "--shift=0,0,-1e10", "--scale=1e12"])
def test_no_program_leads_further_than_any_machine(program: Path, field: str) -> None:
    out = program.with_name("out.ngc")
    said = invoke("nc", "map", program, field, "-o", out, status=3).stderr
    assert said.startswith(f"{program}:") and "CMP-SIZE" in said and "the limit is 1000000 mm" in said
    assert not out.exists()


@pytest.mark.parametrize("option", ["--dialect", "--other-dialect"])
def test_an_empty_name_is_no_dialect(program: Path, option: str) -> None:
    assert "NC-DIALECT: unknown NC dialect ''" in invoke("nc", "diff", program, program, option, "", status=3).stderr


def test_a_comparison_names_the_program_without_a_cut(program: Path) -> None:
    empty = program.with_name("empty.ngc")
    empty.write_text("")
    for pair in ((program, empty), (empty, program)):
        assert invoke("nc", "diff", *pair, status=3).stderr.startswith(f"{empty}: NC-NO-CONTOUR")


def test_a_program_does_not_command_the_terminal(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(program.parent)
    program.write_bytes(b'G1 \x1b[2J"\x07\x9b5m G21\n' + SQUARE.encode())
    said = invoke("nc", "check", program, "-d", "linuxcnc")
    assert ":1:4: " in said.output
    assert all(letter.isprintable() for letter in said.output.replace("\n", ""))


@pytest.mark.parametrize(("name", "instead"), [("translate", "nc map"), ("time", "CAM system")])
def test_a_removed_command_names_what_to_use(program: Path, name: str, instead: str) -> None:
    told = invoke("nc", name, program, "--to", "siemens", status=2).stderr
    assert f"the command {name!r} was removed" in told and instead in told


def test_columns_of_a_path_are_made_once() -> None:
    path = read_program(SQUARE.encode(), "linuxcnc").run()
    assert path.feed is path.feed and path.line is path.line and path.rapid is path.rapid


def test_a_program_is_not_asked_at_every_word_for_what_it_computes_with(
    program: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Program] = []
    used = Program.parameters_used

    def counted(own: Program) -> tuple[str, ...]:
        asked.append(own)
        return used(own)

    monkeypatch.setattr(Program, "parameters_used", counted)
    counts = []
    for times in (1, 40):
        program.write_text(SQUARE.replace("X10\n", "X10\nX11\n" * times))
        invoke("nc", "map", program, "--shift", "0.01,0,0", "-o", program.with_name("out.ngc"), status=0)
        program.with_name("out.ngc").unlink()
        counts.append(len(asked))
        asked.clear()
    assert counts[0] == counts[1]


@pytest.mark.parametrize("arc", ["G2 X5 Y5 R#1", "G2 X#1 Y5 R5", "G3 X5 Y5 I#1 J0", "X#1 Y0\nG3 X5 Y5 I2 J0"])
def test_an_arc_that_hangs_on_a_parameter_without_a_value_is_not_told_in_nan(program: Path, arc: str) -> None:
    program.write_text(SQUARE.replace("X10", arc))
    said = invoke("nc", "check", program, "-d", "fanuc-mill", status=1).stdout
    assert "NC-PARAMETER: parameter #1 has no value" in said
    assert "an arc whose start, end, radius or centre is not known" in said
    assert "nan" not in said.lower()


def test_what_is_not_understood_is_said_beside_what_was_made_of_the_path(tmp_path: Path) -> None:
    """The results are on stdout as ever; the machine may go elsewhere."""
    strange = tmp_path / "strange.ngc"
    strange.write_text("G21 G90 F100\nG0 X0 Y0\nG123 X5\nG1 X10 ??\nM30\n")
    plain = tmp_path / "plain.ngc"
    plain.write_text("G21 G90 F100\nG0 X0 Y0\nX5\nG1 X10\nM30\n")
    commands = [("path", strange), ("diff", strange, plain), ("diff", plain, strange)]
    for command in commands:
        said = invoke("nc", *command, "-d", "linuxcnc").stderr
        assert f'{strange}:3:1: warning NC-CODE: "G123" is no code of the dialect linuxcnc' in said
        assert f"{strange}: 1 more of this kind" in said
    assert json.loads(invoke("nc", *commands[1], "-d", "linuxcnc", "--json").stdout)["not_understood"] == [2, 0]
    assert json.loads(invoke("nc", *commands[0], "-d", "linuxcnc", "-fjson").stdout)["not_understood"] == 2
    assert invoke("nc", "diff", plain, plain, "-d", "linuxcnc").stderr == ""


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        ("0 BEGIN PGM A MM\n1 Q247=+O\n2 L X+Q247 F100\n3 END PGM A MM\n", "heidenhain"),
        ("G710 G90 G54 F100\nG0 X=O Y0\nM30\n", "siemens"),
        ("%\nO1\nG21 G90 G54 G94\nG0 XO Y0\nM30\n%\n", "fanuc-mill"),
    ],
)
def test_a_letter_o_in_place_of_a_figure_is_named(program: Path, text: str, dialect: str) -> None:
    program.write_text(text)
    assert "if the figure is meant, write 0" in invoke("nc", "check", program, "-d", dialect).stdout


def test_a_shift_of_two_numbers_is_complained_of_before_the_program_to_write(program: Path) -> None:
    said = invoke("nc", "map", program, "-d", "fanuc-mill", "--shift", "0.1,0.2", status=2).stderr
    assert "--shift" in said and "--out" not in said
