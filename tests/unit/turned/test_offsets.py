"""Offsets written as a shift of the frame, or as an update of the tool's offset, and what their read-back refuses."""

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.program.program import Program, read_program
from trueloop.turned.program.offsets import (
    Shifted,
    offset_state,
    require_same_path,
    require_shift,
    require_updates,
    shift_edits,
    shifted_moves,
    tool_offset_updates,
    update_edits,
)

OFFSET_MM = (-0.02, 0.013)
STEP_MM = {"linuxcnc": 1e-5, "fanuc-lathe": 1e-3, "haas-lathe": 1e-3, "siemens": 1e-4}
HEADS = {
    "linuxcnc": "G18 G21 G7 G90 G40",
    "fanuc-lathe": "O1\nG18 G21 G40",
    "haas-lathe": "%\nO00001 (HAAS)\nG18 G21 G40",
    "siemens": "G18 G71 G90 G40 DIAMON",
}
COURSE = "G0 X60. Z5.\nG0 X18. Z2.\nG1 X20. Z0. F.1\nZ-20.\nX30.\nG0 X60. Z5.\nM30\n"
CUTS = (2, 4)


def program(dialect: str, course: str = COURSE) -> Program:
    return read_program(f"{HEADS[dialect]}\n{course}".encode(), dialect)


def written(source: Program, shifted: Shifted, offset_mm: tuple[float, float]) -> str:
    return apply_edits(source, shift_edits(source, source.run(), shifted, offset_mm)).decode()


def read_back(source: Program, text: str, cuts: tuple[int, int] = CUTS) -> None:
    after = read_program(text.encode(), source.dialect.name).run(roughing=False)
    before = source.run(roughing=False)
    shifted = shifted_moves(source, before, cuts)
    require_shift(source, before, after, shifted, cuts, OFFSET_MM, STEP_MM[source.dialect.name] / 2 + 1e-9)


def variant(dialect: str, course: str = COURSE, cuts: tuple[int, int] = CUTS) -> str:
    """The program with its contour shifted, read back."""
    source = program(dialect, course)
    text = written(source, shifted_moves(source, source.run(roughing=False), cuts), OFFSET_MM)
    read_back(source, text, cuts)
    return text


def refused(dialect: str, course: str, cuts: tuple[int, int] = CUTS) -> str:
    with pytest.raises(TrueloopError) as found:
        variant(dialect, course, cuts)
    assert found.value.code is Code.NC_OFFSET
    assert found.value.hint
    return found.value.message


@pytest.mark.parametrize(
    ("dialect", "there", "back"),
    [
        ("linuxcnc", "G52 X-0.04000 Z0.01300", "G52 X0.00000 Z0.00000"),
        ("fanuc-lathe", "G52 X-0.040 Z0.013", "G52 X0.000 Z0.000"),
        ("haas-lathe", "G52 X-0.040 Z0.013", "G52 X0.000 Z0.000"),
        ("siemens", "ATRANS X-0.0200 Z0.0130", "ATRANS X0.0200 Z-0.0130"),
    ],
)
def test_the_contour_stands_between_the_shift_and_its_end(dialect: str, there: str, back: str) -> None:
    """X is a diameter in G52, a radius in a frame of Sinumerik."""
    lines = variant(dialect).splitlines()
    first = lines.index("G0 X18. Z2.")
    assert lines[first - 1] == there
    assert lines[lines.index("X30.") + 1] == back


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-lathe", "haas-lathe"])
def test_the_program_begins_without_a_shift_that_a_stopped_run_left(dialect: str) -> None:
    lines = variant(dialect).splitlines()
    settings = HEADS[dialect].splitlines()[-1]
    assert lines[lines.index(settings) - 1].startswith("G52 X0.0")


def test_a_shift_of_the_programs_own_is_added_to_and_put_back() -> None:
    text = variant("linuxcnc", f"G52 X1. Z-7.\n{COURSE}")
    assert "\nG52 X0.96000 Z-6.98700\nG0 X18. Z2.\n" in text
    assert "\nX30.\nG52 X1.00000 Z-7.00000\n" in text


def test_where_another_register_lies_below_a_shift_in_force_is_not_replaced() -> None:
    assert "x 0.5 mm (radius), z -7 mm is in force" in refused("fanuc-lathe", f"G52 X1. Z-7.\n{COURSE}")


UNDER_G42 = COURSE.replace("G0 X18. Z2.\n", "G42\nG0 X18. Z2.\n")


def test_the_shift_stands_outside_of_compensation() -> None:
    text = variant("linuxcnc", UNDER_G42.replace("G0 X60. Z5.\nM30", "G40\nG0 X60. Z5.\nM30"))
    assert "\nG52 X-0.04000 Z0.01300\nG42\n" in text
    assert "\nG40\nG52 X0.00000 Z0.00000\nG0 X60. Z5.\nM30" in text


def test_the_move_that_ends_compensation_is_shifted_too() -> None:
    text = variant("fanuc-lathe", UNDER_G42.replace("G0 X60. Z5.\nM30", "G40 G0 X60. Z5.\nM30"))
    assert "\nG40 G0 X60. Z5.\nG52 X0.000 Z0.000\nM30" in text


def test_compensation_that_is_never_switched_off_is_refused() -> None:
    assert "compensation is in force" in refused("fanuc-lathe", UNDER_G42)


@pytest.mark.parametrize(("block", "what"), [("G54 G52 Z3.", "frame"), ("T0202", "tool")])
def test_nothing_else_may_change_within(block: str, what: str) -> None:
    assert f"the {what} changes" in refused("fanuc-lathe", COURSE.replace("X30.\n", f"{block}\nX30.\n"))


def test_a_coordinate_that_no_word_sets_is_refused() -> None:
    course = "G0 X60.\nG0 X18.\nG1 X20. F.1\nZ-20.\nX30.\nM30\n"
    assert "X and Z are not both set" in refused("haas-lathe", course)


def test_increments_after_the_cut_follow_the_tool() -> None:
    assert "G52" in variant("fanuc-lathe", COURSE.replace("G0 X60. Z5.\nM30", "G0 U20. W2.\nG28 U0 W0\nM30"))


WRONG = {
    "the other sign": lambda text: text.replace("X-0.040", "X0.040").replace("Z0.013", "Z-0.013"),
    "a radius for a diameter": lambda text: text.replace("X-0.040", "X-0.020"),
    "not taken back": lambda text: text.replace("X30.\nG52 X0.000 Z0.000", "X30."),
    "taken back too early": lambda text: text.replace("X30.\nG52 X0.000 Z0.000", "G52 X0.000 Z0.000\nX30."),
    "begun too late": lambda text: text.replace(
        "G52 X-0.040 Z0.013\nG0 X18. Z2.\n", "G0 X18. Z2.\nG52 X-0.040 Z0.013\n"
    ),
    "begun too early": lambda text: text.replace(
        "G0 X60. Z5.\nG52 X-0.040 Z0.013\n", "G52 X-0.040 Z0.013\nG0 X60. Z5.\n"
    ),
    "no shift at all": lambda text: text.replace("G52", "(G52"),
}


@pytest.mark.parametrize("fault", WRONG)
def test_the_read_back_sees_a_wrong_shift(fault: str) -> None:
    """On the machine; in the program's own coordinates all of these are the same path."""
    source, text = program("fanuc-lathe"), variant("fanuc-lathe")
    wrong = WRONG[fault](text)
    assert wrong != text
    with pytest.raises(TrueloopError) as found:
        read_back(source, wrong)
    assert found.value.code is Code.CMP_READ_BACK


@pytest.mark.parametrize("own", ["", "(UPD, 1, TOV(X), 0.1)\n(UPD, 1, TOV(Z), -0.2)\n"])
def test_updates_are_increased_and_read_back(own: str) -> None:
    course = f"G70 G90\n{own}G00 X2.0 Z0.1\nG01 X2.0 Z-1.0\n"
    source = read_program(course.encode(), "ge2000t")
    state = offset_state(source.run().coordinate_state(1), is_diameter=True)
    values_mm = tool_offset_updates(source, state, OFFSET_MM, 1)
    assert values_mm["X"] == pytest.approx(-0.02 + (0.1 * 12.7 if own else 0.0))
    edits = update_edits(source, source.run(), 0, values_mm, 1, True)
    after = read_program(apply_edits(source, edits), "ge2000t")
    require_updates(after, state, values_mm, 1)
    require_same_path(source.run(), after.run())
    for other in ({**values_mm, "X": values_mm["X"] + 0.04}, {**values_mm, "Z": -values_mm["Z"]}):
        with pytest.raises(TrueloopError) as found:
            require_updates(after, state, other, 1)
        assert found.value.code is Code.CMP_READ_BACK


@pytest.mark.parametrize(
    ("before", "after"), [("Z-20.", "Z-20.001"), ("G1 X20.", "G0 X20."), ("X30.\n", "X30.\nX31.\n")]
)
def test_a_changed_path_is_seen(before: str, after: str) -> None:
    source, text = program("haas-lathe"), "\n".join([HEADS["haas-lathe"], COURSE])
    with pytest.raises(TrueloopError) as found:
        require_same_path(source.run(), read_program(text.replace(before, after).encode(), "haas-lathe").run())
    assert found.value.code is Code.CMP_READ_BACK


CYCLE = "G0 X90. Z5.\nG71 U1. R1.\nG71 P10 Q20 U0.5 W0.2 F0.2\nN10 G0 X20. Z2.\nN20 G1 Z-30. F.1\nG70 P10 Q20 ?\nM30\n"


def test_the_finishing_cycle_is_shifted_whatever_else_stands_in_its_block() -> None:
    """The contour's own blocks stand before it: a shift there would not hold while G70 runs them."""
    assert "G52 X-0.040 Z0.013\nG70 P10 Q20 ?\nG52 X0.000 Z0.000\n" in variant("fanuc-lathe", CYCLE, (2, 2))


def test_the_shift_begins_before_the_cycle_where_its_contour_inherits_a_coordinate() -> None:
    text = variant("fanuc-lathe", CYCLE.replace("X20. Z2.", "X20."), (2, 2))
    assert "\nG52 X-0.040 Z0.013\nG0 X90. Z5.\n" in text and "\nG70 P10 Q20 ?\nG52 X0.000 Z0.000\n" in text
