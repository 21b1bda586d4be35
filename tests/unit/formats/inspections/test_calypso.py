"""CALYPSO's tables, and a real one judged by a few lines that know nothing of the reader."""

from datetime import datetime
from pathlib import Path

import pytest

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts

NAMES = [
    *("planid", "partnb", "id", "type", "idsymbol", "actual", "nominal", "uppertol", "lowertol", "deviation", "exceed"),
    *("featureid", "natuppertolid", "natlowertolid", "featurePosX", "featurePosY", "featurePosZ"),
]
ROWS = [
    "Shaft|7|D1|Durchmesser|diameter|25.0132|25|0.02|-0.01|0.0132||Zyl1|1|1|1|2|3",
    "Shaft|7|Round|Rundheit|gdtRound|0.002|0|0.01|0|0.002||Zyl1|1|2|||",
    "Shaft|7|W|Winkel|angle1|45.1|45|0.5|-0.5|0.1||A,B|1|1|||",
    "Shaft|7|X1|X-Wert|xValue|9.98|10|0.05|0.01|-0.02||Zyl1|1|1|||",
]


def _write(folder: Path, header: str | None = None) -> Path:
    path = folder / "Shaft_chr.txt"
    path.write_text("\n".join(["|".join(NAMES), *ROWS, "END", ""]).replace("|", "\t"))
    if header is not None:
        (folder / "Shaft_hdr.txt").write_text(header)
    return path


def _refusal(path: Path, stated: StatedFacts) -> TrueloopError:
    with pytest.raises(TrueloopError) as refusal:
        read_measured_file(path, stated)
    return refusal.value


def test_tolerances_count_from_the_nominal_value_with_their_signs(tmp_path: Path) -> None:
    file = read_measured_file(_write(tmp_path), StatedFacts("mm"))
    diameter, form, angle, x = file.inspections[0].readings
    assert (diameter.lower_limit, diameter.upper_limit) == pytest.approx((24.99, 25.02))
    assert (diameter.place_mm, diameter.feature) == ((1.0, 2.0, 3.0), "Zyl1")
    assert (form.quantity, form.lower_limit, form.upper_limit) == (Quantity.FORM, None, 0.01)
    assert (angle.quantity, angle.feature, angle.other) == (Quantity.ANGLE, "A", "B")
    assert x.axis == "x"
    assert (x.lower_limit, x.upper_limit) == pytest.approx((10.01, 10.05))
    assert not file.remarks


def test_inches_scale_lengths_and_no_angles(tmp_path: Path) -> None:
    diameter, _, angle, _ = read_measured_file(_write(tmp_path), StatedFacts("inch")).inspections[0].readings
    assert diameter.actual == pytest.approx(25.0132 * 25.4)
    assert diameter.lower_limit == pytest.approx(24.99 * 25.4)
    assert angle.actual == 45.1


@pytest.mark.parametrize("cell", ["", "***", "---"])
def test_a_row_without_an_actual_value_is_reported(cell: str, tmp_path: Path) -> None:
    path = _write(tmp_path)
    path.write_text(path.read_text().replace("25.0132\t25", f"{cell}\t25"))
    file = read_measured_file(path, StatedFacts("mm"))
    assert [one.characteristic for one in file.inspections[0].readings] == ["Round", "W", "X1"]
    assert [(remark.text, remark.line) for remark in file.remarks] == [("1 of 4 values are not measured: 'D1'", 2)]


def test_the_header_beside_it_says_order_operator_device_and_time(tmp_path: Path) -> None:
    names = "planid\tpartnb\torder\tdate\ttime\tdateiso\toperid\tdmeid\tdmesn\tpartsn"
    row = "Shaft\t7\tA-99\t4/3/2026\t10:22\t2026-03-04T10:22:00\tmeier\tPRISMO\t123\tSN-0007"
    file = read_measured_file(_write(tmp_path, f"{names}\n{row}\nEND\n"), StatedFacts("mm"))
    (one,) = file.inspections
    assert (one.part.serial, one.operator, one.device) == ("SN-0007", "meier", "PRISMO 123")
    assert one.measured_at == datetime(2026, 3, 4, 10, 22).astimezone()
    assert [remark.text for remark in file.remarks] == ["order 'A-99'"]


def test_a_date_that_may_be_two_is_not_read(tmp_path: Path) -> None:
    header = "planid\tpartnb\tdate\ttime\nShaft\t7\t4/3/2026\t10:22\nEND\n"
    file = read_measured_file(_write(tmp_path, header), StatedFacts("mm"))
    assert file.inspections[0].measured_at is None
    assert "no time" in file.remarks[0].text


def test_an_empty_header_beside_it_says_nothing(tmp_path: Path) -> None:
    (one,) = read_measured_file(_write(tmp_path, ""), StatedFacts("mm")).inspections
    assert (one.part.serial, one.measured_at) == ("7", None)


def test_a_table_names_no_unit_and_a_header_holds_no_characteristics(tmp_path: Path) -> None:
    path = _write(tmp_path, "planid\tpartnb\nShaft\t7\nEND\n")
    assert _refusal(path, StatedFacts()).code is Code.MSR_UNIT
    error = _refusal(tmp_path / "Shaft_hdr.txt", StatedFacts("mm"))
    assert (error.code, "Shaft_chr.txt" in (error.hint or "")) == (Code.MSR_MEANING, True)


@pytest.mark.corpus
def test_a_real_table_is_read_whole(corpus: Path) -> None:
    path = corpus / "data" / "public" / "formats" / "calypso-chr.txt"
    lines = [line.split("\t") for line in path.read_text().splitlines()]
    names, rows = lines[0], [dict(zip(lines[0], cells, strict=False)) for cells in lines[1:] if len(cells) > 5]
    file: MeasuredFile = read_measured_file(path, StatedFacts("mm"))
    (inspection,) = file.inspections
    assert len(inspection.readings) == len(rows) == 30
    assert "deviation" in names
    for one, row in zip(inspection.readings, rows, strict=True):
        assert (one.characteristic, one.actual) == (row["id"], float(row["actual"]))
        assert one.actual - (one.nominal or 0.0) == pytest.approx(float(row["deviation"]), abs=1e-6)
        assert one.upper_limit == pytest.approx(float(row["nominal"]) + float(row["uppertol"]))
        exceed = max(one.actual - (one.upper_limit or 1e9), (one.lower_limit or -1e9) - one.actual)
        assert (exceed > 1e-6) == bool(row["exceed"])
        if row["exceed"]:
            assert exceed == pytest.approx(float(row["exceed"]), abs=1e-6)
    kinds = [one.quantity for one in inspection.readings]
    assert kinds.count(Quantity.DIAMETER) == 7
    assert kinds.count(Quantity.LENGTH) == 11
    assert inspection.part.serial == "10"


@pytest.mark.parametrize("stated", [StatedFacts(), StatedFacts("inch")])
def test_a_column_of_units_overrules_a_unit_that_is_stated(tmp_path: Path, stated: StatedFacts) -> None:
    path = _write(tmp_path)
    names, *rows = path.read_text().splitlines()
    path.write_text(
        "\n".join([f"{names}\tunit", *(f"{row}\t{'deg' if 'angle' in row else 'mm'}" for row in rows[:-1])])
    )
    file = read_measured_file(path, stated)
    assert file.unit == "mm" and file.inspections[0].readings[0].actual == 25.0132
    assert bool(file.remarks) == (stated.unit is not None)
