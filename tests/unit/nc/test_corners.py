"""Corners between two blocks, and lines given by their angle: geometry drawn by hand."""

import math

import numpy as np
import pytest

from trueloop.errors import Code
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

LATHE = "G21\nG00 X20. Z0.\nG01 Z-10. {corner} F.1\n{leaving}\n"
MILL = "G21 G90\nG01 X10. Y0. {corner} F100.\nX10. Y10.\n"


def run(text: str, dialect: str) -> ToolPath:
    path = read_program(text.encode(), dialect).run()
    assert [finding.message for finding in path.findings] == []
    return path


def rows(path: ToolPath, axes: list[int]) -> list[tuple[str, int, list[float]]]:
    """Kind, line and end of every move."""
    return [
        (Motion(kind).name.lower(), int(line), end[axes].tolist())
        for kind, line, end in zip(path.motion, path.line, path.end_mm, strict=True)
    ]


@pytest.mark.parametrize("dialect", ["fanuc-lathe", "fanuc-lathe-b", "haas-lathe"])
def test_sizes_of_corners_are_no_diameters(dialect: str) -> None:
    """From radius 10 along Z to the shoulder at z = -10, then out to X40., radius 20: `,R2.` leaves the cylinder at
    z = -8 and meets the shoulder at radius 12, about (x, z) = (12, -8); were 2 a diameter, at -9 and 11. The tool
    comes along -z and turns towards +x: with z to the right and x up that is clockwise, a quarter turn."""
    path = run(LATHE.format(corner=",R2.", leaving="X40."), dialect)
    cylinder, corner, shoulder = rows(path, [0, 2])[1:]
    assert [cylinder[0], corner[0], shoulder[0]] == ["line", "arc", "line"]
    assert cylinder[2] == pytest.approx([10, -8], abs=1e-12)
    assert corner[2] == pytest.approx([12, -10], abs=1e-12)
    assert path.centre_mm[2, [0, 2]] == pytest.approx([12, -8], abs=1e-12)
    assert path.sweep_rad[2] == pytest.approx(math.pi / 2, abs=1e-12)
    assert shoulder[2] == pytest.approx([20, -10], abs=1e-12)
    assert [row[1] for row in (cylinder, corner, shoulder)] == [3, 3, 4]


def test_a_chamfer_of_fanuc_is_given_by_its_legs() -> None:
    path = run(LATHE.format(corner=",C2.", leaving="X40."), "fanuc-lathe")
    assert [row[2] for row in rows(path, [0, 2])[1:]] == [[10, -8], [12, -10], [20, -10]]


@pytest.mark.parametrize(
    ("text", "dialect", "leg"),
    [
        (MILL.format(corner=",C2."), "fanuc-mill", 2.0),
        (MILL.format(corner=",C2."), "haas-mill", 2.0),
        ("G71\nG1 X10 Y0 CHR=2 F100\nX10 Y10", "siemens", 2.0),
        ("G71\nG1 X10 Y0 CHF=2 F100\nX10 Y10", "siemens", math.sqrt(2)),
        ("0 BEGIN PGM A MM\n1 L X+10 Y+0 F100\n2 CHF 2\n3 L X+10 Y+10", "heidenhain", 2.0),
    ],
)
def test_chf_is_the_length_of_the_chamfer_on_sinumerik_and_a_leg_elsewhere(text: str, dialect: str, leg: float) -> None:
    """A square corner at (10, 0): a chamfer of length l has legs of l / sqrt(2)."""
    ends = np.array([row[2] for row in rows(run(text, dialect), [0, 1])])
    assert ends == pytest.approx(np.array([[10 - leg, 0], [10, leg], [10, 10]]), abs=1e-12)


def test_inches_count_in_corners() -> None:
    path = run("G20\nG01 X1. Y0. ,R.1 F9.\nY1.", "fanuc-mill")
    assert path.end_mm[0, 0] == pytest.approx(0.9 * 25.4)


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        ("G71\nG1 X10 Y0 RND=2 F100\nY10 RND=2\nX0 RND=2\nY5", "siemens"),
        ("G71\nRNDM=2\nG1 X10 Y0 F100\nY10\nX0\nY5\nRNDM=0", "siemens"),
        ("G21\nG01 X10. Y0. ,R2. F9.\nY10. ,R2.\nX0. ,R2.\nY5.", "fanuc-mill"),
        ("1 BEGIN PGM A MM\n2 L X+10 Y+0 F9\n3 RND R2\n4 L Y+10\n5 RND R2\n6 L X+0\n7 RND 2\n8 L Y+5", "heidenhain"),
    ],
)
def test_three_roundings_in_a_row(text: str, dialect: str) -> None:
    path = run(text, dialect)
    expected = [[8, 0], [10, 2], [10, 8], [8, 10], [2, 10], [0, 8], [0, 5]]
    assert path.end_mm[:, :2] == pytest.approx(np.array(expected), abs=1e-12)
    assert path.start_mm[1:] == pytest.approx(path.end_mm[:-1], abs=0)
    assert path.sweep_rad[[1, 3, 5]] == pytest.approx(-math.pi / 2)


def test_a_rounding_between_a_line_and_an_arc_touches_both() -> None:
    """Up along x = 10 to (10, 0), then clockwise about (10, 10) towards (0, 10), radius 10. The rounding of radius 2
    lies left of the line, at x = 8, and outside the circle, 12 from (10, 10): its centre is (8, 10 - sqrt(140)). It
    leaves the line at y = 10 - sqrt(140) and meets the circle where the way from (10, 10) to its centre cuts it."""
    path = run("G21\nG00 X10. Y-20.\nG01 Y0. ,R2. F9.\nG02 X0. Y10. I0. J10.", "fanuc-mill")
    root = math.sqrt(140)
    assert [row[0] for row in rows(path, [0, 1])] == ["rapid", "line", "arc", "arc"]
    assert path.end_mm[1, :2] == pytest.approx([10, 10 - root], abs=1e-12)
    assert path.centre_mm[2, :2] == pytest.approx([8, 10 - root], abs=1e-12)
    assert path.end_mm[2, :2] == pytest.approx([10 - 2 * 10 / 12, 10 - root * 10 / 12], abs=1e-12)
    assert path.centre_mm[3, :2] == pytest.approx([10, 10], abs=0)
    # What is left of the quarter turn ends at the circle's leftmost point.
    assert path.sweep_rad[3] == pytest.approx(math.acos(2 / 12), abs=1e-9)


def test_a_sinumerik_takes_the_feed_of_the_block_after_the_corner() -> None:
    path = read_program(b"G71 G17 G90 G1 X10 F100 RND=2\nY10 F50", "siemens").run()
    assert path.feed.tolist() == [100, 50, 50]


def test_a_feed_beside_rnd_is_the_corner_s_own() -> None:
    path = run("1 BEGIN PGM A MM\n2 L X+10 F100\n3 RND R2 F50\n4 L Y+10", "heidenhain")
    assert path.feed.tolist() == [100, 50, 100]


@pytest.mark.parametrize("corner", [",R11.", ",C10.5", ",R-1."])
def test_a_corner_that_does_not_fit_is_said_and_stays_sharp(corner: str) -> None:
    path = read_program(MILL.format(corner=corner).encode(), "fanuc-mill").run()
    (found,) = path.findings
    assert (found.code, found.place.line, found.place.column) == (Code.NC_OPAQUE, 2, 14)
    assert path.end_mm[:, :2].tolist() == [[10, 0], [10, 10]]


@pytest.mark.parametrize(("frame", "refused"), [("SCALE X2", [Code.NC_ARC]), ("SCALE X2 Y2", []), ("ROT RPL=30", [])])
def test_a_rounding_is_an_arc_where_coordinates_are_scaled_alike(frame: str, refused: list[Code]) -> None:
    text = f"G710 G17 G90 G0 X0 Y0\n{frame}\nG1 X10 RND=2 F100\nY10\n"
    path = read_program(text.encode(), "siemens").run(strict=False)
    assert [(found.code, found.place.line) for found in path.findings] == [(code, 3) for code in refused]


@pytest.mark.parametrize("angle", ["A150.", ",A150."])
def test_a_line_of_a_lathe_by_its_angle(angle: str) -> None:
    """A150. goes down-z and up-x: 10 mm along -z it rises by 10 tan 30 on the radius, whatever X counts."""
    path = run(f"G21\nG00 X20. Z0.\nG01 Z-10. {angle} F.1", "fanuc-lathe")
    assert path.end_mm[1] == pytest.approx([10 + 10 * math.tan(math.radians(30)), 0, -10], abs=1e-12)
    path = run(f"G21\nG00 X20. Z0.\nG01 X40. {angle} F.1", "haas-lathe")
    assert path.end_mm[1] == pytest.approx([20, 0, -10 * math.tan(math.radians(60))], abs=1e-12)


@pytest.mark.parametrize(
    ("text", "dialect"),
    [
        ("G21\nG00 X20. Z0.\nG01 A180. F.1\nX40. Z-20. A135.", "fanuc-lathe"),
        ("G71 G18 DIAMON\nG0 X20 Z0\nG1 ANG=180 F.1\nX40 Z-20 ANG=135", "siemens"),
    ],
)
def test_two_lines_meet_where_their_angles_say(text: str, dialect: str) -> None:
    """Along the cylinder of radius 10, then at 45 degrees to radius 20 at z = -20: they meet at z = -10."""
    path = run(text, dialect)
    assert path.end_mm[1:] == pytest.approx(np.array([[10, 0, -10], [20, 0, -20]]), abs=1e-12)
    assert path.line.tolist() == [2, 3, 4]


def test_a_corner_where_two_angles_meet() -> None:
    """The lines above turn by 45 degrees: a rounding of 4 leaves 4 tan 22.5 before the point where they meet."""
    path = run("G21\nG00 X20. Z0.\nG01 A180. ,R4. F.1\nX40. Z-20. A135.", "fanuc-lathe")
    leg = 4 * math.tan(math.radians(22.5))
    assert path.end_mm[1] == pytest.approx([10, 0, -10 + leg], abs=1e-12)
    assert path.end_mm[2] == pytest.approx([10 + leg * math.sqrt(0.5), 0, -10 - leg * math.sqrt(0.5)], abs=1e-12)
    assert path.line.tolist() == [2, 3, 3, 4]
