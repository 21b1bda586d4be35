"""Reading: blocks and words as spans, what is said of them, what is refused."""

import pytest

from trueloop.errors import Code, Place, Severity, TrueloopError
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Program, Word, read_program


def words(text: str, dialect: str = "ge2000t") -> list[tuple[str, str, str]]:
    program = read_program(text.encode("latin-1"), dialect)
    return [(w.letter, w.kind, w.text) for block in program.blocks for w in block.words]


def test_the_dialects() -> None:
    assert set(DIALECTS) == {
        "ge2000t",
        "linuxcnc",
        "fanuc-lathe",
        "fanuc-lathe-b",
        "fanuc-mill",
        "haas-lathe",
        "haas-mill",
        "siemens",
        "heidenhain",
        "okuma-lathe",
        "mazak-lathe",
        "mitsubishi-mill",
    }


def test_words_of_a_ge_2000t_block() -> None:
    found = words("/N0350 G01 F.005 X(P46+2.2) Z-6.5! To collar X1")
    assert [text for _, _, text in found] == ["N0350", "G01", "F.005", "X(P46+2.2)", "Z-6.5"]
    assert [kind for _, kind, _ in found] == ["number", "number", "number", "expression", "number"]
    assert words("(UPD, 1, TOV(X), 0.0) P42=(P42-0.02) P1=.15") == [
        ("", "statement", "(UPD, 1, TOV(X), 0.0)"),
        ("P", "assignment", "P42=(P42-0.02)"),
        ("P", "assignment", "P1=.15"),
    ]


def test_words_of_a_linuxcnc_block() -> None:
    text = "n1g1x1y-[#1+2]z#<a b>(c)#1=5 #<d> = [1] s sin[3] ; z9"
    assert [word for _, _, word in words(text, "linuxcnc")] == [
        *("n1", "g1", "x1", "y-[#1+2]", "z#<a b>", "#1=5", "#<d> = [1]", "s sin[3]")
    ]
    assert words("o<sub> call [1] [2] (x)", "linuxcnc") == [("O", "flow", "o<sub> call [1] [2]")]


def test_a_word_knows_its_place_and_value() -> None:
    program = read_program(b"G70\r\n  N20 X +1.5 P7=(2)\r\n", "ge2000t", "a.nc")
    block = program.block(1)
    assert (block.line, block.number, block.start, block.end, block.skipped) == (2, 20, 5, 24, False)
    number, *_, assignment = block.words
    assert (number.line, number.column, number.value, number.is_expression) == (2, 3, 20.0, False)
    assert program.source[assignment.value_start : assignment.end] == b"(2)"
    assert program.place(assignment.start) == Place("a.nc", 2, 14)
    assert isinstance(program.word(0), Word)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_byte_order_mark_is_no_part_of_the_first_word(dialect: str) -> None:
    program = read_program("N1 G1 X5\nX6".encode("utf-8-sig"), dialect)
    assert [word.text for word in program.block(0).words][-1] == "X5"
    assert program.block(0).words[0].column == 1
    assert [(block.line, block.start) for block in program.blocks] == [(1, 3), (2, 12)]


def test_a_colon_is_the_o_of_a_program_s_number() -> None:
    text = "%\n:1000(PLATE)\nG21G90\nM98P2000\nM30\n:2000\nG1X5.F1.\nM99\n%\n"
    for dialect in ("fanuc-mill", "haas-mill", "fanuc-lathe"):
        program = read_program(text.encode(), dialect)
        assert [word.letter for word in program.block(1).words] == ["O"]
        path = program.run()
        assert path.line.tolist() == [7] and not [found for found in path.findings if found.code != Code.NC_UNIT]


def test_slash_blocks_are_known() -> None:
    program = read_program(b"/N10 G00 X1\nN20 G00 X2\n / N30\n", "ge2000t")
    assert [block.skipped for block in program.blocks] == [True, False, True]


def codes(program: Program) -> list[tuple[int | None, int | None, str]]:
    return [(f.place.line, f.place.column, f.code.value) for f in program.findings]


@pytest.mark.parametrize(
    ("text", "dialect", "found"),
    [
        ("G00 X1.0 hello X2", "ge2000t", [(1, 10, "NC-WORD"), (1, 16, "NC-DUPLICATE")]),
        ("X(1+2", "ge2000t", [(1, 1, "NC-WORD")]),
        ("X(1+2 Z3 ! ok)", "ge2000t", [(1, 1, "NC-WORD")]),
        ("(UPD, 1", "ge2000t", [(1, 1, "NC-WORD")]),
        ("(not closed", "linuxcnc", [(1, 1, "NC-WORD")]),
        ("G1 X", "linuxcnc", [(1, 4, "NC-WORD")]),
        ("#1 #2=", "linuxcnc", [(1, 1, "NC-WORD"), (1, 4, "NC-WORD")]),
        ("G1 X1 ?2", "linuxcnc", [(1, 7, "NC-WORD")]),
        ("G99.9 M999", "linuxcnc", [(1, 1, "NC-CODE"), (1, 7, "NC-CODE")]),
        ("G1 X1.5.5", "linuxcnc", [(1, 4, "NC-WORD")]),
        ("G0 G90 M3 M8 X1", "linuxcnc", []),
        ("G01 V1", "ge2000t", [(1, 5, "NC-WORD")]),
        ("% G00 what", "ge2000t", []),
    ],
)
def test_what_is_not_known_is_said_and_kept(text: str, dialect: str, found: list[tuple[int, int, str]]) -> None:
    program = read_program(text.encode(), dialect)
    assert codes(program) == found
    assert program.source == text.encode()


def test_a_megabyte_of_nonsense_gives_a_thousand_findings() -> None:
    assert len(read_program(b"?? " * 300_000, "ge2000t").findings) == 1000


def test_parameters_used() -> None:
    program = read_program(b"G70 X(P46+P7/P46) Z((P8)) P9=(P10) P11=3 G81 P1=2\nP8", "ge2000t")
    assert program.parameters_used() == ("P46", "P7", "P8", "P10")
    program = read_program(b"#1=#2 G1 X[#<a>+#[#3]]", "linuxcnc")
    assert program.parameters_used() == ("#2", "#<a>", "#3")
    program = read_program(b"o1 if [#4 LT ##5]\no1 endif", "linuxcnc")
    assert program.parameters_used() == ("#4", "#5")


def test_every_parameter_without_a_value_is_found_once() -> None:
    program = read_program(b"G70\nG00 X(P46) Z(P47+P46)\nG01 X(P48) F(P46)\n", "ge2000t", "a.nc")
    missing = [f for f in program.run(strict=False).findings if f.code is Code.NC_PARAMETER]
    assert [(f.place.line, f.place.column) for f in missing] == [(2, 7), (2, 14), (3, 7)]
    assert all(f.severity is Severity.ERROR for f in missing)


def test_a_parameter_without_a_value_is_refused_with_its_place_and_how_to_give_it() -> None:
    program = read_program(b"N10 G70\nN20 G00 X(P46+0.0625)\n", "ge2000t", "finish.nc")
    with pytest.raises(TrueloopError) as refused:
        program.run({"P47": 0.0})
    assert str(refused.value).startswith("finish.nc:2:11: NC-PARAMETER: parameter P46 has no value")
    assert "--set 'P46=" in refused.value.hint


def test_a_value_for_what_is_no_parameter_is_refused() -> None:
    with pytest.raises(TrueloopError) as refused:
        read_program(b"G70", "ge2000t").run({"height": 1.0})
    assert refused.value.code is Code.NC_PARAMETER
    assert "height" in refused.value.message


@pytest.mark.parametrize(
    ("text", "dialect", "column"),
    [
        ("X(1/0)", "ge2000t", 4),
        ("X(1+)", "ge2000t", 5),
        ("X(1 2)", "ge2000t", 5),
        ("X(SIN(1))", "ge2000t", 3),
        ("X[1 MOD 0]", "linuxcnc", 5),
        ("X[SQRT[-1]]", "linuxcnc", 3),
        ("X[FOO[1]]", "linuxcnc", 3),
        ("X[[0-8] ** 0.5]", "linuxcnc", 9),
        ("X[ATAN[1]]", "linuxcnc", 10),
        ("X#999999", "linuxcnc", 2),
        ("X#[0.5]", "linuxcnc", 2),
        ("X" + "[" * 99 + "1" + "]" * 99, "linuxcnc", 66),
    ],
)
def test_expressions_without_a_value(text: str, dialect: str, column: int) -> None:
    with pytest.raises(TrueloopError) as refused:
        read_program(text.encode(), dialect).run(inch=True)
    assert refused.value.code is Code.NC_EXPRESSION
    assert refused.value.place.column == column


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("o1 while [1]\no1 endwhile", Code.NC_LIMIT, 2),
        ("o1 sub\no1 call\no1 endsub\no1 call", Code.NC_LIMIT, 2),
        ("o1 while [1]", Code.NC_FLOW, 1),
        ("G1\no1 endif", Code.NC_FLOW, 2),
        ("o1 if [1]\no1 endwhile", Code.NC_FLOW, 2),
        ("o1 break", Code.NC_FLOW, 1),
        ("o<far> call", Code.NC_FLOW, 1),
        ("o1 jump", Code.NC_FLOW, 1),
        ("o", Code.NC_FLOW, 1),
    ],
)
def test_flow_control_that_does_not_fit_or_end(text: str, code: Code, line: int) -> None:
    with pytest.raises(TrueloopError) as refused:
        read_program(text.encode(), "linuxcnc").run(block_limit=10_000)
    assert (refused.value.code, refused.value.place.line) == (code, line)


def test_the_unit_is_asked_for_when_the_program_does_not_say_it() -> None:
    program = read_program(b"G0 X10\nG1 X11 F1", "linuxcnc")
    (finding,) = program.run(strict=False).findings
    assert (finding.code, finding.place.line, finding.place.column) == (Code.NC_UNIT, 1, 4)
    assert program.run(inch=False).findings == ()
    assert program.run(inch=True).end_mm[0, 0] == 254.0


def test_the_position_at_the_start() -> None:
    path = read_program(b"G71 G91 G01 Z1 F1", "ge2000t").run(position_mm=(10.0, 0.0, 5.0))
    assert path.end_mm[0].tolist() == [10.0, 0.0, 6.0]


def test_slash_blocks_are_run_when_asked() -> None:
    program = read_program(b"G71\n/G00 X2\nG00 Z1", "ge2000t")
    assert program.run().end_mm[-1].tolist() == [0.0, 0.0, 1.0]
    assert program.run(skipped_blocks=True).end_mm[-1].tolist() == [1.0, 0.0, 1.0]
