"""The judge itself is judged on programs small enough to work out by hand."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support import linuxcnc
from tests.support.linuxcnc import LinuxcncMissingError, Move, ProgramRefusedError, Tool, interpret

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def program(text: str) -> Path:
        file = tmp_path / "program.ngc"
        file.write_text(text)
        return file

    return program


def ends(moves: list[Move]) -> list[tuple[float, float]]:
    """(x, z) of every end point."""
    return [(move.end_mm[0], move.end_mm[2]) for move in moves]


@pytest.mark.parametrize(("mode", "x_mm"), [("G7", 5.0), ("G8", 10.0)])
def test_x_is_a_radius_also_in_diameter_mode(write: Write, mode: str, x_mm: float) -> None:
    (move,) = interpret(write(f"{mode}\nG0 X10 Z3\nM2\n"))
    assert move.end_mm == pytest.approx((x_mm, 0.0, 3.0), rel=1e-15)


@pytest.mark.parametrize(("unit", "mm"), [("G20", 25.4), ("G21", 1.0)])
def test_inch_and_metric_programs_come_out_in_mm_to_the_last_bit_but_one(write: Write, unit: str, mm: float) -> None:
    x_mm, z_mm = ends(interpret(write(f"{unit}\nG0 X1.2345678901 Z-2\nM2\n")))[0]
    assert x_mm == pytest.approx(1.2345678901 * mm, rel=4e-16)
    assert z_mm == pytest.approx(-2 * mm, rel=4e-16)


def test_moves_carry_kind_line_and_both_ends(write: Write) -> None:
    rapid, line = interpret(write("(a comment)\nG0 X10 Z1\n\nG1 X12 Z-4 F100\nM2\n"))
    assert (rapid.kind, rapid.line, line.kind, line.line) == ("rapid", 2, "line", 4)
    assert rapid.start_mm == (0.0, 0.0, 0.0)
    assert line.start_mm == rapid.end_mm == pytest.approx((10.0, 0.0, 1.0))
    assert line.centre_mm is None
    assert line.sweep_rad is None


@pytest.mark.parametrize(
    ("arc", "centre", "sweep_rad"),
    [
        # from (x 10, z 0): z to the right, x up, G02 turns clockwise
        ("G2 X5 Z5 R5", (5.0, 0.0), math.pi / 2),
        ("G3 X5 Z5 R5", (10.0, 5.0), -math.pi / 2),
        ("G2 X5 Z5 I0 K5", (10.0, 5.0), 3 * math.pi / 2),
        ("G2 X10 Z0 I-5 K0", (5.0, 0.0), 2 * math.pi),
        ("G3 X10 Z0 I-5 K0 P2", (5.0, 0.0), -4 * math.pi),
    ],
)
def test_arcs_in_g18_turn_positive_for_g02(
    write: Write, arc: str, centre: tuple[float, float], sweep_rad: float
) -> None:
    _, move = interpret(write(f"G0 X10 Z0\n{arc} F100\nM2\n"))
    assert move.centre_mm is not None
    assert (move.centre_mm[0], move.centre_mm[2]) == pytest.approx(centre, abs=1e-12)
    assert move.sweep_rad == pytest.approx(sweep_rad, rel=1e-12)


def test_arcs_in_g17_follow_the_same_sign(write: Write) -> None:
    _, move = interpret(write("G17 G0 X10 Y0\nG3 X0 Y10 I-10 J0 F100\nM2\n"))
    assert move.sweep_rad == pytest.approx(-math.pi / 2)
    assert move.end_mm == pytest.approx((0.0, 10.0, 0.0), abs=1e-12)


def test_o_word_loops_expressions_and_preset_parameters(write: Write) -> None:
    text = "#1=0\nO100 while [#1 LT 3]\n #1=[#1+1]\n G1 X[#31+#<_step>*#1] F100\nO100 endwhile\nM2\n"
    moves = interpret(write(text), {31: 2.5, "_step": 0.00001})
    assert [x for x, _ in ends(moves)] == pytest.approx([2.50001, 2.50002, 2.50003], rel=1e-15)
    assert {move.line for move in moves} == {4}


def test_block_delete_is_off_unless_asked(write: Write) -> None:
    program = write("G0 X1\n/G0 X2\nG0 X3\nM2\n")
    assert [x for x, _ in ends(interpret(program))] == pytest.approx([1, 2, 3])
    assert [x for x, _ in ends(interpret(program, block_delete=True))] == pytest.approx([1, 3])


def test_g92_renames_where_the_tool_stands(write: Write) -> None:
    first, second = interpret(write("G0 X10 Z5\nG92 X100 Z50\nG1 X101 Z50 F100\nM2\n"))
    assert first.end_mm == pytest.approx((10.0, 0.0, 5.0))
    assert second.start_mm == pytest.approx((100.0, 0.0, 50.0))
    assert second.end_mm == pytest.approx((101.0, 0.0, 50.0))


def test_a_tool_change_finds_the_nose_radius_by_tool_number(write: Write) -> None:
    """G42 to the right of travel along −z keeps the nose centre one radius outside (tool orientation 9: its centre)."""
    tools = [Tool(1, nose_radius_mm=0.4, orientation=9), Tool(9, nose_radius_mm=0.8, orientation=9)]
    text = "T{} M6\nG0 X20 Z5\nG42 G1 X10 Z2 F100\nG1 Z-10\nG1 X15\nG40\nM2\n"
    for tool in tools:
        moves = interpret(write(text.format(tool.number)), tools=tools)
        assert any(x == pytest.approx(10 + tool.nose_radius_mm) for x, _ in ends(moves))


def test_tool_offsets_do_not_move_the_programmed_path(write: Write) -> None:
    program = write("T3 M6 G43\nG0 X10 Z5\nM2\n")
    (move,) = interpret(program, tools=[Tool(3, x_offset_mm=1.5, z_offset_mm=-7.0)])
    assert move.end_mm == pytest.approx((10.0, 0.0, 5.0))


def test_a_bad_program_gives_the_interpreters_message_and_line(write: Write) -> None:
    with pytest.raises(
        ProgramRefusedError, match="line 2: Radius to end of arc differs from radius to start"
    ) as refused:
        interpret(write("G0 X10 Z0\nG2 X5 Z7 I-5 K0 F100\nM2\n"))
    assert refused.value.line == 2


def test_a_parameter_in_range_but_unset_is_zero_and_an_unknown_name_is_refused(write: Write) -> None:
    assert ends(interpret(write("G0 X[#100+1]\nM2\n")))[0][0] == pytest.approx(1.0)
    with pytest.raises(ProgramRefusedError, match="not defined"):
        interpret(write("G0 X#<nobody>\nM2\n"))


def test_without_linuxcnc_the_failure_says_what_to_install(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linuxcnc, "DEBIAN_PYTHON", Path("/nonexistent/python3"))
    with pytest.raises(LinuxcncMissingError, match="apt-get install -y --no-install-recommends linuxcnc-uspace"):
        interpret(write("M2\n"))
