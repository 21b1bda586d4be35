"""A field over programs of Sinumerik and Klartext: read back by our own runner, its moves judged by LinuxCNC."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import interpret
from tests.support.mapped import FREE, MIXED, displaced_path, mapped, path_of
from tests.support.nc_judge import assert_same_moves
from tests.support.plain_moves import plain_program
from trueloop.domain.option import MapOptions
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.machine import mapped_program
from trueloop.nc.field import Field, affine_field, function_field, similarity_field
from trueloop.nc.match.difference import path_difference

SHIFT = affine_field(np.eye(3), (0.01, 0.02, -0.003))
TURNED = similarity_field(shift_mm=(0.013, -0.021, 0.004), rotation_rad=2e-4, scale=1.0003, about_mm=(3.0, 4.0, 0.0))
NOTHING = affine_field(np.eye(3), (0.0, 0.0, 0.0))
STEP_MM = 1e-4

SINUMERIK = """%_N_A_MPF
;$PATH=/_N_MPF_DIR
N10 G17 G71 G90 G94 T1 M6
N20 G0 X=-20 Y=AC(0) Z5
N30 G1 Z-3 F=200
N40 X15.25 Y=IC(5)
N50 R1=20
N60 G3 X=R1+5.25 Y=AC(15) I=AC(15.25) J10
N70 G91 G2 X-5 Y=AC(20) CR=-5
N80 AGAIN: G90 G1 X=(R1+2)
N90 G0 Z5
N100 M30
"""
SINUMERIK_SHIFTED = {
    4: "N20 G0 X=-19.9900 Y=AC(0.0200) Z4.9970",
    5: "N30 G1 Z-3.0030 F=200",
    6: "N40 X15.2600 Y=IC(5)",
    8: "N60 G3 X=R1+5.25+0.01 Y=AC(15.0200) I=AC(15.2600) J10",
    9: "N70 G91 G2 X-5 Y=AC(20.0200) CR=-5",
    10: "N80 AGAIN: G90 G1 X=(R1+2+0.01)",
    11: "N90 G0 Z4.9970",
}
KLARTEXT = """0 BEGIN PGM PLATE MM
1 BLK FORM 0.1 Z X-50 Y-50 Z-20
2 TOOL CALL 5 Z S3000 F500
3 L Z+50 R0 FMAX M3
4 L X-0,01 Y+0,5 R0 F MAX
5 L Z-3 F200
6 L X+15,0 IY+4,5
7 CC X+15 Y+15
8 C X+25 Y+15 DR+
9 CR X+15 Y+25 R+10 DR+ F AUTO
10 L IX-5
11 CC X+10 Y+20
12 C X+10 Y+15 DR-
13 C X+10 Y+25 DR-
14 L Z+50 FMAX M30
15 END PGM PLATE MM
"""
KLARTEXT_SHIFTED = {
    4: "3 L Z+49,9970 R0 FMAX M3",
    5: "4 L X+0,0000 Y+0,5200 R0 F MAX",
    6: "5 L Z-3,0030 F200",
    7: "6 L X+15,0100 IY+4,5",
    8: "7 CC X+15,0100 Y+15,0200",
    9: "8 C X+25,0100 Y+15,0200 DR+",
    10: "9 CR X+15,0100 Y+25,0200 R+10 DR+ F AUTO",
    12: "11 CC X+10,0100 Y+20,0200",
    13: "12 C X+10,0100 Y+15,0200 DR-",
    14: "13 C X+10,0100 Y+25,0200 DR-",
    15: "14 L Z+49,9970 FMAX M30",
}
PROGRAMS = [(SINUMERIK, "siemens"), (KLARTEXT, "heidenhain")]


def without_mark(text: str) -> list[str]:
    return [line for line in text.splitlines() if "trueloop corrected" not in line]


def assert_judged(folder: Path, text: str, dialect: str) -> None:
    """LinuxCNC makes the moves that our own runner reads."""
    path = path_of(text, dialect)
    moves = folder / "moves.ngc"
    moves.write_bytes(plain_program(path))
    assert_same_moves(path, interpret(moves, startup="G17 G21"), same_lines=False)


def assert_displaced(source: str, text: str, dialect: str, field: Field) -> None:
    """Every end from the first cut on, to half a step, whatever its word said.

    An axis whose displacement changes by less than half a step and 1 nm is not written: it then carries the 1 nm, too.
    """
    before, after = path_of(source, dialect), path_of(text, dialect)
    first_cut = np.flatnonzero(~before.rapid)[0]
    wanted_mm = before.end_mm + field.displacement_mm(before.end_mm)
    assert np.abs(after.end_mm - wanted_mm)[first_cut:].max() <= 0.5001 * STEP_MM + 1e-6
    turned = (before.sweep_rad, after.sweep_rad)
    assert np.abs(turned[0] - turned[1]).max() < 1e-3


def test_a_formula_in_the_brackets_of_a_position_or_increment_stays_one(tmp_path: Path) -> None:
    head = "G71 G17 G90 F100\nR1=5\nG0 X0 Y0 Z0\n"
    text = head + "G1 X=AC(R1+2) Y=AC((R1-1)*2)\nX=IC(R1*2) Y=AC(-R1)\nG91 X=AC(R1) Y3\n"
    written, _ = mapped(tmp_path, text, SHIFT, "siemens")
    assert_displaced(text, written, "siemens", SHIFT)


@pytest.mark.parametrize(
    ("text", "dialect", "changed", "mark_line"),
    [(SINUMERIK, "siemens", SINUMERIK_SHIFTED, 3), (KLARTEXT, "heidenhain", KLARTEXT_SHIFTED, 2)],
)
def test_the_programmers_words_stay_what_they_were(
    tmp_path: Path, text: str, dialect: str, changed: dict[int, str], mark_line: int
) -> None:
    written, _ = mapped(tmp_path, text, SHIFT, dialect)
    wanted = [changed.get(line, old) for line, old in enumerate(text.splitlines(), 1)]
    assert without_mark(written) == wanted
    assert written.splitlines()[mark_line - 1].startswith("; trueloop corrected")


@pytest.mark.parametrize(("text", "dialect"), PROGRAMS)
def test_the_written_path_is_the_displaced_one_and_linuxcnc_agrees(tmp_path: Path, text: str, dialect: str) -> None:
    written, _ = mapped(tmp_path, text, SHIFT, dialect)
    assert_displaced(text, written, dialect, SHIFT)
    assert_judged(tmp_path, written, dialect)


@pytest.mark.parametrize(("text", "dialect"), PROGRAMS)
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_no_displacement_leaves_every_byte_but_the_mark(tmp_path: Path, text: str, dialect: str, ending: str) -> None:
    written, done = mapped(tmp_path, text.replace("\n", ending), NOTHING, dialect)
    assert done.edits == 0
    assert ending.join(without_mark(written)) + ending == text.replace("\n", ending)


def test_x_is_a_diameter_its_increments_and_centres_are_what_the_program_says(tmp_path: Path) -> None:
    """Under DIAM90 increments are radii; I=AC() is a diameter, I a radius."""
    text = "DIAM90 G18 G71 G90 G95\nG0 X=20 Z0\nG1 X=IC(5) F0.1\nG3 X=AC(40) Z-5 I=AC(30) K=AC(-5)\nG2 X50 Z-10 I5 K0\n"
    shift = affine_field(np.diag([1.001, 1.0, 1.001]), (0.5, 0.0, 0.0))
    written, _ = mapped(tmp_path, text, shift, "siemens")
    assert without_mark(written)[1:] == [
        "G0 X=21.0200 Z0",
        "G1 X=IC(5.0050) F0.1",
        "G3 X=AC(41.0400) Z-5.0050 I=AC(31.0300) K=AC(-5.0050)",
        "G2 X51.0500 Z-10.0100 I5.0050 K0",
    ]


def test_moves_that_bend_become_several_blocks_in_the_mode_in_force(tmp_path: Path) -> None:
    """New blocks say positions or increments as the mode has it; in Klartext they begin with L and have no number."""
    sinumerik = "G71 G17 G90\nN10 G0 X-80 Y-60 Z0\nN20 G1 X=IC(160) Y0 F200\nN30 G91 G1 X=AC(-80) Y=AC(-60)\nN40 Y50\n"
    klartext = "0 BEGIN PGM A MM\n1 L X-80 Y-60 Z+0 R0 FMAX\n2 L IX+160 Y+0 F200\n3 L X-80 IY-60\n4 END PGM A MM\n"
    for text, dialect, line in ((sinumerik, "siemens", "G1 X"), (klartext, "heidenhain", "L X-")):
        written, done = mapped(tmp_path, text, MIXED, dialect)
        assert done.added_blocks > 4
        assert any(new.startswith(line) for new in written.splitlines())
        before, after = path_of(text, dialect), path_of(written, dialect)
        assert path_difference(after, displaced_path(before, MIXED)).distance_mm < 0.0006
        assert_judged(tmp_path, written, dialect)


HEAD = "G71 G17 G90 F100\nG0 X20 Y1 Z1\n"
PLATE = "0 BEGIN PGM A MM\n1 L X+20 Y+1 Z+1 R0 FMAX\n"


@pytest.mark.parametrize(
    ("dialect", "text", "code", "line", "words"),
    [
        ("siemens", HEAD + "$P_PFRAME[X,TR]=10\nG1 X2\n", Code.NC_OPAQUE, 3, "$P_PFRAME[X,TR]=10"),
        ("siemens", HEAD + "$P_UIFR[1]=$P_UIFR[2]\nG1 X2\n", Code.NC_OPAQUE, 3, "$P_UIFR[1]=$P_UIFR[2]"),
        ("siemens", HEAD + "CYCLE800(0,1)\nG1 X2\n", Code.NC_OPAQUE, 3, "CYCLE800"),
        ("siemens", HEAD + "POCKET4(1)\n", Code.NC_OPAQUE, 3, "POCKET4"),
        ("siemens", HEAD + "R1=5\nG1 X=R1\nCT X9 Y3\n", Code.NC_EDIT, 5, "it depends on X=R1"),
        ("siemens", HEAD + "G1 X9 RND=30\nY9\n", Code.NC_OPAQUE, 3, "does not fit"),
        ("siemens", HEAD + "G1 X9 RND=1\nY9\nX=AC(5)+1\n", Code.NC_EXPRESSION, 5, "AC(5)+1 is not"),
        ("siemens", HEAD + "G1 X9 RND=1\nY9\nX=R7\n", Code.NC_PARAMETER, 5, "R7"),
        ("siemens", HEAD + "G1 X=AC(5)+1\n", Code.NC_EXPRESSION, 3, "AC(5)+1 is not"),
        ("siemens", "G71 G18 G90 F100\nG0 X1 Z1\nG1 X5\n", Code.NC_DIAMETER, 2, "diameter"),
        ("siemens", "G71 G90 F100\nG0 X1 Y1 Z1\nG18 G1 X5\n", Code.NC_DIAMETER, 3, "diameter"),
        ("siemens", "G71 G17 G90 F100\nG0 X1 Z1\nG18 G1 X5\n", Code.NC_DIAMETER, 3, "diameter"),
        ("siemens", "G71 G17 G90 G95 F0.2\nG0 X1 Y0 Z1\nG18\nG0 X5\n", Code.NC_DIAMETER, 4, "diameter"),
        ("siemens", HEAD + "SUPA G0 Z9\nG1 X2\n", Code.NC_MAP, 4, "place of the machine"),
        ("heidenhain", PLATE + "2 Q1 = 5\n3 L X+Q1\n", Code.NC_MAP, 4, "takes no sum"),
        ("heidenhain", PLATE + "2 Q1 = 5\n3 L X+Q1 Y+1\n4 CT X+9 Y+3\n", Code.NC_EDIT, 5, "it depends on X+Q1"),
        ("heidenhain", PLATE + "2 C X-20 Y+1 DR+\n", Code.NC_MAP, 3, "centre is not said"),
        ("heidenhain", PLATE + "2 Q1 = 25\n3 CC X+Q1 Y+1\n4 C X+30 Y+1 DR+\n", Code.NC_MAP, 4, "takes no sum"),
        ("heidenhain", PLATE + "2 CC X+25 Y+1\n3 C X+30 Y+1 DR+ M91\n", Code.NC_MAP, 4, "place of the machine"),
        ("heidenhain", PLATE + "2 CYCL DEF 204 BACK ~\n  Q200=2 ;A\n3 CYCL CALL\n", Code.NC_OPAQUE, 3, "CYCL DEF"),
        ("heidenhain", PLATE + "2 L M91 Z+9 FMAX\n3 L X+2 F9\n", Code.NC_MAP, 4, "place of the machine"),
    ],
)
def test_what_cannot_be_displaced_is_refused_with_its_place_and_nothing_written(
    tmp_path: Path, dialect: str, text: str, code: Code, line: int, words: str
) -> None:
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, text, SHIFT, dialect)
    assert (refused.value.code, refused.value.place.line) == (code, line), refused.value
    assert words in refused.value.message
    assert [file.name for file in tmp_path.iterdir()] == ["program.ngc"]


def test_a_program_that_writes_commas_gets_commas_wherever_it_is_read_in_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only its first move has decimals."""
    text = PLATE + "2 L X+2,5 F200\n" + "".join(f"{k} L X+{k} Y+{k % 5}\n" for k in range(3, 60))
    monkeypatch.setattr(mapped_program, "CHUNK", 64)
    written = mapped(tmp_path, text, SHIFT, "heidenhain")[0]
    moves = [line for line in written.splitlines() if " L " in line and not line.startswith("1 ")]
    assert len(moves) == 58
    assert all("," in line and "." not in line for line in moves)


def test_a_pole_of_two_arcs_has_to_go_to_one_place(tmp_path: Path) -> None:
    arcs = "2 CC X+22 Y+1\n3 C X+24 Y+1 DR+\n4 L X+60\n5 CC X+22 Y+1\n6 L X+24\n7 C X+20 Y+1 DR+\n"
    text = f"{PLATE}{arcs}"
    assert mapped(tmp_path, text, SHIFT, "heidenhain")[0].count("CC X+22.0100 Y+1.0200") == 2
    shared = "2 LBL 1\n3 CC X+22 Y+1\n4 C X+24 Y+1 DR+\n5 L X+20\n6 CALL LBL 1 REP 1\n"
    assert "CC X+22.0100" in mapped(tmp_path, f"{PLATE}{shared}", SHIFT, "heidenhain")[0]


BEND = function_field(lambda p: np.column_stack([1e-4 * p[:, 0] ** 2, 1e-5 * p[:, 0] ** 2, 0 * p[:, 0]]), "bend")
LIFT = function_field(lambda p: np.column_stack([0 * p[:, 0], 0 * p[:, 0], 2e-4 * p[:, 1]]), "lift")


@pytest.mark.parametrize(
    ("cut", "line"),
    [
        ("3 L X+Q2\n", 5),
        ("3 CC X+60 Y+1\n4 C X+Q2 Y+1 DR+\n", 6),
        ("3 CC X+Q1 Y+1\n4 C X+30 Y+1 DR+\n5 L X+60\n6 C X-10 Y+1 DR+\n", 8),
    ],
)
def test_a_parameter_has_nowhere_to_stop_on_the_way(tmp_path: Path, cut: str, line: int) -> None:
    beyond = function_field(lambda p: 1e-4 * np.maximum(p[:, [0]] - 30.0, 0.0) ** 2 * (1.0, 0.1, 0.0), "beyond 30")
    with pytest.raises(TrueloopError, match="parameter") as refused:
        mapped(tmp_path, PLATE + "2 Q1=25\n2 Q2=100\n" + cut, beyond, "heidenhain")
    assert (refused.value.code, refused.value.place.line) == (Code.NC_MAP, line)


def cut_between(text: str, first: str, last: str) -> list[str]:
    """The lines of a written program from one that begins so to one that does."""
    lines = text.splitlines()
    start, end = (next(n for n, line in enumerate(lines) if line.startswith(begin)) for begin in (first, last))
    return lines[start:end]


def test_an_arc_about_a_pole_becomes_several_each_with_its_own(tmp_path: Path) -> None:
    """Block numbers, feed and code stay with the first; the next arc about that pole gets one of its own as well."""
    text = PLATE + "2 CC X+60 Y+1\n3 C X+100 Y+1 DR+ R0 F100 ; half\n4 C X+20 Y+1 DR+\n5 L X+10\n"
    written, done = mapped(tmp_path, text, BEND, "heidenhain")
    upper, lower = cut_between(written, "2 CC", "4 C"), cut_between(written, "4 C", "5 L")
    assert upper[1].startswith("3 C ") and upper[1].endswith(" DR+ R0 F100 ; half")
    assert [line.split()[0] for line in upper[2:]] == ["CC", "C"] * (len(upper) // 2 - 1) + ["CC"]
    assert len(upper) > 8 and len(lower) > 8
    assert done.added_blocks == len(without_mark(written)) - len(text.splitlines())
    assert lower[-1] == "C X+20.0400 Y+1.0040 DR+"


def test_an_arc_by_its_radius_becomes_several_and_none_of_them_nearly_half_a_turn(tmp_path: Path) -> None:
    text = PLATE + "2 CR X+100 Y+1 R+40 DR-\n3 CR X+20 R-41 DR-\n"
    written, _ = mapped(tmp_path, text, TURNED, "heidenhain")
    path = path_of(written, "heidenhain")
    assert np.abs(path.sweep_rad).max() < 2.2
    assert [line.split()[-1] for line in without_mark(written)[2:]] == ["DR-"] * (len(path) - 1)
    assert "R-" not in written.replace("DR-", "")


def test_an_arc_that_would_have_to_leave_its_plane_becomes_lines(tmp_path: Path) -> None:
    """Helices with C are not known of every control."""
    text = PLATE + "2 CC X+20 Y+3\n3 C X+22 Y+3 DR+ F50\n4 CR X+20 Y+5 R+2 DR+ M8\n5 CC Y+9\n"
    written, _ = mapped(tmp_path, text, LIFT, "heidenhain", MapOptions(0.01, np.inf, np.inf))
    first, second = cut_between(written, "3 L", "4 L"), cut_between(written, "4 L", "5 CC")
    assert first[0].startswith("3 L X+") and first[0].endswith(" F50")
    assert second[0].endswith(" M8") and "DR" not in written and "R+" not in written
    assert all(line.startswith("L X+") for line in first[1:] + second[1:])


@pytest.mark.parametrize("turn", ["CP IPA+360 IZ-2 DR+", "CP IPA-90 IZ-2 DR-", "C X+0 Y+10 IZ-2 DR+"])
def test_a_helix_of_klartext_becomes_lines_for_only_cp_writes_one(tmp_path: Path, turn: str) -> None:
    """TNC7 81762x-16, Helix: "can only be programmed with a circular path CP"; C and CR would not cut one.

    A field that is not a shift displaces the pole of a CP and its ends differently.
    """
    text = f"0 BEGIN PGM A MM\n1 L X+10 Y+0 Z+0 R0 F100\n2 CC X+0 Y+0\n3 {turn}\n4 L X+20\n"
    written, _ = mapped(tmp_path, text, affine_field(np.diag((1.0, 1.0, 1.0 + 1e-9)), (0.1, 0.2, -0.25)), "heidenhain")
    lines = written.splitlines()[4:-1]
    assert all(" L X" in f" {line}" for line in lines) and len(lines) > 100
    path = path_of(written, "heidenhain")
    x, y, z = (path.end_mm[1:-1] - (0.1, 0.2, -0.25)).T
    assert np.hypot(x, y) == pytest.approx(10.0, abs=2e-4)
    turned = np.unwrap(np.concatenate([[0.0], np.arctan2(y, x)]))[1:]
    assert z == pytest.approx(-2.0 * turned / turned[-1], abs=2e-4)
    whole = {"CP IPA+360": 360.0, "CP IPA-90 ": -90.0}.get(turn[:10], 90.0)
    assert np.degrees(turned[-1]) == pytest.approx(whole, abs=1e-3)


POLAR = """BEGIN PGM A MM
TOOL CALL 1 Z S2000 F300
L X+60 Y+50 Z+5 R0 FMAX
CC X+50 Y+50
CP IPA+1890 IZ-7 DR+
CC IX-4 Y+40
LP PR+8 PA+30
CC
LP PR+6 IPA-120 R0 FMAX
CP IPA+90 Z-4 DR+
CC X+20 Z-10
CP IPA-45 DR-
L Z+50 R0 FMAX
END PGM A MM
"""


def test_a_shift_moves_the_pole_and_leaves_what_is_about_it(tmp_path: Path) -> None:
    """Five turns and a quarter from (60, 50) about (50, 50) end at (50, 60); the next pole is 4 mm left of that."""
    written, _ = mapped(tmp_path, POLAR, SHIFT, "heidenhain")
    assert without_mark(written) == [
        "BEGIN PGM A MM",
        "TOOL CALL 1 Z S2000 F300",
        "L X+60.0100 Y+50.0200 Z+4.9970 R0 FMAX",
        "CC X+50.0100 Y+50.0200",
        "CP IPA+1890 IZ-7 DR+",
        "CC IX-4 Y+40.0200",
        "LP PR+8 PA+30",
        "CC",
        "LP PR+6 IPA-120 R0 FMAX",
        "CP IPA+90 Z-4.0030 DR+",
        "CC X+20.0100 Z-10.0030",
        "CP IPA-45 DR-",
        "L Z+49.9970 R0 FMAX",
        "END PGM A MM",
    ]
    path = path_of(written, "heidenhain")
    by = np.array((0.01, 0.02, -0.003))
    wanted = np.array([[60, 50, 5], [50, 60, -2], [46 + 8 * math.cos(math.pi / 6), 44, -2]]) + by
    assert path.end_mm[:3] == pytest.approx(wanted, abs=1e-9)
    assert np.degrees(path.sweep_rad[1]) == pytest.approx(-1890.0)
    source = path_of(POLAR, "heidenhain")
    assert path.end_mm == pytest.approx(source.end_mm + by, abs=1e-9)
    assert path.centre_mm[[1, 4, 5]] == pytest.approx(source.centre_mm[[1, 4, 5]] + by, abs=1e-9)


def test_the_tool_s_axis_alone_before_a_position_across_is_displaced_with_that(tmp_path: Path) -> None:
    """Without X and Y the field is not known; a retract there is that of a hole at a place set by hand."""
    text = "BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL Z+9 R0 F9999\nL Z+5\nL X+1 Y+25 FMAX\nL Z-2 F200\nEND PGM A MM\n"
    written, _ = mapped(tmp_path, text, SHIFT, "heidenhain")
    assert without_mark(written)[2:6] == [
        "L Z+9 R0 F9999",
        "L Z+5",
        "L X+1.0100 Y+25.0200 Z+4.9970 FMAX",
        "L Z-2.0030 F200",
    ]
    with pytest.raises(TrueloopError, match="X has no position yet in the cut"):
        mapped(tmp_path, text.replace("L Z+5\n", "L Z+5 FMAX\n"), SHIFT, "heidenhain")


def test_an_arc_about_the_pole_of_a_polar_move_has_the_moved_one(tmp_path: Path) -> None:
    head = "BEGIN PGM A MM\nL X+60 Y+50 Z+5 R0 FMAX\nCC X+50 Y+50\n"
    for moves in ("CP IPA+90 DR+ F100\nC X+40 Y+50 DR+\n", "C X+50 Y+60 DR+ F100\nCP IPA+90 DR+\n"):
        written, _ = mapped(tmp_path, head + moves + "END PGM A MM\n", SHIFT, "heidenhain")
        assert written.count("CC ") == written.count("CC X+50.0100 Y+50.0200") == 1
        assert path_of(written, "heidenhain").end_mm[-1].tolist() == pytest.approx([40.01, 50.02, 4.997])


BY_PARAMETER = """BEGIN PGM A MM
TOOL CALL 1 Z S2000 F300
Q1 = 10
Q99 = 3
LBL 1
L X+Q1 Y-Q99 Z+5 R0 FMAX
L Z-Q99 F100
Q1 = Q1 + 5
CALL LBL 1 REP 2
END PGM A MM
"""


def test_a_coordinate_by_a_parameter_goes_by_one_that_the_program_does_not_use(tmp_path: Path) -> None:
    """−(Q99 − 0.02) is 0.02 more than −Q99. X is 10, 15, 20 in the three runs of the section."""
    written, done = mapped(tmp_path, BY_PARAMETER, SHIFT, "heidenhain")
    assert without_mark(written)[5:11] == [
        "FN 1: Q98 = +Q1 + +0.0100",
        "FN 1: Q97 = +Q99 + -0.0200",
        "L X+Q98 Y-Q97 Z+4.9970 R0 FMAX",
        "FN 1: Q96 = +Q99 + +0.0030",
        "L Z-Q96 F100",
        "Q1 = Q1 + 5",
    ]
    assert done.added_blocks == 3
    ends = path_of(written, "heidenhain").end_mm
    assert ends[:, 0].tolist() == pytest.approx([10.01, 10.01, 15.01, 15.01, 20.01, 20.01])
    assert ends[:, 1] == pytest.approx(-2.98)
    assert ends[1::2, 2] == pytest.approx(-3.003)


def test_arcs_that_hardly_leave_their_planes_do_not_drift(tmp_path: Path) -> None:
    """Z rises by 0.04 µm, less than half a step, an arc: left out of each, and made up for by a line between two."""
    slope = function_field(lambda p: np.column_stack([0 * p[:, 0], 0 * p[:, 0], 2e-5 * (p[:, 0] - 20.0)]), "slope")
    arcs = "".join(f"2 CC X+{x + 1} Y+1\n3 C X+{x + 2} Y+1 DR- F9\n" for x in range(20, 60, 2))
    written, _ = mapped(tmp_path, PLATE + arcs, slope, "heidenhain")
    before, after = path_of(PLATE + arcs, "heidenhain"), path_of(written, "heidenhain")
    assert path_difference(after, displaced_path(before, slope)).distance_mm < 2 * STEP_MM
    lifts = [line for line in written.splitlines() if line.startswith("L X") and "Z+1.000" in line]
    assert 3 < len(lifts) < 9
    assert not any("Z" in line for line in written.splitlines() if line.startswith("3 C"))


@pytest.mark.parametrize("pole", ["2 CC IX+2 Y+1", "2 CC X+22", "2 L X+22\n2 CC\n2 L X+20"])
def test_a_pole_that_is_no_plain_position_is_followed_by_one(tmp_path: Path, pole: str) -> None:
    """It stays; where nothing is displaced nothing is written."""
    text = f"{PLATE}{pole}\n3 C X+24 Y+1 DR+ F100\n4 L X+25\n"
    written, _ = mapped(tmp_path, text, SHIFT, "heidenhain")
    assert cut_between(written, "2 CC", "4 L")[-2:] == ["CC X+22.0100 Y+1.0200", "3 C X+24.0100 Y+1.0200 DR+ F100"]
    assert without_mark(mapped(tmp_path, text, NOTHING, "heidenhain")[0]) == text.splitlines()


def test_a_pole_in_a_loop(tmp_path: Path) -> None:
    """One block cannot be in two places, and another pole before the call is not the one displaced."""
    loop = "2 CC X+22 Y+1\n3 LBL 1\n4 C X+24 Y+1 DR+ F9\n5 L X+20\n6 CALL LBL 1 REP 1\n7 L X+30\n"
    assert_displaced(f"{PLATE}{loop}", mapped(tmp_path, f"{PLATE}{loop}", SHIFT, "heidenhain")[0], "heidenhain", SHIFT)
    again = f"{PLATE}2 CC X+22 Y+1\n3 LBL 1\n4 C X+24 Y+1 DR+ F9\n5 L X+20\n6 CC X+22 Y+1\n7 CALL LBL 1 REP 1\n"
    written = mapped(tmp_path, again, SHIFT, "heidenhain")[0]
    assert_displaced(again, written, "heidenhain", SHIFT)
    assert written.count("CC X+22.0100 Y+1.0200") == 2
    bent = f"{PLATE}2 CC X+60 Y+1\n3 LBL 1\n4 C X+100 Y+1 DR+\n5 C X+20 Y+1 DR+\n6 CALL LBL 1 REP 1\n"
    with pytest.raises(TrueloopError, match="several times"):
        mapped(tmp_path, bent, BEND, "heidenhain")
    inside = bent.replace("3 LBL 1\n", "").replace("2 CC", "2 LBL 1\n3 CC")
    written = mapped(tmp_path, inside, BEND, "heidenhain")[0]
    assert (
        path_difference(path_of(written, "heidenhain"), displaced_path(path_of(inside, "heidenhain"), BEND)).distance_mm
        < 0.0006
    )


def test_an_axis_with_a_number_may_turn(tmp_path: Path) -> None:
    """`A1=30` is a turn as `A30` is, but of which axis is not known: a field that follows A refuses it."""
    follows = Field(SHIFT.identity, SHIFT.core, frozenset("A"))
    for word, words in (("A=30", "A does not stand at 0"), ("A1=30", "an axis with a number turns")):
        with pytest.raises(TrueloopError, match=words) as refused:
            mapped(tmp_path, f"{HEAD}G1 X5 {word}\n", follows, "siemens")
        assert refused.value.place.line == 3


def decimal(value: int) -> str:
    return f"{value / 1000:.3f}"


steps = st.integers(-30_000, 30_000)
sizes = st.integers(1_000, 20_000)


@st.composite
def sinumerik_blocks(draw: st.DrawFn) -> str:
    """Lines and half circles, every word in one of the ways in which a position or an increment may be said."""
    forms = [
        "{a}{v}",
        "{a}={v}",
        "{a} = {v}",
        "{a}=AC({v})",
        "{a}=IC({v})",
        "{a}=R1+{v}",
        "{a}=(R1*2+{v})",
        "{a}=AC(R1)",
    ]
    kind = draw(st.sampled_from(["line", "centre", "about", "radius"]))
    if kind == "line":
        axes = draw(st.lists(st.sampled_from("XYZ"), min_size=1, unique=True))
        words = [draw(st.sampled_from(forms)).format(a=axis, v=decimal(draw(steps))) for axis in axes]
        return " ".join([draw(st.sampled_from(["G0", "G1", "G90 G1", "G91 G1"])), *words])
    code, i, j = draw(st.sampled_from(["G2", "G3"])), draw(sizes), draw(sizes)
    if kind == "centre":
        return f"{code} X=IC({decimal(2 * i)}) Y=IC({decimal(2 * j)}) I{decimal(i)} J=IC({decimal(j)})"
    if kind == "about":
        x, y = draw(steps), draw(steps)
        to = f"X=AC({decimal(x + 2 * i)}) Y=AC({decimal(y)}) I=AC({decimal(x + i)}) J=AC({decimal(y)})"
        return f"G1 X=AC({decimal(x)}) Y=AC({decimal(y)})\n{code} {to}"
    return f"{code} X=IC({decimal(8 * i)}) Y=IC(0) CR={draw(st.sampled_from(['', '-']))}{decimal(5 * i)}"


@st.composite
def klartext_blocks(draw: st.DrawFn) -> str:
    """Without numbers: L with positions and increments, CC with one or two half circles, CR."""
    kind = draw(st.sampled_from(["line", "pole", "radius"]))
    signed = st.sampled_from(["", "+"])

    def word(axis: str, value: int, increment: bool = False) -> str:
        plus = draw(signed) if value >= 0 else ""
        return f"{'I' if increment else ''}{axis}{plus}{decimal(value)}"

    if kind == "line":
        axes = draw(st.lists(st.sampled_from("XYZ"), min_size=1, unique=True))
        words = [word(axis, draw(steps), draw(st.booleans())) for axis in axes]
        return " ".join(["L", *words, draw(st.sampled_from(["", "R0 FMAX", "F200 M3"]))]).rstrip()
    turn = draw(st.sampled_from(["DR+", "DR-"]))
    if kind == "radius":
        size = draw(sizes)
        return f"CR {word('X', 8 * size, True)} R{draw(st.sampled_from(['+', '-']))}{decimal(5 * size)} {turn}"
    x, y, radius = draw(steps), draw(steps), draw(sizes)
    back = f"\nC {word('X', x)} {word('Y', y)} {turn}" if draw(st.booleans()) else ""
    lead = f"L {word('X', x)} {word('Y', y)} F99\nCC {word('X', x)} {word('Y', y + radius)}"
    return f"{lead}\nC {word('X', x)} {word('Y', y + 2 * radius)} {turn}{back}"


fields = st.sampled_from([SHIFT, TURNED])
WIDE = MapOptions(tolerance_mm=0.002, limit_mm=np.inf, slope=np.inf)
CHECKED = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@CHECKED
@given(st.lists(sinumerik_blocks(), min_size=1, max_size=8), fields)
def test_every_end_of_generated_sinumerik_programs_is_displaced(
    tmp_path: Path, blocks: list[str], field: Field
) -> None:
    body = "\n".join(blocks)
    check(tmp_path, f"G71 G17 G90 F100\nR1=7\nG0 X0 Y0 Z0\nG1 X1\n{body}\nM30\n", "siemens", field)


@CHECKED
@given(st.lists(klartext_blocks(), min_size=1, max_size=8), fields, st.booleans())
def test_every_end_of_generated_klartext_is_displaced(
    tmp_path: Path, blocks: list[str], field: Field, comma: bool
) -> None:
    lines = "\n".join(["TOOL CALL 1 Z S1000", "L X+0 Y+0 Z+0 R0 FMAX", "L X+1 F100", *blocks, "L Z+5 M30"]).split("\n")
    text = "".join(f"{number} {line}\n" for number, line in enumerate(["BEGIN PGM A MM", *lines, "END PGM A MM"]))
    check(tmp_path, text.replace(".", ",") if comma else text, "heidenhain", field)


def check(folder: Path, text: str, dialect: str, field: Field) -> None:
    """Displaced to half a step, as LinuxCNC makes its moves; nothing displaced, byte for byte."""
    written, done = mapped(folder, text, field, dialect, WIDE)
    assert done.added_blocks == 0
    assert_displaced(text, written, dialect, field)
    assert_judged(folder, written, dialect)
    assert without_mark(mapped(folder, text, NOTHING, dialect, FREE)[0]) == text.splitlines()


@settings(CHECKED, max_examples=25)
@given(st.lists(klartext_blocks(), min_size=1, max_size=5), st.sampled_from([MIXED, BEND, TURNED]))
def test_generated_klartext_follows_a_field_that_bends(tmp_path: Path, blocks: list[str], field: Field) -> None:
    """Within the tolerance of the displaced path, as LinuxCNC runs it; what is no coordinate stays in its block."""
    lines = "\n".join(["TOOL CALL 1 Z S1000", "L X+0 Y+0 Z+0 R0 FMAX", "L X+1 F100", *blocks, "L Z+5 M30"]).split("\n")
    text = "".join(f"{number} {line}\n" for number, line in enumerate(["BEGIN PGM A MM", *lines, "END PGM A MM"]))
    written, _ = mapped(tmp_path, text, field, "heidenhain")
    before, after = path_of(text, "heidenhain"), path_of(written, "heidenhain")
    assert not after.findings
    assert path_difference(after, displaced_path(before, field)).distance_mm <= 0.0005 + 2 * STEP_MM
    assert_judged(tmp_path, written, "heidenhain")
    old = [line for line in written.splitlines() if line[0].isdigit()]
    assert [rest(line) for line in old] == [rest(line) for line in text.splitlines()]


def rest(line: str) -> str:
    """What a line has beside its function, turn, radius and coordinates."""
    return re.sub(r" (L|CR?|DR[-+]|I?[XYZR][-+]?[\d.]+)(?= |$)", "", line)


@settings(CHECKED, max_examples=25)
@given(sizes, sizes, st.integers(1000, 1500), fields, st.booleans())
def test_arcs_by_a_radius_near_half_a_turn_follow_the_field(
    tmp_path: Path, i: int, j: int, share: int, field: Field, wide: bool
) -> None:
    """The last digit of the radius would throw the middle of such an arc off."""
    radius = np.hypot(i, j) * share / 2e6 + 1e-3
    text = f"G71 G17 G90 F100\nG0 X0 Y0 Z0\nG1 X1\nG3 X{1 + i / 1000:.3f} Y{j / 1000:.3f} CR={'-' * wide}{radius:.4f}\n"
    written, _ = mapped(tmp_path, text, field, "siemens")
    before, after = path_of(text, "siemens"), path_of(written, "siemens")
    assert path_difference(after, displaced_path(before, field)).distance_mm <= 0.0005 + 3 * STEP_MM
    assert_judged(tmp_path, written, "siemens")


RETRACTED = """0 BEGIN PGM A MM
1 TOOL DEF 1 L+1 R+2
2 TOOL DEF 2 L+18.5 R+3
3 TOOL CALL 1 Z S900
4 L X+10 Y+20 R0 FMAX
5 L Z+25 FMAX
6 L Z-3 F200
7 L M140 MB MAX
8 L Z+25 FMAX
9 TOOL CALL 2 Z S900
10 PLANE SPATIAL SPA+0 SPB+0 SPC+0 STAY
11 CYCL DEF 10.0 ROTATION
12 CYCL DEF 10.1 ROT+0
13 CYCL DEF 1.0 PECKING
14 CYCL DEF 1.1 DIST2
15 CYCL DEF 1.2 DEPTH-7
16 L X+30 FMAX M99
17 TOOL CALL 3 Z S900
18 CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206= AUTO Q203=+0 Q204=20
19 L X+40 R0 FMAX
20 CYCL CALL
21 CYCL DEF 7.0 DATUM SHIFT
22 CYCL DEF 7.1 X+100
23 L X+1 F200
24 END PGM A MM
"""
RETRACTED_SHIFTED = {
    5: "4 L X+10.0100 Y+20.0200 R0 FMAX",
    6: "5 L Z+24.9970 FMAX",
    7: "6 L Z-3.0030 F200",
    9: "8 L Z+24.9970 FMAX",
    17: "16 L X+30.0100 FMAX M99",
    19: "18 CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206= AUTO Q203=-0.0030 Q204=20",
    20: "19 L X+40.0100 R0 FMAX",
    24: "23 L X+1.0100 F200",
}
SWIVELLED = """N10 G17 G71 G90 G94 G54
N20 CYCLE800(1,"",0,57,0,0,0,0,0,0,0,0,0,-1,)
N30 T1 D1 M6
N40 G0 X1 Y2
N50 Z5
N60 G1 X9 RND=2 F200
N70 Y9
N80 MCALL CYCLE81(10,0,2,-15)
N90 X20 Y20
N100 MCALL
N110 TRANS X50
N120 X4
N130 AROT Z0
N140 ROT
N150 X6 Y1
N160 G74 Z1=0
N170 G75 X0 Y0
N180 M30
"""
SWIVELLED_SHIFTED = {
    5: "N50 X1.0100 Y2.0200 Z4.9970",
    6: "N60 G1 X7.0100 F200\nN61 G3 X9.0100 Y4.0200 CR=2.0000",
    7: "N70 G1 Y9.0200",
    8: "N80 MCALL CYCLE81(9.9970,-0.0030,2,-15.0030)",
    9: "N90 X20.0100 Y20.0200",
    12: "N120 X4.0100",
    15: "N150 X6.0100 Y1.0200",
}


@pytest.mark.parametrize(
    ("dialect", "text", "changed"),
    [("heidenhain", RETRACTED, RETRACTED_SHIFTED), ("siemens", SWIVELLED, SWIVELLED_SHIFTED)],
)
def test_what_leaves_positions_as_they_are_stops_no_correction(
    tmp_path: Path, dialect: str, text: str, changed: dict[int, str]
) -> None:
    """Tools of stated length, retractions, planes and rotations of 0, shifts between cuts: all other lines stay."""
    written = mapped(tmp_path, text, SHIFT, dialect)[0].splitlines()
    lines = [changed.get(k + 1, line) for k, line in enumerate(text.splitlines())]
    assert [line for line in written if "corrected" not in line] == "\n".join(lines).splitlines()


@pytest.mark.parametrize(
    ("dialect", "text", "words"),
    [
        ("heidenhain", PLATE + "2 CYCL DEF 10.1 ROT+Q1\n", "ROT"),
        ("heidenhain", PLATE + "2 CYCL DEF 11.1 SCL 0.99\n", "SCL"),
        ("heidenhain", PLATE + "2 PLANE SPATIAL SPA+0 SPB+0 SPC+0 MOVE ABST50 F1000\n", "PLANE"),
        ("heidenhain", PLATE + "2 TOOL CALL 2 Z\n3 L X+9 F9\n", "Z has no position"),
        ("heidenhain", PLATE + "2 L X+5 RL F9\n3 DEP LT LEN5\n4 L X+9 FMAX\n5 L Z-1\n", "Y has no position"),
        ("siemens", HEAD + "ROT Z=R0\nG1 X2\n", "ROT"),
        ("heidenhain", PLATE + "2 CYCL DEF 19.1 A+0.00000000 B+0.00000000 C+0.5\n", "19.1"),
        ("siemens", HEAD + "ASCALE X0\nG1 X2\n", "ASCALE"),
        ("siemens", HEAD + 'CYCLE800(0,"",0,57,0,0,0,0,30,0,0,0,0,1)\nG1 X2\n', "CYCLE800"),
        ("siemens", HEAD + "G75 X0\nG1 Y2\n", "X stands at a place of the machine"),
        ("siemens", HEAD + "G74 Z1=0\nG1 Y2\n", "Z stands at a place of the machine"),
        ("siemens", HEAD + "G1 X1=2\n", "X1=2"),
    ],
)
def test_what_turns_positions_or_takes_an_axis_away_stops_it(
    tmp_path: Path, dialect: str, text: str, words: str
) -> None:
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, text, SHIFT, dialect)
    assert words in refused.value.message


LED = """BEGIN PGM A MM
TOOL CALL 1 Z S4000
L X-90 Y-80 R0 FMAX
L Z-5 R0 F1000 M3
APPR LCT X+5 Y+6 R5 RL F300
L X+6 Y+9
DEP LCT X-80 Y+70 R5 F1000
L Z+2 FMAX
L X+20 Y-80 FMAX
L Z-5 F1000
APPR CT X+9 Y+6 CCA180 R+10 RR F300
L X+90 Y+6
DEP CT CCA180 R+8
L Z+2 FMAX
END PGM A MM
"""


def test_the_way_to_a_contour_is_the_control_s_and_not_divided(tmp_path: Path) -> None:
    """120 mm through a field that bends: the points that the blocks name are displaced, and no block is added. The
    field is worked out here."""
    text, _ = mapped(tmp_path, LED, MIXED, "heidenhain")
    lines = [line for line in text.splitlines() if line.startswith(("APPR", "L X+", "DEP"))]
    assert lines[-1] == "DEP CT CCA180 R+8"
    lines = [line for line in lines[:5] if not line.endswith("FMAX")]
    for line, head, tail, (x, y) in zip(
        lines,
        ("APPR LCT ", "L ", "DEP LCT ", "APPR CT "),
        (" R5 RL F300", "", " R5 F1000", " CCA180 R+10 RR F300"),
        ((5.0, 6.0), (6.0, 9.0), (-80.0, 70.0), (9.0, 6.0)),
        strict=True,
    ):
        named = line.removeprefix(head).removesuffix(tail).split()
        ends = [float(word.lstrip("XYZ")) for word in named[:2]]
        assert ends == pytest.approx([x + 0.03 * np.sin(y / 30), y + 0.02 * np.cos(x / 25)], abs=STEP_MM)


TOUCHED = """%
O1001<PLATE>
G21 G90 G17 G94
G54 G0 X0. Y0.
G43 H1 Z50.
G10 L12 P1 R5.
G65 P9810 X10. Y10. Z5. F3000.
G65 P9811 Z0. S1
G0 X5. Y5.
G1 X7. Y8. Z-1. F100.
M30
%
cut X1 Y2 before
"""


def test_touch_macros_tool_data_and_text_behind_the_tape_stay(tmp_path: Path) -> None:
    """After the touches the control has positions of its own: the next move that names all axes is displaced."""
    written = mapped(tmp_path, TOUCHED, SHIFT, "fanuc-mill")[0].splitlines()
    assert written[4:11] == [
        "G54 G0 X0.010 Y0.020",
        "G43 H1 Z49.997",
        "G10 L12 P1 R5.",
        "G65 P9810 X10. Y10. Z5. F3000.",
        "G65 P9811 Z0. S1",
        "G0 X5. Y5.",
        "G1 X7.010 Y8.020 Z-1.003 F100.",
    ]
    assert written[-2:] == ["%", "cut X1 Y2 before"]


def test_a_lathe_s_program_without_a_plane_is_not_mapped_before_x_is_known(tmp_path: Path) -> None:
    """X of such a program was taken as a radius: its shift was half of what the field states where it is a diameter."""
    text = "G71 G90 G95 S250 M4\nG0 X14 Z2\nG1 Z0 F0.1\nG3 X20 Z-3 CR=5\nM30\n"
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, text, SHIFT, "siemens")
    assert refused.value.code is Code.NC_DIAMETER
