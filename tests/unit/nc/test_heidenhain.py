"""Klartext programs: words, edits of them, what is said of them."""

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.changes import insert_heading
from trueloop.nc.edit.edit import (
    apply_edits,
    coordinate_text,
    displace_word,
    insert_blocks_after,
    insert_word,
    replace_block,
)
from trueloop.nc.program.guess import guess_dialect
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import CoordinateState, Motion

STATE = CoordinateState(inch=False, diameter=False)


def klartext(text: str) -> Program:
    return read_program(text.encode(), "heidenhain", "part.h")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("12 L X+10.5 IY-5 R0 FMAX M3", ["N", "name L", "X", "Y", "name R0", "name FMAX", "M"]),
        ("13 C X+1 Y+2 DR- ; arc", ["N", "name C", "X", "Y", "name DR-"]),
        ("14 L C+90 Z+Q5 RL F200", ["N", "name L", "C", "Z", "name RL", "F"]),
        ("15 FN 1: Q1 = +Q2 + +5", ["N", "name FN 1:", "Q"]),
        ("16 CYCL DEF 200 DRILLING ~", ["N", "name CYCL DEF 200 DRILLING"]),
        ("17 CALL LBL 3 REP 2", ["N", "flow CALL LBL 3 REP 2"]),
        ("18 * - Roughing X+5", ["N"]),
    ],
)
def test_words(text: str, words: list[str]) -> None:
    found = klartext(text).block(0).words
    assert [word.letter or f"{word.kind} {word.text}" for word in found] == words


def test_an_edit_changes_the_number_and_nothing_else() -> None:
    program = klartext("12 L  X+10.50 Y-5 R0 FMAX ; X+10.50")
    edit = displace_word(program, program.word(2), 0.0124, STATE)
    assert edit is not None
    assert apply_edits(program, [edit]) == b"12 L  X+10.5124 Y-5 R0 FMAX ; X+10.50"


@pytest.mark.parametrize("text", ["1 L IX+5", "1 L X+Q5", "1 LP PR+5 PA+30"])
def test_what_is_no_number_of_a_position_is_not_moved(text: str) -> None:
    program = klartext(text)
    with pytest.raises(TrueloopError) as refused:
        displace_word(program, program.word(2), 0.1, STATE)
    assert refused.value.code == Code.NC_EDIT


def test_comments_are_written_without_numbers_and_moves_in_g_code_not_at_all() -> None:
    program = klartext("0 BEGIN PGM A MM\n1 L X+1\n")
    assert apply_edits(program, [insert_heading(program, ["; corrected"])]) == (
        b"0 BEGIN PGM A MM\n; corrected\n1 L X+1\n"
    )
    for write in (insert_blocks_after, replace_block):
        with pytest.raises(TrueloopError) as refused:
            write(program, 1, ["G01 X1 Z2"])
        assert refused.value.code == Code.NC_EDIT


def test_the_unit_and_what_is_rapid() -> None:
    path = klartext("0 BEGIN PGM A INCH\n1 L X+1 FMAX\n2 L X+2 F100\n3 L Y+1 F MAX").run()
    assert path.motion.tolist() == [Motion.RAPID, Motion.LINE, Motion.RAPID]
    assert path.end_mm[-1] == pytest.approx([50.8, 25.4, 0.0])


@pytest.mark.parametrize(
    ("label", "call"),
    [
        ("1", "1 REP 2"),
        ("1", "1 REP2"),
        ("1", "1 REP 2/2"),
        ('"REPAIR"', '"REPAIR" REP 2'),
        ('"PREP"', '"PREP" REP2/2 ; REP 9'),
    ],
)
def test_a_section_is_run_as_often_again_as_its_repetition_says(label: str, call: str) -> None:
    path = klartext(f"0 BEGIN PGM A MM\n1 LBL {label}\n2 L IX+1 F9\n3 CALL LBL {call}").run()
    assert path.end_mm[:, 0].tolist() == [1.0, 2.0, 3.0]


def test_a_label_with_rep_in_its_name_is_called_once() -> None:
    path = klartext('0 BEGIN PGM A MM\n1 CALL LBL "REP"\n2 L IX+5 F9 M30\n3 LBL "REP"\n4 L IX+1\n5 LBL 0').run()
    assert path.end_mm[:, 0].tolist() == [1.0, 6.0]


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("1 L X+Q7", Code.NC_PARAMETER, "parameter Q7 has no value"),
        ("1 FN 4: Q1 = +4 DIV +0", Code.NC_EXPRESSION, "division by zero"),
        ("1 Q1 = SQRT -4", Code.NC_EXPRESSION, "the function has no value at -4"),
        ("1 CALL LBL 7", Code.NC_FLOW, "there is no LBL 7 in this program"),
        ("1 CALL LBL 1 REP x\n2 LBL 1", Code.NC_FLOW, "the number of repetitions"),
        ("1 LBL 1\n2 CALL LBL 1 REP 2/1", Code.NC_FLOW, "the number of repetitions"),
        ("1 FN 9: IF +1 EQU +1", Code.NC_FLOW, "a comparison without a jump"),
        ("1 FN 9: IF +1 ~ +1 GOTO LBL 1", Code.NC_FLOW, "a comparison that is not known"),
        ("1 LBL 1\n2 CALL LBL 1", Code.NC_LIMIT, "more than 64 deep"),
        ("1 CYCL CALL M3", Code.NC_OPAQUE, "CYCL CALL M3: the moves of the cycle defined last are not in the path"),
        ("1 PLANE SPATIAL SPA0 SPB0", Code.NC_OPAQUE, "the path goes on as if it were not there"),
        ("1 L A+90 FMAX", Code.NC_OPAQUE, "A+90: this axis is not in the path"),
        ("1 L X+1 M99", Code.NC_OPAQUE, "M99: the moves of the cycle defined last are not in the path"),
        ("1 FL X+1", Code.NC_WORD, "is no word of the dialect heidenhain"),
    ],
)
def test_what_is_said_of_a_program(text: str, code: Code, message: str) -> None:
    program = klartext(text)
    found = [*program.findings, *program.run(strict=False, block_limit=1000).findings]
    assert any(finding.code == code and message in finding.message for finding in found), found


def test_the_dialect_is_guessed() -> None:
    assert guess_dialect(b"0 BEGIN PGM A MM\n1 L X+1 R0 FMAX\n2 END PGM A MM") == "heidenhain"


@pytest.mark.parametrize(("text", "value"), [("X+10,5", 10.5), ("IX-0,25", -0.25), ("X+10.5", 10.5), ("PR7,5", 7.5)])
def test_a_comma_may_be_the_decimal_point(text: str, value: float) -> None:
    program = klartext(f"1 L {text} F100")
    assert (program.block(0).words[2].value, program.findings) == (value, ())


def test_the_coordinates_of_a_pole_are_the_plane_of_its_arcs() -> None:
    """A quarter turn down into the material, in ZX, and one on in XY."""
    path = klartext(
        "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z\n2 L X+155.3 Y-168 Z-3.6 F1\n3 CC X+156.7 Z-3.6\n4 CP IPA-90 DR-\n"
        "5 L X+158.1\n6 CC X+158.1 Y-166.6\n7 CP IPA+90 DR+"
    ).run()
    assert path.end_mm[1] == pytest.approx([156.7, -168.0, -5.0])
    assert path.end_mm[3] == pytest.approx([159.5, -166.6, -5.0])
    assert path.plane[[1, 3]].tolist() == [18, 17]


def test_a_retraction_along_the_tool_is_said() -> None:
    path = klartext("BEGIN PGM A MM\n2 L X+1 Z-5 F9\n3 L M140 MB MAX\n4 L X+2 M140 MB5 F9").run()
    assert path.end_mm[1].tolist() == [1.0, 0.0, 0.0]
    assert [(one.place.line, one.code, one.message) for one in path.findings][:2] == [
        (3, Code.NC_OPAQUE, "M140 MB MAX: the limit of travel is the machine's, taken as its zero"),
        (4, Code.NC_OPAQUE, "M140 MB5 F9: what it does is not in the path"),
    ]


@pytest.mark.parametrize(
    ("block", "letter", "wanted"),
    [
        ("7 L X+2 R0 FMAX M3", "Y", "7 L X+2 Y+1.5000 R0 FMAX M3"),
        ("7 L Z+2 F100", "X", "7 L X+1.5000 Z+2 F100"),
        ("L Y+2 RL", "Z", "L Y+2 Z+1.5000 RL"),
    ],
)
def test_a_coordinate_is_written_behind_the_function_and_the_axes_before_it(
    block: str, letter: str, wanted: str
) -> None:
    """The control wants coordinates before compensation, feed and M."""
    program = klartext(f"BEGIN PGM A MM\n{block}\n")
    edit = insert_word(program, 1, letter, 1.5, STATE)
    assert apply_edits(program, [edit]).decode().splitlines()[1] == wanted


@pytest.mark.parametrize(("old", "new"), [("X+2,5", "X+2,5020"), ("X-0,001", "X+0,0010")])
def test_what_is_written_has_the_signs_and_the_comma_of_the_program(old: str, new: str) -> None:
    program = klartext(f"1 L Y+3,0 {old} F100")
    edit = displace_word(program, program.block(0).words[3], 0.002, STATE)
    assert edit is not None and apply_edits(program, [edit]).decode() == f"1 L Y+3,0 {new} F100"
    assert coordinate_text(program.dialect, "Z", 1.25, STATE) == "Z+1,2500"
