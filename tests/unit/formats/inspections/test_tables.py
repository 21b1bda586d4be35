"""Tables of any columns: what stands where, in which unit and with which sign, read from texts written here."""

import itertools
import shlex
from datetime import datetime
from pathlib import Path

import pytest

from tests.support.workbooks import Raw, write_xlsx
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts
from trueloop.formats.inspections.shared.checks import within
from trueloop.formats.inspections.tables.mapping import toml_of
from trueloop.formats.inspections.tables.propose import propose
from trueloop.formats.inspections.tables.read import grid_of, settled

GERMAN = """Prüfprotokoll;;;;;;;
Teilebezeichnung: Welle;;;;;;;
Seriennummer;4711;;Prüfer:;Müller;;;
Datum;14.03.2024 10:22;;;;;;
Einheit: mm;;;;;;;

;;;;Toleranz;;;
Merkmal;Art;Nennmaß;Istmaß;oben;unten;Abw. [µm];Bemerkung
D1;Ø;25,000;25,0132;0,050;0,050;13,2;
L1;Länge;100,0;100,012;0,1;0,1;12,0;gut
W1;Winkel;45;45,02;0,1;0,1;;
"""


def _read(path: Path, content: str | bytes, name: str = "part.csv", **stated: object) -> MeasuredFile:
    file = path / name
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_measured_file(file, StatedFacts(**stated))  # type: ignore[arg-type]


def _one(file: MeasuredFile) -> list[Reading]:
    (inspection,) = file.inspections
    return list(inspection.readings)


def _refused(path: Path, content: str | bytes, name: str = "part.csv", **stated: object) -> TrueloopError:
    with pytest.raises(TrueloopError) as refusal:
        _read(path, content, name, **stated)
    return refusal.value


def test_a_german_record_with_its_headings_in_row_8_under_a_title_over_two_columns(tmp_path: Path) -> None:
    file = _read(tmp_path, GERMAN)
    diameter, length, angle = _one(file)
    assert (diameter.quantity, diameter.actual, diameter.nominal) == (Quantity.DIAMETER, 25.0132, 25.0)
    assert (diameter.lower_limit, diameter.upper_limit) == (24.95, 25.05)
    assert (length.quantity, length.actual, length.line) == (Quantity.LENGTH, 100.012, 10)
    assert (angle.quantity, angle.actual) == (Quantity.ANGLE, 45.02)
    (one,) = file.inspections
    assert (one.part.part_type.name, one.part.serial, one.operator) == ("Welle", "4711", "Müller")
    assert one.measured_at == datetime(2024, 3, 14, 10, 22).astimezone()
    assert any("without their sign" in remark.text for remark in file.remarks)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252", "latin-1"])
def test_the_encoding_changes_nothing(tmp_path: Path, encoding: str) -> None:
    text = GERMAN.replace("\n", "\r\n")
    assert _one(_read(tmp_path, text.encode(encoding))) == _one(_read(tmp_path, GERMAN))


def test_chinese_text_in_gbk(tmp_path: Path) -> None:
    text = "characteristic,nominal [mm],actual [mm]\n轴承外圆直径测量结果,25,25.01\n端面到基准的长度测量结果,10,10.02\n"
    assert _one(_read(tmp_path, text.encode("gbk")))[0].characteristic == "轴承外圆直径测量结果"


def test_an_inch_heading_makes_millimetres_and_a_micrometre_deviation_is_no_millimetre(tmp_path: Path) -> None:
    file = _read(
        tmp_path, "Name,Nominal (in),Actual (in),Dev (in)\nDIA 1,1.0000,1.0010,0.0010\nDIA 2,2.0000,1.9990,-0.0010\n"
    )
    first, second = _one(file)
    assert file.unit == "inch"
    assert (first.nominal, first.actual) == pytest.approx((25.4, 25.4254))
    assert second.actual == pytest.approx(50.7746)


def test_deviations_counted_the_other_way_are_reported_and_the_actual_value_is_kept(tmp_path: Path) -> None:
    file = _read(tmp_path, "name;nominal [mm];actual [mm];deviation [mm]\nD1;10;10,02;-0,02\nD2;12;11,99;0,01\n")
    assert [one.actual for one in _one(file)] == [10.02, 11.99]
    assert any("2 of 2 deviations are counted the other way" in remark.text for remark in file.remarks)


def test_an_actual_value_that_is_missing_follows_from_a_deviation_whose_sign_the_other_rows_tell(
    tmp_path: Path,
) -> None:
    file = _read(tmp_path, "name;nominal [mm];actual [mm];deviation [mm]\nD1;10;10,02;-0,02\nD2;12;;0,01\n")
    assert _one(file)[1].actual == pytest.approx(11.99)
    plus = _read(tmp_path, "name;nominal [mm];actual [mm];deviation [mm]\nD1;10;10,02;0,02\nD2;12;;0,01\n")
    assert _one(plus)[1].actual == pytest.approx(12.01)


def test_a_nominal_value_that_is_missing_follows_from_the_deviation(tmp_path: Path) -> None:
    file = _read(tmp_path, "name;nominal [mm];actual [mm];deviation [mm]\nD1;10;10,02;0,02\nD2;;12,03;0,01\n")
    assert _one(file)[1].nominal == pytest.approx(12.02)


def test_tolerances_and_deviations_in_micrometres_beside_millimetres(tmp_path: Path) -> None:
    text = "name;nominal [mm];actual [mm];dev [µm];OT [µm];UT [µm]\nD1;10;10,002;2;15;-5\nD2;20;;-4;15;-5\n"
    file = _read(tmp_path, text)
    first, second = _one(file)
    assert (first.lower_limit, first.upper_limit) == pytest.approx((9.995, 10.015))
    assert second.actual == pytest.approx(19.996)
    assert not [remark for remark in file.remarks if "deviations" in remark.text]


def test_deviations_alone_are_not_read_until_the_mapping_says_their_sign(tmp_path: Path) -> None:
    text = "name;nominal [mm];deviation [mm]\nD1;10;0,02\n"
    error = _refused(tmp_path, text)
    assert error.code is Code.MSR_MEANING
    assert "deviation = " in (error.hint or "")
    mapping = tmp_path / "map.toml"
    columns = '[columns]\ncharacteristic = "name"\nnominal = "nominal [mm]"\ndeviation = "deviation [mm]"\n'
    mapping.write_text('deviation = "nominal - actual"\n' + columns)
    assert _one(_read(tmp_path, text, mapping=mapping))[0].actual == pytest.approx(9.98)
    mapping.write_text('deviation = "actual - nominal"\n' + columns)
    assert _one(_read(tmp_path, text, mapping=mapping))[0].actual == pytest.approx(10.02)


@pytest.mark.parametrize(
    ("rows", "limits"),
    [
        ("25;0,05;0,05\n30;0,02;0,01", [(24.95, 25.05), (29.99, 30.02)]),
        ("25;0,05;-0,05\n30;0,02;0,01", [(24.95, 25.05), (30.01, 30.02)]),
        ("25;0,05;0\n30;0,02;0", [(25.0, 25.05), (30.0, 30.02)]),
    ],
)
def test_lower_tolerances_with_and_without_their_sign(
    tmp_path: Path, rows: str, limits: list[tuple[float, float]]
) -> None:
    text = "Soll [mm];OT [mm];UT [mm];Ist [mm]\n" + "\n".join(f"{row};{row.split(';')[0]}" for row in rows.split("\n"))
    readings = _one(_read(tmp_path, text))
    assert [(one.lower_limit, one.upper_limit) for one in readings] == [pytest.approx(pair) for pair in limits]


def test_a_lower_tolerance_that_may_be_either_is_decided_by_the_verdicts_or_refused(tmp_path: Path) -> None:
    head, row = "Soll [mm];OT;UT;Ist;Status\n", "25;0,05;0,02;25,01;{}\n"
    assert _one(_read(tmp_path, head + row.format("i.O.")))[0].lower_limit == pytest.approx(24.98)
    assert _one(_read(tmp_path, head + row.format("n.i.O.")))[0].lower_limit == pytest.approx(25.02)
    assert _refused(tmp_path, head + row.format("")).code is Code.MSR_MEANING


MIXED = "Name;Nominal [mm];+Tol [mm];-Tol [mm];Actual;Result\nØ A;36;0,02;0;35,985;FAIL\nØ B;30;0;-0,021;29,985;PASS\n"


def test_a_tolerance_without_its_sign_beside_signed_ones_has_a_zone_with_a_width(tmp_path: Path) -> None:
    file = _read(tmp_path, MIXED + "Ø C;44;0,02;0,02;44,031;FAIL\n")
    assert _one(file)[2].lower_limit == pytest.approx(43.98)
    assert [one.lower_limit for one in _one(file)[:2]] == pytest.approx([36, 29.979])
    assert any("1 lower tolerances are not signed as the others" in remark.text for remark in file.remarks)
    assert not any("verdicts" in remark.text for remark in file.remarks)


def test_a_further_tolerance_beside_signed_and_unsigned_ones_is_decided_by_its_verdict_or_refused(
    tmp_path: Path,
) -> None:
    """25.01 is out of 25 +0.05/+0.02, and inside of 25 +0.05/-0.02, where +0.02 is then printed without its sign."""
    text = MIXED + "Ø C;44;0,02;0,02;44,031;FAIL\nØ D;25;0,05;0,02;25,01;{}\n"
    assert _one(_read(tmp_path, text.format("FAIL")))[3].lower_limit == pytest.approx(25.02)
    for verdict in ("PASS", ""):
        error = _refused(tmp_path, text.format(verdict))
        assert (error.code, error.place and error.place.line) == (Code.MSR_MEANING, 5)


def test_a_zone_without_a_width_is_reported(tmp_path: Path) -> None:
    file = _read(tmp_path, "Name;Nominal [mm];OGW;UGW;Actual\nD1;25;25,02;25,02;25,01\n")
    assert any("1 tolerance zones have no width: 25.02" in remark.text for remark in file.remarks)


@pytest.mark.parametrize(
    ("row", "heads"), [("20;-20", "OT;UT"), ("0;-16", "OT;UT"), ("±20", "Toleranz"), ("+20/-10", "Toleranz")]
)
def test_tolerances_far_from_the_nominal_value_need_a_unit_of_their_own(tmp_path: Path, row: str, heads: str) -> None:
    text = f"Name;Nominal;{heads};Actual\nØ 44;44;{row};44,031\n"
    error = _refused(tmp_path, text, unit="mm")
    assert (error.code, "at a size of 44 mm" in error.message) == (Code.MSR_UNIT, True)
    for unit, remarked in (("µm", False), ("mm", True)):
        stated = ";".join(f"{head} [{unit}]" for head in heads.split(";"))
        file = _read(tmp_path, text.replace(heads, stated), unit="mm")
        assert any("implausibly large" in remark.text for remark in file.remarks) is remarked


@pytest.mark.parametrize(
    ("heads", "rows", "keys"),
    [
        ("OT;UT", ("1;-2", "2;-2"), ("upper_tolerance", "lower_tolerance")),
        ("Toleranz", ("±1", "+2/-2"), ("tolerance",)),
    ],
)
def test_whole_tolerances_of_sizes_to_the_micrometer_need_a_unit(
    tmp_path: Path, heads: str, rows: tuple[str, str], keys: tuple[str, ...]
) -> None:
    """±1 at 44.0012: 1.2 µm are out of 1 µm, and in 1 mm."""
    text = f"Name;Nominal;{heads};Actual\nD1;44;{rows[0]};44,0012\nD2;12;{rows[1]};12,0003\n"
    error = _refused(tmp_path, text, unit="mm")
    assert error.code is Code.MSR_UNIT and "may be" in error.message
    assert "[units] " + " and ".join(f'{key} = "µm"' for key in keys) in error.hint
    for unit, upper in (("µm", 44.001), ("mm", 45.0)):
        grid = grid_of(tmp_path / "part.csv")
        mapping = tmp_path / "map.toml"
        units = "".join(f'{key} = "{unit}"\n' for key in keys)
        mapping.write_text(
            f"{toml_of(settled(grid, propose(grid), StatedFacts(unit='mm')), 'part.csv')}\n[units]\n{units}"
        )
        assert _one(_read(tmp_path, text, mapping=mapping))[0].upper_limit == pytest.approx(upper)
    for ordinary in ("44,1412", "44,00"):  # a part that uses its ±1 mm, and one measured to 10 µm
        sized = text.replace("44,0012", ordinary).replace("12,0003", "12,00" if ordinary == "44,00" else "12,0003")
        assert _one(_read(tmp_path, sized, unit="mm"))[0].upper_limit == pytest.approx(45.0)
    assert _one(_read(tmp_path, text.replace(rows[1], rows[1].replace("2", "2,0")), unit="mm"))


def test_a_depth_of_plus_three_beside_fine_tolerances_is_stated_in_millimeters(tmp_path: Path) -> None:
    text = "Name;Nominal;OT;UT;Actual\nDepth 1;12;3;0;12,001\nØ 44;44;0,02;-0,02;44,012\n"
    error = _refused(tmp_path, text, unit="mm")
    assert error.code is Code.MSR_UNIT and '[units] upper_tolerance = "mm"; of a cell' in error.hint
    for cell, upper in (("3 mm", 15.0), ("3 µm", 12.003)):
        stated = _one(_read(tmp_path, text.replace(";3;", f";{cell};"), unit="mm"))
        assert [one.upper_limit for one in stated] == pytest.approx([upper, 44.02])


def test_the_mapping_that_the_hint_names_states_the_unit_of_tolerances(tmp_path: Path) -> None:
    text = "Name;Nominal;OT;UT;Actual\nØ 44;44;20;-20;44,031\nT 3;3;5;0;3,1\n"
    _refused(tmp_path, text, unit="mm")
    grid = grid_of(tmp_path / "part.csv")
    proposed = settled(grid, propose(grid), StatedFacts(unit="mm"))
    mapping = tmp_path / "map.toml"
    units = '\n[units]\nupper_tolerance = "µm"\nlower_tolerance = "µm"\n'
    mapping.write_text(toml_of(proposed, "part.csv") + units)
    assert _one(_read(tmp_path, text, mapping=mapping))[0].lower_limit == pytest.approx(43.98)


def test_headings_max_and_min_are_limits_or_tolerances_by_their_values(tmp_path: Path) -> None:
    for low, high in (("24,98", "25,05"), ("-0,02", "0,05")):
        (one,) = _one(_read(tmp_path, f"Name;Soll [mm];Max;Min;Ist\nD1;25;{high};{low};25,01\n", unit="mm"))
        assert (one.lower_limit, one.upper_limit) == pytest.approx((24.98, 25.05))


def test_ut_is_the_lower_tolerance_beside_ot_and_the_upper_one_beside_lt(tmp_path: Path) -> None:
    german = _read(tmp_path, "Soll;Ist;OT;UT\n25;25,01;0,05;-0,02\n", unit="mm")
    english = _read(tmp_path, "nominal;actual;UT;LT\n25;25.01;0.05;-0.02\n", unit="mm")
    assert [(one.lower_limit, one.upper_limit) for one in _one(german)] == [pytest.approx((24.98, 25.05))]
    assert [(one.lower_limit, one.upper_limit) for one in _one(english)] == [pytest.approx((24.98, 25.05))]


def test_parts_side_by_side_and_repeats_side_by_side(tmp_path: Path) -> None:
    parts = _read(tmp_path, "Merkmal;Soll [mm];Teil 1;Teil 2\nD1;25;25,01;25,02\nD2;30;30,01;\n", unit="mm")
    assert [(one.part.serial, [r.actual for r in one.readings]) for one in parts.inspections] == [
        ("Teil 1", [25.01, 30.01]),
        ("Teil 2", [25.02]),
    ]
    assert any("1 of 4 values are not measured" in remark.text for remark in parts.remarks)
    repeats = _read(tmp_path, "Merkmal;Soll [mm];Messung 1;Messung 2\nD1;25;25,01;25,02\n", unit="mm")
    assert [(one.repeat, one.actual) for one in _one(repeats)] == [(1, 25.01), (2, 25.02)]


def test_a_row_without_the_serial_number_that_others_have_is_refused(tmp_path: Path) -> None:
    """A cell that was merged over two rows reads as empty in the second: it may be of either part."""
    text = "Serial;Merkmal;Soll [mm];Ist [mm]\nA1;Ø44;44;44,031\n;Ø36;36;36,025\nA2;Ø44;44;44,041\n;Ø36;36;36,035\n"
    refused = _refused(tmp_path, text)
    assert (refused.code, refused.place.line, refused.place.column) == (Code.MSR_SERIAL, 3, 1)


def test_bare_numbers_are_parts_under_a_title_that_says_so_and_else_a_choice(tmp_path: Path) -> None:
    rows = "1;25.4;0.1;0.1;25.41;25.39;25.40\n2;8;0.1;0.1;8.01;8;7.99\n"
    text = "FAI;;;;{};;\nItem;Dimension [mm];Tol +;Tol -;1;2;3\n" + rows
    parts = _read(tmp_path, text.format("Samples"))
    assert [one.part.serial for one in parts.inspections] == ["1", "2", "3"]
    first = parts.inspections[2].readings[0]
    assert (first.actual, first.nominal, first.lower_limit) == pytest.approx((25.40, 25.4, 25.3))
    repeats = _one(_read(tmp_path, text.format("Measurement")))
    assert [(one.repeat, one.actual) for one in repeats[:2]] == [(1, 25.41), (1, 8.01)]
    hint = _refused(tmp_path, text.format("")).hint or ""
    assert "--column parts=1 --column parts=2 --column parts=3" in hint


@pytest.mark.parametrize(
    ("heads", "row", "quantity", "nominal"),
    [
        ("Merkmal;Ø Soll [mm];Ø Ist [mm]", "Sitz;44;44,031", Quantity.DIAMETER, 44.0),
        ("Merkmal;Nenndurchmesser [mm];Istdurchmesser [mm]", "Sitz;44;44,031", Quantity.DIAMETER, 44.0),
        ("Feature;Measured Diameter (mm);Nominal Diameter (mm)", "seat;44.031;44", Quantity.DIAMETER, 44.0),
        ("Feature;Diameter (mm)", "seat;44.031", Quantity.DIAMETER, None),
        ("Merkmal;Radius [mm];Z [mm]", "Sitz;44,031;-10", Quantity.RADIUS, None),
        ("Merkmal;Istlänge [mm];Solllänge [mm]", "Bund;44,031;44", Quantity.LENGTH, 44.0),
        ("Merkmal;Nennmaß [mm];Länge [mm]", "Bund;44;44,031", Quantity.LENGTH, 44.0),
    ],
)
def test_a_heading_names_the_quantity_beside_the_value_or_alone(
    heads: str, row: str, quantity: Quantity, nominal: float | None, tmp_path: Path
) -> None:
    (reading,) = _one(_read(tmp_path, f"{heads}\n{row}\n"))
    assert (reading.quantity, reading.actual, reading.nominal) == (quantity, 44.031, nominal)


def test_a_name_goes_before_a_heading_and_headings_of_two_quantities_are_refused(tmp_path: Path) -> None:
    """Of 15.5 µm on the radius beside a diameter only one may count; the hint's command leaves the other out."""
    named = _one(_read(tmp_path, "Merkmal;Ø Soll [mm];Ø Ist [mm]\nRadius R5;5;5,01\nSitz;44;44,031\n"))
    assert [one.quantity for one in named] == [Quantity.RADIUS, Quantity.DIAMETER]
    stated = _one(_read(tmp_path, "Merkmal;Typ;Ø Soll [mm];Ø Ist [mm]\nSitz;Qwertz;5;5,01\nBund;;44;44,031\n"))
    assert [one.quantity for one in stated] == [Quantity.OTHER, Quantity.DIAMETER]
    text = "Merkmal;Ø Soll [mm];Ø Ist [mm];Radius Abw [µm]\nSitz;44;44,031;15,5\n"
    refused = _refused(tmp_path, text)
    assert (refused.code, refused.place.line) == (Code.MSR_MEANING, 1)
    assert shlex.split(refused.hint or "")[-1] == "ignored=Radius Abw [µm]"
    two = _refused(tmp_path, "Merkmal;Durchmesser [mm];Radius [mm]\nSitz;44,031;22,0155\n")
    assert "2 columns may be the actual" in two.message


def test_whole_numbers_under_dimension_are_names(tmp_path: Path) -> None:
    (one,) = _one(_read(tmp_path, "Dimension;Nominal [mm];Actual\n7;25,4;25,41\n"))
    assert (one.characteristic, one.nominal) == ("7", 25.4)


def test_what_is_out_of_tolerance_tells_the_sign_of_lower_tolerances(tmp_path: Path) -> None:
    head, row = "Nominal [mm];+TOL;-TOL;MEAS;OUTTOL\n", "25;0,05;0,02;25,01;{}\n"
    assert _one(_read(tmp_path, head + row.format("0,000")))[0].lower_limit == pytest.approx(24.98)
    assert _one(_read(tmp_path, head + row.format("0,010")))[0].lower_limit == pytest.approx(25.02)


OF_STATISTICS = """Mittelwert, Mean, StdDev, Std.-Abw., Standardabw., Standardabweichung (n-1), Streuung, s, R, Cp, Cpk,
    Cpk-Wert, Max., Min, Spannweite R, x̄, X-quer, 6s, 3 Sigma, Avg, n""".replace("\n", " ").split(",")


def test_one_row_a_part_with_rows_of_nominals_and_limits_and_of_statistics(tmp_path: Path) -> None:
    text = (
        "Seriennummer;Durchmesser D1 [mm];Winkel W1 [°]\nNennmaß;25;45\nOGW;25,05;45,5\nUGW;24,95;44,5\n"
        "A1;25,01;45,1\nA2;25,02;44,9\n" + "".join(f"{name};25,015;45,0\n" for name in OF_STATISTICS)
    )
    file = _read(tmp_path, text)
    assert [one.part.serial for one in file.inspections] == ["A1", "A2"]
    assert any(f"{len(OF_STATISTICS)} rows of statistics are left out" in remark.text for remark in file.remarks)
    diameter, angle = file.inspections[1].readings
    assert (diameter.characteristic, diameter.quantity, diameter.actual) == ("Durchmesser D1", Quantity.DIAMETER, 25.02)
    assert (diameter.nominal, diameter.lower_limit, diameter.upper_limit) == (25.0, 24.95, 25.05)
    assert (angle.quantity, angle.actual, angle.nominal) == (Quantity.ANGLE, 44.9, 45.0)


def test_points_with_their_normals(tmp_path: Path) -> None:
    text = "Name,X,Y,Z,Nom X,Nom Y,Nom Z,I,J,K\nP1,1.01,2,3,1,2,3,2,0,0\nP2,1,2,3.5,1,2,3,0,0,-1\n"
    (inspection,) = _read(tmp_path, text, unit="inch").inspections
    first, second = inspection.points
    assert first.measured_mm == pytest.approx((25.654, 50.8, 76.2))
    assert first.nominal_mm == pytest.approx((25.4, 50.8, 76.2))
    assert first.outward_normal == (1.0, 0.0, 0.0)
    assert (second.name, second.outward_normal) == ("P2", (0.0, 0.0, -1.0))


def test_letters_of_a_gdt_font_and_symbols_before_numbers(tmp_path: Path) -> None:
    text = "Name;Type;Nominal [mm];Actual [mm];Tolerance\nA;n;25;25,01;±0,02\nB;c;0;0,004;0,01\nC;j;0;0,01;0,05\n"
    diameter, flatness, position = _one(_read(tmp_path, text))
    assert (diameter.quantity, diameter.lower_limit, diameter.upper_limit) == (Quantity.DIAMETER, 24.98, 25.02)
    assert (flatness.quantity, flatness.lower_limit, flatness.upper_limit) == (Quantity.FORM, None, 0.01)
    assert position.quantity is Quantity.FORM
    (one,) = _one(_read(tmp_path, "Name;Nominal;Actual\nB1;Ø25,0 mm;25,01 mm\n"))
    assert (one.quantity, one.nominal, one.actual) == (Quantity.DIAMETER, 25.0, 25.01)


def test_dates_whose_day_and_month_may_be_exchanged_are_refused(tmp_path: Path) -> None:
    head = "date,nominal [mm],actual [mm]\n"
    assert _refused(tmp_path, head + "03/04/2026 10:00,25,25.01\n").code is Code.MSR_TIME
    told = _read(tmp_path, head + "03/04/2026,25,25.01\n03/14/2026 1:30 PM,25,25.01\n").inspections
    assert [one.measured_at for one in told] == [
        datetime(2026, 3, 4).astimezone(),
        datetime(2026, 3, 14, 13, 30).astimezone(),
    ]
    assert _one(_read(tmp_path, head + "14/03/2026,25,25.01\n"))[0].measured_at == datetime(2026, 3, 14).astimezone()
    assert _one(_read(tmp_path, head + "03.04.2026,25,25.01\n"))[0].measured_at == datetime(2026, 4, 3).astimezone()
    assert _refused(tmp_path, head + "14/03/2026,25,25.01\n03/14/2026,25,25.01\n").code is Code.MSR_TIME


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("name,nominal,actual\nD1,25,25.01\n", Code.MSR_UNIT, 2),
        ('name,nominal [mm],actual [mm]\nD1,25,"1,234.5"\n', Code.MSR_NUMBER, 2),
        ("name;Ist [mm];Messwert [mm]\nD1;25;25\n", Code.MSR_MEANING, 1),
        ("name;upper limit [mm];lower limit [mm];actual [mm]\nD1;24,9;25,1;25\n", Code.MSR_EXCHANGED, 2),
        ("name;nominal [mm];actual [mm]\nD1;25;12 apples\n", Code.MSR_NUMBER, 2),
        ("name;nominal [mm];actual [mm]\n", Code.MSR_FILE, 1),
        ("alpha;beta\n1;2\n", Code.MSR_MEANING, None),
    ],
)
def test_what_is_refused_and_where(tmp_path: Path, text: str, code: Code, line: int | None) -> None:
    error = _refused(tmp_path, text)
    assert (error.code, error.place and error.place.line) == (code, line)


def test_a_zone_that_excludes_the_nominal_value_is_reported(tmp_path: Path) -> None:
    file = _read(tmp_path, "name;nominal [mm];upper limit [mm];lower limit [mm];actual [mm]\nD1;25;25,05;25,02;25,03\n")
    assert any("1 tolerance zones exclude the nominal" in remark.text for remark in file.remarks)


def test_a_mapping_of_another_table_and_one_with_a_column_that_is_missing(tmp_path: Path) -> None:
    text = "name;nominal [mm];actual [mm]\nD1;25;25,01\n"
    mapping = tmp_path / "map.toml"
    mapping.write_text('[columns]\nactual = "actual [mn]"\nnominal = "nominal [mm]"\n')
    error = _refused(tmp_path, text, mapping=mapping)
    assert (error.code, error.hint) == (Code.MSR_MAPPING, "did you mean 'actual [mm]'?")
    mapping.write_text('[columns]\nactual = "Ist"\nnominal = "Soll"\n')
    assert "another table" in str(_refused(tmp_path, text, mapping=mapping))
    mapping.write_text('[columns]\nactual = "actual [mm]"\nnominal = "actual [mm]"\n')
    assert "named 2 times" in str(_refused(tmp_path, text, mapping=mapping))


def test_headings_that_moved_down_are_found_by_the_mapping(tmp_path: Path) -> None:
    mapping = tmp_path / "map.toml"
    mapping.write_text('header_row = 1\nunit = "mm"\n[columns]\nactual = "wartość"\ncharacteristic = "cecha"\n')
    text = "raport;;\n;;\ncecha;wartość;uwagi\nD1;25,01;\n"
    assert [(one.actual, one.line) for one in _one(_read(tmp_path, text, mapping=mapping))] == [(25.01, 4)]


def test_a_workbook_of_several_sheets_with_dates_errors_and_merged_cells(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        ["Inspection record", None, None, None, None],
        ["Serial", "Characteristic", "Nominal [mm]", "Actual [mm]", "Time"],
        ["7", "Diameter 1", 25, 25.01, Raw('s="1"><v>46086.4375</v>')],
        [None, "Diameter 2", 30, Raw('t="e"><v>#REF!</v>'), None],
        [None, "Length 3", 10.5, "10,48", None],
    ]
    sheets: dict[str, list[list[object]]] = {"Notes": [["written by hand"]], "Results": rows}
    path = write_xlsx(tmp_path / "part.xlsx", sheets, merged=["A1:E1", "A3:A5"], creator="Erika Mustermann")
    file = read_measured_file(path, StatedFacts())
    (inspection,) = file.inspections
    assert inspection.part.serial == "7"
    first, length = inspection.readings
    assert first.measured_at == datetime(2026, 3, 5, 10, 30).astimezone()
    assert (length.actual, length.line, length.quantity) == (10.48, 5, Quantity.LENGTH)
    assert any("1 of 3 values are not measured" in remark.text for remark in file.remarks)
    assert "Mustermann" not in repr(file)
    assert file.encoding == "xlsx"


def test_two_sheets_with_headings_are_not_chosen_between_and_hidden_ones_do_not_count(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Name", "Nominal [mm]", "Actual [mm]"], ["D1", 25, 25.01]]
    path = write_xlsx(tmp_path / "two.xlsx", {"A": rows, "B": rows})
    with pytest.raises(TrueloopError) as refusal:
        read_measured_file(path, StatedFacts())
    assert "2 sheets" in str(refusal.value)
    hidden = write_xlsx(tmp_path / "hidden.xlsx", {"A": rows, "B": rows}, hidden=["B"])
    assert _one(read_measured_file(hidden, StatedFacts()))[0].actual == 25.01


def test_workbooks_that_would_fill_the_memory_are_refused_before_they_are_opened(tmp_path: Path) -> None:
    far: list[list[object]] = [["Name", "Nominal [mm]", "Actual [mm]"], [Raw('></c><c r="XFD1048576"><v>1</v>')]]
    for path, words in (
        (write_xlsx(tmp_path / "far.xlsx", {"A": far}), "spans"),
        (write_xlsx(tmp_path / "packed.xlsx", {"A": [["a" * 30_000_000]]}), "times its size"),
        (write_xlsx(tmp_path / "cut.xlsx", {"A": far}), "damaged"),
    ):
        if words == "damaged":
            path.write_bytes(path.read_bytes()[:600])
        with pytest.raises(TrueloopError) as refusal:
            read_measured_file(path, StatedFacts())
        assert refusal.value.code is Code.MSR_FILE
        assert words in str(refusal.value)


LIMITS = "Item,Nominal mm,Upper limit mm,Lower limit mm,Measured mm,Judge\n"


@pytest.mark.parametrize(
    ("rows", "zone"),
    [
        ("D1,10,0.03,-0.03,10.012,OK\nD2,5,0.02,-0.02,4.991,OK\n", (9.97, 10.03)),
        ("D1,10,0.03,,10.012,OK\n", (None, 10.03)),
        ("D1,10,10.03,9.97,10.012,OK\n", (9.97, 10.03)),
        ("D1,10,9.98,9.95,9.96,OK\n", (9.95, 9.98)),  # a fit: neither way holds the nominal value
        ("D1,10,0.05,0.02,10.03,OK\n", (10.02, 10.05)),  # the verdict decides
    ],
)
def test_limits_near_zero_count_from_the_nominal_value(
    tmp_path: Path, rows: str, zone: tuple[float | None, float]
) -> None:
    file = _read(tmp_path, LIMITS + rows)
    first = _one(file)[0]
    assert first.upper_limit == pytest.approx(zone[1])
    assert first.lower_limit == (None if zone[0] is None else pytest.approx(zone[0]))
    assert not any("verdicts" in remark.text for remark in file.remarks)


def test_a_form_beside_the_nominal_of_its_size_keeps_its_limits(tmp_path: Path) -> None:
    """0.012 is inside 0 to 0.02 as stated; counted from 50 it would be 50 mm too small."""
    head = "Item,Nominal mm,Upper limit mm,Lower limit mm,Measured mm\n"
    (reading,) = _one(_read(tmp_path, head + "Flatness 1,50,0.02,0,0.012\n"))
    assert reading.upper_limit == pytest.approx(0.02)
    (size,) = _one(_read(tmp_path, head + "D1,50,0.02,0,50.012\n"))
    assert size.upper_limit == pytest.approx(50.02)


def test_columns_of_statistics_are_no_parts(tmp_path: Path) -> None:
    heads = "Item,Nominal mm,Sample 1,Sample 2,XBAR,Pp,Ppk,Samples in tol,Number of Samples"
    file = _read(tmp_path, f"{heads}\nD1,10,10.01,10.02,10.015,1.2,1.1,2,2\n", unit="mm")
    assert [inspection.part.serial for inspection in file.inspections] == ["Sample 1", "Sample 2"]


def test_a_deviation_beside_nominal_and_measured_points_leaves_them_points(tmp_path: Path) -> None:
    text = "Point,X nom,Y nom,Z nom,X meas,Y meas,Z meas,Deviation\nP1,10,0,5,10.003,0.001,5.004,0.005\n"
    (inspection,) = _read(tmp_path, text, unit="mm").inspections
    assert [(point.nominal_mm, point.measured_mm) for point in inspection.points] == [
        ((10, 0, 5), (10.003, 0.001, 5.004))
    ]


@pytest.mark.parametrize(
    ("heading", "cell", "unit", "zone"),
    [
        ("Tolerance [µm]", "±20", "mm", (24.98, 25.02)),
        ("Tolerance", "±0.001", "inch", (25.3746, 25.4254)),
        ("Tolerance", "±20 µm", "mm", (24.98, 25.02)),
        ("Tolerance", "+0.02/-0.01 mm", "mm", (24.99, 25.02)),
        ("Tolerance", "0.02 -0.01", "mm", (24.99, 25.02)),
        ("Tolerance", "+0.02 0", "mm", (25.0, 25.02)),
        ("Tolerance", "+0,02|0,0", "mm", (25.0, 25.02)),
        ("Tolerance", "-0.02/-0.04", "mm", (24.96, 24.98)),
        ("Tolerance", "0.020", "mm", None),
        ("Tolerance", "0.10", "mm", None),
        ("Tolerance", "H7", "mm", None),
    ],
)
def test_a_column_of_both_tolerances_has_its_unit_and_two_numbers(
    tmp_path: Path, heading: str, cell: str, unit: str, zone: tuple[float, float] | None
) -> None:
    size = "1.0000" if unit == "inch" else "25.000"
    file = _read(tmp_path, f"Name;Nominal;{heading};Actual\nD1 diameter;{size};{cell};{size}\n", unit=unit)
    (one,) = _one(file)
    assert (one.lower_limit, one.upper_limit) == ((None, None) if zone is None else pytest.approx(zone))
    assert any("1 tolerances are not read" in remark.text for remark in file.remarks) is (zone is None)


def test_the_unit_of_a_row_is_that_of_its_tolerance(tmp_path: Path) -> None:
    text = "Name;Nominal;Actual;Tolerance;Unit\nD1;1.0;1.0;±0.001;inch\nD2;25.0;25.0;±0.02;mm\nW1;45;45;±0.1;deg\n"
    zones = [(one.lower_limit, one.upper_limit) for one in _one(_read(tmp_path, text))]
    assert zones == [pytest.approx(pair) for pair in ((25.3746, 25.4254), (24.98, 25.02), (44.9, 45.1))]


@pytest.mark.parametrize(
    ("heads", "rows", "unit"),
    [
        ("Nominal;Actual;OT;UT", "44;44,031;0,02;-0,02 36;36,025;20µm;-20µm", "mm"),
        ("Nominal [mm];Actual [mm];OT [mm];UT [mm]", "44;44,031;0,02;-0,02 36;36,025;20µm;-20µm", None),
        ("Nominal;Actual;OT;UT;Unit", "44;44,031;20µm;-20µm;mm 36;36,025;0,02;-0,02;mm", None),
        ("Nominal;Actual;OT;UT;Unit", "44;44,031;0,02;-0,02;mm 36;36025µm;0,02;-0,02;mm", None),
        ("Nominal [mm];Actual [mm];OT;UT", "44;44,031;0,02;-0,02 1,4173228in;1,4183071in;0,02;-0,02", None),
    ],
)
def test_a_unit_in_a_cell_counts_for_that_cell_alone_and_before_any_other(
    tmp_path: Path, heads: str, rows: str, unit: str | None
) -> None:
    """The cells beside it keep the unit of their heading, their row or the file."""
    lines = "".join(f"Ø D;{row}\n" for row in rows.split())
    first, second = _one(_read(tmp_path, f"Name;{heads}\n{lines}", unit=unit))
    assert (first.nominal, first.actual, first.lower_limit, first.upper_limit) == pytest.approx(
        (44, 44.031, 43.98, 44.02)
    )
    assert (second.nominal, second.actual, second.lower_limit, second.upper_limit) == pytest.approx(
        (36, 36.025, 35.98, 36.02), abs=1e-5
    )


def test_a_bare_number_beside_a_cell_with_a_unit_is_refused_where_no_other_unit_is_stated(tmp_path: Path) -> None:
    error = _refused(tmp_path, "Name;Nominal;Actual\nD1;44 mm;44,031 mm\nD2;36;36,025 mm\n")
    assert (error.code, error.place and error.place.line) == (Code.MSR_UNIT, 3)
    angle, size = _one(_read(tmp_path, "Name;Nominal;Actual\nE;45°;45,1°\nD1;44 mm;44,031 mm\n"))
    assert (angle.quantity, angle.actual, size.actual) == (Quantity.ANGLE, 45.1, 44.031)


def test_deviations_are_read_each_in_its_own_unit(tmp_path: Path) -> None:
    mapping = tmp_path / "map.toml"
    columns = '[columns]\ncharacteristic = "Name"\nnominal = "Soll [mm]"\ndeviation = "{}"\n'
    for heading in ("Abw.", "Abw. [mm]"):
        mapping.write_text('unit = "mm"\ndeviation = "actual - nominal"\n' + columns.format(heading))
        text = f"Name;Soll [mm];{heading}\nD1;44;0,031\nD2;36;25 µm\nD3;30;0,016\n"
        values = [one.actual for one in _one(_read(tmp_path, text, mapping=mapping))]
        assert values == pytest.approx([44.031, 36.025, 30.016])


def test_points_and_places_are_in_the_unit_of_their_row(tmp_path: Path) -> None:
    rows = "P1,1,0,-2,in\nP2,25,0,-50,mm\nP3,1,0,-50 mm,in\n"
    (inspection,) = _read(tmp_path, "Point,X,Y,Z,Unit\n" + rows).inspections
    assert [one.measured_mm for one in inspection.points] == [(25.4, 0, -50.8), (25, 0, -50), (25.4, 0, -50)]
    rows = "D1,44,44.03,-10,mm\nD2,1,1.001,-2,in\nW,11.3,11.35,-3,deg\n"
    places = [one.place_mm for one in _one(_read(tmp_path, "Name,Nominal,Actual,Z,Unit\n" + rows))]
    assert places == [(-10,), pytest.approx((-50.8,)), (-3,)]


def test_a_form_without_a_nominal_value_has_its_limit_and_a_size_without_one_is_reported(tmp_path: Path) -> None:
    text = (
        "Name;Type;Nominal;Actual;Upper tol;Lower tol\nR1;runout;;0.03;0.02;\nF1;flatness;;0.03;0.02;0\nD1;Ø;;8;0.1;\n"
    )
    file = _read(tmp_path, text, unit="mm")
    assert [(one.lower_limit, one.upper_limit) for one in _one(file)] == [(None, 0.02), (None, 0.02), (None, None)]
    assert any("1 tolerances are not applied" in remark.text for remark in file.remarks)


def test_a_form_below_0_is_not_inside_by_its_upper_limit(tmp_path: Path) -> None:
    head = "Name;Nominal;Actual;Upper tol;Status\n"
    file = _read(tmp_path, head + "Profile of surface;0;-0.03;0.05;ok\n", unit="mm")
    assert within(_one(file)[0]) is None
    assert any("'Profile of surface' is -0.03 mm, a signed deviation" in remark.text for remark in file.remarks)


def test_rows_of_statistics_are_left_out_of_a_long_table_and_characteristics_named_like_them_are_not(
    tmp_path: Path,
) -> None:
    head = "Characteristic;Nominal [mm];Actual\nMean diameter;25;25.013\nMax;25;25.011\nR;5;5.01\n"
    assert [one.characteristic for one in _one(_read(tmp_path, head))] == ["Mean diameter", "Max", "R"]
    file = _read(tmp_path, head + "Mean;25.000;25.012\nStd Dev;;0.001\nCpk;;1.33\n")
    assert [one.characteristic for one in _one(file)] == ["Mean diameter", "R"]
    assert any("4 rows of statistics are left out" in remark.text for remark in file.remarks)


def test_statistics_in_another_column_of_text_than_the_serial_number_are_left_out(tmp_path: Path) -> None:
    rows = "2026-01-02;001;25.011;30.001\nMean;;25.012;29.998\nStd Dev;;0.001;0.003\nTol.;;±0.02;±0.02\n"
    file = _read(tmp_path, "Date;Serial;Diameter 1;Diameter 2\n;Nominal;25;30\n" + rows, unit="mm")
    assert [(one.part.serial, len(one.readings)) for one in file.inspections] == [("001", 2)]


def test_part_beside_serial_is_the_part_type(tmp_path: Path) -> None:
    text = "{};{};Characteristic;Nominal [mm];Actual\nshaft;1;D1;25;25.01\nbush;1;D1;40;40.01\n"
    for kind, serial in (("Part", "Serial"), ("Teil", "Seriennummer"), ("Part ID", "S/N")):
        file = _read(tmp_path, text.format(kind, serial))
        assert [(one.part.part_type.name, one.part.serial) for one in file.inspections] == [
            ("shaft", "1"),
            ("bush", "1"),
        ]
    alone = _read(tmp_path, "Part;Characteristic;Nominal [mm];Actual\n1;D1;25;25.01\n2;D1;25;25.02\n")
    assert [one.part.serial for one in alone.inspections] == ["1", "2"]


@pytest.mark.parametrize(
    ("title", "columns", "part", "serial"),
    [
        ("Teil-Nr.;SHAFT;;Serien-Nr.;17", "", "SHAFT", "17"),
        ("Serial: 17\nPart: SHAFT", "", "SHAFT", "17"),
        ("Werkstück;SHAFT", "Serial", "SHAFT", "17"),
        ("Serien-Nr.: A-3", "Teil-Nr.", "17", "A-3"),
        ("Bediener: Meier", "Teil-Nr.", "", "17"),
        ("Werkstück;17", "", "", "17"),
        ("Teilebezeichnung;SHAFT\nTeil;17", "", "SHAFT", "17"),
    ],
)
def test_part_above_the_headings_is_the_part_type_beside_a_serial_number(
    tmp_path: Path, title: str, columns: str, part: str, serial: str
) -> None:
    text = f"{title}\n\nName;Nominal [mm];Actual;{columns}\nD1;25;25.01;{columns and '17'}\n"
    (one,) = _read(tmp_path, text).inspections
    assert (one.part.part_type.name, one.part.serial) == (part, serial)


MEASURED = "Serial;Time;Device;Characteristic;Nominal [mm];Actual\n"


@pytest.mark.parametrize(
    ("rows", "runs"),
    [
        # a characteristic that comes again at another time: a new measurement, in whatever order the rows are
        ("10:00;m;D1 10:01;m;L1 10:20;m;D1 10:21;m;L1", [("10:00", "m", "D1 L1"), ("10:20", "m", "D1 L1")]),
        ("10:20;m;D1 10:00;m;D1 10:20;m;L1 10:00;m;L1", [("10:00", "m", "D1 L1"), ("10:20", "m", "D1 L1")]),
        # at one time it is a repeat; another device at another time is a measurement of its own
        ("10:00;m;D1 10:00;m;D1", [("10:00", "m", "D1 D1")]),
        ("10:00;m;D1 10:05;cmm;L1 10:10;m;D2", [("10:00", "m", "D1 D2"), ("10:05", "cmm", "L1")]),
        ("10:00;m;D1 10:00;cmm;L1", [("10:00", "m, cmm", "D1 L1")]),
        (";m;D1 ;cmm;L1", [("", "m, cmm", "D1 L1")]),
    ],
)
def test_a_new_time_is_a_new_inspection(tmp_path: Path, rows: str, runs: list[tuple[str, str, str]]) -> None:
    lines = []
    for row in rows.split():
        time, device, name = row.split(";")
        lines.append(f"7;{'2026-01-02 ' + time if time else ''};{device};{name};25;25.01\n")
    file = _read(tmp_path, MEASURED + "".join(lines))
    found = [
        (
            "" if one.measured_at is None else f"{one.measured_at:%H:%M}",
            one.device,
            " ".join(each.characteristic for each in one.readings),
        )
        for one in file.inspections
    ]
    assert found == runs
    assert len({one.identity for one in file.inspections}) == len(runs)


@pytest.mark.parametrize(
    ("head", "names", "runs"),
    [
        ("Nr", "1 2 3 4 5", [5]),  # the points have no names
        ("Name", "P1 P2 P3 P1 P2 P3", [3, 3]),
        ("Name", "P1 P2 P2* P3", [2, 2]),  # P2 at its place once more, and what follows
        ("Feature", "PLN1 PLN1 PLN1 CIR1 CIR1", [5]),  # features of several points
        ("Feature", "PLN1 PLN1 CIR1 CIR1 PLN1 PLN1 CIR1", [4, 3]),
    ],
)
def test_points_with_a_time_each_are_one_inspection_until_a_named_one_comes_again(
    tmp_path: Path, head: str, names: str, runs: list[int]
) -> None:
    lines = []
    for k, name in enumerate(names.split()):
        x = 10.0 * (k - name.endswith("*"))
        lines.append(f"7;2026-01-02 10:00:{k:02d};{name.rstrip('*')};{x + 0.01};0;5\n")
    file = _read(tmp_path, f"Serial;Time;{head};X;Y;Z\n" + "".join(lines), unit="mm")
    assert [len(one.points) for one in file.inspections] == runs
    assert [one.measured_at and one.measured_at.second for one in file.inspections] == [0, *runs[:-1]]


@pytest.mark.parametrize("text", ["MW", "CM", "CP", "PP", "3S", "s"])
@pytest.mark.parametrize("head", ["{};Serial;Diameter 1;Diameter 2", "Prüfer;{};Diameter 1;Diameter 2"])
def test_initials_and_serial_numbers_like_words_of_statistics_are_those_of_parts(
    tmp_path: Path, text: str, head: str
) -> None:
    """Beside the operator's initials a serial number, beside such a serial number a date."""
    own = head.startswith("{")
    head = head.format("Operator" if own else "Serial")
    first = f"{text};A1" if own else f"Meier;{text}"
    rows = f"{first};25.011;30.001;2026-01-02\nEB;A2;25.012;30.002;2026-01-02\n"
    last = ";Mean;25.012;30.002;\n;Cp;1.6;1.7;\n"
    file = _read(tmp_path, f"{head};Date\n{rows}{last}", unit="mm")
    assert [one.part.serial for one in file.inspections] == ["A1" if own else text, "A2"]
    assert any(one.text == "2 rows of statistics are left out: 'Mean', 'Cp'" for one in file.remarks)


def test_an_operators_initials_in_front_of_a_long_table_leave_no_value_out(tmp_path: Path) -> None:
    text = "Operator;Characteristic;Nominal [mm];Actual\nMW;D1;25;25.01\nCM;D2;30;30.01\n"
    assert [one.characteristic for one in _one(_read(tmp_path, text))] == ["D1", "D2"]


@pytest.mark.parametrize(
    ("upper", "lower"),
    [
        ("Abmaß oben", "Abmaß unten"),
        ("o. Abm.", "u. Abm."),
        ("ob. Grenzabmaß", "un. Grenzabmaß"),
        ("Grenzabmaß oben", "Grenzabmaß unten"),
        ("Tol. oben", "Tol. unten"),
        ("Tol o.", "Tol u."),
        ("ob. Tol.", "un. Tol."),
        ("Max. Tol.", "Min. Tol."),
    ],
)
def test_german_headings_of_tolerances(tmp_path: Path, upper: str, lower: str) -> None:
    (one,) = _one(_read(tmp_path, f"Merkmal;Sollmaß [mm];Istwert;{upper};{lower}\nØ 25;25;25,013;0,02;-0,01\n"))
    assert (one.lower_limit, one.upper_limit) == pytest.approx((24.99, 25.02))


def test_columns_of_numbers_that_are_not_read_are_named(tmp_path: Path) -> None:
    file = _read(tmp_path, "Name;Nominal [mm];Actual;Grenze A;Cpk;Nr;Note 2\nD1;25;25.01;25.02;1.3;1;fine\n")
    assert any(remark.text == "1 columns of numbers are not read: 'Grenze A'" for remark in file.remarks)


@pytest.mark.parametrize(
    ("text", "proposed"),
    [
        (
            "Name;Nominal;Actual;Max;Min\nD1;25;25.01;0.02;-0.02\nL1;0.03;0.04;0.05;0.01\n",
            "upper_tolerance=Max lower_tolerance=Min",
        ),
        (
            "Name;Nominal;Actual;Oben;Unten\nD1;25;25;25.1;24\nL1;30;30;30.1;29\nL2;8;8;0.1;-0.1\n",
            "upper_limit=Oben lower_limit=Unten",
        ),
        (
            "#;Name;Nominal;Up A;Low A;Ist 1;Ist 2\n1;D1;44;0.02;-0.02;44.01;43.99\n2;L1;8;0.1;-0.1;8;8.01\n",
            "parts=Ist 1 parts=Ist 2",
        ),
        ("Name;Nominal;Probe A;StdDev;Cpk\nD1;25;25.01;0.002;1.3\n", "actual=Probe A"),
    ],
)
def test_the_command_of_a_hint_leads_on_and_proposes_no_statistics(tmp_path: Path, text: str, proposed: str) -> None:
    file = tmp_path / "part.csv"
    file.write_text(text)
    with pytest.raises(TrueloopError) as refusal:
        propose(grid_of(file))
    words = shlex.split((refusal.value.hint or "").partition(": ")[2])
    options = [word for before, word in itertools.pairwise(words) if before == "--column"]
    assert " ".join(options) == proposed
    given: dict[str, list[str]] = {}
    for key, _, name in (option.partition("=") for option in options):
        given.setdefault(key, []).append(name)
    columns = propose(grid_of(file), given).columns
    found = {str(key): [name] for key, name in columns.named().items()} | {"parts": list(columns.parts)}
    assert found.items() >= given.items()


def test_a_table_of_statistics_alone_has_no_actual_value(tmp_path: Path) -> None:
    error = _refused(tmp_path, "Name;Nominal;Mean;Min;Max;StdDev\nD1;25.000;25.010;24.990;25.030;0.002\n", unit="mm")
    assert error.code is Code.MSR_MEANING and "StdDev" not in str(error)


def test_coordinates_in_words_have_their_axis(tmp_path: Path) -> None:
    """A coordinate is read as such however its column of quantities words it; a true position stays a form."""
    worded = {
        "X": "x",
        "position Y": "y",
        "Pos. Z": "z",
        "x_coordinate": "x",
        "Y-Koordinate": "y",
        "Mittelpunkt X": "x",
        "z value": "z",
    }
    rows = [f"P{k},{words},{k}.0,{k}.01" for k, words in enumerate((*worded, "true position X", "distance X"))]
    readings = _one(_read(tmp_path, "\n".join(["Feature,Type,Nominal [mm],Actual [mm]", *rows])))
    assert [one.axis for one in readings] == [*worded.values(), "", ""]
    assert [one.quantity for one in readings[-2:]] == [Quantity.FORM, Quantity.LENGTH]
    assert {one.quantity for one in readings[:-2]} == {Quantity.POSITION}
