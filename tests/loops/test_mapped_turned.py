"""Turned, mirrored and scaled coordinates under a field: displaced in the work frame, written in the program's own.

Where a program goes is worked out here with complex numbers; the angles have no exact sine.
"""

import cmath
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import interpret
from tests.support.mapped import MIXED, mapped
from tests.support.nc_judge import assert_same_moves
from trueloop.domain.option import MapOptions
from trueloop.errors import Code, TrueloopError
from trueloop.nc.field import Field, similarity_field
from trueloop.nc.program.called import CutterTool
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion

SHIFT = similarity_field(shift_mm=(0.0123456, -0.0234567, 0.0345678))
WHOLE = MapOptions(limit_mm=np.inf, slope=np.inf, tolerance_mm=1.0)
"""No move is divided."""

Place = Callable[[complex], complex]
ABOUT, ANGLE = complex(5.0, -3.0), 37.0
TURN = cmath.exp(1j * math.radians(ANGLE))


def about(point: complex) -> complex:
    return ABOUT + TURN * (point - ABOUT)


def turn(point: complex) -> complex:
    return TURN * point


def mirror(point: complex) -> complex:
    return -point.conjugate()


# Ends of lines and of arcs; seven decimals, so that rounding is below a nanometre.
LINES = [10.5 + 2.25j, 31.125 + 4j, 31.125 + 14j]
ARCS = [21.125 + 14j, 26.125 + 9j]
FANUC = """G21 G17 G90 G00 X0.0000000 Y0. Z5.
{before}
G00 X10.5 Y2.25
G01 Z-1. F100.
X31.125 Y4.
Y14.
G03 X21.125 Y14. I-5. J0.
X26.125 Y9. R5.
{after}
G00 Z5.
X0. Y0.
M30
"""
SIEMENS = FANUC.replace("R5.", "CR=5.").replace("G21", "G710")
KLARTEXT = """BEGIN PGM A MM
TOOL CALL 1 Z S100
L X+0.0000000 Y+0 Z+5 R0 FMAX
{before}
L X+10.5 Y+2.25 FMAX
L Z-1 F100
L X+31.125 Y+4
L Y+14
CC X+26.125 Y+14
C X+21.125 Y+14 DR+
CR X+26.125 Y+9 R+5 DR+
{after}
L Z+5 FMAX
L X+0 Y+0 FMAX
END PGM A MM
"""


def cycle(number: int, text: str) -> str:
    return f"CYCL DEF {number}.0 FRAME\nCYCL DEF {number}.1 {text}"


CASES: list[tuple[str, str, str, str, Place]] = [
    ("fanuc-mill", FANUC, "G68 X5. Y-3. R37.", "G69", about),
    ("haas-mill", FANUC, "G68 X5. Y-3. R37.", "G69", about),
    ("siemens", SIEMENS, "ROT RPL=37", "ROT", turn),
    ("siemens", SIEMENS, "TRANS X7 Y2\nAROT Z30\nAROT RPL=7", "TRANS", turn),
    ("siemens", SIEMENS, "MIRROR X0", "MIRROR", mirror),
    ("siemens", SIEMENS, "MIRROR X0\nAROT RPL=37", "ROT", lambda p: mirror(turn(p))),
    ("siemens", SIEMENS, "SCALE X2 Y2", "SCALE", lambda p: 2 * p),
    ("fanuc-mill", FANUC, "G51.1 X0.", "G50.1 X0.", mirror),
    ("haas-mill", FANUC, "G101 X0.", "G100 X0.", mirror),
    ("heidenhain", KLARTEXT, cycle(10, "ROT+37"), cycle(10, "ROT+0"), turn),
    ("heidenhain", KLARTEXT, cycle(10, "ROT+30") + "\n" + cycle(10, "IROT+7"), cycle(10, "IROT-37"), turn),
    ("heidenhain", KLARTEXT, cycle(26, "X2 Y2 CCX+5 CCY-3"), cycle(26, "X1 Y1"), lambda p: 2 * p - ABOUT),
    ("heidenhain", KLARTEXT, cycle(8, "X"), cycle(8, ""), mirror),
]


@pytest.mark.parametrize("field", [SHIFT, MIXED], ids=["shift", "mixed"])
@pytest.mark.parametrize(("dialect", "form", "before", "after", "place"), CASES, ids=lambda value: str(value)[:12])
def test_ends_are_displaced_where_the_frame_puts_them(
    tmp_path: Path, field: Field, dialect: str, form: str, before: str, after: str, place: Place
) -> None:
    text, _ = mapped(tmp_path, form.format(before=before, after=after), field, dialect, WHOLE)
    path = read_program(text.encode(), dialect).run()
    assert before in text and after in text
    flat = [LINES[0], *LINES, *ARCS]
    points = np.array([[place(p).real, place(p).imag, 5.0 if k == 0 else -1.0] for k, p in enumerate(flat)])
    shift = np.array([7.0, 2.0, 0.0]) * ("TRANS X7 Y2" in before)  # places of the work offset
    wanted = points + field.displacement_mm(points + shift)
    written = path.end_mm[path.linear]
    # Klartext has no helices: its arcs become lines where the field leans, with ends between these.
    assert max(np.abs(written - end).max(axis=1).min() for end in wanted) < 1e-6
    # Counterclockwise in the program; where it is mirrored, clockwise on the part.
    mirrors = abs(place(1j) - place(0) - 1j * (place(1) - place(0))) > 1e-9
    turns = np.sign(path.sweep_rad[path.motion == Motion.ARC])
    assert set(turns.tolist()) <= {1.0 if mirrors else -1.0} and (len(turns) == 2 or field is MIXED)
    assert path.end_mm[-1, :2] == pytest.approx(field.displacement_mm(np.array([[0.0, 0.0, 5.0]]))[0, :2], abs=1e-6)


@pytest.mark.parametrize(
    ("dialect", "frame", "cuts", "end"),
    [
        # At R90 the program's X is the part's Y, and its Y the part's −X: 0.1 of X is −0.1 of the program's Y.
        ("fanuc-mill", "G68 X0. Y0. R90.", ["G01 X10.020 Y-0.100 Z-1.040 F100.", "X20.020"], "G69"),
        ("fanuc-mill", "G51.1 X2.", ["G01 X9.900 Y0.020 Z-1.040 F100.", "X19.900"], "G50.1 X0."),
        # Doubled, 0.1 on the part is 0.05 of the program's words.
        ("haas-mill", "G51 X0. Y0. Z0. P2.", ["G01 X10.050 Y0.010 Z-1.020 F100.", "X20.050"], "G50"),
    ],
)
def test_a_shift_is_written_in_the_coordinates_in_force(
    tmp_path: Path, dialect: str, frame: str, cuts: list[str], end: str
) -> None:
    head = ["G21 G17 G90 G00 X{} Y{} Z5.", frame, "G01 X10. Y0. Z-1. F100.", "X20.", end, "G00 Z5.", "X{} Y{}", "M30\n"]
    source = "\n".join(head).format(*["0."] * 4)
    text, _ = mapped(tmp_path, source, similarity_field(shift_mm=(0.1, 0.02, -0.04)), dialect)
    lines = [line for line in text.splitlines() if "corrected" not in line]
    assert lines[1:-3] == [frame, *cuts, end]
    assert lines[-2] == "X0.100 Y0.020 Z4.960"


def test_linuxcnc_turns_a_work_offset_and_the_part_with_it(tmp_path: Path) -> None:
    """The coordinates of a turned work offset are the part's: words are displaced as they stand. LinuxCNC's interpreter
    makes the same moves, goes to the same places of the machine, and back from one offset to another."""
    file = tmp_path / "turned.ngc"
    file.write_text(
        "G21 G17 G90 F100\nG10 L2 P1 X10 Y20 R30\nG10 L2 P2 X-5 Y1 R-75.5\nG54 G0 X1 Y2 Z3\nG1 X5\nG3 X7 Y4 I0 J2\n"
        "G92 X1 Y1\nG1 X3\nG53 G0 X0\nG92.1\nG55 G1 X4\nG1 X0 Y0\nG54 Y3\nG10 L2 P1 R0\nG1 X2\nG53 G0 Z0\nM2\n"
    )
    path = read_program(file.read_bytes(), "linuxcnc").run()
    assert_same_moves(path, interpret(file, startup="G17 G21 G40"))
    text, _ = mapped(tmp_path, "G21 G90 F100\nG10 L2 P1 X0 Y0 R30\nG0 X1 Y2 Z3\nG1 X5 Y2 Z3\nM2\n", SHIFT)
    assert "G0 X1.01235 Y1.97654 Z3.03457\nG1 X5.01235 Y1.97654 Z3.03457" in text


TURNED_CUT = "G68 X0. Y0. R90.\nG01 X10. Y10. F100.\nG69\n"


@pytest.mark.parametrize(
    ("text", "off"),
    [
        ("G01 X10. Y10. F100.\nG92 X0.\nG68 X0. Y0. R90.\nG01 X10. Y5.", True),
        ("G01 X10. Y10. F100.\nG92 Y0.\nG68 X0. Y0. R90.\nG01 X10. Y5.", False),
        (TURNED_CUT + "G92 X0.\nG01 X10. Y5.", True),
        (TURNED_CUT + "G92 Y0.\nG01 X10. Y5.", False),
        (TURNED_CUT + "G92 X0.", True),
        ("G92 X0. Y0.\nG68 X10. Y10. R90.\nG01 X5. Y5. F100.\nX0. Y20.", True),  # at the part's X0 Y0, still turned
        ("G92 X0. Y0.\nG68 X10. Y10. R90.\nG01 X5. Y5. F100.\nG69\nG00 X0. Y0.", False),
    ],
)
def test_the_register_is_judged_in_the_coordinates_of_the_part(tmp_path: Path, text: str, off: bool) -> None:
    """X of the part is 0.1 mm off, in whichever coordinates the moves beside G92 are written."""
    source = f"G21 G17 G90\n{'' if text.startswith('G92') else 'G00 X0. Y0. Z5.'}\n{text}\nM30\n"
    shift = similarity_field(shift_mm=(0.1, 0.0, 0.0))
    if not off:
        mapped(tmp_path, source, shift, "fanuc-mill")
        return
    with pytest.raises(TrueloopError, match=r"0\.10000 mm off") as refused:
        mapped(tmp_path, source, shift, "fanuc-mill")
    assert refused.value.code == Code.NC_MAP


@pytest.mark.parametrize(
    ("frame", "then", "ends"),
    [
        ("", "", [10 + 15j, 30 + 15j]),
        ("ROT RPL=90", "", [-15 + 10j, -15 + 30j]),
        ("MIRROR X0", "", [-10 + 15j, -30 + 15j]),
        ("SCALE Z2", "", [10 + 15j, 30 + 15j]),
        ("SCALE X2 Y2", "", None),
        ("SCALE X2", "", None),
        ("", "G40\nROT RPL=90\n", None),
    ],
)
def test_a_tool_keeps_its_radius_where_coordinates_are_turned(
    frame: str, then: str, ends: list[complex] | None
) -> None:
    text = f"G710 G17 G90 G0 X0 Y0 Z5\nT1 D1\n{frame}\nG41 G1 X10 Y10 F100\nX30\n{then}G40 G1 X60 Y60\n"
    path = read_program(text.encode(), "siemens").run(tools=[CutterTool(5.0, number=1)], strict=False)
    errors = {found.code for found in path.findings if found.severity == "error"}
    assert errors == (set() if ends else {Code.NC_OPAQUE})
    if ends:
        assert path.end_mm[1:3, :2] == pytest.approx(np.array([[end.real, end.imag] for end in ends]), abs=1e-12)


def test_a_tip_is_not_turned() -> None:
    text = "G710 G18 G90 DIAMOF G0 X20 Z5\nT1 D1\n{}G41 G1 X10 Z0 F100\nZ-20\nG40 G1 X40 Z9\n"
    for frame, refused in (("", False), ("MIRROR X0\n", True), ("ROT RPL=30\n", True)):
        program = read_program(text.format(frame).encode(), "siemens")
        path = program.run(tools=[CutterTool(0.4, tip=3, number=1)], strict=False)
        errors = {found.code for found in path.findings if found.severity == "error"}
        assert errors == ({Code.NC_OPAQUE} if refused else set())


@pytest.mark.parametrize(
    ("dialect", "text", "end"),
    [
        ("heidenhain", "BEGIN PGM A MM\nQ1=0\n{}\n{}\nL X+10 Y+0 F9\nEND PGM A MM\n", [-10.0, 0.0]),
        ("siemens", "G710 G90 G0 X0 Y0\nR1=0\nG41 D1 G1 X5 Y5 F9\nAROT RPL=R1\nX10 Y0\n", [10.0, 0.0]),
    ],
)
def test_a_turn_by_a_parameter_that_is_zero_is_none(dialect: str, text: str, end: list[float]) -> None:
    path = read_program(text.format(cycle(10, "ROT+Q1"), cycle(8, "X")).encode(), dialect).run()
    assert not [found for found in path.findings if found.severity == "warning"]
    assert path.end_mm[-1, :2].tolist() == end


@pytest.mark.parametrize(
    ("dialect", "text", "line", "words"),
    [
        ("fanuc-mill", "G68 R30.\nG1 X5. Y5. F9.", 2, "G68"),  # about where the tool stands
        ("fanuc-mill", "G68 X0. Y0.\nG1 X5. Y5. F9.", 2, "G68"),  # by parameter 5410
        ("fanuc-mill", "G68 X0. Y0. I0. J0. K1. R30.\nG1 X5. Y5. F9.", 2, "G68"),
        ("fanuc-mill", "G68 X0. Y0. R30.\nG55\nG1 X5. Y5. F9.", 3, "set anew"),
        ("fanuc-mill", "G68 X0. Y0. R30.\nG52 X1.\nG1 X5. Y5. F9.", 3, "set anew"),
        ("fanuc-mill", "G68 X0. Y0. R30.\nG1 X5. F9.", 3, "Y has no position"),
        ("fanuc-mill", "G68 X0. Y0. R30.\nG91 G1 X5. Y5. F9.", 3, "has no position"),
        ("fanuc-mill", "G68 X0. Y0. R30.\nG0 X5. Y5.\nG18 G2 X9. Z5. R2. F9.", 4, "turned out of its plane"),
        ("haas-mill", "G41 D1 X1. Y1.\nG68 X0. Y0. R30.\nG1 X5. Y5. F9.", 3, "under G41"),
        ("siemens", "SCALE X2\nG0 X5 Y5\nG2 X9 Y5 CR=2 F9", 4, "scaled differently"),
        ("siemens", "G1 X-10 Y0 F9\nX0 Y0 RND=2\nROT RPL=90\nX20 Y0", 3, "a corner that is not cut"),
        ("siemens", "G1 X-10 Y0 F9\nANG=0\nROT RPL=90\nX20 Y5 ANG=60", 5, "an angle beside both"),
        ("fanuc-mill", "G1 X-9. Y0. F9.\nX0. Y0. ,R2.\nG68 X0. Y0. R90.\nX9. Y0.", 3, "a corner that is not cut"),
        ("siemens", "ROT X30\nG1 X5 Y5 F9", 2, "ROT X30"),
        ("fanuc-mill", "G51.1 X0.\nG55\nG1 X5. Y5. F9.", 3, "set anew"),
        ("fanuc-mill", "G41 D1 X1. Y1.\nG51.1 X0.\nG1 X5. Y5. F9.", 3, "under G41"),
        ("fanuc-mill", "G51.1 X0.\nG68 X5. Y0. R30.\nG1 X5. Y5. F9.", 3, "G68"),  # whose centre the mirror moves
        ("haas-mill", "G51 X0. Y0. Z0. P2.\nG51 X1. Y0. Z0. P2.\nG1 X5. Y5. F9.", 3, "over another"),
    ],
)
def test_what_is_not_followed_is_refused_by_its_block(
    tmp_path: Path, dialect: str, text: str, line: int, words: str
) -> None:
    head = "G710 G17 G90 G0 X0 Y0 Z5\n" if dialect == "siemens" else "G21 G17 G90 G00 X0. Y0. Z5.\n"
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, head + text + "\nM30\n", SHIFT, dialect)
    assert words in str(refused.value) and refused.value.place.line == line
    assert refused.value.code in (Code.NC_OPAQUE, Code.NC_MAP, Code.NC_ARC)
