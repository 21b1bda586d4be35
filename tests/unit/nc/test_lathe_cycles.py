"""Roughing and grooving cycles of Fanuc and Haas lathes: every move worked out by hand, x a radius."""

import numpy as np
import pytest

from tests.unit.nc.test_turning_cycles import START, rows, run
from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import read_program

CONTOUR = "N10 G00 X20.\nG01 Z-10.\nN20 X60."


def test_roughing_in_one_block_leaves_more_before_the_last_cut() -> None:
    """D is the depth of cut, I and K (radii) what the straight cuts leave beside U and W: 8 mm deep from 30.5 they go
    to 22.5 and 14.5, and stop at z = -9.4; the last cut leaves U and W: 10.2 and -9.9."""
    path = run(f"G71 P10 Q20 U.4 W.1 I.3 K.5 D8. F.2\n{CONTOUR}", "haas-lathe")
    assert rows(path) == [
        *[("rapid", 30.5, 2.6), ("rapid", 22.5, 2.6), ("line", 22.5, -9.4), ("rapid", 23.77, -8.13)],
        *[("rapid", 23.77, 2.6), ("rapid", 14.5, 2.6), ("line", 14.5, -9.4), ("rapid", 15.77, -8.13)],
        *[("rapid", 15.77, 2.6), ("rapid", 10.2, 2.1), ("line", 10.2, -9.9), ("line", 30.2, -9.9), ("rapid", 30, 2)],
    ]
    (lifted,) = path.findings
    assert (lifted.code, lifted.severity) == (Code.NC_OPAQUE, "note")
    assert "1.27 mm" in lifted.message


def test_roughing_inside_has_a_negative_u() -> None:
    path = run(f"G00 X10.\nG71 U3. R.5\nG71 P10 Q20 U-.4 W.1\n{CONTOUR.replace('X60.', 'X10.')}")
    assert {row[1] for row in rows(path, 2) if row[0] == "line"} == {7.8, 9.8, 4.8}


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("G71 U2. R1.\nG71 P10 Q20\nN10 G00 X20.\nG01 Z-5.\nX10. Z-8.\nN20 X60.", "a pocket"),
        ("G71 U2. R1.\nG71 P10 Q20\nN10 G00 X20.\nG01 Z-5.\nX40.\nZ-3.\nN20 X60.", "a pocket"),
        ("G71 U2. R1.\nG71 P10 Q20\nN10 G00 X20. Z5.\nG01 Z-5.\nN20 X60.", "turns back"),
        ("G71 U2. R1.\nG71 P10 Q20\nN10 G00 X20. W0\nG01 Z-5.\nX70.\nZ-8.\nX50.\nN20 Z-9.", "above its start"),
        ("G71 U0 R1.\nG71 P10 Q20\nN10 G00 X20. W0\nG01 Z-5.\nN20 X60.", "its depth of cut makes no sense"),
        ("G71 P10 Q20\n" + CONTOUR, "its depth of cut is a parameter"),
        ("G71 U0 R1.\nG71 P10 Q20\n" + CONTOUR, "its depth of cut makes no sense"),
        ("G73 P10 Q20\n" + CONTOUR, "its relief or its number of passes"),
        ("G73 U1. W1. R0\nG73 P10 Q20\n" + CONTOUR, "its number of passes makes no sense"),
        ("G71 U2. R1.\nG71 P10 Q20\nN10 G00 X20.\nG00 Z-10.\nN20 X60.", "its contour has no cut"),
        ("G71 U2. R1.\nG71 P10 Q20\nN10 G00 X20.\nG01 Z-5.\nG00 Z-9.\nG01 Z-10.\nN20 X60.", "lines and arcs alone"),
        ("G71 U2. R1.\nG71 P10 Q20\nN10 G00 X20.\nG01 Z-5.\nG52 X1.\nG01 Z-10.\nN20 X60.", "the frame changes"),
    ],
)
def test_what_cannot_be_roughed_is_said_and_nothing_moves(text: str, why: str) -> None:
    path = run(text)
    found = next(found for found in path.findings if found.code == Code.NC_OPAQUE)
    assert (found.severity, why in found.message) == ("warning", True)
    assert len(path) == 1


@pytest.mark.parametrize("names", ["W0", "Z2."])
def test_a_first_block_of_both_axes_has_the_tool_follow_the_wall(names: str) -> None:
    """The cut at 21 ends at the cone, z = -2.9; along that to the height of the start, and off by R."""
    path = run(f"G71 U9. R1.\nG71 P10 Q20 W.1\nN10 G00 X40. {names}\nG01 Z-2.\nX60. Z-12.\nN20 G01")
    assert path.findings == ()
    assert rows(path) == [
        *[("rapid", 30, 2.1), ("rapid", 21, 2.1), ("line", 21, -2.9), ("line", 30, -11.9), ("rapid", 31, -10.9)],
        *[("rapid", 30, 2.1), ("rapid", 20, 2.1), ("line", 20, -1.9), ("line", 30, -11.9), ("rapid", 30, 2)],
    ]


def test_facing_follows_its_wall_as_well() -> None:
    """From z = 2 the cut at -7 ends at x = 25.05, on a slope that comes out at 16.05."""
    path = run("G72 W9. R1.\nG72 P10 Q20 U.1\nN10 G00 Z-8. U0\nG01 X52.\nX32. Z2.\nN20 G01")
    assert rows(path) == [
        *[("rapid", 30.05, 2), ("rapid", 30.05, -7), ("line", 25.05, -7), ("line", 16.05, 2), ("rapid", 17.05, 3)],
        *[("rapid", 30.05, 2), ("rapid", 30.05, -8), ("line", 26.05, -8), ("line", 16.05, 2), ("rapid", 30, 2)],
    ]


def test_an_allowance_along_the_cuts_of_a_pocket_is_said() -> None:
    pocket = "N10 G00 X50. W0\nG01 Z-5.\nX40. Z-8.\nZ-12.\nN20 X60."
    (plain,) = run(f"G71 U2. R1.\nG71 P10 Q20 U.4\n{pocket}").findings
    (moved,) = run(f"G71 U2. R1.\nG71 P10 Q20 W.1\n{pocket}").findings
    assert [found.code for found in (plain, moved)] == [Code.NC_OPAQUE] * 2
    assert "both walls" in moved.message and "both walls" not in plain.message


def test_the_way_back_from_a_contour_that_ends_in_a_pocket_is_over_its_ridge() -> None:
    path = run("G71 U9. R1.\nG71 P10 Q20 U.4\nN10 G00 X50. W0\nG01 Z-5.\nX58. Z-8.\nX40. Z-12.\nN20 Z-14.")
    assert rows(path)[-2:] == [("rapid", 30.2, -14), ("rapid", 30, 2)]


def test_a_contour_does_not_run_on_a_contour() -> None:
    text = START + "G71 U2. R1.\nG71 P10 Q20\nN10 G00 X20.\nG70 P10 Q20\nN20 G01 X60."
    path = read_program(text.encode(), "fanuc-lathe").run(strict=False)
    assert Code.NC_FLOW in {found.code for found in path.findings}


def test_roughing_leaves_state_parameters_and_feed_of_the_contour_alone() -> None:
    path = run(f"#1=5.\nG71 U15. R1.\nG71 P10 Q20 F.3\n{CONTOUR.replace('Z-10.', 'Z-10. F.1')}\n#1=#1+1.\nG01 X#1")
    assert set(path.feed[path.line == 5].tolist()) == {0.3}
    assert path.end_mm[-1, 0] == 3.0


def groove(across: float, *, away: float = 0.0) -> list[tuple[str, float, float]]:
    """From radius 30 to 21 in pecks of 4, back by 1 after each; `away` at the bottom."""
    pecks = [("line", 26, across), ("rapid", 27, across), ("line", 22, across), ("rapid", 23, across)]
    out = [("rapid", 30, across + away)]
    return [*pecks, ("line", 21, across), *([("rapid", 21, across + away)] if away else []), *out]


def test_grooves_along_x_in_pecks() -> None:
    """P counts 0.001 mm on the radius, X42. is radius 21; Q4000 is 4 mm: at z = 2, -2 and the last at -5. R moves the
    tool away from the wall at the bottom, back towards the groove before; not in the first, which has none."""
    path = run("G75 R1.\nG75 X42. Z-5. P4000 Q4000 R.5 F.1")
    first, second, third = groove(2), groove(-2, away=0.5), groove(-5, away=0.5)
    assert rows(path) == [*first, ("rapid", 30, -2), *second, ("rapid", 30, -5), *third, ("rapid", 30, 2)]
    assert path.findings == ()


def test_one_groove_of_haas_and_how_far_it_goes_back() -> None:
    path = run("G75 X42. I5. F.1", "haas-lathe")
    assert rows(path) == [("line", 25, 2), ("rapid", 25.254, 2), ("line", 21, 2), ("rapid", 30, 2)]
    assert [found.code for found in path.findings] == [Code.NC_OPAQUE]


def test_pecks_along_z_and_columns_along_x() -> None:
    """P3000 is 3 mm on the radius, though U-10. is one of 5 mm: x = 30, 27, 25."""
    path = run("G74 R.5\nG74 U-10. W-5. P3000 Q4000 F.1")
    column = [[("line", x, -2), ("rapid", x, -1.5), ("line", x, -3), ("rapid", x, 2)] for x in (30, 27, 25)]
    assert rows(path) == [*column[0], ("rapid", 27, 2), *column[1], ("rapid", 25, 2), *column[2], ("rapid", 30, 2)]


def test_drilling_by_g74_alone() -> None:
    path = run("G00 X0.\nG74 R.5\nG74 Z-5. Q4000 F.1")
    assert rows(path, 2) == [("line", 0, -2), ("rapid", 0, -1.5), ("line", 0, -5), ("rapid", 0, 2)]


@pytest.mark.parametrize("words", ["X42. P0", "X42. P-4000", "X42. Z-5. P4000 Q0"])
def test_grooves_whose_pecks_make_no_sense_are_refused(words: str) -> None:
    (found,) = run(f"G75 R1.\nG75 {words}").findings
    assert found.code == Code.NC_MISPLACED


def test_dwells_at_the_bottom_count() -> None:
    """P is thousandths of a second where it has no point; G81 has none; the dwell stands before the way out."""
    mill = run("G82 X1. Z-5. R1. P500 F100\nX2.\nG80\nG81 X3. Z-5. R1. P500\nG80\nG89 X4. Z-5. R1. P1.5", "fanuc-mill")
    assert mill.dwell_s.tolist() == [0.5, 0.5, 1.5]
    assert [mill.end_mm[k - 1, 2] for k in mill.dwell_before] == [-5.0] * 3
    text = "G17\nG82 X1 Z-5 R1 P.5 F100\nG85 X2 Z-5 R1\nG89 X3 Z-5 R1 P2"
    assert run(text, "linuxcnc").dwell_s.tolist() == [0.5, 2.0]


@pytest.mark.parametrize("cycle", ["G92 X50. Z-5. F1.5", "G83 Z-5. R-3. F.1"])
def test_a_way_to_a_place_of_the_machine_runs_no_cycle(cycle: str) -> None:
    before, path = run(cycle), run(f"{cycle}\nG53 X0 Z0")
    assert rows(path, len(before)) == [("rapid", 0, 0)]


@pytest.mark.parametrize(("step", "dialect"), [("Q4000", "fanuc-lathe"), ("K4.", "haas-lathe")])
def test_pecks_without_a_step_across_stay_where_they_began(step: str, dialect: str) -> None:
    """From z = 2 to -5 by 4: to -2 and -5, at x = 0; X of the end is that of the start."""
    path = run(f"G00 X0.\nG74 X0. Z-5. {step} F.1", dialect)
    assert [row for row in rows(path, 1) if row[0] == "line"][-2:] == [("line", 0, -2), ("line", 0, -5)]
    assert not [one for one in path.findings if one.code is Code.NC_MISPLACED]
    path = run(f"G74 R.5\nG74 X40. Z-5. {step} F.1", dialect)
    assert {row[1] for row in rows(path) if row[0] == "line"} == {30}
    assert [one.code for one in path.findings if one.code is Code.NC_MISPLACED] == [Code.NC_MISPLACED]


def test_the_second_reference_point_is_the_machine_s() -> None:
    (found,) = run("G30 U0 W0").findings
    assert (found.code, found.severity) == (Code.NC_OPAQUE, "note")


def test_a_contour_with_a_cycle_in_it_is_refused() -> None:
    for first in ("N10 G0 X20.\nG71 U2. R1.", "N10 G71 U2. R1."):  # the number alone, also at the cycle itself
        with pytest.raises(
            TrueloopError, match="the contour of this cycle has a cycle with a contour in it"
        ) as refused:
            run(f"{first}\nG71 P10 Q20\nN20 X30.\nG70 P10 Q20")
        assert refused.value.code is Code.NC_FLOW


def test_of_a_number_that_is_there_twice_the_contour_without_a_cycle_counts() -> None:
    """N10 of the tool's change comes before that of the contour: from there G70 would run G71."""
    cycles = "G71 U2. R1.\nG71 P10 Q20\n{}\nG70 P10 Q20"
    twice = run("N10 T0101\n" + cycles.format(CONTOUR))
    once = run("T0101\n" + cycles.format(CONTOUR))
    assert np.array_equal(twice.end_mm, once.end_mm)
