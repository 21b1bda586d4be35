"""Words as programs of shops have them by mistake: none is lost without a word."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import ProgramRefusedError, interpret
from tests.support.mapped import mapped
from trueloop.errors import Code, Severity, TrueloopError
from trueloop.nc.field import affine_field
from trueloop.nc.program.program import read_program

LATHE = "G21 G99 F.1\nG00 X20. Z5.\n"


def codes(text: str, dialect: str) -> list[tuple[Code, int | None, int | None]]:
    program = read_program(text.encode(), dialect)
    findings = (*program.findings, *program.run(strict=False).findings)
    return [(found.code, found.place.line, found.place.column) for found in findings]


@pytest.mark.parametrize("dialect", ["fanuc-lathe", "haas-lathe"])
@pytest.mark.parametrize(
    ("words", "end", "column"),
    [
        ("X14. U1.", (10.5, 5.0), 10),
        ("U1. X14.", (7.0, 5.0), 9),
        ("Z-2. W-1.", (10.0, 4.0), 10),
        ("W-1. Z-2.", (10.0, -2.0), 10),
    ],
)
def test_of_a_position_and_an_increment_of_one_axis_the_last_counts_and_is_told(
    dialect: str, words: str, end: tuple[float, float], column: int
) -> None:
    text = f"{LATHE}G01 {words}"
    path = read_program(text.encode(), dialect).run()
    assert tuple(path.end_mm[-1, [0, 2]]) == end
    assert (Code.NC_DUPLICATE, 3, column) in codes(text, dialect)


@pytest.mark.parametrize(("words", "column"), [("G01,X5.", 4), ("G01 X5.,Z2.", 8), ("G01 X5. ,W-1.", 9)])
def test_a_coordinate_behind_a_comma_is_told(words: str, column: int) -> None:
    assert codes(LATHE + words, "fanuc-lathe") == [(Code.NC_WORD, 3, column)]


@pytest.mark.parametrize(
    ("text", "dialect", "place"),
    [
        (f"{LATHE}G01 X10. I2.", "fanuc-lathe", (3, 10)),
        (f"{LATHE}G01 Z-9. K2.", "haas-lathe", (3, 10)),
        ("G21 G18 F1\nG64 P.01\nG1 X5 Z1\nG1 X6 I1", "linuxcnc", (4, 7)),
        ("G71 G18 DIAMOF F1\nG1 X5 Z1\nG1 X6 K1", "siemens", (3, 7)),
    ],
)
def test_a_centre_without_an_arc_is_told(text: str, dialect: str, place: tuple[int, int]) -> None:
    """Older lathes cut a chamfer there, others stop."""
    assert codes(text, dialect) == [(Code.NC_MISPLACED, *place)]


@pytest.mark.parametrize(
    ("text", "dialect"),
    [("G21 G18\nG0 X5 Z1\nF1 G33 Z-5", "linuxcnc"), ("G71 G18 DIAMOF\nG0 X5 Z1\nF1 G33 Z-5", "siemens")],
)
def test_a_thread_whose_lead_is_not_written_does_not_take_the_feed_for_it(text: str, dialect: str) -> None:
    assert (Code.NC_MISPLACED, 3, 1) in codes(text, dialect)


def test_a_letter_that_the_ge_2000t_has_not_got_is_told() -> None:
    assert codes("G70\nG00 X1.0\nU1.0 W2.0", "ge2000t") == [(Code.NC_WORD, 3, 1), (Code.NC_WORD, 3, 6)]


@pytest.mark.parametrize(
    ("blanks", "packed"),
    [
        ("N 10 G 01 X 15. Z\t-2.5 F .2", "N10 G01 X15. Z-2.5 F.2"),
        ("G01 X   +15.,R 2.\nZ  -9.", "G01 X+15.,R2.\nZ-9."),
        ("G00 U 1. W -1.", "G00 U1. W-1."),
        ("M 98 P 7\nM 30\nO 7\nG01 X 9. F 1.\nM 99", "M98 P7\nM30\nO7\nG01 X9. F1.\nM99"),
        ("#1 = 3\nIF [#1 EQ 3] GOTO 20\nX 99.\nN 20 X #1", "#1=3\nIF[#1EQ3]GOTO20\nX99.\nN20 X#1"),
    ],
)
@pytest.mark.parametrize("dialect", ["fanuc-lathe", "haas-lathe"])
def test_blanks_between_an_address_and_its_number_are_none_of_it(dialect: str, blanks: str, packed: str) -> None:
    spaced, plain = (read_program((LATHE + text).encode(), dialect).run() for text in (blanks, packed))
    assert len(plain) > 1
    assert np.array_equal(spaced.end_mm, plain.end_mm)
    assert np.array_equal(spaced.feed, plain.feed, equal_nan=True)
    assert not [code for code, *_ in codes(LATHE + blanks, dialect) if code is not Code.NC_NUMBER]


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas-mill", "linuxcnc"])
def test_an_edit_of_such_a_word_changes_its_digits_alone(dialect: str, tmp_path: Path) -> None:
    text = "G21\nG00 X 10. Y\t-2.5 Z 5.\r\nG01 X  12.50 F 100.\nM2\n"
    after, _ = mapped(tmp_path, text, affine_field(np.eye(3), (0.01, 0.02, 0.0)), dialect)
    places = {"linuxcnc": ("10.01000", "-2.48000", "12.51000")}.get(dialect, ("10.010", "-2.480", "12.510"))
    assert after.endswith("G21\nG00 X {} Y\t{} Z 5.\r\nG01 X  {} F 100.\nM2\n".format(*places))


@pytest.mark.parametrize("word", ["X 1 5.", "X1 5.", "X - 5.", "X 1.5.2", "X"])
def test_a_number_with_blanks_in_it_stays_unknown_to_fanuc(word: str) -> None:
    assert Code.NC_WORD in {code for code, *_ in codes(f"{LATHE}G01 {word}", "fanuc-lathe")}


GROUPS = ["G0 G1 X1", "G1 G1 X1", "G17 G18", "G90 G91", "G21 G20", "G94 G93", "G40 G41", "G54 G55", "G96 G97 S1"]


@pytest.mark.parametrize("block", GROUPS)
def test_two_codes_of_one_group_are_an_error_where_the_control_stops(block: str, tmp_path: Path) -> None:
    linuxcnc, sinumerik = f"G21 F1\n{block}\nM2\n", f"G71 F1\n{block.replace('G20', 'G70').replace('G21', 'G71')}\nM2\n"
    file = tmp_path / "group.ngc"
    file.write_text(linuxcnc)
    with pytest.raises(ProgramRefusedError, match="same modal group"):
        interpret(file)
    for text, dialect in ((linuxcnc, "linuxcnc"), (sinumerik, "siemens")):
        with pytest.raises(TrueloopError) as refused:
            read_program(text.encode(), dialect).run()
        assert (refused.value.code, refused.value.place.line, refused.value.place.column) == (
            *(Code.NC_DUPLICATE, 2),
            block.index("G", 1) + 1,
        )


@pytest.mark.parametrize(
    "block", ["G80 G0 X1", "G90 G90.1 G17 G40 G49 G54 G64 P0 G94 G97 G8", "G0 G53 X1", "G98 G0 X1"]
)
def test_codes_of_different_groups_stand_together(block: str, tmp_path: Path) -> None:
    text = f"G21 F1\n{block}\nM2\n"
    file = tmp_path / "groups.ngc"
    file.write_text(text)
    interpret(file)
    assert not [found for found in codes(text, "linuxcnc") if found[0] is Code.NC_DUPLICATE]


@pytest.mark.parametrize(
    ("block", "x_mm"), [("G00 G01 X8.", 4.0), ("G90 X8. Z-1. G00", 4.0), ("G01 G00 X8.", 4.0), ("G98 G99 X8.", 4.0)]
)
def test_the_last_of_one_group_counts_for_fanuc_and_is_told(block: str, x_mm: float) -> None:
    text = f"{LATHE}{block} F.2"
    last = read_program(text.encode(), "fanuc-lathe").run()
    assert last.end_mm[-1, 0] == x_mm
    told = [found for found in codes(text, "fanuc-lathe") if found[0] is Code.NC_DUPLICATE]
    assert bool(told) == (block != "G90 X8. Z-1. G00")


def test_the_motion_of_fanuc_is_that_of_the_last_code() -> None:
    for block, rapid in (("G00 G01", False), ("G01 G00", True)):
        path = read_program(f"{LATHE}{block} X8.".encode(), "fanuc-lathe").run()
        assert path.rapid[-1] == rapid
    assert not [code for code, *_ in codes(f"{LATHE}G01 G01 X8.", "fanuc-lathe")]


@pytest.mark.parametrize(
    ("text", "dialect", "place"),
    [
        ("G21 S-5", "linuxcnc", (1, 5)),
        ("G21\nG1 X1 F-5", "linuxcnc", (2, 7)),
        ("G21\nG01 X1. F-5.", "fanuc-mill", (2, 9)),
        ("G21 G97\nS-500 M3", "haas-lathe", (2, 1)),
        ("G71 F=-R1\nG1 X1", "siemens", (1, 5)),
        ("0 BEGIN PGM A MM\n1 L X+1 F-100", "heidenhain", (2, 9)),
    ],
)
def test_a_feed_or_a_speed_below_zero_is_an_error(text: str, dialect: str, place: tuple[int, int]) -> None:
    text = text.replace("G71 F", "R1=5 G71 F")
    line, column = place[0], place[1] + 5 * ("R1=5" in text)
    assert (Code.NC_FEED, line, column) in codes(text, dialect)
    with pytest.raises(TrueloopError):
        read_program(text.encode(), dialect).run()


def test_arguments_of_a_macro_are_no_feed_and_no_speed() -> None:
    assert codes("G21 G65 P2 F-1. S-2.\nM30\nO2 G00 X#9\nM99", "fanuc-mill") == []


@pytest.mark.parametrize(("block", "column"), [("G04 X2. Z3.", 9), ("G04 P500 W1.", 10), ("G04 Z3.", 5)])
def test_a_coordinate_beside_a_dwell_is_told(block: str, column: int) -> None:
    assert (Code.NC_MISPLACED, 3, column) in codes(LATHE + block, "fanuc-lathe")
    assert codes(f"{LATHE}G04 U2.", "fanuc-lathe") == []


@pytest.mark.parametrize(("word", "column"), [("X=IC(5)+2", 6), ("X=2+IC(5)", 8), ("X=-IC(5)", 7), ("Y=AC(IC(5))", 9)])
def test_an_increment_inside_a_sum_is_an_error(word: str, column: int) -> None:
    text = f"G71 G17\nG0 {word}"
    program = read_program(text.encode(), "siemens")
    said = [found for found in program.run(strict=False).findings if found.severity is Severity.ERROR]
    assert [(found.code, found.place.line, found.place.column) for found in said] == [(Code.NC_EXPRESSION, 2, column)]
    assert codes("G71 G17\nG0 X=IC(5+2) Y=AC( (1)+2 )", "siemens") == []
