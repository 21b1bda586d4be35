"""Macros with arguments, where moves come from, the state at every block, and offsets that the user gives."""

import math

import pytest

from trueloop.errors import Code, Severity, TrueloopError
from trueloop.nc.program.called import offset_number
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import ToolPath


def run(text: str, dialect: str = "fanuc-mill", **options: object) -> ToolPath:
    return read_program(text.encode(), dialect).run(**options)  # type: ignore[arg-type]


def test_letters_become_local_parameters_and_the_caller_keeps_its_own() -> None:
    """A #1, B #2, C #3, D #7, I #4, X #24, Z #26; #1 of the caller is 5 before and after."""
    path = run(
        "G21 #1=5.\nG65 P100 A1. B2. C3. I4. D7. X24. Z26. L2\nG00 X#1\nM30\n"
        "O100\nG00 X#24 Z#26\nX#1 Y#2 Z#3\nX#4 Y#7\nM99"
    )
    once = [[24, 0, 26], [1, 2, 3], [4, 7, 3]]
    again = [[24, 7, 26], [1, 2, 3], [4, 7, 3]]
    assert path.end_mm.tolist() == [*once, *again, [5, 7, 3]]


def test_of_two_arguments_for_one_parameter_the_later_counts() -> None:
    """Fanuc B-63684EN, page 278: I4.0 is the second I and D5.0 behind it is the same #7; before it D does not count."""
    text = "G21 G65 P1000 {}\nM30\nO1000\nG00 X#7 Y#4 Z#2\nM99"
    assert run(text.format("A1.0 B2.0 I-3.0 I4.0 D5.0")).end_mm.tolist() == [[5, -3, 2]]
    assert run(text.format("A1.0 B2.0 D5.0 I-3.0 I4.0")).end_mm.tolist() == [[4, -3, 2]]


def test_a_call_that_begins_within_a_program_is_refused_by_the_control_s_own_letter() -> None:
    """H of a Mitsubishi is what Q is elsewhere; a Fanuc's H beside M98 is another word of its block."""
    text = "G21 G90 G00 X0. Y0. Z9.\nM98 P100 {} L2\nM30\nO100\nX10.\nN20 Y10.\nM99"
    for dialect, word in (("mitsubishi-mill", "H20"), ("mitsubishi-mill", "Q20"), ("fanuc-mill", "Q20")):
        with pytest.raises(TrueloopError, match=f"{word}: where in the program the call begins") as refused:
            run(text.format(word), dialect)
        assert (refused.value.code, refused.value.place.line) == (Code.NC_FLOW, 2)
    assert run(text.format("H20"), "fanuc-mill").end_mm[-1].tolist() == [10, 10, 9]


def test_words_of_a_macro_call_set_no_feed_and_no_speed() -> None:
    path = run("G21 G01 X1. F10. S100\nG65 P100 F77. S88. T9\nX2.\nM30\nO100\nM99")
    assert (path.feed.tolist(), path.spindle_speed.tolist(), path.tool.tolist()) == ([10, 10], [100, 100], [-1, -1])


def test_a_value_that_decides_an_alarm_alone_is_not_asked_for() -> None:
    """The machine decides if the tool's life is over: the path is that of the program without the alarm."""
    path = run("G21 G00 X1.\nIF[#5405GE6000.]THEN#3000=15(LIFE)\nX2.\nM30", "haas-mill")
    assert path.end_mm[:, 0].tolist() == [1, 2]
    assert [(found.code, found.severity) for found in path.findings] == [(Code.NC_FLOW, Severity.NOTE)]
    with pytest.raises(TrueloopError, match="#5405 has no value"):
        run("G21 G00 X1.\nIF[#5405GE6000.]THEN#1=15.\nX2.\nM30", "haas-mill")


def test_arguments_are_no_axes() -> None:
    """A, B and C turn the tool or the work where they are axes, and the path says that it is without them."""
    path = run("G21\nG65 P100 A1. B2. C3.\nG66 P100 C3.\nG67\nG00 A5.\nM30\nO100\nM99")
    assert [(found.place.line, found.message) for found in path.findings] == [(5, "A5.: this axis is not in the path")]


def test_an_argument_left_out_makes_its_word_vacant() -> None:
    path = run("G21 G00 Y9.\nG65 P100 X1.\nM30\nO100\nIF[#25EQ#0]GOTO5\nX99.\nN5 X#24 Y#25\nM99")
    assert path.end_mm.tolist() == [[0, 9, 0], [1, 9, 0]]


@pytest.mark.parametrize(
    ("lines", "x"),
    [("X[#25+1.]", 1.0), ("#30=#25+2.\nX#30", 2.0), ("IF[#25LT1.]GOTO5\nX9.", 0.0), ("X[SIN[#25]+3.]", 3.0)],
)
def test_an_argument_left_out_counts_as_zero_in_a_sum_and_where_sizes_compare(lines: str, x: float) -> None:
    """Mitsubishi M700V programming manual, page 314: vacant variables in operations and conditions."""
    path = run(f"G21 G00 Y9.\nG65 P100 X1.\nM30\nO100\n{lines}\nN5 M99")
    assert path.end_mm[-1, 0] == x


def test_a_macro_that_is_elsewhere_is_said() -> None:
    (found,) = run("G21 G65 P8100 Z5.").findings
    assert (found.code, found.message) == (Code.NC_OPAQUE, "G65: what it does is not in the path")


def test_calls_of_a_move_the_outermost_first() -> None:
    path = run("G21\nG00 X1.\nM98 P10\nG65 P20\nX9.\nM30\nO10\nX2.\nM98 P20 L2\nX3.\nM99\nO20\nX4.\nM99")
    stacks = [path.call_stack(move) for move in range(len(path))]
    assert path.end_mm[:, 0].tolist() == [1, 2, 4, 4, 3, 4, 9]
    assert stacks == [(), (3,), (3, 9), (3, 9), (3,), (4,), ()]


def test_calls_by_o_words_labels_names_and_contours() -> None:
    path = run("G21\no1 sub\nG0 X2\no1 endsub\no2 sub\no1 call\nG0 X3\no2 endsub\no2 call\nG0 X4", "linuxcnc")
    assert [path.call_stack(move) for move in range(3)] == [(9, 6), (9,), ()]
    path = run("1 BEGIN PGM A MM\n2 CALL LBL 1\n3 L X+9\n4 M30\n5 LBL 1\n6 L X+1\n7 LBL 0", "heidenhain")
    assert [path.call_stack(move) for move in range(2)] == [(2,), ()]
    path = run("%_N_A_MPF\nG71\nPART\nG0 X9\nM30\n%_N_PART_SPF\nG0 X1\nM17", "siemens")
    assert [path.call_stack(move) for move in range(2)] == [(3,), ()]
    path = run("G21 G00 X9.\nG70 P1 Q2\nX8.\nM30\nN1 G00 X1.\nN2 Z1.", "fanuc-lathe")
    assert [path.call_stack(move) for move in range(5)] == [(), (2,), (2,), (), ()]


def test_the_state_at_every_block_executed() -> None:
    path = run("G20\nM98 P10 L2\nG95\nM30\nO10\nG01 F5.\nM99", trace=True)
    state = path.executed[:, 2]
    assert (path.executed[:, 0] + 1).tolist() == [1, 2, 5, 6, 7, 5, 6, 7, 3, 4]
    assert path.states["feed_mode"][state].tolist() == [94] * 8 + [95] * 2
    assert path.states["feed"][state][-3] == 5 * 25.4
    assert run("G21").executed.shape == (0, 3)


def test_zeros_of_work_offsets_that_the_user_gives() -> None:
    """The tool stands at machine x = 1: in G54 at 1, in G55, whose zero is at 10, at -9; G53 takes it to 0."""
    path = run("G21 G00 X1.\nG55 X2.\nG53 G00 X0.\nG54.1 P2\nX1.", work_offsets_mm={2: (10, 0, 0), 102: (-3, 0, 0)})
    assert path.start_mm[:, 0].tolist() == [0, -9, 2, 3]
    assert path.end_mm[:, 0].tolist() == [1, 2, -10, 1]
    assert path.work_offset.tolist() == [1, 2, 2, 102]


def test_g52_is_added_to_the_offset_in_force_and_stays_when_it_changes() -> None:
    path = run("G21 G52 X1.\nG00 X0.\nG55 X0.\nG52 X0.\nX0.", work_offsets_mm={2: (10, 0, 0)})
    machine = path.end_mm[:, 0] + [1, 11, 10]
    assert machine.tolist() == [1, 11, 10]
    assert path.start_mm[:, 0].tolist() == [-1, -10, 1]


def test_lengths_of_tools() -> None:
    from trueloop.nc.program.called import CutterTool

    tools = [CutterTool(5, number=3, length_mm=80.0)]
    path = run("G21 G00 Z100.\nG43 H3 Z20.\nG49\nG44 H3\nX1.\nG43 H4", tools=tools)
    assert path.start_mm[:, 2].tolist() == [0, 20, 180]
    assert [found.message for found in path.findings] == ["G43: the tool table's length offset is taken as zero"]


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("G54", 1), ("g59", 6), ("G59.1", 7), ("G59.3", 9), ("G54.1P1", 101), ("G154 P99", 199), ("G505", 5),
        ("G53", None), ("G54.2", None), ("G54.1", None), ("G54.1P0", None), ("G500", None), ("X", None),
    ],
)  # fmt: skip
def test_names_of_work_offsets(name: str, number: int | None) -> None:
    assert offset_number(name) == number


def test_a_dwell_is_between_two_moves() -> None:
    path = run("G21 G00 X1.\nG04 P500\nG04 X2.5\nG00 X2.\nG04 P1.")
    assert (path.dwell_before.tolist(), path.dwell_s.tolist()) == ([1, 1, 2], [0.5, 2.5, 1.0])
    assert run("G21 G0 X1\nG4 P.5 X3\nG4 P1", "linuxcnc").dwell_s.tolist() == [0.5, 1.0]
    path = run("G71 G1 X1 F100\nG4 F2\nX2\nG4 S30", "siemens")
    assert path.feed.tolist() == [100, 100]
    assert path.dwell_s[0] == 2 and math.isnan(path.dwell_s[1])


MODAL = (
    "O1 G21 G90\nG00 X0 Y0 Z9.\nG66 P2 L{} Z-5.\nX1.\nM98 P3\nG67\nX3.\nM30\nO2 G01 Z#26 F9.\nZ9.\nM99\nO3 G00 X2.\nM99"
)


def test_a_macro_after_each_move_until_it_ends() -> None:
    """Not after those of its own; after those of subprograms too; and not in the block of G66 itself."""
    path = run(MODAL.format(1), "fanuc-mill")
    places = [(float(x), float(z)) for x, _, z in path.end_mm]
    assert places == [(0, 9), (1, 9), (1, -5), (1, 9), (2, 9), (2, -5), (2, 9), (3, 9)]
    assert path.findings == ()


def test_a_macro_after_each_move_runs_as_often_as_l_says() -> None:
    assert len(run(MODAL.format(2), "haas-mill")) == 8 + 4


def test_macros_after_each_move_nest() -> None:
    """The later is called after the program's move, the earlier after that macro's; G67 ends the later."""
    text = "O1 G21\nG66 P2 Z1.\nG66 P3 Z2.\nG00 X1.\nG67\nX2.\nG67\nX3.\nM30\nO2 G00 Z#26\nM99\nO3 G00 Y#26\nM99"
    path = run(text, "fanuc-mill")
    assert path.line.tolist() == [4, 12, 10, 6, 10, 8]
    assert path.findings == ()


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("O1 G21\nG66 P2\nG00 X1.\nG67\nM30\nO2 G67\nG00 Z1.\nM99", 6),
        ("O1 G21\nG66 P2\nG00 X1.\nG67\nM30\nO2 G66 P3\nG00 Z1.\nM99\nO3 G00 Y1.\nM99", 6),
        ("O1 G21\n" + 5 * "G66 P2\n" + "M30\nO2 G00 Z1.\nM99", 6),
    ],
)
def test_what_nests_in_another_way_is_a_warning(text: str, line: int) -> None:
    """A macro that changes what calls it, and a fifth level."""
    found = run(text, "fanuc-mill").findings
    assert [(each.severity, each.code, each.place.line) for each in found] == [(Severity.WARNING, Code.NC_OPAQUE, line)]


def test_a_macro_after_each_move_that_is_not_there_is_said() -> None:
    path = run("O1 G21\nG66 P9 Z1.\nG00 X1.\nG67", "fanuc-mill")
    assert [found.code for found in path.findings] == [Code.NC_OPAQUE]
