"""PC-DMIS text in the forms that its settings give it: columns on and off, signs printed or not, several runs."""

from datetime import datetime
from pathlib import Path

import pytest

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts

HEADER = "PART NAME  : BLOCK\nREV NUMBER : A\nSER NUMBER : {}\nSTATS COUNT : 1\nDATE={}   TIME=10:22:33 AM\n\n"
LOCATION = """DIM LOC1= LOCATION OF CIRCLE CIR1  UNITS=MM ,$
GRAPH=OFF  TEXT=OFF  MULT=10.00  OUTPUT=BOTH  HALF ANGLE=NO
AX    NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL
X      10.000      0.050      0.050     10.002      0.002      0.000 ----#----
D      25.000      0.050      0.020     25.060      0.060      0.010 -------->
END OF DIMENSION LOC1
"""
POSITION = """DIM LOC2= POSITION OF CIRCLE CIR1  UNITS=IN
AX       MEAS    NOMINAL       +TOL       -TOL      BONUS        DEV     OUTTOL
X      -1.005     -1.000                                      -0.005
DF      0.504      0.500      0.020      0.010      0.004      0.004      0.000
TP      0.010        MMC      0.020                 0.004      0.010      0.000
"""


def _read(path: Path, text: str, **stated: object) -> MeasuredFile:
    file = path / "report.txt"
    file.write_text(text)
    return read_measured_file(file, StatedFacts(**stated))  # type: ignore[arg-type]


def _readings(file: MeasuredFile) -> dict[str, Reading]:
    (inspection,) = file.inspections
    return {one.characteristic: one for one in inspection.readings}


def test_the_lower_tolerance_is_below_although_it_has_no_sign(tmp_path: Path) -> None:
    file = _read(tmp_path, HEADER.format(17, "14/3/2026") + LOCATION)
    found = _readings(file)
    assert (found["LOC1.D"].lower_limit, found["LOC1.D"].upper_limit) == pytest.approx((24.98, 25.05))
    assert (found["LOC1.D"].quantity, found["LOC1.D"].feature) == (Quantity.DIAMETER, "CIR1")
    assert (found["LOC1.X"].quantity, found["LOC1.X"].axis) == (Quantity.POSITION, "x")
    (one,) = file.inspections
    assert (one.part.part_type.name, one.part.part_type.revision, one.part.serial) == ("BLOCK", "A", "17")
    assert one.measured_at == datetime(2026, 3, 14, 10, 22, 33).astimezone()
    assert not file.remarks


def test_a_lower_tolerance_with_its_sign_beside_others_without_has_a_zone_with_a_width(tmp_path: Path) -> None:
    file = _read(tmp_path, LOCATION.replace("     0.050     10.002", "    -0.050     10.002"))
    assert [one.lower_limit for one in _readings(file).values()] == pytest.approx([9.95, 24.98])
    assert [(one.text[:36], one.line) for one in file.remarks] == [("1 -TOL are printed with their sign, ", 4)]


def test_a_heading_directly_below_a_line_that_goes_on_is_that_of_its_dimension(tmp_path: Path) -> None:
    text = LOCATION.replace("GRAPH=OFF  TEXT=OFF  MULT=10.00  OUTPUT=BOTH  HALF ANGLE=NO\n", "")
    assert [one.actual for one in _readings(_read(tmp_path, text)).values()] == [10.002, 25.06]


def test_with_signs_printed_it_is_the_same(tmp_path: Path) -> None:
    signed = LOCATION.replace("     0.050     10.002", "    -0.050     10.002").replace(
        " 0.020     25", "-0.020     25"
    )
    file = _read(tmp_path, signed)
    assert _readings(file)["LOC1.D"].lower_limit == pytest.approx(24.98)
    assert "with its sign" in file.remarks[0].text


def test_one_negative_lower_tolerance_among_positive_ones_is_a_limit_above_the_nominal(tmp_path: Path) -> None:
    file = _read(tmp_path, LOCATION.replace(" 0.020     25", "-0.020     25"))
    assert _readings(file)["LOC1.D"].lower_limit == pytest.approx(25.02)


def test_columns_go_by_their_heading_and_empty_cells_by_where_they_end(tmp_path: Path) -> None:
    found = _readings(_read(tmp_path, POSITION))
    assert found["LOC2.X"].actual == pytest.approx(-1.005 * 25.4)
    assert found["LOC2.X"].nominal == pytest.approx(-25.4)
    assert found["LOC2.X"].upper_limit is None
    assert found["LOC2.DF"].lower_limit == pytest.approx(0.49 * 25.4)
    assert found["LOC2.TP"].quantity is Quantity.FORM
    assert found["LOC2.TP"].lower_limit is None
    assert found["LOC2.TP"].upper_limit == pytest.approx(0.024 * 25.4)


def test_distances_angles_and_forms(tmp_path: Path) -> None:
    text = """DIM DIST1= 2D DISTANCE FROM CIRCLE CIR1 TO CIRCLE CIR2 PAR TO X AXIS,NO_RADIUS  UNITS=IN
AX    NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL
M       4.000      0.050      0.050      3.990     -0.010      0.000
DIM FLAT1= FLATNESS OF PLANE PLN1 UNITS=IN
AX    NOMINAL       +TOL       -TOL       MEAS        MAX        MIN        DEV     OUTTOL
M       0.000      0.010      0.000      0.004      0.002     -0.002      0.004      0.000
DIM ANG1= 3D ANGLE FROM LINE LIN1 TO LINE LIN2  UNITS=DEG
AX    NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL
A      45.000      0.500      0.500     45.100      0.100      0.000
"""
    found = _readings(_read(tmp_path, text))
    assert found["DIST1"].actual == pytest.approx(101.346)
    assert (found["DIST1"].feature, found["DIST1"].other) == ("CIR1", "CIR2")
    assert (found["FLAT1"].quantity, found["FLAT1"].lower_limit) == (Quantity.FORM, None)
    assert (found["ANG1.A"].actual, found["ANG1.A"].upper_limit) == (45.1, 45.5)


def test_without_the_column_of_measured_values_the_deviation_says_them(tmp_path: Path) -> None:
    text = "DIM A= LOCATION OF CIRCLE C1 UNITS=MM\nAX  NOMINAL   DEV\nD  25.000  -0.010\n"
    assert _readings(_read(tmp_path, text))["A.D"].actual == pytest.approx(24.99)
    text = "DIM A= LOCATION OF CIRCLE C1 UNITS=MM\nAX  MEAS   DEV\nD  25.000  -0.010\n"
    assert _readings(_read(tmp_path, text))["A.D"].nominal == pytest.approx(25.01)


def test_several_runs_and_a_printed_report_that_names_dimensions_with_their_unit(tmp_path: Path) -> None:
    label = "MM   LOC1 - CIR1\nAX  NOMINAL  +TOL  -TOL  MEAS  DEV  OUTTOL\nD  25.0  0.05  0.05  {}  {}  0.0\n"
    text = HEADER.format(1, "03/14/26") + label.format("25.01", "0.01") + HEADER.format(2, "03/15/26")
    first, second = _read(tmp_path, text + label.format("25.02", "0.02")).inspections
    assert (first.part.serial, second.part.serial) == ("1", "2")
    assert (first.readings[0].actual, second.readings[0].actual) == (25.01, 25.02)
    assert second.measured_at == datetime(2026, 3, 15, 10, 22, 33).astimezone()
    assert second.readings[0].feature == "CIR1"


def test_what_contradicts_itself_is_reported(tmp_path: Path) -> None:
    file = _read(tmp_path, LOCATION.replace("0.060      0.010", "-0.060      0.000"))
    texts = " ".join(remark.text for remark in file.remarks)
    assert "counted the other way" in texts
    assert "1 verdicts are not those of the values" in texts


def test_a_dimension_without_a_unit_asks_for_it(tmp_path: Path) -> None:
    text = LOCATION.replace("UNITS=MM ,", "")
    with pytest.raises(TrueloopError) as refusal:
        _read(tmp_path, text)
    assert refusal.value.code is Code.MSR_UNIT
    assert _readings(_read(tmp_path, text, unit="inch"))["LOC1.D"].nominal == pytest.approx(635.0)


def test_dates_that_may_be_two_leave_the_runs_without_a_time(tmp_path: Path) -> None:
    file = _read(tmp_path, HEADER.format(17, "3/4/2026") + LOCATION)
    assert file.inspections[0].measured_at is None
    assert "no time" in file.remarks[0].text


@pytest.mark.parametrize(
    ("date", "month", "day", "hour"),
    [
        ("Mar 14, 2026  TIME=10:22", 3, 14, 10),
        ("14. März 2026  TIME=10:22", 3, 14, 10),
        ("4-DEC-2026  TIME=2:22 PM", 12, 4, 14),
        ("4-DEC-2026  TIME=12:22 PM", 12, 4, 12),
        ("4-DEC-2026  TIME=12:22 AM", 12, 4, 0),
    ],
)
def test_a_date_that_names_its_month_can_be_read_in_one_way(
    date: str, month: int, day: int, hour: int, tmp_path: Path
) -> None:
    file = _read(tmp_path, f"PART NAME  : BLOCK\nDATE={date}\n\n{LOCATION}")
    assert file.inspections[0].measured_at == datetime(2026, month, day, hour, 22).astimezone()


def test_a_row_without_a_measured_value_is_reported(tmp_path: Path) -> None:
    file = _read(tmp_path, LOCATION.replace("25.060      0.060      0.010", "*****      *****      *****"))
    assert list(_readings(file)) == ["LOC1.X"]
    assert file.remarks[0].text.startswith("1 of 2 values are not measured: LOC1 D has no MEAS")


def test_a_row_that_is_only_a_graph_is_no_value(tmp_path: Path) -> None:
    file = _read(tmp_path, LOCATION.replace("END OF", "----#----\nEND OF"))
    assert file.inspections[0].count == 2
    assert "1 lines under headings are not understood" in file.remarks[0].text
