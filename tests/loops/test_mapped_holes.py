"""Drilling cycles under a field: their words are displaced, each hole in its own block."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.support.mapped import FREE, mapped, path_of
from trueloop.arrays import Array
from trueloop.domain.option import MapOptions
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.machine import mapped_program
from trueloop.nc.field import affine_field, function_field

INCH_MM = 25.4

RISING = function_field(
    lambda p: np.column_stack([1e-4 * p[:, 0], 0 * p[:, 0], 1e-4 * p[:, 0] + 1e-3 * p[:, 2]]), "rising"
)
"""X grows by 1e-4 of itself; Z rises by 1e-4 of X and by 1e-3 of itself."""


def body(folder: Path, text: str, dialect: str) -> list[str]:
    """The mapped program's lines without the mark."""
    lines = mapped(folder, text, RISING, dialect)[0].splitlines()
    return [line for line in lines if "trueloop corrected" not in line]


def test_a_series_names_what_changes_from_hole_to_hole(tmp_path: Path) -> None:
    """At X 100 the plane R 2 is 2 + 0.01 + 0.002, the bottom -5 + 0.01 - 0.005; after G80 the tool is where it was."""
    source = (
        "O1\nG21 G90\nG0 X0. Y0. Z20.\nG98 G81 X100. Y10. Z-5. R2. F100.\nX200.\nY20.\nX100. Z-11.\nG80\nG0 X0.\nM30\n"
    )
    assert body(tmp_path, source, "fanuc-mill") == [
        "O1",
        "G21 G90",
        "G0 X0. Y0. Z20.020",
        "G98 G81 X100.010 Y10. Z-4.995 R2.012 F100.",
        "X200.020 R2.022 Z-4.985",
        "Y20.",
        "X100.010 Z-11.001 R2.012",
        "G80",
        "G0 X0.",
        "M30",
    ]


def test_a_series_that_begins_at_a_height_the_program_does_not_state(tmp_path: Path) -> None:
    """R and Z of the block are positions. Under G91 R would count from that height: refused."""
    source = "G21 G90 G00 X0. Y0.\nG81 X100. Y10. Z-5. R2. F100.\nX200.\nG80\nM30\n"
    wanted = ["G81 X100.010 Y10. Z-4.995 R2.012 F100.", "X200.020 R2.022 Z-4.985"]
    assert body(tmp_path, source, "fanuc-mill")[1:3] == wanted
    with pytest.raises(TrueloopError, match="Z has no position yet in the cut"):
        body(tmp_path, source.replace("\nX200.", "\nG91 X100."), "fanuc-mill")


def test_heights_given_under_g90_stay_where_they_are_under_g91(tmp_path: Path) -> None:
    """Three more holes at X 0 need no word; at X 100 R is 2.012 - 20.020 and Z is -4.995 - 2.012, and both stay."""
    source = "G21 G90\nG0 X0. Y0. Z20.\nG98 G81 Z-5. R2. F100.\nG91 Y10. L3\nX100.\nG90 Y20.\nG80\nM30\n"
    wanted = ["G98 G81 Z-5.005 R2.002 F100.", "G91 Y10. L3", "X100.010 R-18.008 Z-7.007", "G90 Y20."]
    assert body(tmp_path, source, "haas-mill")[2:6] == wanted


def test_a_lathe_counts_r_from_where_the_cycle_began(tmp_path: Path) -> None:
    """From Z 5.005 down by 3.003 to Z 2.002, then to -20.02; W counts from there."""
    source = "G21\nG00 X0. Z5.\nG83 Z-20. R-3. Q5000 F0.1\nG80\nG00 Z10.\nG83 W-7. R-3. Q5000\nM30\n"
    written = body(tmp_path, source, "fanuc-lathe")
    assert written[1:6] == [
        "G00 X0. Z5.005",
        "G83 Z-20.020 R-3.003 Q5000 F0.1",
        "G80",
        "G00 Z10.010",
        "G83 W-7.007 R-3.003 Q5000",
    ]


@pytest.mark.parametrize(("plane", "after", "refused"), [
    ("G99 G82", "G90 G01 X150. F100.", None),
    ("G98 G82", "G90 G00 X150. Z20.", None),
    ("G98 G82", "G90 G01 X150. F100.", 6),
    ("G91 G99 G82", "G90 G00 X150. Z20.", 4),
])  # fmt: skip
def test_a_cycle_states_the_height_that_a_new_work_offset_left_unknown(
    tmp_path: Path, plane: str, after: str, refused: int | None
) -> None:
    """At X 100 R 2 is 2 + 0.01 + 0.002, the bottom -5 + 0.01 - 0.005. G98 goes back to a height in the old offset: a
    cut may not start there. Under G91 R counts from that height."""
    blocks = [
        "G21 G90 G54 G00 X0. Y0. Z20. ;",
        "G98 G81 Z-5. R2. F100. ;",
        "G80 G55 X100. Y0. ;",
        f"{plane} Z-5. R2. P20 ;",
    ]
    source = "\n".join([*blocks, "G80 ;", after, "M30", ""])
    if refused:
        with pytest.raises(TrueloopError) as refusal:
            body(tmp_path, source, "fanuc-mill")
        assert (refusal.value.code, refusal.value.place.line) == (Code.NC_MAP, refused)
        assert "Z has no position since tool or offset changed" in refusal.value.message
    else:
        assert body(tmp_path, source, "fanuc-mill")[3] == f"{plane} X100.010 Z-4.995 R2.012 P20 ;"


@pytest.mark.parametrize("away", ["G80 G55 X0. Y0.", "G80\nG91 G28 Z0.\nG90 G00 X0. Y0."])
@pytest.mark.parametrize(("after", "refused"), [("G00 X300.", False), ("G01 X300. F90.", True), ("G00 Z9.", False)])
def test_a_return_to_an_unknown_height_stays_unknown_after_holes_that_end_at_the_plane_r(
    tmp_path: Path, away: str, after: str, refused: bool
) -> None:
    """G99, then G98 in one series: the rapid after it goes across at that height, without a word Z."""
    head = f"G21 G90 G54 G00 X0. Y0. Z20.\nG98 G81 Z-5. R2. F100.\n{away}\n"
    source = head + f"G99 G82 X100. Z-5. R2. P20\nG98 X200.\nG80\n{after}\nM30\n"
    if refused:
        with pytest.raises(TrueloopError, match=r"Z (has no position since|stands at a place of the machine)"):
            body(tmp_path, source, "fanuc-mill")
    else:
        assert body(tmp_path, source, "fanuc-mill")[-2] == {"G00 X300.": "G00 X300.", "G00 Z9.": "G00 Z9.029"}[after]


def test_holes_that_are_put_off_are_displaced_where_they_are_drilled(tmp_path: Path) -> None:
    source = "O1\nG21 G90\nG0 X0. Y0. Z20.\nG83 G99 Z-5. R2. Q3. F100. L0\nX200.\nG80\nG0 X0.\nM30\n"
    written = body(tmp_path, source, "haas-mill")
    assert written[3:] == ["G83 G99 Z-5. R2. Q3. F100. L0", "X200.020 R2.022 Z-4.985", "G80", "G0 X0. Z2.002", "M30"]


def test_a_tool_that_comes_back_to_the_plane_r_goes_on_from_there(tmp_path: Path) -> None:
    """The cycle began at Z 2.002; displaced, the plane R lies above, at 2.012."""
    source = "G21 G90 F5\nG0 X0 Y0 Z2\nG98 G81 X100 Z-5 R2\nG80\nG91 G0 Z1\nM2\n"
    assert body(tmp_path, source, "linuxcnc")[2:5] == [
        "G98 G81 X100.01000 Z-4.99500 R2.01200",
        "G80",
        "G91 G0 Z1.00100",
    ]


def test_increments_and_inches(tmp_path: Path) -> None:
    """In inches the field is the same: 10 in become 10.001, and R counts from the plane before, Z from R."""
    source = "G20 G90 G17 F5\nG0 X0 Y0 Z2\nG91 G99 G82 X10 Z-1 R-1.5 P.1\nX10\nG80 G90\nG0 Z2\nX0\nM2\n"
    written = body(tmp_path, source, "linuxcnc")
    assert written[1:] == [
        "G0 X0 Y0 Z2.002000",
        "G91 G99 G82 X10.001000 Z-1.001000 R-1.500500 P.1",
        "X10.001000 R-1.499500",
        "G80 G90",
        "G0 Z2.004000",
        "X0 Z2.002000",
        "M2",
    ]


def test_the_size_of_the_parts_does_not_show(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    holes = "".join(f"X{k}. Y{k % 7}.\n" for k in range(300))
    source = f"O1\nG21 G90\nG0 X0. Y0. Z20.\nG98 G83 X1. Y1. Z-5. R2. Q1.5 F100.\n{holes}G80\nG0 X0.\nM30\n"
    whole = mapped(tmp_path, source, RISING, "fanuc-mill")[0]
    monkeypatch.setattr(mapped_program, "CHUNK", 64)
    assert mapped(tmp_path, source, RISING, "fanuc-mill")[0] == whole


def test_a_formula_gets_its_term(tmp_path: Path) -> None:
    source = "G21 G90 F100\n#1=-5\n#2=2\nG0 X0 Y0 Z20\nG81 X100 Y0 Z#1 R[#2] \nG80\nM2\n"
    text, _ = mapped(tmp_path, source, affine_field(np.eye(3), (0.0, 0.0, 0.25)))
    assert text.splitlines()[5] == "G81 X100 Y0 Z[#1+0.25] R[#2+0.25] "
    assert path_of(text).end_mm[:, 2].min() == -4.75


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("G21 F1\nG0 X1 Y1\nG81 X2 Z-3 R1\n", 3, "Z has no position yet in the cut"),
        ("G21 F1\nG0 Z9\nG81 X2 Z-3 R1\n", 3, "mm, but the program never says where"),
        ("G21 F1\nG0 X0 Y0 Z9\nG81 X2 Z-43 R1\n", 3, "Y is displaced by 4.40 µm more at one end of the hole"),
        ("G21 F1\nG0 X0 Y0 Z9\nG91 G81 X2 Y0 Z-3 R-5 L4\n", 3, "a hole that the block repeats would be"),
        ("G21 F1\nG0 X0 Y0 Z9\no1 repeat [2]\nG91 G81 X2 Z-3 R-5\no1 endrepeat\n", 4, "several times"),
        ("G21 F1\nG0 X0 Y0 Z9\nG81 X2 Y2 Z-3 R1 L0\nG80\nG0 Z5\nG81 X3 Z-3 R1 L0\nG28 Z5\nX5\n", 8, "Z stands at"),
    ],
)
def test_holes_that_cannot_be_written(tmp_path: Path, text: str, line: int, words: str) -> None:
    leaning = function_field(
        lambda p: np.column_stack([0 * p[:, 0], 0.02 + 1e-4 * p[:, 2] + 2e-3 * p[:, 0], 0 * p[:, 0]]), "leaning"
    )
    with pytest.raises(TrueloopError) as refusal:
        mapped(tmp_path, text, leaning)
    assert (refusal.value.code, refusal.value.place.line) == (Code.NC_MAP, line)
    assert words in refusal.value.message


def test_a_leaning_hole_goes_through_its_middle_where_the_tolerance_allows_it(tmp_path: Path) -> None:
    leaning = function_field(lambda p: np.column_stack([1e-3 * p[:, 2], 0 * p[:, 0], 0 * p[:, 0]]), "leaning")
    options = MapOptions(tolerance_mm=0.005, limit_mm=FREE.limit_mm, slope=FREE.slope)
    text, _ = mapped(tmp_path, "G21 F1\nG0 X0 Y0 Z9\nG81 X2 Z-8 R2\nM2\n", leaning, options=options)
    assert text.splitlines()[3] == "G81 X1.99700 Z-8 R2"


def holes_in(text: str) -> Array:
    """X, Y, R and Z of every hole of G81 and G83 under G90, as its words say, inch: (n, 4)."""
    cycle, values, holes = False, dict.fromkeys("XYRZ", np.nan), []
    for line in re.sub(r"\(.*?\)", "", text).splitlines():
        words = dict(re.findall(r"([XYRZ])(-?[\d.]+)", line))
        cycle = bool(re.search(r"G8[13]", line)) or (cycle and not re.search(r"G80|G0[0-3]", line))
        if "G53" not in line:
            values |= {letter: float(number) for letter, number in words.items()}
        if cycle and words:
            holes.append([values[letter] for letter in "XYRZ"])
    return np.array(holes)


@pytest.mark.corpus
def test_the_holes_of_a_shops_program_are_where_the_field_wants_them(corpus: Path, tmp_path: Path) -> None:
    source = (corpus / "data" / "public" / "nc" / "fanuc-mill-nims.nc").read_text(encoding="latin-1")
    field = affine_field(np.diag([1.0005, 1.0004, 1.0003]), (0.01, 0.02, 0.03))
    before, after = holes_in(source), holes_in(mapped(tmp_path, source, field, "fanuc-mill")[0])
    assert len(before) == len(after) == 8
    for height in (2, 3):
        moved = before[:, [0, 1, height]] * INCH_MM
        wanted = (moved + field.displacement_mm(moved)) / INCH_MM
        assert after[:, [0, 1, height]] == pytest.approx(wanted, abs=0.00005 + 1e-9)


TAPPED = "G17 G71 G90 G94 S200\nG0 X100 Y10 Z5\nG331 Z-12 K1.5\nG332 Z5 K1.5\nM30\n"
TAPPED_ON_A_LATHE = "G18 G71 DIAMOF G90 G95 S200\nG0 X100 Z5\nG331 Z-12 K1.5\nG332 Z5 K1.5\nM30\n"


def test_a_tap_keeps_its_place_along_its_axis(tmp_path: Path) -> None:
    """At X 100 the bottom -12 is -12 + 0.01 - 0.012, the start 5 + 0.01 + 0.005."""
    assert body(tmp_path, TAPPED, "siemens")[1:4] == [
        "G0 X100.0100 Y10 Z5.0150",
        "G331 Z-12.0020 K1.5",
        "G332 Z5.0150 K1.5",
    ]


@pytest.mark.parametrize("text", [TAPPED, TAPPED_ON_A_LATHE])
def test_a_tap_that_the_field_would_lead_aside_is_refused(tmp_path: Path, text: str) -> None:
    """Over 17 mm of depth X changes by 1e-3 of it; it was tapped askew."""
    leaning = function_field(lambda p: np.column_stack([1e-3 * p[:, 2], 0 * p[:, 0], 0 * p[:, 0]]), "leaning")
    with pytest.raises(TrueloopError, match=r"a tap would be led 17\.0 µm aside"):
        mapped(tmp_path, text, leaning, "siemens")
