"""A field over a program: the written path is the displaced one, in any dialect, in streaming, without drift."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import interpret
from tests.support.mapped import FREE, MIXED, displaced_path, mapped, path_of
from tests.support.nc_judge import assert_same_moves
from tests.support.refusals import refused
from trueloop.arrays import Array
from trueloop.domain.option import MapOptions
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.machine import mapped_program
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.nc.field import affine_field, function_field, similarity_field, table_field
from trueloop.nc.match.difference import path_difference
from trueloop.nc.program.program import read_program

PART = """%
G21 G17 G90 G54 F200 (pocket, boss and slope)
#1=20
N10 G0 X-80 Y-60 Z5
N20 G1 Z-2
N30 X[80+#1] (an expression)
N40 Y60.0 F400
N50 G3 X80 Y80 I-20 J0
N60 G1 X-60
N70 G3 X-80 Y60 R20
N80 G91 G1 Y-60
N90 X-.5
N100 G90 G0 Z5
N110 X30 Y0
N120 G1 Z-3
N130 G2 I-30 J0
N140 G3 X-30 Y0 Z-10 I-30 J0 (helix)
N150 G1 X0 Y0 Z-15
N160 G18 G2 X40 Z-15 I20 K5
N170 G19 G3 Y30 Z0 J15 K7.5
N180 G17 G1 X100 Y90 Z4.5
N190 G0 Z20
M2
%
"""


def test_the_written_path_is_the_displaced_one_and_linuxcnc_runs_it(tmp_path: Path) -> None:
    text, _ = mapped(tmp_path, PART, MIXED)
    path = path_of(text)
    assert path_difference(path, displaced_path(path_of(PART), MIXED)).distance_mm < 0.0006
    assert_same_moves(
        read_program(text.encode(), "linuxcnc").run(), interpret(tmp_path / "mapped.ngc", startup="G17 G21")
    )


def test_what_need_not_change_stays_and_the_programmers_hand_is_kept(tmp_path: Path) -> None:
    text, _ = mapped(tmp_path, PART, affine_field(np.eye(3), (0.25, 0.0, 0.0)))
    lines = {line.split()[0]: line for line in text.splitlines() if line.startswith("N")}
    assert lines["N20"] == "N20 G1 Z-2"
    assert lines["N30"] == "N30 X[80+#1+0.25] (an expression)"
    assert lines["N40"] == "N40 Y60.0 F400"
    assert lines["N50"] == "N50 G3 X80.25000 Y80 I-20 J0"
    assert lines["N90"] == "N90 X-.5"
    assert lines["N130"] == "N130 G2 I-30 J0"


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_no_displacement_leaves_every_byte_but_the_mark(tmp_path: Path, ending: str) -> None:
    source = PART.replace("\n", ending)
    text, _ = mapped(tmp_path, source, affine_field(np.eye(3), (0.0, 0.0, 0.0)))
    mark = text.splitlines(keepends=True)[1]
    assert mark.startswith("(trueloop corrected ")
    assert text.replace(mark, "") == source


def test_the_size_of_the_parts_does_not_show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    once, _ = mapped(tmp_path, PART, MIXED)
    for size in (1, 7, 64, 300):
        monkeypatch.setattr(mapped_program, "CHUNK", size)
        assert mapped(tmp_path, PART, MIXED)[0] == once


@pytest.mark.parametrize(
    ("before", "after"),
    [
        # Z has no position at the first rapid: it is not driven to 0 and its displacement waits for its own word
        ("G54\nG0 X100 Y50\nG43 H1 Z50\nG1 Z2 F1", "G0 X100.10000 Y50.10000\nG43 H1 Z50.10000\nG1 Z2.10000 F1"),
        ("G91 G28 Z0\nG90\nG0 X10 Y5\nZ5", "G91 G28 Z0\nG90\nG0 X10 Y5\nX10.10000 Y5.10000 Z5.10000"),
        # the first cut arrives from an unknown height: it is not divided
        ("G0 X10 Y5\nG1 Z5 F1\nX20", "G0 X10.10000 Y5.10000\nG1 Z5.10000 F1\nX20.10000"),
    ],
)
def test_an_axis_of_which_nobody_knows_where_it_stands_is_not_driven(tmp_path: Path, before: str, after: str) -> None:
    up = function_field(lambda p: np.full_like(p, 0.1), "a tenth in all directions")
    written, _ = mapped(tmp_path, f"G21 G90\n{before}\nM2\n", up)
    lines = written.splitlines()
    wanted = after.splitlines()
    assert lines[-1 - len(wanted) : -1] == wanted


def test_an_axis_that_the_machine_may_not_have_is_not_named(tmp_path: Path) -> None:
    turn = similarity_field(rotation_rad=0.0003, axis="Z")
    with pytest.raises(TrueloopError, match=r"Y is displaced by 0\.00900 mm"):
        mapped(tmp_path, "G21 F1\nG0 X30. Z1.\nG1 Z-20.\n", turn, "fanuc-mill")


def test_the_limits_hold_within_a_move_too(tmp_path: Path) -> None:
    bump = table_field(
        np.array([0.0, 50.0, 100.0]), np.array([0.0]), np.array([0.0]), np.array([[0.0, 0, 0], [0, 5.0, 0], [0, 0, 0]])
    )
    source = "G21 F1\nG0 X0 Y0\nG1 X100\n"
    with pytest.raises(TrueloopError, match=r"reaches 5.0000 mm .* limit is 0.15") as refusal:
        mapped(tmp_path, source, bump, options=MapOptions(slope=1.0))
    assert (refusal.value.code, refusal.value.place.line) == (Code.CMP_SIZE, 3)
    with pytest.raises(TrueloopError, match=r"100.0 µm/mm") as refusal:
        mapped(tmp_path, source, bump, options=MapOptions(limit_mm=10.0))
    assert refusal.value.code == Code.CMP_SLOPE
    assert mapped(tmp_path, source, bump)[1].largest_mm[1] == pytest.approx(5.0)


def test_the_mark_stands_after_the_percent_sign_wherever_that_is(tmp_path: Path) -> None:
    still = affine_field(np.eye(3), (0.0, 0.0, 0.0))
    text, _ = mapped(tmp_path, "\n%\nG21 G0 X1\nM2\n%\n", still)
    assert text.splitlines()[:2] == ["", "%"]
    assert text.splitlines()[2].startswith("(trueloop corrected ")


def test_what_the_parameters_were_is_part_of_the_record(tmp_path: Path) -> None:
    source, grown = tmp_path / "p.ngc", similarity_field(scale=1.1)
    source.write_text("G21\nG0 X#2\nM2\n")
    done = [map_program(source, tmp_path / "o.ngc", grown, FREE, parameters={"2": value}) for value in (1.0, 5.0)]
    assert done[0].record != done[1].record
    assert "holds for 2=5.0 only" in (tmp_path / "o.ngc").read_text()


def test_functions_and_matrices_are_the_same_field(tmp_path: Path) -> None:
    turn = similarity_field(rotation_rad=0.3, about_mm=(3.0, 4.0, 0.0), shift_mm=(0.0, 1.0, 2.0), scale=1.01)
    flat = PART[: PART.index("N160")] + "M2\n"
    assert (
        mapped(tmp_path, flat, turn)[0].splitlines()[2:]
        == (mapped(tmp_path, flat, function_field(turn.displacement_mm, "turn"))[0].splitlines()[2:])
    )


def test_a_turn_is_exact_and_keeps_arcs_whole(tmp_path: Path) -> None:
    quarter = similarity_field(rotation_rad=np.pi / 2)
    text, done = mapped(tmp_path, "G21 G17 F1\nG0 X10 Y0\nG3 X0 Y10 I-10 J0\nG3 X-10 Y0 R10\nM2\n", quarter)
    assert done.added_blocks == 0
    assert np.allclose(path_of(text).end_mm, [[0, 10, 0], [-10, 0, 0], [0, -10, 0]], atol=1e-9)


def test_increments_do_not_drift(tmp_path: Path) -> None:
    """1000 increments, each of which rounds away 0.4 of the last digit."""
    scale = similarity_field(scale=1.0004)
    body = "".join("U0.01 W-0.01\n" for _ in range(1000))
    text, _ = mapped(tmp_path, f"G21 F1\nG00 X0.0 Z0.0\nG01\n{body}M30\n", scale, "fanuc-lathe")
    assert path_of(text, "fanuc-lathe").end_mm[-1] == pytest.approx([5.002, 0.0, -10.004], abs=0.00051)


def test_an_axis_half_a_digit_off_is_not_written_again(tmp_path: Path) -> None:
    """10.0005 is written as 10.000; that it is not where it should be is no news for the next block."""
    shift = affine_field(np.eye(3), (0.0005, 0.0, 0.1))
    text, _ = mapped(tmp_path, "G21 G90\nG0 X10. Y0. Z5.\nG0 Z3.\nG81 Z-1. R2. F9.\nM30\n", shift, "fanuc-mill")
    assert text.splitlines()[3:5] == ["G0 Z3.100", "G81 Z-0.900 R2.100 F9."]


def test_x_is_a_diameter_where_the_control_takes_one(tmp_path: Path) -> None:
    source = "N010 G70\nN020 G00 X(P46+0.5) Z1.0\nN030 G01 Z-1.00 F.01\n"
    file = tmp_path / "lathe.nc"
    file.write_text(source)
    map_program(
        file, tmp_path / "out.nc", affine_field(np.eye(3), (0.0254, 0, 0)), FREE, dialect="ge2000t",
        parameters={"P46": 1.0},
    )  # fmt: skip
    assert (tmp_path / "out.nc").read_text().splitlines()[2:] == [
        "N020 G00 X(P46+0.5+0.002) Z1.0",
        source.splitlines()[2],
    ]


def test_new_blocks_are_numbered_where_there_is_room(tmp_path: Path) -> None:
    bend = function_field(lambda p: np.column_stack([0 * p[:, 0], 1e-5 * p[:, 0] ** 2, 0 * p[:, 0]]), "bend")
    source = "N10 G21 G1 F1 X0 Y0\nN20 G01 X20.0\nN30 X40\nN31 X60\nM2\n"
    lines = mapped(tmp_path, source, bend, options=MapOptions(tolerance_mm=0.0005, limit_mm=1))[0].splitlines()
    assert [line.split()[0] for line in lines[1:]] == ["N10", "N20", "N21", "N30", "X40.00000", "N31", "N32", "M2"]
    assert lines[2:4] == ["N20 G01 X10.00000 Y0.00100", "N21 G01 X20.00000 Y0.00400"]
    taken = "N21 G21 G1 F1 X0 Y0\nN20 G01 X20.0\nN30 X40\nM2\n"
    lines = mapped(tmp_path, taken, bend, options=MapOptions(tolerance_mm=0.0005, limit_mm=1))[0].splitlines()
    assert [line.split()[0] for line in lines[1:]] == ["N21", "N20", "G01", "N30", "N31", "M2"]


def test_places_of_the_machine_stay_and_need_no_field(tmp_path: Path) -> None:
    table = table_field(
        np.array([0.0, 100.0]), np.array([0.0]), np.array([-50.0, 50.0]), np.tile([0.01, 0.0, 0.0], (4, 1))
    )
    source = "G21 G90 F1\nG53 G0 Z-1\nG0 X10\nZ5\nG1 Z0\nX20\nG28 Z30\nG0 X50\n"
    text, _ = mapped(tmp_path, source, table)
    lines = ["G53 G0 Z-1", "G0 X10", "X10.01000 Z5", "G1 Z0", "X20.01000", "G28 Z30", "G0 X50"]
    assert text.splitlines()[2:] == lines


@pytest.mark.parametrize(
    ("text", "code", "line", "words"),
    [
        ("G21\nG0 X1\nG87 X2 Z-3 R1 F1\n", Code.NC_OPAQUE, 3, "G87"),
        ("G21 F1 G0 X0 Y0\no1 repeat [3]\nG91 G1 X10\no1 endrepeat\n", Code.NC_MAP, 3, "several times"),
        ("G21 F1\nG0 X0 Y0 Z0\nG1 X10\nG92 X0\nG1 X5\n", Code.NC_MAP, 4, "set anew"),
        ("G21 G91 F1\nG1 X10\n", Code.NC_MAP, 2, "X has no position yet in the cut"),
        ("G21 F1\nG1 X10\nG1 Y2\n", Code.NC_MAP, 2, "Y has no position yet in the cut"),
        ("G21 F1\nG0 X1 Y1 Z1\nG28 Z5\nG1 X10\n", Code.NC_MAP, 4, "Z stands at a place of the machine in the cut"),
        ("G21 F1\nG1 X10\n", Code.NC_MAP, 2, "Y is displaced by 0.00100 mm, but the program never says where"),
        ("G21 F1\nG0 X1 Y1\nG2 X3 Y1 Z2 I1 J0\n", Code.NC_MAP, 3, "Z has no position yet"),
        ("G21 F1 ??\n", Code.NC_WORD, 1, "??"),
        ("G21 F1\nG0 X#<no>\n", Code.NC_PARAMETER, 2, "no"),
        ("G21 F1\nG1 X0 Y0\nG1 X200 M1\n", Code.NC_MAP, 3, "M1"),
        ("G21 F1\nG1 X0 Y0\nG93 G1 X200 F2\n", Code.NC_MAP, 3, "G93"),
        ("G21 F1\nG0 X10\nG3 I-5 J0 P4\n", Code.NC_MAP, 3, "more than 1 turn"),
        ("G21\n(trueloop corrected 12)\nG0 X10\n", Code.CMP_TWICE, 2, "corrected already"),
        ("G21\rG0 X1\rG1 X9 F1\r", Code.NC_WORD, 1, "carriage returns without line feeds"),
        ("%\rG21\rG0 X1\r%\r", Code.NC_WORD, 1, "carriage returns without line feeds"),
        ("G21\r\nG0 X1\rY1\r\nM2\r\n", Code.NC_WORD, 2, "carriage returns without line feeds"),
        ("G21\nG0 X1 Y1 Z9\nG38.3 Z-5 F9\no1 if [#5070 EQ 0]\nM2\no1 endif\n", Code.NC_PARAMETER, 4, "#5070"),
        ("G21\nG0 X1 Y1 Z9\nG38.3 Z-5 F9\nG0 Z[#5063+9]\nM2\n", Code.NC_PARAMETER, 4, "#5063"),
        ("G21\nT1 M6\nG0 X[#5410/2]\nM2\n", Code.NC_PARAMETER, 3, "#5410"),
    ],
)
def test_what_cannot_be_mapped_is_refused_with_its_place_and_nothing_written(
    tmp_path: Path, text: str, code: Code, line: int, words: str
) -> None:
    bend = function_field(lambda p: np.column_stack([1e-4 * p[:, 0] ** 2, 1e-5 * p[:, 0] ** 2, 0 * p[:, 0]]), "bend")
    with pytest.raises(TrueloopError) as refusal:
        mapped(tmp_path, text, bend)
    assert (refusal.value.code, refusal.value.place.line) == (code, line)
    assert words in refusal.value.message
    assert [file.name for file in tmp_path.iterdir()] == ["program.ngc"]


@pytest.mark.parametrize(
    ("dialect", "text", "line", "words"),
    [
        ("linuxcnc", "G0 X0 Y0 Z5\nG1 Z-1 F9\nX[#<_x>+10]\nM2\n", 4, "X 10.2000 Y 0.2000 .*X 10.1000 .*: #<_x> is"),
        ("linuxcnc", "G0 X0 Y0 Z5\nG1 Z-1 F9\n#1=#5421\nY[#1+10]\nM2\n", 5, "Y 10.4000 .*Y 10.2000 .*: #5421 is"),
        (
            "linuxcnc",
            "o1 sub\nG0 X#1 Y0\nG1 Z-#2 F9\nG0 Z[#<_z>+7]\no1 endsub\nG0 X0 Y0 Z5\no1 call [10] [2]\nM2\n",
            5,
            "Z 4.5000 mm in place of .*Z 4.7500 mm: #<_z>",
        ),
        ("linuxcnc", "G0 X9 Y0 Z5\nG38.2 Z-5 F9\nG0 Z5\nX[#5061+3]\nM2\n", 5, "X 12.2000 .*X 12.1000 .*: #5061"),
        ("siemens", "G0 X10 Y10 Z10\nG1 X=$P_EP[X]+10 F9\nM30\n", 3, r"X 20.2000 .*X 20.1000 .*: \$P_EP\[X\] is"),
        ("siemens", "G0 X10 Y10 Z9\nR1=$AA_IM[Y]\nG1 Y=R1+5 F9\nM30\n", 4, r"Y 15.4000 .*Y 15.2000 .*\$AA_IM\[Y\]"),
        ("siemens", "G0 X1 Y1 Z9\nMEAS=1 G1 Z0 F9\nG0 Z9\nX=$AA_MW[X]+3\nM30\n", 5, r"X 4.2000 .*X 4.1000 "),
    ],
)
def test_what_a_program_reads_of_its_displaced_position_is_not_displaced_again(
    tmp_path: Path, dialect: str, text: str, line: int, words: str
) -> None:
    """The shift is in the position that is read: the term of the word comes on top of it."""
    shift, source = similarity_field(shift_mm=(0.1, 0.2, -0.25)), tmp_path / "program.ngc"
    refusal = refused(mapped, tmp_path, f"G17 G90 {'G71' if dialect == 'siemens' else 'G21'}\n{text}", shift, dialect)
    assert (refusal.code, refusal.place.line) == (Code.NC_MAP, line)
    assert re.search(words, refusal.message)
    assert [file.name for file in tmp_path.iterdir()] == ["program.ngc"]
    found = mapped_program.program_obstacles(source, shift, FREE, dialect=dialect)
    assert [(one.code, one.message) for one in found] == [(refusal.code, refusal.message)]


def test_a_position_read_back_where_it_is_not_displaced_or_decides_alone_is_mapped(tmp_path: Path) -> None:
    text = (
        "G21 G17 G90\nG0 X0 Y0 Z5\nG1 Z-1 F9\no1 if [#<_z> LT 0]\nG1 X10\no1 endif\nG0 Z[#<_z>+7]\n"
        "o2 while [#5420 LT 30]\nG91 G1 X10\nG90\no2 endwhile\nM2\n"
    )
    written, _ = mapped(tmp_path, text, similarity_field(shift_mm=(0.1, 0.0, 0.0)))
    ran = interpret(tmp_path / "mapped.ngc", startup="G17 G21")
    assert_same_moves(path_of(written), ran)
    assert path_of(written).end_mm == pytest.approx(path_of(text).end_mm + np.array([0.1, 0.0, 0.0]))


@pytest.mark.parametrize(
    ("dialect", "cycle"),
    [
        ("haas-mill", "G70 I25. J30. L6"),
        ("haas-mill", "G72 I5. J0. K3 L2"),
        ("mitsubishi-mill", "G34 I25. J30. K6"),
        ("mitsubishi-mill", "G22 P100"),
        ("fanuc-mill", "G66 P9100 R2. D-12."),
    ],
)
def test_what_cuts_by_the_cycle_in_force_or_after_each_move_is_not_left_as_it_is(
    tmp_path: Path, dialect: str, cycle: str
) -> None:
    """Holes on a circle without X, Y or Z: R and Z of the cycle would stay undisplaced."""
    text = f"G21 G17 G90 G54\nG0 X50. Y50.\nZ25.\nG81 G99 Z-10. R2. F100. L0\n{cycle}\nG80\nM30\n"
    refusal = refused(mapped, tmp_path, text, similarity_field(shift_mm=(0.0, 0.0, -0.25)), dialect)
    assert (refusal.code, refusal.place.line) == (Code.NC_OPAQUE, 5)


def test_a_contour_that_is_roughed_too_begins_where_it_says(tmp_path: Path) -> None:
    """G70 comes to the contour at Z1, G71 at Z2: a Z written into its first block would begin both at Z1."""
    turn = similarity_field(rotation_rad=1e-4, axis="Y")
    text = (
        "G21 G90 G18 G8 F100\nO100 sub\n{first}\nG1 Z-5\nX8 Z-10\nG1 X10\nO100 endsub\n"
        "G0 X12 Z2\nG71 Q100 D0.5 I1 R0.3\nG0 X12 Z1\nG70 Q100\nM2\n"
    )
    with pytest.raises(TrueloopError, match="Z is displaced on the contour before it names Z") as refusal:
        mapped(tmp_path, text.format(first="G0 X5"), turn)
    assert (refusal.value.code, refusal.value.place.line) == (Code.NC_MAP, 3)
    written, _ = mapped(tmp_path, text.format(first="G0 X5 Z2"), turn)
    finish_mm = path_of(text.format(first="G0 X5 Z2")).end_mm[-3:]
    assert path_of(written).end_mm[-3:] == pytest.approx(finish_mm + turn.displacement_mm(finish_mm), abs=1e-5)


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("fanuc-mill", "G21G17G90F1\nG1X10.Y0Z0\nG3X10.0Y0.001I-10.J0\nG1X0\n"),
        ("fanuc-mill", "G21G17G90F1\nG1X10.Y0Z0\nG3X10.0Y0.001R10.\nG1X0\n"),
        ("siemens", "G71G17G90F1\nG1X10Y0Z0\nG3X10Y0.001I-10J0\nG1X0\n"),
        ("heidenhain", "BEGIN PGM A MM\nL X+10 Y+0 Z+0 F1\nC X+10 Y+0,001 DR+\nL X+0\n"),
    ],
)
def test_an_arc_shorter_than_the_rounding_becomes_no_circle(tmp_path: Path, dialect: str, text: str) -> None:
    text = text.replace("C X", "CC X+0 Y+0\nC X")
    assert abs(read_program(text.encode(), dialect).run().sweep_rad).max() == pytest.approx(1e-4)
    flattened = affine_field(np.diag([1.0, 0.04, 1.0]), (0.0, 0.01796, 0.0))
    refusal = refused(mapped, tmp_path, text, flattened, dialect)
    assert refusal.code is Code.NC_MAP and refusal.place.line == text.count("\n") - 1
    assert "would turn by 360.000 degrees" in refusal.message
    assert not (tmp_path / "mapped.ngc").exists()


def test_a_circle_whose_end_is_a_step_from_its_start_stays_whole(tmp_path: Path) -> None:
    head = "G21G17G90F1\nG1X10.Y0Z0\n"
    for end in ("X10.001Y0", "X10.Y-0.001", "X9.999Y0"):
        text = f"{head}G3{end}I-10.J0\nG1X0\n"
        written, _ = mapped(tmp_path, text, affine_field(np.eye(3), (0.0104, -0.0204, 0.0)), "fanuc-mill")
        assert -path_of(written, "fanuc-mill").sweep_rad.sum() == pytest.approx(np.pi * 2, abs=2e-4)


def test_a_cycle_that_is_refused_is_not_said_to_need_no_mending(tmp_path: Path) -> None:
    lathe = "G71 G18 G90 DIAMON\nG0 X24 Z4\nCYCLE97(1.5,,0,-20,30,30,3,2)\n"
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, lathe, affine_field(np.eye(3), (0.01, 0, 0)), "siemens")
    assert (refused.value.code, refused.value.place.line) == (Code.NC_OPAQUE, 3)
    assert "write what it does out as moves" in refused.value.hint


def test_an_unknown_code_is_seen_behind_a_thousand_slips(tmp_path: Path) -> None:
    """A radius on a straight move is worth a warning each; what nobody knows must not drown in them."""
    slips = "".join(f"X{k}. Y{k}. R1.\n" for k in range(1, 600))
    with pytest.raises(TrueloopError) as refusal:
        mapped(tmp_path, f"G21 G90\nG0 X0. Y0. Z0.\nG1 F100.\n{slips}G123 X5.\nM30\n", MIXED, "fanuc-mill")
    assert (refusal.value.code, refusal.value.place.line) == (Code.NC_CODE, 603)


def test_a_loop_whose_turns_are_displaced_alike_is_mapped(tmp_path: Path) -> None:
    loop = "G21 F1\nG0 X0\no1 repeat [3]\nG91 G1 X10\no1 endrepeat\nM2\n"
    text, _ = mapped(tmp_path, loop, affine_field(np.eye(3), (0.5, 0.0, 0.0)))
    assert text.splitlines()[2] == "G0 X0.50000"
    assert text.splitlines()[4] == "G91 G1 X10"


def test_what_was_not_run_is_counted(tmp_path: Path) -> None:
    shift = affine_field(np.eye(3), (0.5, 0.0, 0.0))
    text, done = mapped(tmp_path, "G21 F1\nG0 X0\n/G1 X5\nG1 X7\nM2\nX9\n", shift)
    assert (done.not_run, done.first_not_run_line) == (2, 3)
    assert "/G1 X5\n" in text
    assert mapped(tmp_path, "G21 F1\nG0 X0\n/G1 X5\nM2\n", shift, options=MapOptions(1, 1, 1, True))[1].not_run == 0


def test_limits_and_the_fields_own_end(tmp_path: Path) -> None:
    table = table_field(np.array([0.0, 10.0]), np.array([0.0]), np.array([0.0]), np.array([[0.0, 0, 0], [0.5, 0, 0]]))
    cut = "G21 F1\nG0 X0\nG1 X4\n"
    for options, code in ((MapOptions(), Code.CMP_SIZE), (MapOptions(limit_mm=1), Code.CMP_SLOPE)):
        with pytest.raises(TrueloopError) as refusal:
            mapped(tmp_path, cut, table, options=options)
        assert (refusal.value.code, refusal.value.place.line) == (code, 3)
    with pytest.raises(TrueloopError, match="not known") as refusal:
        mapped(tmp_path, "G21 F1\nG0 X0\nG1 X10.1\n", table)
    assert (refusal.value.code, refusal.value.place.line) == (Code.NC_FIELD, 3)


def test_what_a_function_raises_reaches_its_author(tmp_path: Path) -> None:
    def broken(_: Array) -> Array:
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        mapped(tmp_path, "G21 F1\nG0 X1\n", function_field(broken, "broken"))
    with pytest.raises(TypeError, match=r"answered \[(\d), 2\] to \1 positions"):
        mapped(tmp_path, "G21 F1\nG0 X1\nX2\nX3\n", function_field(lambda p: p[:, :2], "flat"))


codes = st.sampled_from(["G0", "G1", "", "G91", "G90"])
some_axes = st.lists(st.sampled_from("XYZ"), min_size=1, unique=True)
places = st.lists(st.integers(-30000, 30000), min_size=3, max_size=3)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(codes, some_axes, places), min_size=1, max_size=12))
def test_every_end_of_generated_programs_is_displaced(
    tmp_path: Path, blocks: list[tuple[str, list[str], list[int]]]
) -> None:
    """Ends of the written program, at the places of the old ones, to a step of the control."""
    body = "".join(
        f"{code} {' '.join(f'{axis}{value / 1000}' for axis, value in zip(sorted(axes), values, strict=False))}\n"
        for code, axes, values in blocks
    )
    source = f"G21 F1 G0 X0 Y0 Z0\nG1 X1\n{body}M2\n"
    text, _ = mapped(tmp_path, source, MIXED)
    path, found = path_of(source), path_of(text)
    wanted = path.end_mm + MIXED.displacement_mm(path.end_mm)
    for end in wanted:
        assert np.abs(found.end_mm - end).max(axis=1).min() < 2e-5
    assert path_difference(found, displaced_path(path, MIXED)).distance_mm < 0.0006


LARGE = """
import resource, sys
from pathlib import Path
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.nc.field import similarity_field
done = map_program(Path(sys.argv[1]), Path(sys.argv[2]), similarity_field(scale=1.0001), dialect="linuxcnc")
print(done.blocks, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def test_memory_does_not_grow_with_the_program(tmp_path: Path) -> None:
    """A program of 100 MB takes no more than one of 5 MB: the same to a part's worth, 1 MB of text."""
    line = b"".join(b"N%d G1 X%d.1234 Y%d.4321 Z-1.5\n" % (k, k % 90, k % 70) for k in range(10_000))
    peaks_kib = []
    for repeats in (16, 320):
        file = tmp_path / "large.ngc"
        with file.open("wb") as out:
            out.write(b"G21 G90 F100\n")
            for _ in range(repeats):
                out.write(line)
        command = [sys.executable, "-c", LARGE, str(file), str(tmp_path / "out.ngc")]
        answer = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
        assert int(answer[0]) == 1 + 10_000 * repeats
        peaks_kib.append(int(answer[1]))
    assert file.stat().st_size > 100e6
    assert peaks_kib[1] < peaks_kib[0] + 8 * 1024
