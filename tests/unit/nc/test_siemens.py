"""Sinumerik programs: words, edits of them, what is said of them."""

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import apply_edits, circle_text, displace_word
from trueloop.nc.program.guess import guess_dialect
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import CoordinateState

RADIUS = CoordinateState(inch=False, diameter=False)


def siemens(text: str) -> Program:
    return read_program(text.encode(), "siemens", "part.mpf")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("N10 G1 X=R1+10 Y-5 F=R2", ["N10:number", "G1:number", "X=R1+10:expression", "Y-5:number", "F=R2:expression"]),
        ("G2X5Y=6 CR=2.5", ["G2:number", "X5:number", "Y=6:number", "CR=2.5:number"]),
        ("R1=2 R[R1+1]= R1 * 2 ; R9=1", ["R1=2:assignment", "R[R1+1]= R1 * 2:assignment"]),
        ('AGAIN: X=IC(5) MSG("a;b)")', ["AGAIN::label", "X=IC(5):expression", 'MSG("a;b)"):name']),
        ("N5 IF R1 == 2 GOTOF AGAIN ; x", ["N5:number", "IF R1 == 2 GOTOF AGAIN:flow"]),
        ("POCKET(5, R1) L100 P2", ["POCKET(5, R1):call", "L100:number", "P2:number"]),
        ('T="MILL 10" D1 M1=3', ['T="MILL 10":expression', "D1:number", "M1=3:number"]),
        ("X R1", ["X R1:expression"]),
        ("X10 !5 MSG(", ["X10:number", "!5:unknown", "MSG(:unknown"]),
    ],
)
def test_words(text: str, words: list[str]) -> None:
    assert [f"{word.text}:{word.kind}" for word in siemens(text).block(0).words] == words


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("G1 X10.5 F5", "G1 X10.5124 F5"),
        ("G1 X = 10 F5", "G1 X = 10.0124 F5"),
        ("G1 X=R1+10 F5", "G1 X=R1+10+0.0124 F5"),
        ("G1 X=AC( R1 ) F5", "G1 X=AC( R1 +0.0124) F5"),
        ("G1 X=(R1 + 1)*2;F5", "G1 X=(R1 + 1)*2+0.0124;F5"),
        ("G1 X=R1 B_AND 6", "G1 X=((R1 B_AND 6)+0.0124)"),
    ],
)
def test_an_edit_changes_the_value_and_nothing_else(before: str, after: str) -> None:
    program = siemens(before)
    word = next(word for word in program.block(0).words if word.letter == "X")
    edit = displace_word(program, word, 0.0124, RADIUS)
    assert edit is not None
    assert apply_edits(program, [edit]).decode() == after
    given = "G71 G90 R1=7\n"
    at = [siemens(given + text).run().end_mm[-1, 0] for text in (before, after)]
    assert at[1] - at[0] == pytest.approx(0.0124, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "word"), [("G90 X=IC(5)", 1), ("G91 X5", 1), ("G1 AP=30 RP=5", 1), ("G1 X5 ANG=30", 2)]
)
def test_what_is_no_position_is_not_moved(text: str, word: int) -> None:
    program = siemens(text)
    with pytest.raises(TrueloopError) as refused:
        displace_word(program, program.word(word), 0.1, CoordinateState(False, False, incremental="G91" in text))
    assert refused.value.code == Code.NC_EDIT


def test_a_position_is_moved_though_increments_are_in_force() -> None:
    program = siemens("G91 X=AC(5)")
    edit = displace_word(program, program.word(1), 0.1, CoordinateState(False, False, incremental=True))
    assert edit is not None
    assert apply_edits(program, [edit]) == b"G91 X=AC(5.1000)"


def test_diameters_of_positions_are_radii_in_increments() -> None:
    path = siemens("G18 G71 DIAM90 G1 X10 F1\nX=IC(1)\nG91 X1\nDIAMON X1\nDIAMOF X1").run()
    assert path.end_mm[:, 0] == pytest.approx([5.0, 6.0, 7.0, 7.5, 8.5])


def test_the_radius_of_an_arc_is_written_as_the_control_reads_it() -> None:
    circle = np.array([1.5, 0.0, 0.0]), np.zeros(3)
    assert circle_text(siemens(""), RADIUS, (0, 1), *circle, by_radius=True) == "CR=1.5000"
    assert circle_text(siemens(""), RADIUS, (1, 0), *circle, by_radius=False) == "I1.5000 J0.0000"


def test_sections_and_blocks_are_repeated_by_their_labels() -> None:
    """A to B once and twice more; B three times more; C to ENDLABEL, which was jumped over, twice."""
    start = "G71 G90 G0 X0 Y0\nA: G91 X1\nB: Y2\n"
    assert siemens(start + "REPEAT A B P=2\nREPEATB B P=3\nM30").run().end_mm[-1, :2] == pytest.approx([3.0, 12.0])
    jumped = "G71 G90 G0 X0 Y0\nGOTOF GO\nC: G91 X1\nENDLABEL: Y1\nGO: REPEAT C P=2\nM30"
    assert siemens(jumped).run().end_mm[-1, :2] == pytest.approx([2.0, 2.0])


def test_expressions_follow_the_order_of_the_manual() -> None:
    path = siemens("R1=1 R2=3 R3=7 DIV 2+7 MOD 4\nG71 G0 X=R3 Y=(R1>0) AND (R2>5) Z=NOT (R1==1) OR (R2<>1)").run()
    assert path.end_mm[0] == pytest.approx([6.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        ("G71 G0 X=R1", Code.NC_PARAMETER, "parameter R1 has no value"),
        ("G71 G0 X=DEPTH", Code.NC_PARAMETER, "parameter DEPTH has no value"),
        ("G71 G0 X=FOO(1)", Code.NC_EXPRESSION, "unknown function foo"),
        ("G71\nTOOLCHANGE(5)", Code.NC_WORD, '"TOOLCHANGE" is no word of the dialect siemens and no program'),
        ("G71\nL900", Code.NC_WORD, '"L900" is no word of the dialect siemens and no program'),
        ("G71\nWHILE 1", Code.NC_FLOW, '"WHILE" without its end'),
        ("G71\nENDIF", Code.NC_FLOW, 'the end of "ENDIF" without its beginning'),
        ("G71\nA:\nGOTOF A", Code.NC_FLOW, 'there is no "A" to jump to that way'),
        ("G71\nFOR R1=1", Code.NC_FLOW, "FOR"),
        ("G71\nREPEATB B P=3", Code.NC_FLOW, "what is to be repeated"),
        ("G71\nROT X45", Code.NC_OPAQUE, "ROT X45: the path goes on as if it were not there"),
        (
            "G71\n$P_UIFR[1]=CTRANS(X,10)",
            Code.NC_OPAQUE,
            "$P_UIFR[1]=CTRANS(X,10): the path goes on as if it were not there",
        ),
        ("G71\n$P_PFRAME[X,TR]=10", Code.NC_OPAQUE, "$P_PFRAME[X,TR]=10: the path goes on as if it were not there"),
        (
            "G71\nDEF FRAME TILT\nTILT=CROT(Z,30)",
            Code.NC_OPAQUE,
            "TILT=CROT(Z,30): the path goes on as if it were not there",
        ),
        ("G71\nCYCLE800(0,1)", Code.NC_OPAQUE, "CYCLE800(0,1): the path goes on as if it were not there"),
        ("G71\nPOCKET3(10,0,2,-5)", Code.NC_OPAQUE, "POCKET3(10,0,2,-5): what it does is not in the path"),
        ("G71 G0 X1=5", Code.NC_OPAQUE, "X1=5: this axis is not in the path"),
        ("G71 DIAMON\nTRANS X5", Code.NC_OPAQUE, "X of the shift is taken as a radius"),
        ("G71 G1 X5 Y5 ANG=30 F1", Code.NC_OPAQUE, "an angle beside both coordinates of the end"),
        ("G71 CT X5 Y5", Code.NC_ARC, "a tangent arc without a move before it"),
        ("G71 CIP X5 Y5 I1=2 J1=2", Code.NC_ARC, "an arc through a point"),
        ("G71 G2 X5 AR=400", Code.NC_ARC, "an arc of 400.00000 degrees"),
    ],
)
def test_what_is_said_of_a_program(text: str, code: Code, message: str) -> None:
    program = siemens(text)
    found = [*program.findings, *program.run(strict=False, block_limit=1000).findings]
    assert any(finding.code == code and message in finding.message for finding in found), found
    assert all(finding.place.line for finding in found)


@pytest.mark.parametrize("text", ["N10 G1 X=R1+10 F100 ; to the face\nN20 DIAMON\nM30", "%_N_A_MPF\nG71\nCR=5\nM17"])
def test_the_dialect_is_guessed(text: str) -> None:
    assert guess_dialect(text.encode()) == "siemens"


@pytest.mark.parametrize(
    ("word", "value"), [("X10", "10"), ("X1.5", "1.5"), ("X0", "0"), ("X1=5", "5"), ("S1500", "1500"), ("CR=4", "4")]
)
def test_a_value_begins_behind_its_address(word: str, value: str) -> None:
    """`X1.5` is X and 1.5; with an equals sign X1 is an axis of that name."""
    program = read_program(f"G1 {word}\n".encode(), "siemens")
    found = program.block(0).words[1]
    assert program.source[found.value_start : found.end].decode() == value


def test_a_plain_coordinate_is_displaced_as_a_whole() -> None:
    program = read_program(b"G71 G90 G1 X12.500 F100\n", "siemens")
    edit = displace_word(program, program.block(0).words[3], 0.1, program.run().coordinate_state(0))
    assert edit is not None
    assert apply_edits(program, [edit]) == b"G71 G90 G1 X12.6000 F100\n"


def test_an_error_is_told_behind_a_thousand_notes() -> None:
    program = siemens("G71 G90\n" + "CYCLE90(10,0,2,-5)\n" * 1001 + "G1 X=R5 F100")
    found = program.run(strict=False).findings
    assert sum(one.code is Code.NC_OPAQUE for one in found) == 1000
    assert found[-1].code is Code.NC_PARAMETER


def test_an_axis_that_is_not_in_the_path_is_told_once() -> None:
    found = siemens("G71 G90\nG1 X5 C10 F100\nC20\nA5\nC30").run(strict=False).findings
    told = [(one.place.line, one.message) for one in found if one.code is Code.NC_OPAQUE]
    assert told == [(2, "C10: this axis is not in the path"), (4, "A5: this axis is not in the path")]
