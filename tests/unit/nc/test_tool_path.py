"""The tool path's columns: provenance, modal state, signs, and the CSV."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.csv_reference import csv_lines
from tests.support.linuxcnc import interpret
from trueloop._core import nc_rows
from trueloop.geometry.feature import Arc
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import CSV_HEADER, CoordinateState, Motion, ToolPath, csv_text

decimals = st.integers(0, 12)
PROGRAM = b"""N10 G70 G94 T0101 M03 S1200
N20 G00 X2.0 Z0.1
N30 G95 G96 S300 G01 Z-1.0 F0.01
N40 G42 X3.0 Z-1.5
N50 G71 X50.0 F0.2
N60 G40 G02 X70.0 Z-48.1 R10.0
"""


@pytest.fixture
def path() -> ToolPath:
    return read_program(PROGRAM, "ge2000t").run()


def test_each_coordinate_knows_the_word_that_set_it(path: ToolPath) -> None:
    program = read_program(PROGRAM, "ge2000t")
    texts = [[program.word(int(word)).text if word >= 0 else None for word in row] for row in path.word]
    assert texts == [
        ["X2.0", None, "Z0.1"],
        [None, None, "Z-1.0"],
        ["X3.0", None, "Z-1.5"],
        ["X50.0", None, None],
        ["X70.0", None, "Z-48.1"],
    ]
    assert path.line.tolist() == [2, 3, 4, 5, 6]
    assert path.block.tolist() == [1, 2, 3, 4, 5]
    assert path.column.tolist() == [9, 22, 9, 9, 13]


def test_modal_state_of_each_move(path: ToolPath) -> None:
    assert path.motion.tolist() == [Motion.RAPID, Motion.LINE, Motion.LINE, Motion.LINE, Motion.ARC]
    assert path.rapid.tolist() == [True, False, False, False, False]
    assert path.feed[1:].tolist() == pytest.approx([0.254, 0.254, 0.2, 0.2])
    assert math.isnan(path.feed[0])
    assert path.feed_mode.tolist() == [94, 95, 95, 95, 95]
    assert path.spindle_mode.tolist() == [97, 96, 96, 96, 96]
    assert path.spindle_speed.tolist() == [1200, 300, 300, 300, 300]
    assert path.tool.tolist() == [101] * 5
    assert path.compensation.tolist() == [40, 40, 42, 42, 40]
    assert path.inch.tolist() == [True, True, True, False, False]
    assert path.diameter.all() and not path.incremental.any()
    assert set(path.plane.tolist()) == {18}
    assert path.coordinate_state(0) == CoordinateState(inch=True, diameter=True)
    assert path.coordinate_state(4) == CoordinateState(inch=False, diameter=True)


def test_a_move_starts_where_the_one_before_ended(path: ToolPath) -> None:
    np.testing.assert_array_equal(path.start_mm[1:], path.end_mm[:-1])
    assert path.end_mm[:, [0, 2]].tolist() == pytest.approx(
        np.array([[25.4, 2.54], [25.4, -25.4], [38.1, -38.1], [25.0, -38.1], [35.0, -48.1]])
    )


@pytest.mark.parametrize(("code", "sign"), [("G2", 1), ("G3", -1)])
@pytest.mark.parametrize(("plane", "arc"), [("G17", "X2 Y0 I1 J0"), ("G18", "Z2 X0 K1 I0"), ("G19", "Y2 Z0 J1 K0")])
def test_clockwise_is_positive_in_every_plane(plane: str, arc: str, code: str, sign: int) -> None:
    """From (0, 0) to (2, 0) about (1, 0) in (first, second) axis: G02 goes over the positive second axis."""
    path = read_program(f"G21 {plane} G1 X0 Y0 Z0 F1\n{code} {arc}\n".encode(), "linuxcnc").run()
    assert path.sweep_rad[1] == pytest.approx(sign * math.pi)


def test_the_sweep_in_g18_is_that_of_a_profile_arc() -> None:
    """The convex dome of a part is cut by G02 from the cylinder to the axis; its points are those of the feature."""
    path = read_program(b"G71 G00 X20. Z-10. \nG02 X0. Z0. I-10. K0. F1", "ge2000t").run()
    start, end, centre = (tuple(p[1, [0, 2]].tolist()) for p in (path.start_mm, path.end_mm, path.centre_mm))
    arc = Arc("dome", start, end, centre, float(path.sweep_rad[1]))
    np.testing.assert_allclose(arc.point_mm(arc.length_mm), end, atol=1e-12)
    np.testing.assert_allclose(arc.outward_normal(0.0), [1.0, 0.0], atol=1e-12)


def test_csv() -> None:
    path = read_program(PROGRAM, "ge2000t").run()
    rows = list(csv.DictReader("".join(csv_text(path)).splitlines(), CSV_HEADER))
    assert [row["motion"] for row in rows] == ["rapid", "line", "line", "line", "arc"]
    assert rows[0]["feed"] == "" and rows[1]["feed"] == "0.254" and rows[1]["feed_unit"] == "mm/rev"
    assert rows[1]["sweep_rad"] == "" and rows[1]["centre_x_mm"] == ""
    assert (rows[4]["x_mm"], rows[4]["z_mm"], rows[4]["start_x_mm"]) == ("35", "-48.1", "25")
    for name, column in (("x_mm", path.end_mm[:, 0]), ("z_mm", path.end_mm[:, 2])):
        assert [float(row[name]) for row in rows] == pytest.approx(column.tolist(), abs=1e-9)
    assert float(rows[4]["sweep_rad"]) == pytest.approx(path.sweep_rad[4], abs=1e-12)


def test_the_csv_of_a_path_longer_than_what_is_written_at_once() -> None:
    cuts = "\n".join(f"G1 X{k / 1024:.10f} Y{-k / 3:.6f} F{k}" for k in range(20_003))
    path = read_program(f"G21 G90\n{cuts}\n".encode(), "linuxcnc").run()
    assert "".join(csv_text(path)).splitlines() == list(csv_lines(path))


@given(st.lists(st.floats() | st.floats(-1e4, 1e4) | st.integers(-4096, 4096).map(lambda k: k / 1024)), decimals)
def test_numbers_of_a_table_are_those_of_python(values: list[float], places: int) -> None:
    """Of ties (an odd number of 1024ths has ten decimals) too."""

    def cell(value: float) -> str:
        text = f"{value:.{places}f}"
        short = text.rstrip("0").rstrip(".") if "." in text else text
        return "" if math.isnan(value) else "0" if short == "-0" else short

    column = (np.array(values, dtype=np.float64), places)
    assert nc_rows([column, column], 0, len(values)).splitlines() == [f"{cell(v)},{cell(v)}" for v in values]


def test_a_column_that_is_too_short_or_lacks_a_name_is_refused() -> None:
    for column in ((np.zeros(2), 3), (np.array([0, 2, 0], dtype=np.uint32), ["rapid", "line"])):
        with pytest.raises(ValueError, match="a column lacks rows or names"):
            nc_rows([column], 0, 3)


def test_a_program_without_moves() -> None:
    path = read_program(b"", "ge2000t").run()
    assert len(path) == 0
    assert list(csv_text(path)) == []
    assert path.feed.shape == (0,)


@pytest.mark.parametrize("below_mm", [4e-7, -4e-7])
@pytest.mark.parametrize(
    ("dialect", "head", "arc"),
    [
        ("fanuc-mill", "G21G17G90G1X10.Y0F100\n", "G3X10.Y{}I-10.J0"),
        ("siemens", "G71G17G90G1X10Y0F100\n", "G3 X10 Y{} I-10 J0"),
        ("heidenhain", "BEGIN PGM A MM\nL X+10 Y+0 F100\nCC X+0 Y+0\n", "C X+10 Y{} DR+"),
        ("linuxcnc", "G21G17G90G1X10Y0F100\n", "G3X10Y{}I-10J0"),
    ],
)
def test_an_end_on_the_start_but_for_what_computing_left_makes_a_full_turn(
    dialect: str, head: str, arc: str, below_mm: float
) -> None:
    """Not nothing at all: nobody programs an arc that no control can tell from its start."""
    path = read_program((head + arc.format(f"{below_mm:+.9f}")).encode(), dialect).run()
    assert path.sweep_rad[-1] == pytest.approx(-math.tau, abs=1e-6)


def test_an_arc_of_a_step_of_the_control_is_one_but_where_linuxcnc_makes_it_a_full_turn(tmp_path: Path) -> None:
    text = "G21G17G90\nG1X1000.Y0F100\nG3X1000.Y0.0005I-1000.J0\nM2\n"
    (tmp_path / "arc.ngc").write_text(text)
    judged = interpret(tmp_path / "arc.ngc")[-1].sweep_rad
    own = read_program(text.encode(), "linuxcnc").run().sweep_rad[-1]
    assert own == pytest.approx(judged) == pytest.approx(-math.tau)
    assert read_program(text.encode(), "fanuc-mill").run().sweep_rad[-1] == pytest.approx(-5e-7)


def test_restored_modes_leave_the_tool_in_the_spindle() -> None:
    """M72 brings back modes, not T1: the length that G43 calls is that of T2."""
    path = read_program(b"G21 G90\nT1 M6\nM70\nT2 M6\nM72\nG43\nG0 X1\nM2\n", "linuxcnc").run()
    assert (path.tool.tolist(), path.tool_offset.tolist()) == ([2], [2])
