"""Readings of hand gauges as CSV."""

from datetime import datetime
from pathlib import Path

import pytest

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.gauge_csv import recognises
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts


def read(folder: Path, text: str | bytes, stated: StatedFacts | None = None) -> MeasuredFile:
    path = folder / "readings.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_measured_file(path, stated or StatedFacts())


def readings(folder: Path, text: str | bytes) -> tuple[Reading, ...]:
    (inspection,) = read(folder, text).inspections
    return inspection.readings


def refused(folder: Path, text: str) -> TrueloopError:
    with pytest.raises(TrueloopError) as caught:
        read(folder, text)
    return caught.value


def test_a_row_is_a_reading_with_its_place_its_line_and_what_comments_state_for_all(tmp_path: Path) -> None:
    text = (
        "# Monday, first part\n# instrument: micrometer 114\n# operator = M. Keller\n# uncertainty_um: 2\n"
        "# measured_at: 2026-11-20 09:40+01:00\n# temperature_c: 21.5\n# serial: S-7\n"
        "feature,z_mm,diameter_mm\nseat-44,-105,44.031\n"
    )
    found = read(tmp_path, text)
    assert (found.format, found.encoding, found.unit, found.remarks) == ("gauge readings (CSV)", "utf-8", "mm", ())
    (inspection,) = found.inspections
    when = datetime.fromisoformat("2026-11-20T09:40:00+01:00")
    assert (inspection.part.serial, inspection.device, inspection.operator) == ("S-7", "micrometer 114", "M. Keller")
    assert inspection.measured_at == when
    (reading,) = inspection.readings
    assert reading == Reading(
        characteristic="seat-44 diameter z -105",
        quantity=Quantity.DIAMETER,
        actual=44.031,
        feature="seat-44",
        place_mm=(-105.0,),
        standard_u=0.002,
        measured_at=when,
        temperature_c=21.5,
        line=9,
    )


def test_a_position_names_its_axis(tmp_path: Path) -> None:
    text = "feature,quantity,axis,nominal,value_in\nB1,position,Y,1.5,1.501\nB1,diameter,,0.5,0.499\n"
    y, across = readings(tmp_path, text)
    assert (y.quantity, y.axis) == (Quantity.POSITION, "y") and y.actual == pytest.approx(38.1254)
    assert (across.quantity, across.axis) == (Quantity.DIAMETER, "")
    error = refused(tmp_path, text.replace(",Y,", ",radial,"))
    assert (error.code, error.place.line, error.place.column) == (Code.MSR_COLUMN, 2, 3)


@pytest.mark.parametrize(
    ("column", "cell", "quantity", "actual"),
    [
        ("diameter_mm", "44.031", Quantity.DIAMETER, 44.031),
        ("diameter_in", "1.7335", Quantity.DIAMETER, 44.0309),
        ("radius_mm", "22.0155", Quantity.RADIUS, 22.0155),
        ("length_in", "2", Quantity.LENGTH, 50.8),
        ("runout_um", "6", Quantity.RUNOUT, 0.006),
        ("angle_deg", "11.31", Quantity.ANGLE, 11.31),
    ],
)
def test_a_column_names_quantity_and_unit(
    tmp_path: Path, column: str, cell: str, quantity: Quantity, actual: float
) -> None:
    (reading,) = readings(tmp_path, f"feature,{column}\ncone,{cell}\n")
    assert reading.quantity is quantity
    assert reading.actual == pytest.approx(actual, rel=1e-12)


def test_quantity_and_value_in_columns_of_their_own(tmp_path: Path) -> None:
    found = readings(tmp_path, "feature,quantity,value_in,from\nA,Length,1,B\nC,diameter,2,\n")
    assert [(one.quantity, one.actual, one.other) for one in found] == [
        (Quantity.LENGTH, 25.4, "B"),
        (Quantity.DIAMETER, 50.8, ""),
    ]
    assert "angle" in str(refused(tmp_path, "feature,quantity,value_mm\nA,angle,1\n"))


def test_nominal_limits_and_uncertainty_are_scaled_as_the_value_is(tmp_path: Path) -> None:
    text = "feature,diameter_in,nominal,lower_limit,upper_limit,expanded_uncertainty_um\nA,1.001,1,0.999,1.002,5\n"
    (reading,) = readings(tmp_path, text)
    assert reading.nominal == 25.4
    assert (reading.lower_limit, reading.upper_limit) == pytest.approx((25.3746, 25.4508))
    assert reading.standard_u == pytest.approx(0.0025), "the expanded one is k = 2 times it"


def test_places_are_z_or_x_and_z(tmp_path: Path) -> None:
    found = readings(tmp_path, "feature,x_in,z_in,diameter_mm\nA,1,-2,50.8\nB,,-2,50.8\nC,,,50.8\n")
    assert [one.place_mm for one in found] == [(25.4, -50.8), (-50.8,), ()]
    assert refused(tmp_path, "feature,x_mm,diameter_mm\nA,1,50.8\n").code is Code.MSR_COLUMN


def test_repeats_are_kept_and_numbered(tmp_path: Path) -> None:
    rows = "A,-5,20.003\nA,-5,20.007\nA,-9,20.004\nA,-5,20.005\n"
    found = readings(tmp_path, f"feature,z_mm,diameter_mm\n{rows}")
    assert [(one.place_mm, one.repeat, one.actual) for one in found] == [
        ((-5.0,), 1, 20.003),
        ((-5.0,), 2, 20.007),
        ((-9.0,), 1, 20.004),
        ((-5.0,), 3, 20.005),
    ]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_and_encodings(tmp_path: Path, encoding: str, separator: str) -> None:
    lines = ["# instrument: Bügelmessschraube für Außenmaße, Größe 25–50", "feature;z_mm;diameter_mm", "Maß;-5;20,003"]
    text = "\r\n".join(lines).replace(";", separator)
    (inspection,) = read(tmp_path, text.encode(encoding)).inspections
    (reading,) = inspection.readings
    assert (reading.feature, reading.actual) == ("Maß", 20.003)
    assert inspection.device.endswith("für Außenmaße, Größe 25–50")


def test_rows_without_a_value_were_not_measured(tmp_path: Path) -> None:
    found = read(tmp_path, "feature,z_mm,diameter_mm\nA,-5,20.003\nB,-9,\n")
    assert [len(one.values) for one in found.inspections] == [1]
    assert [remark.text for remark in found.remarks] == ["1 of 2 rows have no value: not measured"]


def test_a_part_is_one_inspection_whoever_read_it_with_what(tmp_path: Path) -> None:
    text = "serial,operator,instrument,feature,diameter_mm\nA1,K,m1,A,20\nA2,K,m1,A,20.01\nA1,K,m1,B,30\nA1,M,m2,B,30\n"
    first, second = read(tmp_path, text).inspections
    assert [(one.part.serial, one.operator, one.device, one.count) for one in (first, second)] == [
        ("A1", "K, M", "m1, m2", 3),
        ("A2", "K", "m1", 1),
    ]
    assert [reading.repeat for reading in first.readings] == [1, 1, 2]
    assert (first.device_of("A diameter"), first.device_of("B diameter")) == ("m1", "m1, m2")


def test_a_row_without_the_serial_number_that_others_have_is_refused(tmp_path: Path) -> None:
    """Below A1 and A2 alike: by the file it may be of either."""
    caught = refused(tmp_path, "serial,feature,diameter_mm\nA1,A,20\n,B,\n,B,30.01\nA2,A,20.1\n,B,30.11\n")
    assert (caught.code, caught.place.line, "2 of 4 readings" in caught.message) == (Code.MSR_SERIAL, 4, True)


@pytest.mark.parametrize("cell", ["***", "*****", "-", "--", "NaN", "n/a", "?"])
def test_a_cell_that_states_no_number_was_not_measured(cell: str, tmp_path: Path) -> None:
    found = read(tmp_path, f"feature,z_mm,diameter_mm\nA,{cell},20.003\nB,-9,{cell}\n")
    assert [(one.feature, one.place_mm) for one in found.inspections[0].readings] == [("A", ())]
    assert [remark.text for remark in found.remarks] == ["1 of 2 rows have no value: not measured"]


def test_a_deviation_of_the_opposite_sign_is_found(tmp_path: Path) -> None:
    text = "feature,nominal,diameter_mm,deviation\nA,20,20.011,-0.011\nB,30,30.004,-0.004\n"
    found = read(tmp_path, text)
    assert [one.actual for one in found.inspections[0].readings] == [20.011, 30.004]
    (remark,) = found.remarks
    assert "2 of 2 deviations are counted the other way" in remark.text
    assert read(tmp_path, text.replace(",-0", ",0")).remarks == ()


def test_what_two_cells_say_or_nobody_can_say_is_refused_with_its_place(tmp_path: Path) -> None:
    both = refused(tmp_path, "feature,diameter_mm,radius_mm\nA,20,10\n")
    assert (both.code, both.place.line, both.place.column) == (Code.MSR_COLUMN, 2, 3)
    number = refused(tmp_path, 'feature,diameter_mm\nA,"1,020.5"\n')
    assert (number.code, number.place.line, number.place.column) == (Code.MSR_NUMBER, 2, 2)
    assert refused(tmp_path, "feature,diameter_mm,measured_at\nA,20,yesterday\n").code is Code.MSR_NUMBER
    zero = refused(tmp_path, "feature,diameter_mm,uncertainty_um\nA,20,0\n")
    assert (zero.code, zero.place.column) == (Code.MSR_COLUMN, 3)
    mistyped = refused(tmp_path, "# operater: K\nfeature,diameter_mm\nA,20\n")
    assert (mistyped.code, mistyped.place.line) == (Code.MSR_COLUMN, 1)
    assert "'operator'" in mistyped.hint
    twice = refused(tmp_path, "# operator: K\n# operator: M\nfeature,diameter_mm\nA,20\n")
    assert (twice.code, twice.place.line) == (Code.MSR_COLUMN, 2)


def test_a_stated_unit_agrees_with_columns_that_name_theirs_or_is_refused(tmp_path: Path) -> None:
    mm, inch = StatedFacts("mm"), StatedFacts("inch")
    for stated, text in ((inch, "feature,diameter_mm\nA,20\n"), (mm, "feature,z_in,diameter_mm\nA,1,20\n")):
        with pytest.raises(TrueloopError) as caught:
            read(tmp_path, text, stated)
        assert caught.value.code is Code.MSR_UNIT and "`gauging.readings_unit`" in caught.value.hint
    for stated, column, value in ((mm, "diameter_mm", 25.4), (inch, "diameter_in", 1)):
        (one,) = read(tmp_path, f"feature,{column},uncertainty_um\nA,{value},1\n", stated).inspections
        assert one.readings[0].actual == 25.4


@pytest.mark.parametrize(
    ("header", "is_one"),
    [
        ("feature,z_mm,diameter_mm", True),
        ("Feature;Z_mm;Diameter_mm;note", True),
        ("characteristic,quantity,value_in", True),
        ("feature,z_mm,diameter_mm,instrumnt", True),
        ("feature,diameter_mm,verdict,inspector", False),
        ("point,feature,error_um", False),
        ("diameter_mm", False),
        ("Feature 5", False),
        ("", False),
    ],
)
def test_which_tables_are_gauge_readings(header: str, is_one: bool) -> None:
    assert recognises(Path("readings.csv"), f"# a comment\n\n{header}\n".encode()) is is_one
