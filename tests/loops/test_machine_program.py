"""How a machine's corrections are written: backlash at quadrants, loops, cycles, probing, machine coordinates."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.machined_path import corrected
from tests.support.machines import chain_with_travel
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.machine.correct import Setup, compensation_field, references_mm
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import CONSTANT, Part, Term, segments
from trueloop.nc.program.along import points_along
from trueloop.nc.program.program import read_program

MILL = Machine("mill", chain_with_travel("mill-table-x"))
SETUP = Setup({1: (250.0, 0.0, -100.0)}, reference_mm={"Y": -200.0})


def _model(term: Term, *coefficients: float) -> MachineModel:
    return MachineModel(MILL, (term,), np.array(coefficients), np.zeros((len(coefficients),) * 2))


STRETCHED = _model(Term(error_name("EXX"), (Part(segments(0.0, 500.0, 1, 1)),)), 0.0, 0.05)
"""EXX = 0.1 µm a millimetre: 25 µm at the work zero."""

BACKLASH = _model(Term(error_name("EYY"), (Part(CONSTANT),), both_ways=True), 0.0, 0.01)
"""Y stands 10 µm too far when it came back."""


def test_a_linear_scale_error_splits_nothing() -> None:
    after = corrected("G21 G1 X20. Y5. F100\nX30.\nG0 X0.\n", STRETCHED, SETUP)
    assert after == "G21 G1 X19.97300 Y5. F100\nX29.97200\nG0 X-0.02500\n"


def test_backlash_is_put_in_where_the_axis_turns_round() -> None:
    """Y turns round in the third block: a block that takes up the backlash, then the move."""
    after = corrected("G21 G1 X10. Y5. F100\nX20.\nY2.\nX30.\n", BACKLASH, SETUP)
    assert after.splitlines() == ["G21 G1 X10. Y5. F100", "X20.", "Y4.99000", "Y1.99000", "X30."]


@pytest.mark.parametrize(
    ("start", "zero_mm", "reference_mm", "written"),
    [
        ("", -100.0, 200.0, "Y4.99000"),  # from +200 down to −95
        ("", -100.0, -200.0, "Y5"),
        ("", -100.0, -95.01, "Y5"),
        ("", -100.0, -94.99, "Y4.99000"),
        ("G0 Y-20.\nG91 G28 Y0\nG90\n", -100.0, 200.0, "Y4.99000"),  # Y −20 is forgotten at the reference point
        ("G0 Y-20.\nG91 G28 Y0\nG90\n", -100.0, -200.0, "Y5"),
        ("G53 G0 Y150.\n", 100.0, -200.0, "Y4.99000"),  # from 150 down to 105, wherever the reference point is
        ("G53 G0 Y90.\n", 100.0, 200.0, "Y5"),
        ("G91 G0 Y-3.\nG90 ", -100.0, -200.0, "Y5"),
    ],
)
def test_the_way_to_a_first_place_is_from_the_reference_point(
    start: str, zero_mm: float, reference_mm: float, written: str
) -> None:
    """Y goes 10 µm too far when it came down: the first place of the program is so far from where Y stood before."""
    setup = Setup({1: (250.0, zero_mm, -100.0)}, reference_mm={"Y": reference_mm})
    after = corrected(f"G21 G90 G54\n{start}G0 X10. Y5 Z5.\nG1 Z-1. F100\nX20.\n", BACKLASH, setup)
    assert after.splitlines()[-3:] == [
        *(f"{'G90 ' * start.endswith(' ')}G0 X10. {written} Z5.",),
        "G1 Z-1. F100",
        "X20.",
    ]


@pytest.mark.parametrize("start", ["", "G0 Y-20.\nG28 Y-20.\n", "G0 Y-20.\nG30 Y-20.\n"])
def test_a_cut_at_a_place_to_which_an_axis_may_have_come_from_either_side_is_refused(start: str) -> None:
    """Travel −200 … 200 mm: zero is no end of it. G30 leads elsewhere, though the reference point is stated."""
    setup = replace(SETUP, reference_mm={"Y": 200.0} if "G30" in start else {})
    program = f"G21 G90 G54\n{start}G0 X10. Y5. Z5.\nG1 Z-1. F100\nX20.\n"
    with pytest.raises(TrueloopError, match=r"Y comes to this cut .* 10\.0 µm of backlash") as refused:
        corrected(program, BACKLASH, setup)
    assert refused.value.code is Code.MCH_FRAME and refused.value.place.line == 3 + start.count("\n")
    passed = program.replace("G0 X10. Y5. Z5.", "G0 X10. Y9. Z5.\nY5.")  # as the hint tells
    assert corrected(passed, BACKLASH, setup).splitlines()[-3:] == ["Y4.99000", "G1 Z-1. F100", "X20."]
    little = _model(Term(error_name("EYY"), (Part(CONSTANT),), both_ways=True), 0.0, 0.4e-3)
    assert "X20." in corrected(program, little, setup)


def test_an_axis_comes_from_the_end_of_travel_where_its_zero_is() -> None:
    """X travels 0 … 500 mm: from zero it comes up, whatever the program calls its place."""
    model = _model(Term(error_name("EXX"), (Part(CONSTANT),), both_ways=True), 0.01, 0.0)
    text = "G21 G90 G54\nG0 X-5. Y0. Z5.\nG1 Z-1. F100\n"
    assert corrected(text, model, SETUP).splitlines()[1] == "G0 X-5.01000 Y0. Z5."
    away = replace(SETUP, reference_mm={"X": 500.0})
    assert corrected(text, model, away) == text
    with pytest.raises(TrueloopError, match="a reference point is stated of") as refused:
        turned = MachineModel(
            Machine("five", chain_with_travel("five-axis-table-table-ac")), (), np.zeros(0), np.zeros((0, 0))
        )
        references_mm(turned, replace(SETUP, reference_mm={"C": 0.0}))
    assert refused.value.code is Code.MCH_AXIS


def test_an_arc_is_cut_where_an_axis_turns_round() -> None:
    after = corrected("G21 G1 X20. Y-9. F100\nY0.\nG3 X-20. Y0. I-20. J0.\n", BACKLASH, SETUP)
    to_top, backlash, down = after.splitlines()[-3:]
    assert to_top.startswith("G3 X0.00000 Y20.00000")
    assert backlash == "G01 X0.00000 Y19.99000"
    assert down.startswith("G3 X-20.00000 Y-0.01000")


def test_an_arc_of_more_than_half_a_turn_by_its_radius_is_cut_into_ones_of_less() -> None:
    """R-10 goes three quarters round: none of its quarters may keep the minus sign."""
    after = corrected("G21 G1 X20. Y-9. F100\nX10. Y0.\nG3 X0. Y-10. R-10.\n", BACKLASH, SETUP)
    path = read_program(after.encode(), "linuxcnc").run()
    turned = path.sweep_rad[path.sweep_rad != 0.0]
    assert turned == pytest.approx(-np.pi / 2, abs=0.01) and len(turned) == 3
    centres = path.centre_mm[path.sweep_rad != 0.0, :2]
    assert np.abs(centres).max() < 0.011


def test_backlash_before_an_arc_is_taken_up_in_a_block_before_it() -> None:
    """Y comes up to 0 and goes down in the arc, which inherits its G2."""
    source = "G21 G1 X0. Y-5. F100\nY0.\nG2 X10. Y-10. I0. J-10.\nX0. Y-20. I-10. J0. F50\nG1 Y-25.\n"
    assert corrected(source, BACKLASH, SETUP).splitlines()[2:] == [
        "G01 X0.00000 Y-0.01000",
        "G2 X10. Y-10.01000 I0. J-10.",
        "X0. Y-20.01000 I-10. J0. F50",
        "G1 Y-25.01000",
    ]
    inherits = "G21 G2 X5. Y5. Z0. R5. F100\nG1 Y9.\nG2 X14. Y4. I0. J-5.\n"
    with pytest.raises(TrueloopError, match="has no position yet"):
        corrected(inherits, BACKLASH, SETUP)


def test_an_optional_arc_is_not_moved_by_a_block_that_is_always_run() -> None:
    source = "G21 G1 X0. Y-5. F100\nY0.\n/G2 X10. Y-10. I0. J-10.\n"
    with pytest.raises(TrueloopError, match="3:1: NC-MAP: an axis turns round before this arc"):
        corrected(source, BACKLASH, SETUP, skipped_blocks=True)


@pytest.mark.parametrize("late", ["M30", "M5", "M1"])
def test_a_code_that_comes_at_the_end_is_not_put_in_the_middle(late: str) -> None:
    source = f"G21 G1 X10. Y5. F100\nX20.\nY2. {late}\n"
    with pytest.raises(TrueloopError, match=late):
        corrected(source, BACKLASH, SETUP)


def test_a_lathe_is_given_no_y() -> None:
    lathe = Machine("lathe", chain_with_travel("turning"))
    terms = tuple(Term(error_name(name), (Part(CONSTANT),)) for name in ("EXZ", "EYZ"))
    model = MachineModel(lathe, terms, np.array([0.02, 0.05]), np.zeros((2, 2)))
    setup = Setup({1: (60.0, 0.0, -60.0)}, {-1: (20.0, 0.0, 25.0)})
    after = corrected("G18 G21 G8\nG0 X20 Z1\nG1 Z-80 F100\n", model, setup)
    assert after == "G18 G21 G8\nG0 X19.98000 Z1\nG1 Z-80 F100\n"


def test_a_correction_larger_than_the_limit_is_refused(tmp_path: Path) -> None:
    """3 mm of EXX: X goes too far by what nobody's machine errs."""
    source = tmp_path / "part.ngc"
    source.write_text("G21\nG0 X30 Y0 Z0\nM2\n")
    field = compensation_field(_model(Term(error_name("EXX"), (Part(CONSTANT),)), 3.0), SETUP, {})
    with pytest.raises(TrueloopError) as refusal:
        map_program(source, tmp_path / "out.ngc", field, dialect="linuxcnc")
    assert refusal.value.code is Code.CMP_SIZE
    assert not (tmp_path / "out.ngc").exists()


@pytest.mark.parametrize("text", ["G68 X0 Y0\nG0 X10 Y0 Z0", "G0 X10 Y0 Z0 G987", "G16 G0 X10 Y45 Z0"])
def test_what_is_not_understood_is_not_corrected(text: str) -> None:
    with pytest.raises(TrueloopError):
        corrected(f"G21\n{text}\n", STRETCHED, SETUP, dialect="fanuc-mill")


def test_an_unknown_offset_is_told_with_its_line() -> None:
    with pytest.raises(TrueloopError, match="work offset 2 is used") as refusal:
        corrected("G21 G0 X1 Y0 Z0\nG55\nG0 X2 Y0 Z0\n", STRETCHED, SETUP)
    assert (refusal.value.code, refusal.value.place.line) == (Code.MCH_FRAME, 3)


@pytest.mark.parametrize("word", ["G10 L2 P1 X5 Y0 Z0", "G10 L10 P1 R3"])
@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc-mill"])
def test_an_offset_set_by_the_program_is_not_what_the_set_up_says(word: str, dialect: str) -> None:
    """The error would be taken where the zero lay before."""
    source = f"G21 G90 G54\nG0 X0 Y0 Z5\n{word}\nG1 X50 F100\n"
    with pytest.raises(TrueloopError, match="sets an offset, by G10") as refusal:
        corrected(source, STRETCHED, SETUP, dialect=dialect)
    assert (refusal.value.code, refusal.value.place.line) == (Code.MCH_FRAME, 3)


@pytest.mark.parametrize("radius", ["R-6.", "R6."])
def test_an_arc_by_its_radius_keeps_to_the_displaced_circle(radius: str) -> None:
    """X and Y read 1 µm a millimetre too far: the circle has to be as much smaller, on whichever side of the chord."""
    scale = (
        Term(error_name("EXX"), (Part(segments(0.0, 500.0, 1, 1)),)),
        Term(error_name("EYY"), (Part(segments(-300.0, 200.0, 1, 1)),)),
    )
    coefficients = np.array([0.0, 0.5, 0.0, 0.5])
    model = MachineModel(MILL, scale, coefficients, np.zeros((4, 4)))
    source = f"G21 G61 G1 X0. Y0. F100\nG2 X10.000 Y0.000 {radius}000\n"
    before, after = (
        read_program(text.encode(), "linuxcnc").run() for text in (source, corrected(source, model, SETUP))
    )
    assert after.sweep_rad[1] == pytest.approx(before.sweep_rad[1], rel=1e-3)
    assert after.programmed_radius_mm[1] == pytest.approx(6.0 * (1 - 0.001), abs=2e-4)


@pytest.mark.parametrize(
    ("dialect", "shift", "cut", "line"),
    [
        ("linuxcnc", "G21 G52 X-30\n", "G1 X50. Y0 F100\n", "G1 X49.97300 Y0 F100"),
        ("siemens", "G71\nTRANS X-30\n", "G1 X50 Y0 F100\n", "G1 X49.9730 Y0 F100"),
        ("heidenhain", "0 BEGIN PGM A MM\n1 CYCL DEF 7.1 X-30\n", "2 L X+50 Y+0 F100\n", "2 L X+49.9730 Y+0 F100"),
    ],
)
def test_a_shift_of_the_programs_own_is_no_place_of_the_machine(dialect: str, shift: str, cut: str, line: str) -> None:
    """X50 is cut where X20 is without the shift, and is as far off as that."""
    assert corrected(shift + cut, STRETCHED, SETUP, dialect=dialect).splitlines()[-1] == line


def test_machine_coordinates_and_probing_stay() -> None:
    source = "G21 G1 X20. F100\nG53 G0 X5.\nG38.2 X30. F50\n"
    after = corrected(source, STRETCHED, SETUP).splitlines()
    assert after == ["G21 G1 X19.97300 F100", "G53 G0 X5.", "G38.2 X30. F50"]


def test_a_loop_at_several_places_is_refused_and_at_one_place_is_not() -> None:
    loop = "#1=0\nG21 G0 X0. Z5.\no1 while [#1 LT 2]\nG1 X{} Z1. F100\nG0 Z5.\n#1=[#1+1]\no1 endwhile\nM2\n"
    same = corrected(loop.format("20."), STRETCHED, SETUP)
    assert "G1 X19.97300 Z1." in same
    with pytest.raises(TrueloopError) as refusal:
        corrected(loop.format("[10*#1]"), STRETCHED, SETUP)
    assert (refusal.value.code, refusal.value.place.line) == (Code.NC_MAP, 4)


def test_the_holes_of_a_cycle_are_corrected_in_their_own_blocks() -> None:
    """0.1 µm a millimetre of the machine's X, which is 250 mm more; backlash of Y by the way it came to each hole."""
    text = "G21 G90 F100\nG0 X0 Y0 Z10\nG81 X10 Y5 Z-3 R2\nX20\nX30 Y2\nG80\nM2\n"
    assert corrected(text, STRETCHED, SETUP).splitlines()[2:5] == [
        "G81 X9.97400 Y5 Z-3 R2",
        "X19.97300",
        "X29.97200 Y2",
    ]
    assert corrected(text, BACKLASH, SETUP).splitlines()[2:5] == ["G81 X10 Y5 Z-3 R2", "X20", "X30 Y1.99000"]


def test_inch_programs_are_written_in_inches() -> None:
    setup = Setup({1: (0.0, 0.0, -100.0)})
    assert corrected("G20\nG1 X15. F10\n", STRETCHED, setup) == "G20\nG1 X14.998500 F10\n"


FIVE = Machine("five", chain_with_travel("five-axis-table-table-ac"))
PUSHED = MachineModel(FIVE, (Term(error_name("EXX"), (Part(CONSTANT),)),), np.array([0.02]), np.zeros((1, 1)))
"""X goes 20 µm too far."""


@pytest.mark.parametrize("turned", [0.0, 0.5 * np.pi, 1.0])
def test_the_error_of_x_is_taken_out_of_x_however_the_table_is_turned(turned: float) -> None:
    """Seen from a table turned by a quarter it is an error along Y, but the program's X moves the machine's X."""
    setup = Setup({1: (250.0, 0.0, -100.0)}, fixed={"C": turned, "A": 0.3})
    assert corrected("G21 G1 X20. Y5. F100\n", PUSHED, setup) == "G21 G1 X19.98000 Y5. F100\n"


def test_a_program_that_turns_a_rotary_axis_is_refused() -> None:
    with pytest.raises(TrueloopError) as refusal:
        corrected("G21 G1 X20. Y5. F100\nA30.\nX30.\n", PUSHED, replace(SETUP, fixed={"A": 0.0, "C": 0.0}))
    assert refusal.value.code is Code.NC_MAP
    assert refusal.value.place.line == 2
    assert refusal.value.message.startswith("A turns")


def test_a_turned_head_is_refused() -> None:
    head = Machine("head", chain_with_travel("five-axis-head-head-ca"))
    setup = Setup(SETUP.work_zero_mm, fixed={"A": 0.1, "C": 0.0})
    with pytest.raises(TrueloopError) as refusal:
        corrected("G21 G1 X20. F100\n", MachineModel(head, PUSHED.terms, PUSHED.coefficients, PUSHED.covariance), setup)
    assert refusal.value.code is Code.MCH_FRAME
    assert refusal.value.message.startswith("A turns the tool")


def test_where_every_rotary_axis_stands_is_stated() -> None:
    """At another angle than the one assumed the errors are others: 0 is not assumed."""
    with pytest.raises(TrueloopError) as refusal:
        corrected("G21 G1 X20. F100\n", PUSHED, replace(SETUP, fixed={"A": 0.3}))
    assert refusal.value.code is Code.MCH_FRAME
    assert "--at C=0" in refusal.value.hint and "--at A" not in refusal.value.hint


def test_a_contour_with_corners_is_corrected_along_the_way_that_is_cut() -> None:
    """X stands 0.1 µm a millimetre too far, from the machine's zero, 250 mm before the part's: added to the written
    path that gives the line, rounding, line, chamfer and line of the drawing, to two steps of the control.
    """
    text = "G21 G90 G17\nG00 X1. Y1. Z1.\nG01 X10. ,R2. F100.\nY20.,C1.\nX30.\n"
    path = read_program(corrected(text, STRETCHED, SETUP, dialect="fanuc-mill").encode(), "fanuc-mill").run()
    share = np.linspace(0.0, 1.0, 21)
    x, y = np.concatenate([points_along(path, np.intp(k), share) for k in np.flatnonzero(~path.rapid)])[:, :2].T
    x = x + 1e-4 * (x + 250.0)
    off = np.select(
        [x < 8.0, y < 3.0, y < 19.0, y < 20.0 - 1e-3],
        [y - 1.0, np.hypot(x - 8.0, y - 3.0) - 2.0, x - 10.0, (x - y + 9.0) / np.sqrt(2.0)],
        y - 20.0,
    )
    assert np.abs(off).max() < 0.002
    assert (x.min(), x.max()) == pytest.approx((1.0, 30.0), abs=0.002)


def test_by_hand_a_tool_that_is_only_preselected_has_no_part_in_the_correction() -> None:
    """T2 waits in the magazine while T1 cuts: X stands at 270 with T1 (27 µm), at 170 with T2 (17 µm)."""
    tools = Setup({1: (250.0, 0.0, -100.0)}, {1: (0.0, 0.0, 0.0), 2: (100.0, 0.0, 0.0)})
    cut = "G1 X20. Y5. Z0. F100\n"
    for change, x in (("T1 M6\n", "X19.97300"), ("T1 M6\nT2\n", "X19.97300"), ("T2 M6\nT1\n", "X19.98300")):
        assert x in corrected(f"G21 {change}{cut}", STRETCHED, tools)
