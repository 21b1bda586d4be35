"""Holes of cycles that are called, of Sinumerik and Klartext: their heights are displaced where they are defined."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.support.mapped import FREE, mapped, path_of
from trueloop.errors import Code, TrueloopError
from trueloop.nc.field import Field, affine_field, function_field

SHIFT = affine_field(np.eye(3), (0.1, 0.2, -0.05))
RISING = function_field(lambda p: np.column_stack([0 * p[:, 0], 0 * p[:, 0], 1e-3 * p[:, 0]]), "rising")
LOWER = function_field(lambda p: np.column_stack([0 * p[:, 0], 0 * p[:, 0], 1e-3 * p[:, 2]]), "lower")

SINUMERIK = """G17 G71 G90 G94 F300
G0 X0 Y0 Z50
R1=5
MCALL CYCLE83(30,R1,2,-21.5,,-3,,2,,,1,0)
X10 Y20
X30
MCALL
G0 Z50
CYCLE84(30,5,2,,12,0,3,8,,0,300,300)
CYCLE85(R1+25,R1,2,R1-16)
M30
"""
KLARTEXT = """0 BEGIN PGM A MM
1 TOOL CALL 1 Z S900 F300
2 L X+0 Y+0 Z+50 R0 FMAX
3 CYCL DEF 200 DRILLING ~
  Q200=2 ;SET-UP CLEARANCE ~
  Q201=-15 ;DEPTH ~
  Q206=250 ;FEED ~
  Q203=+0 ;SURFACE ~
  Q204=50 ;2ND CLEARANCE
4 L X+10 Y+20 FMAX M99
5 L X+30 FMAX M99
6 CYCL CALL M3
7 END PGM A MM
"""


def lines(folder: Path, text: str, field: Field, dialect: str) -> list[str]:
    return [line for line in mapped(folder, text, field, dialect)[0].splitlines() if "trueloop" not in line]


def test_every_height_of_a_sinumerik_cycle_that_is_a_position_moves_with_the_hole(tmp_path: Path) -> None:
    """DPR and the clearance are no positions: RFP, from which DPR counts, moves by the depth."""
    written = lines(tmp_path, SINUMERIK, SHIFT, "siemens")
    assert written[1] == "G0 X0.1000 Y0.2000 Z49.9500"
    assert written[3:6] == [
        "MCALL CYCLE83(29.9500,R1-0.05,2,-21.5500,,-3.0500,,2,,,1,0)",
        "X10.1000 Y20.2000",
        "X30.1000",
    ]
    assert written[7:10] == [
        "G0 Z49.9500",
        "CYCLE84(29.9500,4.9500,2,,12,0,3,8,,0,300,300)",
        "CYCLE85(R1+25-0.05,R1-0.05,2,R1-16-0.05)",
    ]


def test_of_a_klartext_cycle_the_surface_moves(tmp_path: Path) -> None:
    written = lines(tmp_path, KLARTEXT, SHIFT, "heidenhain")
    assert written == [
        line.replace("X+0 Y+0 Z+50", "X+0.1000 Y+0.2000 Z+49.9500")
        .replace("X+10 Y+20", "X+10.1000 Y+20.2000")
        .replace("X+30", "X+30.1000")
        .replace("Q203=+0", "Q203=-0.0500")
        for line in KLARTEXT.splitlines()
    ]


def test_depth_and_plane_have_displacements_of_their_own(tmp_path: Path) -> None:
    """At Z 7, where feed begins, 0.007; at −21.5 −0.0215."""
    text = "G17 G71 G90 F300\nG0 X0 Y0 Z50\nCYCLE81(30,5,2,-21.5)\nM30\n"
    assert lines(tmp_path, text, LOWER, "siemens")[2] == "CYCLE81(30.0070,5.0070,2,-21.5215)"


@pytest.mark.parametrize(
    ("text", "dialect", "line"),
    [(SINUMERIK, "siemens", 6), (KLARTEXT, "heidenhain", 11)],
    ids=["sinumerik", "klartext"],
)
def test_holes_of_one_definition_that_are_displaced_differently_are_refused(
    text: str, dialect: str, line: int, tmp_path: Path
) -> None:
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, text, RISING, dialect, FREE)
    assert refused.value.code is Code.NC_MAP
    assert refused.value.place.line == line
    assert "define the cycle anew" in str(refused.value.hint)


def test_each_hole_with_a_definition_of_its_own_goes_by_its_own_displacement(tmp_path: Path) -> None:
    text = "G17 G71 G90 F300\nG0 X0 Y0 Z50\nX10\nCYCLE81(30,5,2,-20)\nX30\nCYCLE81(30,5,2,-20)\nM30\n"
    written = lines(tmp_path, text, RISING, "siemens")
    assert [line for line in written if "CYCLE" in line] == [
        "CYCLE81(30.0100,5.0100,2,-19.9900)",
        "CYCLE81(30.0300,5.0300,2,-19.9700)",
    ]


@pytest.mark.parametrize(
    ("dialect", "text", "words"),
    [
        ("siemens", "MCALL CYCLE81(30,5,2,-20,10)\nX5\n", "given twice"),
        ("siemens", "CYCLE81(30,5,2)\n", "depth is not given"),
        ("siemens", "CYCLE81(30,5,2,9)\n", "it drills from 7.0000 mm to 9.0000 mm"),
        ("siemens", "CYCLE82(30,5,2,-9,,0,10)\n", "which the tool decides"),
        ("siemens", "CYCLE83(30,5,2,-9,,,,,,,,,1)\n", "another axis"),
        ("siemens", "MCALL POCKET3(1)\nX5\n", "runs after each move"),
        ("heidenhain", "3 CYCL DEF 200 D ~\n Q200=2 ~\n Q203=0\n4 L X+5 M99\n", "not all given"),
        ("heidenhain", "3 CYCL DEF 240 C ~\n Q343=1 ~\n Q200=2 ~\n Q201=-3 ~\n Q203=0\n4 L X+5 M99\n", "Q344 are not"),
        ("heidenhain", "3 CYCL DEF 200 D ~\n Q200=2 ~\n Q201=+3 ~\n Q203=0\n4 L X+5 M99\n", "its depth is 3"),
        ("heidenhain", "3 CYCL DEF 208 B ~\n Q200=2 ~\n Q201=-3 ~\n Q203=0\n4 L X+5 M99\n", "its size is not given"),
        ("heidenhain", "3 CYCL DEF 258 S ~\n Q200=2\n4 L X+5 M99\n", "CYCL DEF 258"),
        (
            "heidenhain",
            "3 CYCL DEF 254 S ~\n Q200=2 ~\n Q201=-3 ~\n Q203=0 ~\n Q367=0 ~\n Q375=9 ~\n Q219=2\n4 CYCL CALL\n",
            "Q216 and Q217",
        ),
        (
            "heidenhain",
            "3 CYCL DEF 210 S Q200=2 Q201=-3 Q203=0 Q216=1 Q217=2 Q218=9 Q219=2\n4 CYCL CALL POS X+1 Y+2 Z+3\n",
            "centre of its own",
        ),
        ("siemens", "CYCLE801(0,0,0,5,5,2)\n", "number of its lines"),
        ("siemens", "CYCLE801(0,0,0,5,5,2,1.5)\n", "2 x 1.5 holes"),
        ("heidenhain", "3 CYCL DEF 232 F ~\n Q225=0\n4 CYCL CALL\n", "Q225, Q226, Q227 and Q386"),
        (
            "heidenhain",
            "3 CYCL DEF 10.1 ROT+30\n4 CYCL DEF 208 B ~\n Q200=2 ~\n Q201=-3 ~\n Q203=0 ~\n Q335=9\n5 L X+5 Y+5 M99\n",
            "are turned",
        ),
        ("siemens", "POCKET4(50,0,1,-10,10,0,0,5,0,0,100,100,2,1,0,0,0,0,0,0,1)\n", "further arguments"),
        ("siemens", "POCKET3(50,0,1,-10,10,5,1,0)\n", "its sizes and its place"),
        ("heidenhain", "3 CYCL CALL POS X+1 Y+2 Z+3\n", "CYCL CALL POS"),
    ],
)
def test_what_is_not_followed_is_refused_by_its_name(dialect: str, text: str, words: str, tmp_path: Path) -> None:
    head = {
        "siemens": "G17 G71 G90 F300\nG0 X0 Y0 Z50\n",
        "heidenhain": "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+50 R0 FMAX\n2 L Z+40 F300\n",
    }[dialect]
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, head + text, SHIFT, dialect)
    assert refused.value.code is Code.NC_OPAQUE
    assert re.search(re.escape(words), refused.value.message)


PATTERN = "G17 G71 G90 G94 F300\nG0 X0 Y0 Z50\nMCALL CYCLE81(30,5,2,-21.5)\nHOLES2(R1+10,20,5,0,0,4)\nMCALL\nG0 X50\n"
AT_A_PLACE = KLARTEXT.replace("6 CYCL CALL M3", "6 CYCL CALL POS X+40 Y+20 Z-2.5 FMAX")
OLD = """0 BEGIN PGM A MM
1 TOOL CALL 1 Z S900 F300
2 L X+0 Y+0 Z+2 R0 FMAX
3 CYCL DEF 1.0 PECKING
4 CYCL DEF 1.1 SET UP 2
5 CYCL DEF 1.2 DEPTH -15
6 CYCL DEF 1.3 PECKG 15
7 CYCL DEF 1.4 DWELL 0
8 CYCL DEF 1.5 F80
9 L X+10 Y+20 FMAX M99
10 END PGM A MM
"""


def test_a_pattern_is_displaced_by_its_reference_point(tmp_path: Path) -> None:
    written = lines(tmp_path, "R1=1\n" + PATTERN, SHIFT, "siemens")
    assert written[3:6] == ["MCALL CYCLE81(29.9500,4.9500,2,-21.5500)", "HOLES2(R1+10+0.1,20.2000,5,0,0,4)", "MCALL"]
    assert written[6] == "G0 X50.1000"


@pytest.mark.parametrize(
    ("cycle", "displaced"),
    [
        ("CYCLE71(29,0,2,-3,10,20,60,40,0)", "CYCLE71(28.9500,-0.0500,2,-3.0500,10.1000,20.2000,60,40,0)"),
        ("CYCLE76(29,0,2,-3,,60,40,5,10,20)", "CYCLE76(28.9500,-0.0500,2,-3.0500,,60,40,5,10.1000,20.2000)"),
        ("CYCLE77(29,0,2,-3,,30,10,20)", "CYCLE77(28.9500,-0.0500,2,-3.0500,,30,10.1000,20.2000)"),
        ("LONGHOLE(29,0,2,-3,,4,30,10,20,15)", "LONGHOLE(28.9500,-0.0500,2,-3.0500,,4,30,10.1000,20.2000,15)"),
        ("SLOT1(29,0,2,-3,,4,30,6,10,20,15)", "SLOT1(28.9500,-0.0500,2,-3.0500,,4,30,6,10.1000,20.2000,15)"),
        ("SLOT2(29,0,2,-3,,3,70,6,10,20,15)", "SLOT2(28.9500,-0.0500,2,-3.0500,,3,70,6,10.1000,20.2000,15)"),
    ],
)
def test_a_milling_cycle_is_displaced_by_its_heights_and_its_place(cycle: str, displaced: str, tmp_path: Path) -> None:
    text = f"G17 G71 G90 G94 F300\nG0 X0 Y0 Z90\n{cycle}\n"
    assert displaced in lines(tmp_path, text, SHIFT, "siemens")


def test_a_defined_pattern_is_displaced_by_its_reference_point_and_surface(tmp_path: Path) -> None:
    """`SHIFT` is 0.1, 0.2, -0.05 mm; the drilling cycle's own surface drills no hole and stays."""
    cells = tomllib.loads((Path(__file__).parents[1] / "programs/controls/cells.toml").read_text())["cell"]
    source = next(cell["program"] for cell in cells if cell["id"] == "HH cycle 221")
    written = "\n".join(lines(tmp_path, source, SHIFT, "heidenhain"))
    assert re.findall(r"Q(203|225|226)=(\S+)", written) == [
        ("203", "+0"), ("225", "+100.1000"), ("226", "+0.2000"), ("203", "-0.0500")
    ]  # fmt: skip


def test_a_pattern_whose_holes_are_displaced_differently_is_refused(tmp_path: Path) -> None:
    """Along X by 0.1 % of X: the holes at X 16 and at X 6 lie 0.01 mm apart of what one reference point can do."""
    wider = function_field(lambda p: np.column_stack([1e-3 * p[:, 0], 0 * p[:, 0], 0 * p[:, 0]]), "wider")
    with pytest.raises(TrueloopError, match="one definition states one value") as refused:
        lines(tmp_path, "R1=1\n" + PATTERN, wider, "siemens")
    assert refused.value.code is Code.NC_MAP


def test_a_call_at_a_place_is_displaced_by_its_own_words(tmp_path: Path) -> None:
    across = affine_field(np.eye(3), (0.1, 0.2, 0.0))
    assert "6 CYCL CALL POS X+40.1000 Y+20.2000 Z-2.5 FMAX" in lines(tmp_path, AT_A_PLACE, across, "heidenhain")


def test_a_call_at_a_height_is_not_displaced_by_its_own_word_and_by_the_cycle_s(tmp_path: Path) -> None:
    """Z of the place adds to Q203: both displaced by 50 µm would take the hole 100 µm down."""
    with pytest.raises(
        TrueloopError, match=r"Z -0\.6000 mm in place of X 40\.1000 Y 20\.2000 Z 47\.4500 mm"
    ) as refused:
        lines(tmp_path, AT_A_PLACE, SHIFT, "heidenhain")
    assert (refused.value.code, refused.value.place.line) == (Code.NC_MAP, 12)


def test_heights_that_count_from_where_the_tool_stands_follow_it(tmp_path: Path) -> None:
    written = lines(tmp_path, OLD, SHIFT, "heidenhain")
    changed = OLD.replace("X+0 Y+0 Z+2", "X+0.1000 Y+0.2000 Z+1.9500").replace("X+10 Y+20", "X+10.1000 Y+20.2000")
    assert written == changed.splitlines()
    with pytest.raises(TrueloopError, match=r"Z is displaced by 17\.00 µm more") as refused:
        lines(tmp_path, OLD, LOWER, "heidenhain")
    assert refused.value.code is Code.NC_MAP


@pytest.mark.parametrize("remark", ["", " ;SURFACE"])
def test_parameters_behind_a_skipped_definition_are_skipped_with_it(remark: str, tmp_path: Path) -> None:
    """The control reads the lines behind `~` as one block: the hole is drilled from Q203 of the definition before."""
    skipped = f"/ 4 CYCL DEF 201 REAMING ~\n  Q200=2 ~\n  Q201=-30 ~\n  Q203=-7{remark} ~\n  Q204=50\n"
    text = KLARTEXT.replace("4 L X+10", skipped + "5 L X+10", 1)
    written = lines(tmp_path, text, SHIFT, "heidenhain")
    assert f"  Q203=-7{remark} ~" in written
    assert "  Q203=-0.0500 ;SURFACE ~" in written
    path = path_of(text, "heidenhain")
    assert path.end_mm[:, 2].min() == -15.0


PLACES = """0 BEGIN PGM A MM
1 TOOL CALL 1 Z S900 F300
2 L X+0 Y+0 Z+50 R0 FMAX
3 PATTERN DEF POS1 (X+10 Y+20 Z+0) ~
  ROW1 (X+30 Y+5 D+8 NUM3 ROT+90 Z+0)
4 CYCL DEF 200 DRILLING ~
  Q200=2 ~
  Q201=-15 ~
  Q203=+0 ~
  Q204=50
5 CYCL CALL PAT FMAX M3
6 END PGM A MM
"""


def test_the_places_of_a_pattern_move_where_it_states_them(tmp_path: Path) -> None:
    before, after = PLACES.splitlines(), lines(tmp_path, PLACES, SHIFT, "heidenhain")
    assert [line for line in after if line not in before] == [
        "2 L X+0.1000 Y+0.2000 Z+49.9500 R0 FMAX",
        "3 PATTERN DEF POS1 (X+10.1000 Y+20.2000 Z+0) ~",
        "  ROW1 (X+30.1000 Y+5.2000 D+8 NUM3 ROT+90 Z+0)",
        "  Q203=-0.0500 ~",
    ]
