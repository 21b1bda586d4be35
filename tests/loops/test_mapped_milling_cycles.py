"""Cycles whose passes are the control's (pockets, faces, threads of an Okuma) are displaced as a whole."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.mapped import FREE, mapped, path_of
from trueloop.arrays import Array
from trueloop.domain.option import MapOptions
from trueloop.errors import Code, TrueloopError
from trueloop.nc.field import Field, affine_field, function_field

SHIFT = affine_field(np.eye(3), (0.1, 0.2, -0.05))

BORE = """0 BEGIN PGM A MM
1 TOOL CALL 24 Z S2222 F160
2 CYCL DEF 208 BORE MILLING ~
  Q200=+2 ;SET-UP CLEARANCE ~
  Q201=-8 ;DEPTH ~
  Q206= AUTO ;FEED ~
  Q334=+0.6 ;PLUNGING ~
  Q203=+0 ;SURFACE ~
  Q204=+50 ;2ND CLEARANCE ~
  Q335=+20 ;DIAMETER
3 L X+40 Y+30 R0 FMAX M99
4 L Z+80 FMAX
5 END PGM A MM
"""
FACE = """0 BEGIN PGM A MM
1 TOOL CALL 6 Z S3000 F600
2 L X+0 Y+0 Z+60 R0 FMAX
3 CYCL DEF 232 FACE MILLING ~
  Q389=+2 ;STRATEGY ~
  Q225=-30 ;START 1ST AXIS ~
  Q226=-15 ;START 2ND AXIS ~
  Q227=+1 ;START 3RD AXIS ~
  Q386=+0 ;END 3RD AXIS ~
  Q218=+65 ;1ST SIDE ~
  Q219=+35 ;2ND SIDE ~
  Q200=+2 ;CLEARANCE
4 CYCL CALL
5 END PGM A MM
"""
OLD = """0 BEGIN PGM A MM
1 TOOL CALL 2 Z S2020 F200
2 L X+60 Y+45 Z+1 FMAX
3 CYCL DEF 5.0 KREISTASCHE
4 CYCL DEF 5.1 ABST 1
5 CYCL DEF 5.2 TIEFE -5.5
6 CYCL DEF 5.3 ZUSTLG 5.5 F100
7 CYCL DEF 5.4 RADIUS 20
8 CYCL DEF 5.5 F200 DR-
9 CYCL CALL
10 L X+90 FMAX
11 CYCL CALL
12 END PGM A MM
"""
HEAD = "0 BEGIN PGM A MM\n1 TOOL CALL 6 Z S3000 F600\n2 L X+0 Y+0 Z+60 R0 FMAX\n"
TAIL = "\n8 L X+1 Y+2 FMAX\n9 END PGM A MM\n"
AT_START = {"X+0 Y+0 Z+60": "X+0.1000 Y+0.2000 Z+59.9500", "X+1 Y+2": "X+1.1000 Y+2.2000"}
ROUND_SLOT = "3 CYCL DEF 254 SLOT Q200=2 Q201=-9 Q203=+4 Q204=50 Q216=+30 Q217=-7 Q367={} Q375=40 Q219=8\n4 CYCL CALL"
WALLED = "3 CYCL DEF 233 FACE Q200=2 Q204=50 Q218=60 Q219=40 Q227=+1 Q386=-3\n4 L X+9 Y+8 FMAX M99"
BORED = "3 CYCL DEF 202 BORING Q200=2 Q201=-9 Q206=100 Q203=+4 Q204=50 Q214=1\n4 L X+9 Y+8 FMAX M99"
CENTRED = "3 CYCL DEF 240 CENTRE Q200=2 Q343=1 Q344=-9 Q203=+4 Q204=50\n4 L X+9 Y+8 FMAX M99"
OLD_STUD = "3 CYCL DEF 215 STUD Q200=2 Q201=-9 Q203=+4 Q204=50 Q216=+30 Q217=-7 Q222=40 Q223=30\n4 CYCL CALL"
SUNK = "3 CYCL DEF 263 THREAD Q200=2 Q201=-9 Q203=+4 Q204=50 Q335=10\n4 L X+9 Y+8 FMAX M99"
CIRCLE = (
    "3 CYCL DEF 201 REAM Q200=2 Q201=-9 Q206=100 Q203=+4 Q204=50\n"
    "4 CYCL DEF 220 PATTERN Q216=+30 Q217=-7 Q244=20 Q245=0 Q246=360 Q247=0 Q241=3 Q200=3 Q203=+5 Q204=40 Q301=1"
)
OWN = {"Q216=+30": "Q216=+30.1000", "Q217=-7": "Q217=-6.8000", "Q203=+4": "Q203=+3.9500"}
HERE = {"X+9 Y+8": "X+9.1000 Y+8.2000", "Q203=+4": "Q203=+3.9500"}
POCKET = "G17 G71 G90 G94 F300\nG0 X0 Y0 Z50\nPOCKET4(50,0,1,-10,20,R1+40,30,5)\nG0 X0 Y0\nM30\n"
HAAS = "G21 G17 G90 G94\nG00 X10. Y20. Z2.\nG13 Z-3. I4. K9. Q4. D1 F100.\nG01 X12.\nG00 Z5.\nM30\n"
OKUMA = """G00 X50 Z8
G71 X27.55 Z-30 B60 D0.7 U0.1
$ H2.45 L2 F2 M23
G00 X60 Z20
M02
"""


def lines(folder: Path, text: str, field: Field, dialect: str = "heidenhain", options: MapOptions = FREE) -> list[str]:
    if dialect == "okuma-lathe":
        options = replace(options, unit="mm")
    return [line for line in mapped(folder, text, field, dialect, options)[0].splitlines() if "trueloop" not in line]


@pytest.mark.parametrize(
    ("text", "dialect", "changes"),
    [
        (BORE, "heidenhain", {"X+40 Y+30": "X+40.1000 Y+30.2000", "Q203=+0": "Q203=-0.0500", "Z+80": "Z+79.9500"}),
        (
            FACE,
            "heidenhain",
            {
                "X+0 Y+0 Z+60": "X+0.1000 Y+0.2000 Z+59.9500",
                "Q225=-30": "Q225=-29.9000",
                "Q226=-15": "Q226=-14.8000",
                "Q227=+1": "Q227=+0.9500",
                "Q386=+0": "Q386=-0.0500",
            },
        ),
        (OLD, "heidenhain", {"X+60 Y+45 Z+1": "X+60.1000 Y+45.2000 Z+0.9500", "X+90": "X+90.1000"}),
        (
            "R1=0\n" + POCKET,
            "siemens",
            {
                "X0 Y0 Z50": "X0.1000 Y0.2000 Z49.9500",
                "(50,0,1,-10,20,R1+40,30,5)": "(49.9500,-0.0500,1,-10.0500,20,R1+40+0.1,30.2000,5)",
                "\nG0 X0 Y0\n": "\nG0 X0.1000 Y0.2000\n",
            },
        ),
        (
            OKUMA,
            "okuma-lathe",
            {"X50 Z8": "X50.200 Z7.950", "X27.55 Z-30": "X27.750 Z-30.050", "X60 Z20": "X60.200 Z19.950"},
        ),
        (
            HAAS,
            "haas-mill",
            {
                "X10. Y20. Z2.": "X10.100 Y20.200 Z1.950",
                "Z-3. I4. K9.": "Z-3.050 I4. K9.",
                "X12.": "X12.100",
                "Z5.": "Z4.950",
            },
        ),
    ],
    ids=["bore", "face", "old", "pocket4", "okuma", "haas"],
)
def test_place_and_heights_are_displaced_and_sizes_stay(
    text: str, dialect: str, changes: dict[str, str], tmp_path: Path
) -> None:
    wanted = text
    for old, new in changes.items():
        assert wanted.count(old) == 1
        wanted = wanted.replace(old, new)
    shift = affine_field(np.eye(3), (0.1, 0.0, -0.05)) if dialect == "okuma-lathe" else SHIFT
    assert lines(tmp_path, text, shift, dialect) == wanted.splitlines()


@pytest.mark.parametrize(
    ("cycle", "changes"),
    [
        (ROUND_SLOT.format(0), OWN),
        (ROUND_SLOT.format(1), {"Q203=+4": "Q203=+3.9500"}),
        (WALLED, {"X+9 Y+8": "X+9.1000 Y+8.2000", "Q227=+1": "Q227=+0.9500", "Q386=-3": "Q386=-3.0500"}),
        (BORED, HERE),
        (CENTRED, HERE),
        (OLD_STUD, OWN),
        (SUNK, HERE),
        (CIRCLE, {"Q216=+30": "Q216=+30.1000", "Q217=-7": "Q217=-6.8000", "Q203=+5": "Q203=+4.9500"}),
    ],
    ids=["slot", "slot here", "walled", "bored", "centred", "stud", "sunk", "circle"],
)
def test_centre_surface_and_end_of_a_cycle_are_displaced_and_nothing_else(
    cycle: str, changes: dict[str, str], tmp_path: Path
) -> None:
    test_place_and_heights_are_displaced_and_sizes_stay(HEAD + cycle + TAIL, "heidenhain", AT_START | changes, tmp_path)


@pytest.mark.parametrize(
    ("cycle", "low", "high"),
    [
        (ROUND_SLOT.format(0), (2, -35, -5), (58, 21, 6)),
        (ROUND_SLOT.format(2), (-28, -28, -5), (28, 28, 6)),
        (WALLED, (-63.111, -64.111, -3), (81.111, 80.111, 3)),
        (CENTRED, (4.5, 3.5, -0.5), (13.5, 12.5, 6)),
        (OLD_STUD, (-10, -47, -5), (70, 33, 6)),
        (SUNK, (-1, -2, -5), (19, 18, 6)),
        (BORED, (8.8, 7.8, -5), (9.2, 8.2, 6)),
    ],
)
def test_a_field_is_asked_up_to_the_ends_of_what_a_cycle_mills(
    cycle: str, low: tuple[float, ...], high: tuple[float, ...], tmp_path: Path
) -> None:
    """A slot of 40 mm pitch diameter, 8 mm wide, reaches 28 mm from its centre; a face its diagonal, √(60² + 40²)."""
    asked = []

    def noted(points_mm: Array) -> Array:
        asked.append(points_mm.copy())
        return np.zeros_like(points_mm)

    mapped(tmp_path, HEAD + cycle + TAIL, function_field(noted, "noted"), "heidenhain", FREE)
    space = max(asked, key=len)
    assert space.min(axis=0).tolist() == pytest.approx(low, abs=1e-3)
    assert space.max(axis=0).tolist() == pytest.approx(high, abs=1e-3)


def stretch(axis: int, along: int, slope: float) -> Field:
    """Displaces along one axis by `slope` times another."""

    def displacement(points_mm: np.ndarray) -> np.ndarray:
        found = np.zeros_like(points_mm)
        found[:, axis] = slope * points_mm[:, along]
        return found

    return function_field(displacement, "stretch")


@pytest.mark.parametrize(
    ("text", "dialect", "across_mm", "deep_mm"),
    [
        (BORE, "heidenhain", 20.0, 10.0),
        (FACE, "heidenhain", 65.0, 3.0),
        (OLD, "heidenhain", 40.0, 6.5),
        ("R1=0\n" + POCKET, "siemens", 40.0, 11.0),
        (OKUMA, "okuma-lathe", 11.225, 38.0),
        (HAAS, "haas-mill", 18.0, 5.0),
    ],
    ids=["bore", "face", "old", "pocket4", "okuma", "haas"],
)
@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize("along", [0, 2])
def test_what_differs_within_the_cycle_is_refused(
    text: str, dialect: str, across_mm: float, deep_mm: float, axis: int, along: int, tmp_path: Path
) -> None:
    """The field differs by 4 µm from one side of what is milled to the other, or from its top to its bottom."""
    field = stretch(axis, along, 4e-3 / (deep_mm if along == 2 else across_mm))
    with pytest.raises(TrueloopError, match="differently within what the cycle mills") as refused:
        lines(tmp_path, text, field, dialect, MapOptions(limit_mm=np.inf, slope=np.inf, tolerance_mm=1.9e-3))
    assert refused.value.code is Code.NC_MAP


def test_the_middle_of_what_is_milled_counts(tmp_path: Path) -> None:
    """Z is displaced by 1e-3 Z: 2 µm at the top, where feed begins, -8 µm at the bottom, -3 µm in the middle."""
    wide = MapOptions(limit_mm=np.inf, slope=np.inf, tolerance_mm=5.1e-3)
    written = lines(tmp_path, BORE, stretch(2, 2, 1e-3), "heidenhain", wide)
    assert "  Q203=-0.0030 ;SURFACE ~" in written


def test_a_field_is_asked_all_over_the_pocket(tmp_path: Path) -> None:
    """A bump 6 mm wide beside the middle, away from the corners of the space that is milled."""

    def bump(points_mm: np.ndarray) -> np.ndarray:
        near = np.linalg.norm(points_mm[:, :2] - [45.0, 30.0], axis=1) < 3.0
        return np.column_stack([0.004 * near, 0 * near, 0 * near])

    with pytest.raises(TrueloopError, match="differently within what the cycle mills"):
        lines(tmp_path, BORE, function_field(bump, "bump"), "heidenhain")


def test_after_a_slot_a_cut_names_both_axes_of_the_plane(tmp_path: Path) -> None:
    """Where a slot ends depends on its position's number; a bore ends where it began."""
    slot = BORE.replace("CYCL DEF 208 BORE MILLING", "CYCL DEF 253 SLOT MILLING").replace(
        "Q335=+20 ;DIAMETER", "Q218=+20 ~\n  Q219=+8"
    )
    cut = "4 L Z+80 FMAX\n5 L X+50 R0 F100\n"
    lines(tmp_path, BORE.replace("4 L Z+80 FMAX\n", cut), SHIFT)
    with pytest.raises(TrueloopError, match="Y has no position since") as refused:
        lines(tmp_path, slot.replace("4 L Z+80 FMAX\n", cut), SHIFT)
    assert refused.value.place.line == slot.splitlines().index("4 L Z+80 FMAX") + 2


def test_no_pass_of_the_cycle_is_in_the_path() -> None:
    """The tool goes to the plane Q203 + Q200 and out to Q203 + Q204; what it cuts between is the control's."""
    path = path_of(BORE, "heidenhain")
    assert path.rapid.all()
    assert path.end_mm.tolist()[:3] == [[40.0, 30.0, 0.0], [40.0, 30.0, 2.0], [40.0, 30.0, 50.0]]


def test_a_cycle_is_not_displaced_where_a_rotary_axis_stands_turned(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError, match="A does not stand at 0 degrees"):
        lines(tmp_path, BORE.replace("3 L X+40", "3 L A+90 R0 FMAX\n4 L X+40"), SHIFT)


OKUMA_REFUSED = [
    ("G00 X50 Z8\nG71 X27.55 D0.7 H2.45 F2\n", 2, "X and Z are not both given"),
    ("G00 X50 Z8\nG71 X27.55 Z-30 D0.7\n$ H2.45 X3 F2\n", 3, "it goes on with the block before"),
    ("G00 X50 Z8\nG01 X40 F0.2\n$ Z-3\n", 3, "it goes on with the block before"),
    ("G00 X50 Z8\nG71 X27.55 Z-30 D0.7 H2.45 F2\nG01 Z-3\n", 3, "X has no position since"),
    ("G00 X50 Z8 B30\nG01 Z-3 F0.2\n", 1, "is no word of the dialect okuma-lathe"),
]


@pytest.mark.parametrize(("text", "line", "words"), OKUMA_REFUSED)
def test_what_an_okuma_cycle_leaves_open_is_refused(text: str, line: int, words: str, tmp_path: Path) -> None:
    with pytest.raises(TrueloopError, match=words) as refused:
        lines(tmp_path, text, affine_field(np.eye(3), (0.1, 0.0, -0.05)), "okuma-lathe")
    assert refused.value.place.line == line


def test_other_conditions_of_a_roughing_cycle_stay(tmp_path: Path) -> None:
    """The contour is displaced once; the control works the passes out from it, whatever depth they have where."""
    text = "G00 X82 Z5\nG85 NLAP1 D4 F0.3 U0.4 W0.2\n$ G84 XA=60 DA=2 FA=0.25\nG87 NLAP1\nM02\n"
    contour = "NLAP1 G81\nG00 X40\nG01 Z-20 F0.1\nX82\nG80\n"
    written = lines(tmp_path, text + contour, affine_field(np.eye(3), (0.1, 0.0, 0.0)), "okuma-lathe")
    assert written[2] == "$ G84 XA=60 DA=2 FA=0.25"
    assert written[6] == "G00 X40.200"


@pytest.mark.parametrize(
    ("dialect", "head"), [("fanuc-lathe", "G21 "), ("haas-lathe", "G21 "), ("linuxcnc", "G21 G7 G18 G90 ")]
)
def test_c_of_a_lathe_turns_no_displacement_along_the_radius(dialect: str, head: str, tmp_path: Path) -> None:
    text = head + "G0 X40. Z5.\nG1 Z-5. F100.\nG0 Z5.\nC90.\nG1 Z-3.\n"
    shift = affine_field(np.eye(3), (0.1, 0.0, 0.0))
    assert lines(tmp_path, text, shift, dialect)[0].startswith(head + "G0 X40.2")
    if dialect == "linuxcnc":  # with Y it may be a mill's table
        with pytest.raises(TrueloopError, match="C does not stand at 0 degrees"):
            lines(tmp_path, text.replace("Z5.", "Y0. Z5.", 1), shift, dialect)


PROBED = """0 BEGIN PGM A MM
1 TOOL CALL 30 Z S50
2 TCH PROBE 419 DATUM IN ONE AXIS ~
  Q263=+0 ;1ST POINT ~
  Q305=+1 ;NUMBER ~
  Q303=+1
3 CYCL DEF 247 DATUM SETTING ~
  Q339=+1
4 TOOL CALL 22 Z S3000 F600
5 L X+5 Y+6 R0 FMAX
6 L Z+2 R0 FMAX
7 L Z-1 R0 F100
8 END PGM A MM
"""


def test_a_probe_cycle_stays_and_what_is_cut_after_it_is_displaced(tmp_path: Path) -> None:
    changes = {"X+5 Y+6": "X+5.1000 Y+6.2000", "Z+2 ": "Z+1.9500 ", "Z-1 ": "Z-1.0500 "}
    wanted = PROBED
    for old, new in changes.items():
        wanted = wanted.replace(old, new)
    assert lines(tmp_path, PROBED, SHIFT) == wanted.splitlines()


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        ("5 L X+5 Y+6", "5 L Y+6", Code.NC_MAP, "X has no position since"),
        ("TCH PROBE 419", "TCH PROBE 3.0", Code.NC_OPAQUE, "TCH PROBE 3.0"),
        ("7 L Z-1", "7 L Z+Q151", Code.NC_PARAMETER, "Q151"),
    ],
)
def test_what_a_probe_cycle_changes_is_not_known(old: str, new: str, code: Code, words: str, tmp_path: Path) -> None:
    """Q151 holds a measured centre; a value from before is overwritten."""
    text = PROBED.replace("2 TCH", "Q151 = 7\n2 L X+1 R0 FMAX\n2 TCH").replace(old, new)
    with pytest.raises(TrueloopError, match=words) as refused:
        lines(tmp_path, text, SHIFT)
    assert refused.value.code is code


def along_z(by_mm: Callable[[Array], Array]) -> Field:
    return function_field(lambda p: np.stack([0.0 * p[:, 0], 0.0 * p[:, 0], by_mm(p)], axis=1), "along z")


def test_a_cycle_under_a_shift_is_displaced_by_the_field_where_it_mills(tmp_path: Path) -> None:
    """50 µm down beyond X500 of the work offset: under TRANS X1000 the pocket about X0 is there."""
    field = along_z(lambda p: np.where(p[:, 0] > 500.0, -0.05, 0.0))
    pocket = POCKET.replace("R1+40", "40")
    shifted = lines(tmp_path, pocket.replace("G0 X0 Y0 Z50", "TRANS X1000\nG0 X0 Y0 Z50", 1), field, "siemens")
    assert "POCKET4(49.9500,-0.0500,1,-10.0500,20,40,30,5)" in shifted
    assert "POCKET4(50,0,1,-10,20,40,30,5)" in lines(tmp_path, pocket, field, "siemens")


def test_a_field_without_a_value_in_the_space_of_a_cycle_is_refused(tmp_path: Path) -> None:
    field = along_z(lambda p: np.where(p[:, 2] > 0.0, 0.01, np.nan))
    with pytest.raises(TrueloopError, match="not known everywhere"):
        lines(tmp_path, POCKET.replace("R1+40", "40"), field, "siemens")


def test_a_cycle_whose_surface_the_program_does_not_write_is_refused(tmp_path: Path) -> None:
    """Q203 from outside is an absolute height all the same: 50 µm down would not be written anywhere."""
    (tmp_path / "a.h").write_text(BORE.replace("  Q203=+0 ;SURFACE ~\n", ""))
    options = ("--set", "Q203=0", "-o", tmp_path / "b.h")
    shown = run("nc", "map", tmp_path / "a.h", "--shift=0,0,-0.05", *options, status=3)
    assert "heights of the cycle are not written" in shown
    assert not (tmp_path / "b.h").exists()


CONTOURS = """0 BEGIN PGM A MM
1 TOOL CALL 1 Z S2000 F200
2 L X+0 Y+0 Z+50 R0 FMAX
3 CYCL DEF 14.0 CONTOUR
4 CYCL DEF 14.1 CONTOUR LABEL1
5 CYCL DEF 20 CONTOUR DATA ~
  Q1=-20 ;DEPTH ~
  Q5=+1 ;SURFACE ~
  Q7=+30 ;CLEARANCE HEIGHT
6 CYCL DEF 22 ROUGH-OUT ~
  Q10=-5 ;PLUNGING
7 CYCL CALL M3
8 CYCL DEF 24 SIDE FINISHING ~
  Q10=-20 ;PLUNGING
9 CYCL CALL
10 M30
11 LBL 1
12 L X+10 Y+5 RL
13 L X+40
14 L Y+25
15 L X+10 Y+5
16 LBL 0
17 END PGM A MM
"""


def test_contours_of_labels_move_with_the_surface_and_the_clearance_height(tmp_path: Path) -> None:
    """Roughing and finishing run the same blocks; depth and infeed are no positions."""
    before, after = CONTOURS.splitlines(), mapped(tmp_path, CONTOURS, SHIFT, "heidenhain")[0].splitlines()
    assert [line for line in after if line not in before and "trueloop" not in line] == [
        "2 L X+0.1000 Y+0.2000 Z+49.9500 R0 FMAX",
        "  Q5=+0.9500 ;SURFACE ~",
        "  Q7=+29.9500 ;CLEARANCE HEIGHT",
        "12 L X+10.1000 Y+5.2000 RL",
        "13 L X+40.1000",
        "14 L Y+25.2000",
        "15 L X+10.1000 Y+5.2000",
    ]


def test_contours_of_labels_are_displaced_as_a_whole_or_not_at_all(tmp_path: Path) -> None:
    turned = function_field(lambda p: np.column_stack([0 * p[:, 0], 1e-3 * p[:, 0], 0 * p[:, 0]]), "turned")
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, CONTOURS, turned, "heidenhain")
    assert refused.value.code is Code.NC_MAP
