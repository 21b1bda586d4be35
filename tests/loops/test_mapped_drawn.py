"""Contours drawn with less than every point under a field: written out, then displaced as any other."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.cli import invoke
from tests.support.drawn_contours import DRAWING, drawn_contours
from tests.support.mapped import MIXED, displaced_path, mapped, path_of
from trueloop.nc.field import Field, affine_field, function_field, similarity_field
from trueloop.nc.match.difference import path_difference
from trueloop.nc.program.program import read_program

SHIFT = affine_field(np.eye(3), (0.01, 0.02, -0.003))
TURNED = similarity_field(shift_mm=(0.013, -0.021, 0.004), rotation_rad=2e-4, scale=1.0003, about_mm=(3.0, 4.0, 0.0))
IN_XZ = function_field(
    lambda p: np.column_stack([0.03 * np.sin(p[:, 2] / 30), 0 * p[:, 1], 0.02 * np.cos(p[:, 0] / 25)]), "in XZ"
)
TOLERANCE_MM = 0.0005
STEPS = 3.0
"""Half a step an axis each for writing out and for displacing, at both ends of an arc."""

CASES = [
    ("siemens", "G71 G17 G90 F100\nG0 X20 Y1 Z1\nG1 X5\nCT X9 Y3\n"),
    ("siemens", "G71 G17 G90 F100\nG0 X20 Y1 Z1\nG1 X5\nCIP X9 Y3 I1=AC(6) J1=AC(4)\n"),
    ("siemens", "G71 G17 G90 F100\nG0 X20 Y1 Z1\nG111 X0 Y0\nG1 AP=30 RP=20\nG3 AP=120\n"),
    ("siemens", "G71 G17 G90 F100\nG0 X20 Y1 Z1\nG1 X9 ANG=30\nG2 X15 Y-3 AR=110\n"),
    ("siemens", "G71 G17 G90 F100\nG0 X20 Y1 Z1\nRNDM=1\nG1 X9\nY9\nX0\nRNDM=0\nY20\n"),
    ("heidenhain", "0 BEGIN PGM A MM\n1 L X+20 Y+1 Z+1 R0 FMAX\n2 L X+5 Y+1 F9\n3 CT X+9 Y+3\n"),
    ("heidenhain", "0 BEGIN PGM A MM\n1 L X+20 Y+1 Z+1 R0 FMAX\n2 CC X+2 Y+1\n3 LP PR+9 PA+0 F9\n4 CP PA+100 DR+\n"),
    ("heidenhain", "0 BEGIN PGM A MM\n1 L X+20 Y+1 Z+1 R0 FMAX\n2 L X+9 F9\n3 RND R1\n4 L Y+9\n5 CTP PA+45 PR+9\n"),
]


def assert_displaced(text: str, dialect: str, field: Field) -> None:
    """The written path is the displaced one, within the tolerance and the rounding."""
    with tempfile.TemporaryDirectory() as folder:
        written, _ = mapped(Path(folder), text, field, dialect)
    before, after = path_of(text, dialect), path_of(written, dialect)
    assert not after.findings
    step_mm = read_program(b"", dialect).dialect.step_mm(bool(before.inch[0]))
    off = path_difference(after, displaced_path(before, field))
    assert off.distance_mm <= TOLERANCE_MM + STEPS * step_mm


@pytest.mark.parametrize(("dialect", "text"), CASES)
@pytest.mark.parametrize("field", [SHIFT, TURNED], ids=["shift", "turned"])
def test_arcs_and_ends_by_other_words(dialect: str, text: str, field: Field) -> None:
    assert_displaced(text, dialect, field)


@pytest.mark.parametrize("dialect", DRAWING)
@settings(max_examples=3, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_corners(dialect: str, data: st.DataObject) -> None:
    text = data.draw(drawn_contours(dialect))
    assert_displaced(text, dialect, MIXED if "Y" in text else IN_XZ)


def test_what_was_done_is_told_of_the_file(tmp_path: Path) -> None:
    """Two blocks were added to six; the block that is not run stands in the file's line 6."""
    text = "G21 G90\nG00 X1. Y1. Z1.\nG01 X10. ,R2. F100.\nY20.,C1.\nX30.\n/X50.\n"
    written, done = mapped(tmp_path, text, SHIFT, "fanuc-mill")
    assert (done.blocks, done.added_blocks, done.not_run, done.first_not_run_line) == (6, 2, 1, 6)
    assert written.splitlines()[3:8] == [
        "G01 X8.010 F100.",
        "G03 X10.010 Y3.020 R2.000",
        "G01 Y19.020",
        "X11.010 Y20.020",
        "X30.010",
    ]


def test_plain_corners_of_a_lathe_where_the_contour_is_roughed_alone(tmp_path: Path) -> None:
    """R2. leaves the cylinder of radius 10 at z = -8 and meets the shoulder at radius 12; R-1. leaves it at radius 19
    and ends at z = -11. X is 0.05 mm further out on the radius, Z 0.03 mm further in."""
    contour = "N1 G00 X20.\nG01 Z-10. R2. F.1\nX40. R-1.\nN2 Z-30.\n"
    text = f"G21 G00 X50. Z2.\nG71 U2. R1.\nG71 P1 Q2 U.4 W.1 F.2\n{contour}"
    written, _ = mapped(tmp_path, text, affine_field(np.eye(3), (0.05, 0.0, -0.03)), "fanuc-lathe")
    assert written.splitlines()[4:] == [
        *["N1 G00 X20.100", "G01 Z-8.030 F.1", "G02 X24.100 Z-10.030 R2.000"],
        *["G01 X38.100", "G03 X40.100 Z-11.030 R1.000", "N2 G01 Z-30.030"],
    ]


def test_the_command_displaces_a_contour_with_corners(tmp_path: Path) -> None:
    source, target = tmp_path / "plate.nc", tmp_path / "out.nc"
    source.write_text("G21 G90 G17\nG00 X1. Y1. Z1.\nG01 X10. ,R2. F100.\nY20.\nM30\n")
    invoke("nc", "map", source, "--dialect", "fanuc-mill", "--shift", "0.01,0,0", "--out", target, status=0)
    assert "G01 X8.010 F100.\nG03 X10.010 Y3.000 R2.000\nG01 Y20." in target.read_text()


def test_a_contour_in_increments_stays_one(tmp_path: Path) -> None:
    """Each increment goes from where the tool really is: a corner's end, rounded, and none of it adds up."""
    text = "G21 G90\nG00 X1. Y1. Z1.\nG91 G01 X9. ,R2. F100.\nY19.,C1.\nX20.\nX-.5\nG90 Y0.\n"
    written, _ = mapped(tmp_path, text, SHIFT, "fanuc-mill")
    assert written.splitlines()[2:] == [
        "G00 X1.010 Y1.020 Z0.997",
        "G91 G01 X7.000 F100.",
        "G03 X2.000 Y2.000 R2.000",
        "G01 Y16.000",
        "X1.000 Y1.000",
        "X19.000",
        "X-.5",
        "G90 Y0.020",
    ]
