"""Edits: only the intended bytes change, and the number written is the one meant."""

from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.changes import verify_written
from trueloop.nc.edit.edit import (
    Edit,
    apply_edits,
    coordinate_text,
    displace_word,
    insert_blocks_after,
    insert_word,
    replace_block,
    set_offset,
)
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.program import Program, Word, read_program
from trueloop.nc.program.tool_path import CoordinateState

INCH_DIAMETER = CoordinateState(inch=True, diameter=True)
INCH_RADIUS = CoordinateState(inch=True, diameter=False)
MM_DIAMETER = CoordinateState(inch=False, diameter=True)
MM_RADIUS = CoordinateState(inch=False, diameter=False)


def word_of(text: str, dialect: str = "ge2000t") -> tuple[Program, Word]:
    program = read_program(text.encode(), dialect)
    return program, program.block(0).words[-1]


def displaced(text: str, delta_mm: float, state: CoordinateState, dialect: str = "ge2000t") -> str | None:
    program, word = word_of(text, dialect)
    edit = displace_word(program, word, delta_mm, state)
    return None if edit is None else apply_edits(program, [edit]).decode()


@pytest.mark.parametrize(
    ("old", "delta_in", "new"),
    [
        ("Z00.03125", -0.00113, "Z00.03012"),
        ("Z-.06250", 0.001, "Z-.06150"),
        ("Z-.06250", 0.1, "Z.03750"),
        ("Z+1.5", 0.00002, "Z+1.50002"),
        ("Z+1.5", -2.0, "Z-0.50000"),
        ("Z-1.46", 0.00172, "Z-1.45828"),
        ("Z0", 0.25, "Z0.25000"),
        ("Z10.5", -1.0, "Z9.50000"),
        ("Z09.5", 1.0, "Z10.50000"),
        ("Z0.000001", 0.00001, "Z0.000011"),
        ("Z1.", 0.5, "Z1.50000"),
        ("Z-0.00002", 0.00002, "Z0.00000"),
        ("Z6,2625", 0.001, "Z6.26350"),
    ],
)
def test_a_plain_number_keeps_its_style(old: str, delta_in: float, new: str) -> None:
    """Sign habit, leading zeros and decimals stay; no fewer than the control resolves (1e-5 in) or the word has."""
    assert displaced(f"N10 G01 {old}", delta_in * 25.4, INCH_DIAMETER) == f"N10 G01 {new}"


@pytest.mark.parametrize(
    ("old", "dialect", "new"),
    [
        ("Z(P46+0.0625)", "ge2000t", "Z(P46+0.0625-0.00172)"),
        ("Z(-6.44375+(3.6-P46)/2)", "ge2000t", "Z(-6.44375+(3.6-P46)/2-0.00172)"),
        ("Z((1+P46)/(2+P47))", "ge2000t", "Z((1+P46)/(2+P47)-0.00172)"),
        ("Z[#1+2]", "linuxcnc", "Z[#1+2-0.00172]"),
        ("Z#1", "linuxcnc", "Z[#1-0.00172]"),
        ("Z-#<depth>", "linuxcnc", "Z[-#<depth>-0.00172]"),
        ("Z-[#1+2]", "linuxcnc", "Z[-[#1+2]-0.00172]"),
        ("ZSIN[30]", "linuxcnc", "Z[SIN[30]-0.00172]"),
        ("Z[1 LT 2]", "linuxcnc", "Z[[1 LT 2]-0.00172]"),
        ("Z[1]", "linuxcnc", "Z[1-0.00172]"),
    ],
)
def test_into_an_expression_goes_a_term(old: str, dialect: str, new: str) -> None:
    assert displaced(f"G1 {old}", -0.00172 * 25.4, INCH_RADIUS, dialect) == f"G1 {new}"


@pytest.mark.parametrize(
    ("state", "written"),
    [(INCH_DIAMETER, "X2.20000"), (INCH_RADIUS, "X2.10000"), (MM_DIAMETER, "X7.0800"), (MM_RADIUS, "X4.5400")],
)
def test_delta_is_on_the_radius_whatever_x_means(state: CoordinateState, written: str) -> None:
    """2.54 mm on the radius: 0.1 in, 0.2 in on the diameter; 2.54 mm, 5.08 mm on the diameter."""
    assert displaced("G01 X2.0", 2.54, state) == f"G01 {written}"


@pytest.mark.parametrize("letter", ["Z", "I", "K", "R"])
def test_only_x_is_a_diameter(letter: str) -> None:
    assert displaced(f"G02 {letter}2.0", 2.54, INCH_DIAMETER) == f"G02 {letter}2.10000"


def test_a_displacement_that_rounds_to_nothing_is_no_edit() -> None:
    assert displaced("G01 X2.0", 0.49e-5 * 12.7, INCH_DIAMETER) is None
    assert displaced("G01 X2.0", 0.51e-5 * 12.7, INCH_DIAMETER) == "G01 X2.00001"
    assert displaced("G01 Z(P46)", 0.49e-5 * 25.4, INCH_DIAMETER) is None
    assert displaced("G01 X2.000004", 0.0, INCH_DIAMETER) is None


def test_increments_are_not_displaced() -> None:
    with pytest.raises(TrueloopError) as refused:
        displaced("G91 G01 X2.0", 1.0, CoordinateState(inch=True, diameter=True, incremental=True))
    assert refused.value.code is Code.NC_EDIT
    assert refused.value.place.column == 9


@given(
    whole=st.integers(0, 999),
    decimals=st.text("0123456789", max_size=7),
    sign=st.sampled_from(["", "-", "+"]),
    delta_mm=st.floats(-1, 1),
    state=st.sampled_from([INCH_DIAMETER, INCH_RADIUS, MM_DIAMETER, MM_RADIUS]),
    dialect=st.sampled_from(["ge2000t", "linuxcnc"]),
)
def test_the_number_written_is_the_sum_within_half_a_step(
    whole: int, decimals: str, sign: str, delta_mm: float, state: CoordinateState, dialect: str
) -> None:
    text = f"G01 X{sign}{whole}.{decimals}"
    new = displaced(text, delta_mm, state, dialect)
    program, _ = word_of(text, dialect)
    step = program.dialect.resolution_inch if state.inch else program.dialect.resolution_mm
    delta = delta_mm / state.unit_mm("X")
    if new is None:
        assert abs(delta) <= step / 2 * (1 + 1e-9)
    else:
        exact = Decimal(f"{sign}{whole}.{decimals}") + Decimal(delta_mm) / Decimal(state.unit_mm("X"))
        assert abs(Decimal(new.removeprefix("G01 X")) - exact) <= Decimal(step) / 2 * Decimal(1 + 1e-9)


@given(value=st.floats(-9, 9), delta_mm=st.floats(-0.1, 0.1), dialect=st.sampled_from(["ge2000t", "linuxcnc"]))
def test_a_term_moves_the_path_by_the_displacement(value: float, delta_mm: float, dialect: str) -> None:
    text, name = ("G70 G00 X(P46*2)", "P46") if dialect == "ge2000t" else ("G20 G7 G0 X[#1*2]", "#1")
    program = read_program(text.encode(), dialect)
    before = program.run({name: value})
    word = program.word(int(before.word[0, 0]))
    edit = displace_word(program, word, delta_mm, before.coordinate_state(0))
    after = read_program(apply_edits(program, [edit] if edit else []), dialect).run({name: value})
    step_mm = program.dialect.resolution_inch * 12.7
    assert after.end_mm[0, 0] - before.end_mm[0, 0] == pytest.approx(delta_mm, abs=step_mm / 2 * (1 + 1e-6))


def test_edits_touch_nothing_else() -> None:
    source = b"N10 G01 X1.0 ! caf\xe9\r\n\x00%\r\nN20 Z2.0  \r\n"
    program = read_program(source, "ge2000t")
    word = program.block(0).words[2]
    edits = [Edit(word.value_start, word.end, "1.5"), Edit(len(source), len(source), "N30\r\n")]
    assert apply_edits(program, edits) == b"N10 G01 X1.5 ! caf\xe9\r\n\x00%\r\nN20 Z2.0  \r\nN30\r\n"
    assert apply_edits(program, []) == source


@pytest.mark.parametrize("edits", [[Edit(0, 4, ""), Edit(3, 5, "")], [Edit(5, 99, "")], [Edit(3, 2, "")]])
def test_edits_that_overlap_or_lie_outside_are_refused(edits: list[Edit]) -> None:
    with pytest.raises(TrueloopError) as refused:
        apply_edits(read_program(b"G00 X1.0", "ge2000t"), edits)
    assert refused.value.code is Code.NC_EDIT


@pytest.mark.parametrize(
    ("letter", "value_mm", "state", "text"),
    [
        ("X", 37.87775, INCH_DIAMETER, "X2.98250"),
        ("X", 37.87775, INCH_RADIUS, "X1.49125"),
        ("Z", -0.00001, MM_DIAMETER, "Z0.0000"),
        ("I", -31.147258, INCH_DIAMETER, "I-1.22627"),
    ],
)
def test_coordinate_words(letter: str, value_mm: float, state: CoordinateState, text: str) -> None:
    assert coordinate_text(dialect_named("ge2000t"), letter, value_mm, state) == text


@pytest.mark.parametrize(
    ("old", "letter", "new"),
    [
        ("N10 G01 Z2.0 F1", "X", "N10 G01 X0.20000 Z2.0 F1"),
        ("N10 G01 X2.0 F1", "Z", "N10 G01 X2.0 Z0.10000 F1"),
        ("N10 G01 F1 X2.0", "Z", "N10 G01 F1 X2.0 Z0.10000"),
        ("N10G01Z2.0", "X", "N10G01X0.20000Z2.0"),
        ("Z2.0 ! here", "X", "X0.20000 Z2.0 ! here"),
        ("N10 G01", "X", "N10 G01 X0.20000"),
        ("! nothing", "X", "X0.20000 ! nothing"),
    ],
)
def test_an_inherited_coordinate_is_written_into_its_block(old: str, letter: str, new: str) -> None:
    program = read_program(old.encode(), "ge2000t")
    edit = insert_word(program, 0, letter, 2.54, INCH_DIAMETER)
    assert apply_edits(program, [edit]).decode() == new


def test_new_blocks_follow_the_numbering_and_the_line_ends() -> None:
    program = read_program(b"N0410 G01 Z1\r\nN0420 G02 X0 ! Dome\r\n\r\nN0430 M30\r\n", "ge2000t")
    three = apply_edits(program, [insert_blocks_after(program, 1, ["G01 X1", "G01 X2", "G01 X3"])])
    assert three == (
        b"N0410 G01 Z1\r\nN0420 G02 X0 ! Dome\r\nN0421 G01 X1\r\nN0422 G01 X2\r\nN0423 G01 X3\r\n\r\nN0430 M30\r\n"
    )
    ten = apply_edits(program, [insert_blocks_after(program, 1, ["G01"] * 10)])
    assert ten.count(b"N") == 3 and ten.count(b"\r\nG01\r\n") == 5
    after_all = read_program(b"N5 G01 X1", "ge2000t")
    assert apply_edits(after_all, [insert_blocks_after(after_all, 0, ["X2"])]) == b"N5 G01 X1\nN6 X2"


def test_programs_without_numbers_stay_so() -> None:
    program = read_program(b"G1 X1\nG1 X2\n", "linuxcnc")
    assert apply_edits(program, [insert_blocks_after(program, 0, ["X1.5"])]) == b"G1 X1\nX1.5\nG1 X2\n"


def test_a_replaced_block_keeps_number_slash_and_comments() -> None:
    program = read_program(b"/N0420 G02 X0 Z1 R2 ! Dome\nN0430 M30\n", "ge2000t")
    new = apply_edits(program, [replace_block(program, 0, ["G01 X2", "G01 X1", "G01 X0"])])
    assert new == b"/N0420 G01 X2 ! Dome\nN0421 G01 X1\nN0422 G01 X0\nN0430 M30\n"
    program = read_program(b"N5 G2 (to) X0 Z1 (the dome) R2 ; end\n", "linuxcnc")
    new = apply_edits(program, [replace_block(program, 0, ["G1 X0"])])
    assert new == b"N5 G1 X0 (to) (the dome) ; end\n"


OFFSETS = b"N0310 (UPD, 1, TOV(X), 0.00000)\nN0320 (UPD, 1, TOV(Z), -0.00010)\nN0330 (UPD,2,TOV(X),0.1)\n"


def test_offset_statements_are_found() -> None:
    program = read_program(OFFSETS, "ge2000t")
    found = [(s.tool, s.axis, s.value, s.line) for s in program.offset_statements]
    assert found == [(1, "X", 0.0, 1), (1, "Z", -0.0001, 2), (2, "X", 0.1, 3)]


@pytest.mark.parametrize(
    ("axis", "tool", "diameter", "line"),
    [
        ("X", 1, None, b"N0310 (UPD, 1, TOV(X), -0.00200)"),
        ("X", 1, True, b"N0310 (UPD, 1, TOV(X), -0.00200)"),
        ("X", 1, False, b"N0310 (UPD, 1, TOV(X), -0.00100)"),
        ("Z", None, None, b"N0320 (UPD, 1, TOV(Z), -0.00100)"),
        ("X", 2, False, b"N0330 (UPD,2,TOV(X),-0.00100)"),
    ],
)
def test_an_offset_is_set(axis: str, tool: int | None, diameter: bool | None, line: bytes) -> None:
    """−0.001 in on the radius; twice that where the control takes X offsets as diameters."""
    program = read_program(OFFSETS, "ge2000t")
    edit = set_offset(program, axis, -0.0254, INCH_DIAMETER, tool=tool, diameter=diameter)
    changed = set(apply_edits(program, [edit]).splitlines()) - set(OFFSETS.splitlines())
    assert changed == {line}


def test_which_offset_must_be_clear() -> None:
    program = read_program(OFFSETS, "ge2000t")
    with pytest.raises(TrueloopError) as refused:
        set_offset(program, "X", 0.1, INCH_DIAMETER)
    assert refused.value.code is Code.NC_OFFSET


def test_comments_are_written_as_the_dialect_has_them() -> None:
    assert dialect_named("ge2000t").comment("corrected\nonce") == "! corrected once"
    assert dialect_named("linuxcnc").comment("once (and for all)") == "(once [and for all])"


def test_a_coordinate_that_no_control_could_go_to_is_refused() -> None:
    with pytest.raises(TrueloopError, match="1e16 is further than a control could go") as refused:
        coordinate_text(dialect_named("linuxcnc"), "X", 1e16, MM_RADIUS)
    assert refused.value.code == Code.NC_EDIT


def test_who_writes_u_on_a_lathe_is_not_told_to_write_g90_which_cuts() -> None:
    program = read_program(b"G21\nG00 X20. Z5.\nG01 U10. F.1", "fanuc-lathe")
    word = next(word for word in program.block(2).words if word.letter == "U")
    with pytest.raises(TrueloopError) as refused:
        displace_word(program, word, -0.0072989204, CoordinateState(inch=False, diameter=True))
    assert refused.value.message == "U10. is an increment: moving it by -0.007299 mm would move all that follows"
    assert refused.value.hint == "program the contour by positions: X in place of U"


WRITTEN = "G21 G90 G17\nG1 X10. F100.\nG2 I5.\nG1 X0.\n"


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("X10.", "X10.001", "line 2 of the written program ends 1.00 µm from"),
        ("I5.", "I5.002", "line 3 of the written program ends 2.00 µm from"),
        ("G1 X0.", "G0 X0.", "line 4 of the written program makes another move"),
        ("G2 I5.", "G3 I5.", "line 3 of the written program turns another way"),
        ("X10.", "T2 M6 X10.", "line 2 of the written program has another tool"),
        ("G1 X0.", "G1 X0. F90.", "line 4 of the written program has another feed"),
    ],
)
def test_a_move_that_is_written_otherwise_is_named(old: str, new: str, what: str) -> None:
    before, after = (read_program(text.encode(), "fanuc-mill").run() for text in (WRITTEN, WRITTEN.replace(old, new)))
    moves = np.arange(len(before))
    verify_written(before, before, (moves, moves), before.end_mm, allowed_mm=1e-9)
    with pytest.raises(TrueloopError, match=what) as refused:
        verify_written(before, after, (moves, moves), before.end_mm, allowed_mm=0.5e-3)
    assert refused.value.code is Code.CMP_READ_BACK
