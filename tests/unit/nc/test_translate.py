"""Programs written in another dialect send the tool where the source does; what is lost is said."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.support.linuxcnc import Tool, interpret
from tests.support.machine_moves import machine_moves
from tests.support.nc_judge import assert_same_moves
from tests.support.spelled_moves import GIVEN_UNIT
from trueloop.errors import Code, Severity, TrueloopError
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.translate.controls import CONTROLS
from trueloop.nc.translate.translate import Translation, translate

PROGRAMS = Path(__file__).parents[2] / "programs"
WHOLE = (
    *("facetst-finish", "fanuc-lathe-b", "fanuc-macros", "linuxcnc-diameter", "linuxcnc-expressions", "linuxcnc-flow"),
    *("metric-increments", "modbas2-finish", "optional-block", "piecs11-finish", "siemens-curves", "turning-cycle"),
    *("linuxcnc-planes", "siemens-mill", "siemens-lathe", "fanuc-lathe-compensated", "linuxcnc-spelling"),
    *("fanuc-lathe-roughing", "fanuc-lathe-grooves", "linuxcnc-splines"),
)
"""Programs whose moves all have words in every dialect of their kind."""
STARTUP = "G17 G20 G8 G40 G90 G94 S1000"
"""Feed per revolution needs a spindle speed, which cut-outs of programs may lack."""


def source(name: str) -> tuple[Program, dict[str, float]]:
    case = tomllib.loads((PROGRAMS / name / "case.toml").read_text())
    file = next((PROGRAMS / name).glob("program.*"))
    program = read_program(file.read_bytes(), case["dialect"], file.name, unit=case.get("given_unit"))
    return program, case.get("parameters", {})


def lost(made: Translation, severity: Severity) -> list[str]:
    return [loss.message for loss in made.losses if loss.severity is severity]


def of(text: str, dialect: str, to: str, *, decimals: int | None = None) -> Translation:
    return translate(read_program(text.encode(), dialect, "part.nc"), to, decimals=decimals)


def test_every_dialect_has_a_row() -> None:
    assert CONTROLS.keys() == DIALECTS.keys()


@pytest.mark.parametrize("name", [*WHOLE, "fanuc-mill", "position-register"])
def test_linuxcnc_makes_the_source_s_moves_of_the_translation(name: str, tmp_path: Path) -> None:
    """Its own interpreter reads the translation as our reader does, and that is the source's path (below)."""
    program, parameters = source(name)
    out = tmp_path / "out.ngc"
    out.write_bytes(translate(program, "linuxcnc", parameters, decimals=9).source)
    judged = interpret(out, tools=[Tool(number) for number in range(1, 10)], startup=STARTUP)
    assert_same_moves(read_program(out.read_bytes(), "linuxcnc").run(), judged)


@pytest.mark.parametrize("to", DIALECTS)
@pytest.mark.parametrize("name", WHOLE)
def test_the_path_is_the_source_s_to_the_rounding(name: str, to: str) -> None:
    program, parameters = source(name)
    wanted = machine_moves(program, parameters)
    try:
        made = translate(program, to, parameters, decimals=5)
    except TrueloopError as refused:
        assert refused.code is Code.NC_LOST
        assert {"turning", "milling"} & set(refused.message.split()) or "G1" in refused.message
        return
    own = lost(translate(program, program.dialect.name, parameters), Severity.ERROR)
    by_target = [error for error in lost(made, Severity.ERROR) if error not in own]
    if by_target:
        no_words = ("position register", "machine coordinates", "way to the reference point", "surface speed")
        assert all(any(what in error for what in no_words) for error in by_target)
        return
    found = machine_moves(read_program(made.source, to, unit=GIVEN_UNIT.get(to)))
    step_mm = 25.4e-5 if program.run(parameters).inch.any() else 1e-5
    assert made.rounded_mm <= (2.2 if to == "heidenhain" else 0.5) * step_mm * (1 + 1e-9)
    assert [move.motion for move in found] == [move.motion for move in wanted]
    for ours, true in zip(found, wanted, strict=True):
        assert np.abs(ours.end_mm - true.end_mm).max() <= made.rounded_mm + 1e-9
        assert np.nan_to_num(np.abs(ours.centre_mm - true.centre_mm)).max() <= 1.5 * step_mm
        assert ours.sweep_rad == pytest.approx(true.sweep_rad, abs=1e-3)


def test_a_turning_program_is_written_word_for_word() -> None:
    made = of(
        "%\nO0012 (SHAFT)\nG21 G18 G40 G99\nT0101\nG50 S2500\nG96 S180 M03\nG00 X40. Z2. M08\nG01 Z-20. F.2\n"
        "G02 U10. W-5. R5.\nG04 P500\nG28 U0 W0\nM30\n%\n",
        "fanuc-lathe",
        "linuxcnc",
    )
    assert made.source.decode().splitlines()[2:] == [
        *("(SHAFT)", "G21 G07 G90 G91.1", "G18 G95", "G40", "T1 M06", "G43 H1", "G96 S180", "M03", "M08"),
        *("G00 X40.0 Z2.0", "G01 Z-20.0 F0.2", "G02 X50.0 Z-25.0 I5.0 K0.0", "G04 P0.5", "G91 G28 X0 Z0", "G90", "M30"),
    ]
    assert lost(made, Severity.ERROR) == []
    assert lost(made, Severity.WARNING) == ['"S2500": the spindle\'s speed is not bounded to 2500 1/min']


def test_a_milling_program_is_written_in_klartext_word_for_word() -> None:
    made = of(
        "G20 G17 G90 T4 M06 G43 H4\nG54 S2000 M03\nG00 X1. Y0. Z2.\nG41 D4 G01 X2. F10.\nG03 X4. Y2. J2.\n"
        "G02 Z1. I-1.\nG40 G01 X0.\nG04 P500\nG53 G00 Z0.\nM30\n",
        "fanuc-mill",
        "heidenhain",
    )
    assert made.source.decode().splitlines()[3:] == [
        *("3 TOOL CALL 4 Z", "4 TOOL CALL 4 Z S2000", "5 M3", "6 L X+25.4 Y+0 Z+50.8 R0 FMAX", "7 L X+50.8 RL F254"),
        *("8 CC X+50.8 Y+50.8", "9 C X+101.6 Y+50.8 DR+", "10 CC X+76.2 Y+50.8", "11 CP IPA-360 IZ-25.4 DR-"),
        *("12 L X+0 R0", "13 CYCL DEF 9.0 DWELL TIME", "14 CYCL DEF 9.1 DWELL 0.5", "15 L Z+0 FMAX M91", "16 M30"),
        "17 END PGM O0001 MM",
    ]


def test_feeds_of_a_time_and_of_a_revolution_are_those_of_a_minute() -> None:
    """10 mm in 1/4 min are 40 mm/min, 5π mm of a half circle 20π; 0.2 mm at 500 1/min are 100 mm/min."""
    timed = of("G21 G93 G0 X0 Y0\nG1 X10 F4\nG2 X0 I-5 F4", "linuxcnc", "fanuc-mill").source
    assert b"F40.0" in timed and b"F62.831853" in timed and b"G93" not in timed
    inch = of("G20 G0 X1. Y0.\nG1 X2. F10.", "fanuc-mill", "linuxcnc").source
    assert b"G01 X2.0 F10.0" in inch
    turned = of("G21 G95 S500 M3\nG0 X0. Y0.\nG1 X10. F.2", "fanuc-mill", "heidenhain").source
    assert b"X+10 F100" in turned
    klartext = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S500\n2 L X+0 FMAX M3\n3 L X+10 F0.2 M136\n"
    assert b"G95\nG01 X10.0 F0.2" in of(klartext, "heidenhain", "fanuc-mill").source
    unknown = of("G21 G95\nG0 X0. Y0.\nG1 X10. F.2", "fanuc-mill", "heidenhain")
    assert "without the spindle's speed" in lost(unknown, Severity.ERROR)[0]


@pytest.mark.parametrize(
    ("text", "dialect", "to", "word"),
    [
        ("G21 G0 X1\nG10 L2 P1 X5\nG0 X2", "linuxcnc", "fanuc-mill", "G10"),
        ("G21 G0 X1\nG92 Z0\nG0 X2", "linuxcnc", "siemens", "G92"),
        ("G21 G90 G0 X1\nG28 Z50.\nG0 X2", "fanuc-mill", "linuxcnc", "G28"),
        ("G21 G91 G0 X1", "linuxcnc", "fanuc-mill", "X1"),
        ("G21 G0 X1\nG55 X2", "linuxcnc", "heidenhain", "G55"),
        ("G21 G0 X1\nG55\nG91 X2", "linuxcnc", "fanuc-mill", "X2"),
        ("G21 G0 X1\nG38.2 Z-5 F10", "linuxcnc", "fanuc-mill", "Z-5"),
        ("G21 G0 X1\nG123 X5", "linuxcnc", "fanuc-mill", "G123"),
        ("G18 G71 G0 X1 Z0", "siemens", "linuxcnc", "X1"),
        ("G21 G0 X1. Y0. Z5.\nG84 Z-5. R1. F1.", "fanuc-mill", "linuxcnc", "G84"),
        ("G71 T=\"DRILL\" M6", "siemens", "linuxcnc", "T="),
        ("G71 G17\nT2 D2\nG0 X1", "siemens", "linuxcnc", "D2"),
        ("G71 G17\nT2 D1\nG0 X1\nD2\nG0 X2", "siemens", "fanuc-mill", "D2"),
        ("G71 G18 DIAMON\nT2\nG0 X1\nD3\nG0 X2", "siemens", "siemens", "D3"),
        ("G21 G0 X1. Z1.\nG71 P1 Q2\nN1 G0 X0.\nN2 Z0.", "fanuc-lathe", "linuxcnc", "G71"),
        ("(UPD, 1, TOV(X), 0.1)\nG70 G00 X1.0", "ge2000t", "linuxcnc", "(UPD"),
        ("0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1 DL+0.1", "heidenhain", "fanuc-mill", "DL"),
        ("0 BEGIN PGM A MM\n1 L X+1 F100 M128", "heidenhain", "fanuc-mill", "M128"),
    ],
)  # fmt: skip
def test_what_moves_the_machine_otherwise_is_an_error_at_its_word(text: str, dialect: str, to: str, word: str) -> None:
    errors = [loss for loss in of(text, dialect, to).losses if loss.severity is Severity.ERROR]
    assert {loss.code for loss in errors} == {Code.NC_LOST}
    places = [(loss.place.line or 0, loss.place.column or 0) for loss in errors]
    assert any(text.splitlines()[line - 1][column - 1 :].startswith(word) for line, column in places)


@pytest.mark.parametrize(
    ("text", "dialect", "to", "what"),
    [
        ("G21 G8 G18 G0 X5 Z0\nG33 Z-20 K1.5", "linuxcnc", "ge2000t", "a thread"),
        ("G21 G17 G0 X1 Y0\nG2 X2 Y1 I1 J0 F1", "linuxcnc", "ge2000t", "for milling"),
        ("G21 G19 G0 X1 Y1 Z0\nG2 Y1 Z2 R1 F1\nG7 G1 X5", "linuxcnc", "ge2000t", "an arc in the plane G19"),
        ("G21 G0 X5. Z0.", "fanuc-lathe", "heidenhain", "for turning (its dialect is fanuc-lathe)"),
        ("G21 G7 G18 G0 X5 Z0", "linuxcnc", "fanuc-mill", "for turning (X is a diameter)"),
        ("0 BEGIN PGM A MM\n1 L X+1 F100", "heidenhain", "haas-lathe", "for milling"),
        ("G21 G90 G0 X1. Y0.\nG41 G02 X2. Y1. R1. F1.", "fanuc-mill", "heidenhain", "begins or ends with an arc"),
    ],
)
def test_what_cannot_be_written_at_all_is_refused(text: str, dialect: str, to: str, what: str) -> None:
    with pytest.raises(TrueloopError, match="NC-LOST") as refused:
        of(text, dialect, to)
    assert what in refused.value.message


def test_a_thread_keeps_its_lead() -> None:
    assert b"G32 Z-20.0 F1.5" in of("G21 G8 G18 G0 X5 Z0\nG33 Z-20 K1.5", "linuxcnc", "fanuc-lathe").source
    assert b"G33 Z-20.0 K1.5" in of("G21 G0 X5. Z0.\nG32 Z-20. F1.5", "fanuc-lathe", "siemens").source


def test_the_lead_of_a_threading_cycle_is_its_pitch_not_its_depth() -> None:
    made = of("G21 G8 G18 G0 X10 Z2\nG76 P1.5 Z-10 I-1 J0.5 K0.9", "linuxcnc", "siemens").source
    assert made.count(b"K1.5") == 2 and b"K0.9" not in made


def test_a_dwell_keeps_its_seconds() -> None:
    assert b"G04 X2.0\nG01 X10.0" in of("G21 G8 G18 G0 X1 Z2\nG4 P2 G1 X5 F1", "linuxcnc", "fanuc-lathe").source
    assert b"G04 P0.5" in of("G21 G00 X1.\nG04 P500", "fanuc-mill", "linuxcnc").source
    assert b"CYCL DEF 9.1 DWELL 3.0" in of("G71 G0 X1\nG4 F3", "siemens", "heidenhain").source
    klartext = "0 BEGIN PGM A MM\n1 CYCL DEF 9.0 DWELL TIME\n2 CYCL DEF 9.1 DWELL 2.5"
    assert b"G4 F2.5" in of(klartext, "heidenhain", "siemens").source.replace(b"G04", b"G4")


def test_x_of_a_lathe_is_a_diameter_and_its_centre_a_radius() -> None:
    """A quarter of radius 5 mm from X 20 mm (diameter): to X 30, its centre 5 mm away on the radius."""
    arc = "G21 G8 G18 G0 X10 Z0\nG2 X15 Z-5 I5 K0 F1"
    assert b"G02 X30.0 Z-5.0 I5.0 K0.0" in of(arc, "linuxcnc", "fanuc-lathe").source
    assert b"DIAMOF" in of(arc, "linuxcnc", "siemens").source
    back = of("G21 G0 X20. Z0.\nG02 X30. Z-5. R5. F1.", "fanuc-lathe", "siemens").source
    assert b"DIAMON" in back and b"G02 X30.0 Z-5.0 I5.0 K0.0" in back


def test_a_drilling_cycle_is_written_as_moves() -> None:
    made = of("G21 G0 X1. Y1. Z5.\nG81 X2. Z-5. R1. F100.\nG80", "fanuc-mill", "siemens")
    assert b"G00 Z1.0\nG01 Z-5.0 F100.0\nG00 Z5.0" in made.source
    assert not lost(made, Severity.ERROR)


def test_offsets_of_a_tool_come_into_force_as_the_control_has_it() -> None:
    turret = "G21 T0102\nG00 X5. Z0.\nT0100"
    assert b"T1 M06\nG43 H2" in of(turret, "fanuc-lathe", "linuxcnc").source
    assert b"G49" in of(turret, "fanuc-lathe", "linuxcnc").source
    assert "row 2 of the offset table" in lost(of(turret, "fanuc-lathe", "siemens"), Severity.WARNING)[0]
    assert b"T0303" in of("G21 G8 G18 T3 M6 G43\nG0 X5 Z0", "linuxcnc", "haas-lathe").source
    assert b"T5 M06\nG43 H5" in of("0 BEGIN PGM A MM\n1 TOOL CALL 5 Z S1", "heidenhain", "haas-mill").source


def test_a_zero_set_by_the_program_becomes_part_of_the_positions_where_the_control_has_no_words_for_it() -> None:
    """X 10 is named 3: positions after it are 7 less. Moves in machine coordinates are not shifted with them."""
    made = of("G21 G90 G0 X10 Y0 Z0\nG92 X3\nG1 X5 F9\nG53 G0 X2\n", "linuxcnc", "siemens")
    assert b"G01 X12.0 F9.0\nG53 G00 X2.0" in made.source
    kept = of("G21 G90 G0 X10 Y0 Z0\nG92 X3\nG1 X5 F9\nG53 G0 X2\n", "linuxcnc", "fanuc-mill")
    assert b"G92 X3.0\nG01 X5.0 F9.0\nG53 G00 X2.0" in kept.source


def test_an_arc_that_only_names_its_third_axis_ends_where_it_says_and_a_circle_after_it_is_whole() -> None:
    text = "G71 G17 G90 G94\nG1 X0 Y0 Z0 F1\nG2 X-0.02 Y0.06 Z0 I-0.1 J0\nX-0.02 Y0.06 I-0.1 J0\nM30\n"
    made = translate(read_program(text.encode(), "siemens"), "heidenhain").source
    assert b"C X-0.02 Y+0.06 DR-" in made and b"CP" not in made
    assert read_program(made, "heidenhain").run().sweep_rad[-1] == pytest.approx(math.tau)


def test_an_arc_that_rounding_would_make_a_full_circle_is_a_line() -> None:
    program = read_program(b"G21 G90 G0 X0 Y0\nG2 X0.0004 Y0 R5 F9", "linuxcnc")
    made = translate(program, "fanuc-mill", decimals=3)
    assert b"G02" not in made.source and b"G01 X0.0 Y0.0 F9.0" in made.source


def test_what_was_not_run_is_said() -> None:
    made = of("G21\n/G0 X1\nG0 Y1 ; a remark\nM2\nG0 X5", "linuxcnc", "fanuc-mill")
    assert lost(made, Severity.WARNING) == ['"G0": 2 blocks were not run, from this one on, and are not written']
    assert b"(a remark)" in made.source


def test_a_corner_between_two_blocks_comes_before_what_the_second_switches() -> None:
    made = of("G21 G0 X0. Y0.\nG01 X10. ,R2. F9.\nM08 Y10.\nM30", "fanuc-mill", "linuxcnc")
    assert b"G01 X8.0 F9.0\nG03 X10.0 Y2.0 I0.0 J2.0\nM08\nG01 Y10.0" in made.source
    assert not lost(made, Severity.ERROR)


def test_what_looks_like_a_comment_in_a_comment_is_part_of_it() -> None:
    written = of("G21 G18 (one; two)\nG0 X1 ; (three)\nM2\n", "linuxcnc", "fanuc-lathe").source.decode()
    assert written.count("two") == written.count("three") == 1
    assert "(one; two)" in written


def test_two_rows_of_one_tool_stay_two_edges_on_a_sinumerik() -> None:
    """T0202 and T0212 are two offsets: with one edge for both, one of two cuts would be off by their difference."""
    lathe = "G21 G18\nT0202\nG00 X10. Z1.\nT0212\nG00 X9.\nT0200\nT0404\nG00 X8.\nT0414\nT0202\nG00 X7."
    made = of(lathe, "fanuc-lathe", "siemens")
    lines = [line for line in made.source.decode().split() if line[0] in "TD" and line[1:].isdigit()]
    assert lines == ["T2", "D1", "T2", "D2", "T2", "D0", "T4", "D1", "T4", "D2", "T2", "D1"]
    assert [loss for loss in lost(made, Severity.WARNING) if "row 12 " in loss and "D2 of tool 2" in loss]
    later = of("G21 G18\nT0212\nG00 X9. Z1.\nT0202\nG00 X8.", "fanuc-lathe", "siemens").source
    assert later.index(b"D2") < later.index(b"D1")  # the tool's own row is D1, whenever it comes


def test_a_row_that_tools_share_comes_into_force_with_each_of_them() -> None:
    """Row 1 is the second edge of tool 2 there: with T2 alone its first one would be in force."""
    made = of("G21 G18\nT0202\nG00 X9. Z1.\nT0101\nG00 X8.\nT0201\nG00 X7.", "fanuc-lathe", "siemens")
    assert made.source.split()[-5:-2] == [b"T2", b"D2", b"G00"]


def test_ten_rows_of_one_tool_are_more_than_it_has_edges() -> None:
    lathe = "G21 G18\n" + "".join(f"T02{row}\nG00 X9. Z{row}.\n" for row in range(11, 21))
    with pytest.raises(TrueloopError, match="more than 9 rows"):
        of(lathe, "fanuc-lathe", "siemens")


def test_rows_of_the_table_that_klartext_has_not_got_are_told() -> None:
    both = of("G21\nT2 M06\nG43 H2 Z9.\nG00 X1. Y1.\nG43 H12 Z9.\nG01 X2. F100.", "fanuc-mill", "heidenhain")
    assert ["row 12" in loss for loss in lost(both, Severity.ERROR)] == [True]
    one = of("G21\nT2 M06\nG43 H12 Z9.\nG00 X1. Y1.", "fanuc-mill", "heidenhain")
    assert not lost(one, Severity.ERROR)
    assert [loss for loss in lost(one, Severity.WARNING) if "row 12" in loss]


def test_a_row_of_three_digits_has_no_room_in_t() -> None:
    """T02112 would be tool 21 with row 12."""
    with pytest.raises(TrueloopError, match="NC-LOST") as refused:
        of("G21 G18\nT2 M6 G43 H112\nG0 X1 Z1", "linuxcnc", "fanuc-lathe")
    assert "row 112" in refused.value.message


@pytest.mark.parametrize(
    ("end", "longer", "slant"),
    [("X16. Z-20.", "K", math.hypot(3, 20) / 20), ("X80. Z-20.", "I", math.hypot(35, 20) / 35)],
)
def test_the_lead_of_a_taper_counts_as_each_control_has_it(end: str, longer: str, slant: float) -> None:
    """From X10. (radius 5) and Z0. Fanuc and Sinumerik count it on the axis on which the thread is longer (Siemens
    6FC5398-1BP10-2BA0, page 169), LinuxCNC along the thread."""
    fanuc = f"G21 G18\nG00 X10. Z0.\nG32 {end} F2."
    assert f" {longer}2.0\n".encode() in of(fanuc, "fanuc-lathe", "siemens").source
    linuxcnc = of(fanuc, "fanuc-lathe", "linuxcnc").source
    assert f" K{round(2 * slant, 6)}\n".encode() in linuxcnc
    back = of(linuxcnc.decode(), "linuxcnc", "haas-lathe").source
    lead = float(back.split(b"G32")[1].split()[2][1:])
    assert lead == pytest.approx(2.0, abs=1e-6)
