"""The unit of a program: stated before the first length, or given; never guessed, never given against the program."""

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import Unit, read_program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.nc.program.unit import unit_of_path

INCH_MM = 25.4


def run(text: str, dialect: str = "fanuc-mill", unit: Unit | None = None, *, skipped_blocks: bool = False) -> ToolPath:
    return read_program(text.encode(), dialect, "a.nc", unit).run(skipped_blocks=skipped_blocks)


def refusal(text: str, dialect: str = "fanuc-mill", unit: Unit | None = None) -> TrueloopError:
    with pytest.raises(TrueloopError) as raised:
        run(text, dialect, unit)
    assert raised.value.code is Code.NC_UNIT
    assert raised.value.hint
    return raised.value


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("fanuc-mill", "%\n(INCH)\nG0 X1. Y2.\n"),
        ("haas-mill", "%\n(INCH)\nG0 X1. Y2.\n"),
        ("fanuc-lathe", "%\n(MM)\nG0 X1. Z2.\n"),
        ("linuxcnc", "(MM)\n(MM)\nG0 X1 Y2\n"),
        ("siemens", "; MM\n; MM\nG0 X1 Y2\n"),
        ("ge2000t", "! INCH\n! INCH\nG00 X1. Z2.\n"),
        ("heidenhain", "; MM\n; MM\nL X+1 Y+2 FMAX\n"),
    ],
)
def test_a_length_without_a_unit_is_refused_on_every_control(dialect: str, text: str) -> None:
    refused = refusal(text, dialect)
    assert refused.place.file == "a.nc"
    assert refused.place.line == 3
    assert "--unit" in refused.hint
    assert run(text, dialect, "mm").end_mm[-1].max() == 2.0
    assert run(text, dialect, "inch").end_mm[-1].max() == 2.0 * INCH_MM


def test_the_place_is_that_of_the_first_length_and_a_later_unit_does_not_reach_back() -> None:
    refused = refusal("G90\nG0 X0 Y3.\nG21\nG1 X2. F100\n")
    assert (refused.place.line, refused.place.column) == (2, 4)


def test_the_given_unit_is_the_one_in_force_at_the_start_and_the_programs_own_comes_after_it() -> None:
    path = run("G90\nG0 X1. Y0.\nG21\nG1 X2. F100\n", "linuxcnc", unit="inch")
    assert path.end_mm[:, 0].tolist() == [INCH_MM, 2.0]
    assert unit_of_path("inch", path) == {"unit": "inch", "stated_by": "--unit or programs.unit"}


def test_a_program_with_both_units_is_read_with_both() -> None:
    """A control of the Fanuc kind refuses the second: its offsets would count in the other unit."""
    text = "G20\nG0 X1. Y0.\nG21\nG0 X1.\n"
    assert refusal(text).place.line == 3
    path = run(text, "linuxcnc")
    assert path.end_mm[:, 0].tolist() == [INCH_MM, 1.0]
    assert unit_of_path(None, path) == {"unit": "inch", "stated_by": "the program, line 1"}


@pytest.mark.parametrize(("stated", "given"), [("G20", "mm"), ("G21", "inch")])
def test_a_given_unit_that_contradicts_the_program_is_refused(stated: str, given: Unit) -> None:
    refused = refusal(f"%\n{stated}\nG0 X1. Y0.\n", unit=given)
    assert refused.place.line == 2
    other: Unit = "inch" if given == "mm" else "mm"
    assert run(f"%\n{stated}\nG0 X1. Y0.\n", unit=other).end_mm[0, 0] == (1.0 if other == "mm" else INCH_MM)


def test_klartexts_heading_is_a_statement() -> None:
    text = "BEGIN PGM A INCH\nL X+1 Y+0 FMAX\nEND PGM A INCH\n"
    assert run(text, "heidenhain").end_mm[0, 0] == INCH_MM
    assert refusal(text, "heidenhain", "mm").place.line == 1


@pytest.mark.parametrize(
    "way", ["G28 X0 Y0", "G91 G28 Z0\nG90", "G53 G0 Z0", "G0 G53 X0. Y0.", "G92 X0 Y0", "G52 X0 Y0", "G4 P500", "T1 M6"]
)
def test_zero_and_what_is_no_length_need_no_unit(way: str) -> None:
    path = run(f"{way}\nG21\nG0 X1. Y2. Z3.\n")
    assert path.end_mm[-1].tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("way", ["G92 X5.", "G52 X5.", "G10 L2 P1 X5.", "G28 Z5.", "G53 G0 Z-1.", "F100", "G0 X0 Y0"])
def test_lengths_of_frames_ways_and_feeds_count(way: str) -> None:
    assert refusal(f"G90\n{way}\nG21\nG0 X1. Y2. Z3.\n").place.line == 2


def test_only_what_is_run_states_the_unit() -> None:
    optional = "G90\n/G21\nG0 X1. Y2.\n"
    assert refusal(optional).place.line == 3
    assert run(optional, skipped_blocks=True).end_mm[0, 0] == 1.0
    jumped = "#1=1\nIF [#1 EQ 1] GOTO 5\nG21\nN5 G0 X1. Y2.\nM30\n"
    assert refusal(jumped).place.line == 4


def test_a_subprogram_states_it_for_what_comes_after_its_call() -> None:
    called = "O1\nM98 P2\nG0 X1. Y2.\nM30\nO2\nG20\nM99\n"
    path = run(called)
    assert path.end_mm[0, 0] == INCH_MM
    assert unit_of_path(None, path)["stated_by"] == "the program, line 6"
    assert refusal("O1\nM98 P2\nG21\nM30\nO2\nG0 X1. Y2.\nM99\n").place.line == 6


def test_what_only_checks_reports_it() -> None:
    findings = read_program(b"G0 X1. Y2.\n", "fanuc-mill").run(strict=False).findings
    assert [finding.code for finding in findings] == [Code.NC_UNIT]


def test_a_rewritten_program_keeps_its_unit() -> None:
    program = read_program(b"G0 X1. Y2.\n", "fanuc-mill", unit="inch")
    assert program.rewritten(b"G0 X2. Y2.\n").run().end_mm[0, 0] == 2 * INCH_MM
