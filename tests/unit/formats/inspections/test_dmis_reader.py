"""DMIS results read into readings and points: signs, diameters, units, labels, runs, frames, contradictions."""

import csv
import math
from datetime import datetime
from pathlib import Path

import pytest

from tests.support.dmis import by_name, in_mm, only_inspection, only_point, read_text, remarks
from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts

CIRCLE = (
    "OUTPUT/F(D1),T(D1_DIAM)",
    "F(D1)=FEAT/CIRCLE,OUTER,CART,0,0,-30,0,0,1,30",
    "T(D1_DIAM)=TOL/DIAM,-0.02,0.01",
    "OUTPUT/FA(D1),TA(D1_DIAM)",
)


def _circle(actual: str = "30.005", deviation: str = "0.005", verdict: str = "INTOL") -> MeasuredFile:
    return in_mm(
        *CIRCLE,
        f"FA(D1)=FEAT/CIRCLE,OUTER,CART,0.001,-0.002,-30.000,0,0,1,{actual}",
        f"TA(D1_DIAM)=TOL/DIAM,{deviation},{verdict}",
    )


def test_a_diameter_is_a_diameter_with_absolute_limits() -> None:
    reading = by_name(_circle())["D1_DIAM"]
    assert (reading.quantity, reading.feature, reading.side) == (Quantity.DIAMETER, "D1", "outer")
    assert (reading.actual, reading.nominal) == (30.005, 30.0)
    assert (reading.lower_limit, reading.upper_limit) == pytest.approx((29.98, 30.01), abs=1e-12)
    assert (reading.place_mm, reading.line, reading.repeat) == ((0.0, 0.0, -30.0), 6, 1)
    assert not _circle().remarks


def test_the_coordinates_of_a_circle_are_positions() -> None:
    found = by_name(_circle())
    assert [(found[f"D1 {axis}AXIS"].axis, found[f"D1 {axis}AXIS"].actual) for axis in "XYZ"] == [
        ("x", 0.001),
        ("y", -0.002),
        ("z", -30.0),
    ]
    assert {found[f"D1 {axis}AXIS"].quantity for axis in "XYZ"} == {Quantity.POSITION}


def test_inch_is_25_4_mm_for_sizes_places_and_limits() -> None:
    text = "\n".join(["UNITS/INCH,ANGDEC", *CIRCLE, "FA(D1)=FEAT/CIRCLE,OUTER,CART,0,0,-30,0,0,1,30.005"])
    reading = by_name(read_text(text))["D1_DIAM"]
    assert reading.actual == pytest.approx(30.005 * 25.4, abs=1e-9)
    assert reading.nominal == pytest.approx(762.0, abs=1e-9)
    assert reading.upper_limit == pytest.approx(30.01 * 25.4, abs=1e-9)
    assert reading.place_mm[2] == pytest.approx(-762.0, abs=1e-9)


def test_a_unit_that_changes_within_the_file_holds_from_there_on() -> None:
    file = read_text(
        "UNITS/MM,ANGDEC\nF(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,25.4\nUNITS/INCH\n"
        "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,1.001\n"
    )
    reading = by_name(file)["D1 DIAM"]
    assert (file.unit, reading.nominal) == ("mm", 25.4)
    assert reading.actual == pytest.approx(25.4254, abs=1e-9)


@pytest.mark.parametrize(("word", "mm"), [("CM", 10.0), ("M", 1000.0), ("FEET", 304.8)])
def test_other_units(word: str, mm: float) -> None:
    file = read_text(f"UNITS/{word},ANGDEC\nFA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,2\n")
    assert by_name(file)["D1 DIAM"].actual == pytest.approx(2 * mm, abs=1e-9)
    assert file.unit is None


def test_a_file_without_a_unit_is_refused_where_nobody_states_it() -> None:
    text = "\nFA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,2\n"
    with pytest.raises(TrueloopError) as refused:
        read_text(text)
    assert (refused.value.code, refused.value.place.line) == (Code.MSR_UNIT, 2)
    assert by_name(read_text(text, StatedFacts(unit="inch")))["D1 DIAM"].actual == 50.8


POINT = (
    "OUTPUT/F(P),T(P_PROFP)",
    "F(P)=FEAT/POINT,CART,10.0000,0,5.0000,0.8,0,0.6",
    "T(P_PROFP)=TOL/PROFP,-0.1,0.1",
    "OUTPUT/FA(P),TA(P_DN)",
)


def test_a_point_has_its_nominal_place_and_normal_and_its_deviation_is_outward() -> None:
    file = in_mm(*POINT, "FA(P)=FEAT/POINT,CART,10.0160,0,5.0120,0.8,0,0.6", "TA(P_DN)=TOL/PROFP,0.0200,INTOL")
    point = only_point(file)
    assert (point.name, point.nominal_mm, point.outward_normal) == ("P", (10.0, 0.0, 5.0), (0.8, 0.0, 0.6))
    assert point.measured_mm == (10.016, 0.0, 5.012)
    reading = by_name(file)["P_PROFP"]  # labelled P_DN in the result: matched by feature and kind
    assert (reading.actual, reading.nominal, reading.lower_limit, reading.upper_limit) == (0.02, 0.0, -0.1, 0.1)
    assert not file.remarks


@pytest.mark.parametrize(
    ("stated", "words"),
    [("-0.0200", "with the opposite sign"), ("0.0300", "states 0.03 mm; the features make a deviation of 0.02 mm")],
)
def test_a_point_s_deviation_that_its_coordinates_contradict_is_remarked_and_not_taken(stated: str, words: str) -> None:
    file = in_mm(*POINT, "FA(P)=FEAT/POINT,CART,10.0160,0,5.0120,0.8,0,0.6", f"TA(P_DN)=TOL/PROFP,{stated},INTOL")
    assert by_name(file)["P_PROFP"].actual == pytest.approx(0.02, abs=1e-12)
    ((line, text),) = remarks(file)
    assert (line, words in text) == (7, True)


@pytest.mark.parametrize(
    ("deviation", "words"),
    [
        ("0.005", None),
        ("30.005", None),  # some software states the value itself
        ("-0.005", "opposite sign"),
        ("0.0025", "the features make a deviation of 0.005 mm"),  # radial: half of it
        ("0.010", "the features make a deviation of 0.005 mm"),  # twice
        ("0.0052", None),  # rounded features
    ],
)
def test_a_stated_deviation_is_compared_with_the_diameter(deviation: str, words: str | None) -> None:
    found = [text for _, text in remarks(_circle(deviation=deviation))]
    assert (words is None and not found) or (words is not None and words in found[0])


@pytest.mark.parametrize(
    ("actual", "verdict", "remarked"),
    [
        ("30.005", "INTOL", False),
        ("30.005", "OUTOL", True),
        ("30.005", "OUTTOL", True),
        ("30.020", "INTOL", True),
        ("30.020", "OUTTOL", False),
        ("29.970", "INTOL", True),
        ("29.970", "OUTOL", False),
        ("30.0101", "INTOL", False),  # within what rounding may do at the limit
    ],
)
def test_a_verdict_is_compared_with_the_limits(actual: str, verdict: str, remarked: bool) -> None:
    file = _circle(actual, f"{float(actual) - 30.0:.3f}", verdict)
    assert [text for _, text in remarks(file) if "limits" in text] == ([] if not remarked else [remarks(file)[0][1]])


def test_a_radius_tolerance_of_a_circle_is_half_the_diameter() -> None:
    file = in_mm(
        "OUTPUT/F(D1),T(R)",
        "F(D1)=FEAT/CIRCLE,INNER,CART,0,0,0,0,0,1,30",
        "T(R)=TOL/RAD,-0.02,0.01",
        "OUTPUT/FA(D1),TA(R)",
        "FA(D1)=FEAT/CIRCLE,INNER,CART,0,0,0,0,0,1,30.010",
        "TA(R)=TOL/RAD,0.005,INTOL",
    )
    reading = by_name(file)["R"]
    assert (reading.quantity, reading.actual, reading.nominal) == (Quantity.RADIUS, 15.005, 15.0)
    assert (reading.lower_limit, reading.upper_limit) == pytest.approx((14.98, 15.01))
    assert not file.remarks


def test_a_result_without_a_measured_feature_is_nominal_plus_deviation() -> None:
    file = in_mm(*CIRCLE, "TA(D1_DIAM)=TOL/DIAM,-0.005,INTOL")
    assert by_name(file)["D1_DIAM"].actual == pytest.approx(29.995, abs=1e-12)
    assert by_name(in_mm(*CIRCLE, "TA(D1_DIAM)=TOL/DIAM,29.995,INTOL"))["D1_DIAM"].actual == 29.995


def test_forms_and_positions_have_one_limit() -> None:
    file = in_mm(
        "OUTPUT/F(A),T(FL),T(PO)",
        "F(A)=FEAT/PLANE,CART,0,0,5,0,0,1",
        "T(FL)=TOL/FLAT,0.1",
        "T(PO)=TOL/POS,2D,0.05,MMC,DAT(A)",
        "OUTPUT/FA(A),TA(FL),TA(PO)",
        "FA(A)=FEAT/PLANE,CART,0.3,0.7,5.002,0,0,1",
        "TA(FL)=TOL/FLAT,0.023,INTOL",
        "TA(PO)=TOL/POS,2D,0.06,OUTOL,MMC,DAT(A)",
    )
    found = by_name(file)
    assert (found["FL"].quantity, found["FL"].actual, found["FL"].upper_limit) == (Quantity.FORM, 0.023, 0.1)
    assert (found["PO"].quantity, found["PO"].actual, found["PO"].lower_limit) == (Quantity.OTHER, 0.06, None)
    assert sorted(found) == ["A ZAXIS", "FL", "PO"]  # where on its plane a plane is stated means nothing
    assert not file.remarks


def test_distances_carry_their_nominal_value() -> None:
    file = in_mm(
        "T(L)=TOL/DISTB,NOMINL,40,-0.05,0.1,ZAXIS,AVG",
        "T(M)=TOL/DISTB,LIMIT,9.9,10.1,XAXIS",
        "OUTPUT/FA(A),FA(B),TA(L)",
        "TA(L)=TOL/DISTB,40.020,INTOL,ZAXIS",
        "OUTPUT/FA(A),FA(B),TA(M)",
        "TA(M)=TOL/DISTB,10.2,OUTOL,XAXIS",
    )
    length, other = by_name(file)["L"], by_name(file)["M"]
    assert (length.actual, length.nominal, length.lower_limit, length.upper_limit) == (40.02, 40.0, 39.95, 40.1)
    assert (length.quantity, length.feature, length.other) == (Quantity.LENGTH, "A", "B")
    assert (other.actual, other.nominal, other.lower_limit, other.upper_limit) == (10.2, None, 9.9, 10.1)


def test_one_tolerance_of_several_features_is_told_by_the_output() -> None:
    file = in_mm(
        "T(DIA)=TOL/DIAM,-0.1,0.1",
        *(
            line
            for name, size in (("A", 8), ("B", 12))
            for line in (
                f"F({name})=FEAT/CIRCLE,INNER,CART,0,0,0,0,0,1,{size}",
                f"OUTPUT/FA({name}),TA(DIA)",
                f"FA({name})=FEAT/CIRCLE,INNER,CART,0,0,0,0,0,1,{size}.02",
                "TA(DIA)=TOL/DIAM,0.02,INTOL",
            )
        ),
    )
    found = [(r.feature, r.actual) for r in only_inspection(file).readings if r.quantity is Quantity.DIAMETER]
    assert found == [("A", 8.02), ("B", 12.02)]
    assert not file.remarks


def test_labels_are_compared_without_regard_to_capitals_and_blanks() -> None:
    file = in_mm("f(bore 1)=feat/circle,inner,cart,0,0,0,0,0,1,8", "FA(Bore1)=FEAT/CIRCLE,INNER,CART,0,0,0,0,0,1,8.01")
    assert by_name(file)["Bore1 DIAM"].nominal == 8.0


def test_a_feature_measured_twice_is_kept_twice() -> None:
    actual = "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,{}"
    file = in_mm(*CIRCLE, actual.format(30.001), actual.format(30.002))
    found = [(r.repeat, r.actual) for r in only_inspection(file).readings]
    assert found == [(1, 30.001), (2, 30.002)]


@pytest.mark.parametrize("boundary", ["DATE=2026/02/02", "FILNAM/'second'", "PS(a)=PARTSN/'2'", "ENDFIL"])
def test_several_runs_in_one_file(boundary: str) -> None:
    measured = [*CIRCLE, "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.001"]
    file = in_mm("DATE=2026/02/01", "TIME=08:00:00", "PS(a)=PARTSN/'1'", *measured, boundary, *measured)
    assert len(file.inspections) == 2
    assert {reading.repeat for inspection in file.inspections for reading in inspection.readings} == {1}


def test_a_second_file_in_the_file_says_its_part_and_time_itself() -> None:
    measured = "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.001"
    file = in_mm("FILNAM/'a'", "PS(s)=PARTSN/'1'", "DATE=2026/02/01", measured, "FILNAM/'b'", measured)
    assert [(i.part.part_type.name, i.part.serial, i.measured_at is None) for i in file.inspections] == [
        ("a", "1", False),
        ("b", "", True),
    ]


def test_a_date_between_features_of_one_run_is_no_new_run() -> None:
    file = in_mm(
        "DATE=2026/02/01",
        "TIME=08:00:00",
        "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.001",
        "DATE=2026/02/01",
        "TIME=08:05:00",
        "FA(D2)=FEAT/CIRCLE,OUTER,CART,,,,,,,20.001",
        "DATE=2026/02/01",
        "TIME=08:09:00",
    )
    inspection = only_inspection(file)
    assert inspection.measured_at == datetime(2026, 2, 1, 8)
    assert [r.measured_at for r in inspection.readings] == [None, datetime(2026, 2, 1, 8, 5)]


def test_the_heading_names_part_serial_device_and_operator() -> None:
    file = in_mm(
        "FILNAM/'C:\\jobs\\shaft 7.dmo',5.2",
        "PN(p)=PARTID/'4711'",
        "PS(s)=PARTSN/'A-012'",
        "PR(r)='B'",
        "DI(d)=DMEID/'CMM 3'",
        "OP(o)=OPERID/'it''s me'",
        "DATE=2026-02-01",
        "TIME=14:02:03.5",
        "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.001",
    )
    inspection = only_inspection(file)
    assert inspection.part.identity == ("4711", "B", "A-012")
    assert (inspection.device, inspection.operator) == ("CMM 3", "it's me")
    assert inspection.measured_at == datetime(2026, 2, 1, 14, 2, 3)
    assert not remarks(file)


@pytest.mark.parametrize("text", ["DATE=01/02/2026", "DATE=2026/13/01", "TIME=25:00:00"])
def test_a_date_that_may_be_two_is_remarked(text: str) -> None:
    file = in_mm(text, "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.001")
    assert only_inspection(file).measured_at is None
    assert "is not read" in remarks(file)[0][1]


@pytest.mark.parametrize(
    ("plane", "point"), [("XYPLAN", (0.0, 20.0, 7.0)), ("YZPLAN", (7.0, 0.0, 20.0)), ("ZXPLAN", (20.0, 7.0, 0.0))]
)
def test_polar_coordinates_turn_in_the_working_plane(plane: str, point: tuple[float, ...]) -> None:
    file = in_mm(f"WKPLAN/{plane}", "FA(P)=FEAT/POINT,POL,20,90,7,1,0,0")
    assert only_point(file).measured_mm == pytest.approx(point, abs=1e-12)


@pytest.mark.parametrize(
    ("unit", "angle"), [("ANGDEC", "90.5"), ("ANGDMS", "90:30:00"), ("ANGRAD", str(math.radians(90.5)))]
)
def test_angles_in_each_unit(unit: str, angle: str) -> None:
    file = read_text(f"UNITS/MM,{unit}\nFA(P)=FEAT/POINT,POL,20,{angle},7,1,0,0\n")
    assert only_point(file).measured_mm[1] == pytest.approx(20 * math.sin(math.radians(90.5)), abs=1e-9)


@pytest.mark.parametrize(("angle", "degrees"), [("-30:30:00", -30.5), ("+30:30:00", 30.5), ("-0:30:36", -0.51)])
def test_the_sign_of_degrees_holds_for_minutes_and_seconds(angle: str, degrees: float) -> None:
    file = read_text(f"UNITS/MM,ANGDMS\nFA(P)=FEAT/POINT,POL,20,{angle},7,1,0,0\n")
    assert only_point(file).measured_mm[1] == pytest.approx(20 * math.sin(math.radians(degrees)), abs=1e-9)


def test_an_origin_that_is_moved_between_features_is_taken_back() -> None:
    file = in_mm(
        "FA(A)=FEAT/POINT,CART,1,2,3,0,0,1",
        "D(1)=TRANS/XORIG,10,ZORIG,-5",
        "FA(B)=FEAT/POINT,CART,1,2,3,0,0,1",
        "D(2)=ROTATE/ZAXIS,90",
        "FA(C)=FEAT/POINT,CART,1,2,3,1,0,0",
        "RECALL/D(1)",
        "FA(E)=FEAT/POINT,CART,1,2,3,0,0,1",
    )
    a, b, c, e = only_inspection(file).points
    assert (a.measured_mm, b.measured_mm, e.measured_mm) == ((1.0, 2.0, 3.0), (11.0, 2.0, -2.0), (11.0, 2.0, -2.0))
    # x of the turned axes lies along y: (1, 2) is 1 along y and 2 along −x from (10, 0)
    assert c.measured_mm == pytest.approx((8.0, 1.0, -2.0), abs=1e-12)
    assert c.outward_normal == pytest.approx((0.0, 1.0, 0.0), abs=1e-12)


def test_datums_set_before_the_first_feature_are_the_part_s_frame() -> None:
    file = in_mm("D(1)=DATSET/DAT(A),ZDIR,ZORIG", "D(2)=TRANS/XORIG,FA(B)", "FA(A)=FEAT/POINT,CART,1,2,3")
    assert (only_inspection(file).frame, only_point(file).measured_mm) == ("part", (1.0, 2.0, 3.0))


def test_features_measured_before_the_datums_are_kept_apart() -> None:
    file = in_mm("FA(A)=FEAT/POINT,CART,1,2,3", "D(1)=DATSET/DAT(A),ZDIR,ZORIG", "FA(B)=FEAT/POINT,CART,4,5,6")
    assert [(i.frame, i.points[0].name) for i in file.inspections] == [("device", "A"), ("part", "B")]
    assert remarks(file)[0][0] == 3


@pytest.mark.parametrize(
    "statement",
    ["D(2)=TRANS/XORIG,FA(A)", "D(2)=ROTATE/ZAXIS,FA(A),XDIR", "RECALL/D(9)", "D(2)=DATSET/DAT(B),XDIR", "D(2)=TRANS/"],
)
def test_a_frame_that_changes_by_an_unknown_amount_is_refused(statement: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        in_mm("D(1)=DATSET/DAT(A),ZDIR", "FA(A)=FEAT/POINT,CART,1,2,3", statement, "FA(B)=FEAT/POINT,CART,4,5,6")
    assert (refused.value.code, refused.value.place.line) == (Code.MSR_FRAME, 4)


@pytest.mark.parametrize("value", ["********", "1.2.3", "nan", "1e999", "1_000", "0x10"])
@pytest.mark.parametrize(
    "statement",
    [
        "FA(D1)=FEAT/CIRCLE,OUTER,CART,0,0,0,0,0,1,{}",
        "FA(D1)=FEAT/CIRCLE,OUTER,CART,{},0,0,0,0,1,30",  # it must not shift the numbers behind it either
        "TA(D1)=TOL/DIAM,{},INTOL",
        "OUTPUT/FA(C)$\n\nPTDATA/CART,1,{},3",
    ],
)
def test_a_measured_value_that_is_no_number_is_refused_with_its_line(value: str, statement: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        in_mm(statement.format(value))
    assert (refused.value.code, refused.value.place.line) == (Code.MSR_NUMBER, 2 + statement.count("\n"))


def test_a_nominal_by_variables_is_not_known_and_said_so() -> None:
    file = in_mm("F(D1)=FEAT/CIRCLE,OUTER,CART,0,0,ZZ,0,0,1,30", "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.001")
    assert by_name(file)["D1 DIAM"].nominal is None
    assert [remark.line for remark in file.remarks] == [2, 3]
    shifted = in_mm("F(D1)=FEAT/CIRCLE,OUTER,CART,XX,1,2,0,0,1,30", "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.001")
    assert by_name(shifted)["D1 DIAM"].nominal is None


def test_words_beyond_the_fields_that_are_known_are_remarked() -> None:
    file = in_mm("FA(P)=FEAT/POINT,CART,1,2,3,0,0,1,LSTSQR")
    assert only_point(file).measured_mm == (1.0, 2.0, 3.0)
    assert remarks(file) == [(2, "FA(…)=FEAT/POINT has 1 fields more than are known")]


def test_a_zero_behind_the_numbers_of_a_point_costs_neither_its_nominal_nor_its_measured_place() -> None:
    file = in_mm("F(P)=FEAT/POINT,CART,10.5,0,5,0,0,1,0", "FA(P)=FEAT/POINT,CART,10.503,0.001,5.004,0,0,1,0")
    assert (only_point(file).nominal_mm, only_point(file).measured_mm) == ((10.5, 0.0, 5.0), (10.503, 0.001, 5.004))
    assert not remarks(file)


@pytest.mark.parametrize(
    "statement",
    [
        "FA(P)=FEAT/POINT,CART,10,5,3,0,1,0,0",
        "FA(D1)=FEAT/CIRCLE,OUTER,CART,0,0,-30,0,0,1,30,005",
        "FA(P)=FEAT/POINT,CART,10,016,0,000,5,012,0,8,0,0,0,6",
        "TA(D1_DIAM)=TOL/DIAM,0,005,INTOL",
    ],
)
def test_decimal_commas_make_no_other_values(statement: str) -> None:
    file = in_mm(*CIRCLE, statement)
    assert not file.inspections
    assert "as decimal commas would make" in " ".join(text for _, text in remarks(file))


@pytest.mark.parametrize(
    ("statement", "lost"),
    [("CIRCLE,OUTER,CART,0,0,-30,0,0,1", "DIAM"), ("POINT,CART,1,2", "place"), ("ARC,INNER,CART,0,0,0,0,0,1", "RAD")],
)
def test_a_feature_that_ends_early_is_remarked(statement: str, lost: str) -> None:
    file = in_mm(f"FA(A)=FEAT/{statement}")
    assert remarks(file)[0] == (2, f"FA(…)=FEAT/{statement.split(',', maxsplit=1)[0]} ends before its {lost}")
    assert not only_inspection(file).points


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ("LO,0.02", "stands where a number"),
        ("0.02,-0.02", "lower limit of 0.02 mm above"),
        ("30,0.02,-0.02", "more than 2"),
        ("0.02", "has 1 of 2 limits"),
    ],
)
def test_limits_that_are_none_are_remarked_and_not_taken(limits: str, words: str) -> None:
    file = in_mm(f"T(A)=TOL/DIAM,{limits}", "OUTPUT/FA(A),TA(A)", "TA(A)=TOL/DIAM,30.0,INTOL")
    assert by_name(file)["A"].upper_limit is None
    assert words in remarks(file)[0][1]


def test_what_is_not_understood_is_counted_with_its_first_line() -> None:
    file = in_mm("WHATEVER/1", "WHATEVER/2", "FA(G)=FEAT/GEAR,1", "TA(G)=TOL/LEAD,1,INTOL", "= 5", "MEAS/POINT,F(A),1")
    assert remarks(file)[1:] == [
        (2, "WHATEVER is not understood and was left out: 2 times, first here"),
        (4, "FA(…)=FEAT/GEAR is not read"),
        (5, "TA(…)=TOL/LEAD is not read"),
        (6, "a line that is no statement was left out"),
    ]


def test_sizes_that_are_all_nominal_were_not_measured() -> None:
    lines = [f"{kind}(D{k})=FEAT/CIRCLE,OUTER,CART,,,,,,,{k}0" for k in (1, 2) for kind in ("F", "FA")]
    assert "exactly nominal" in remarks(in_mm(*lines))[0][1]


def test_a_feature_without_an_actual_is_remarked() -> None:
    file = in_mm(*CIRCLE, "F(D9)=FEAT/CIRCLE,OUTER,CART,,,,,,,9", "FA(D1)=FEAT/CIRCLE,OUTER,CART,,,,,,,30.001")
    assert remarks(file) == [(6, "1 of 2 features has no actual: 'D9'")]


def test_the_angle_of_a_cone_is_not_guessed() -> None:
    file = in_mm("FA(C)=FEAT/CONE,OUTER,CART,0,0,0,0,0,1,60.1")
    assert not [r for r in only_inspection(file).readings if r.quantity is Quantity.ANGLE]
    assert "CONE" in remarks(file)[0][1]


def test_single_points_of_a_feature() -> None:
    file = in_mm("OUTPUT/FA(C)", "PTDATA/CART,1,2,3,0,0,1", "RAWDAT/CART,4,5,6", "PTDATA/CART,1,2")
    assert [(p.name, p.measured_mm, p.outward_normal) for p in only_inspection(file).points] == [
        ("C", (1.0, 2.0, 3.0), (0.0, 0.0, 1.0)),
        ("C", (4.0, 5.0, 6.0), None),
    ]
    assert remarks(file) == [(5, "PTDATA with 2 numbers is not read")]


def test_a_program_holds_what_is_asked_for_and_no_results() -> None:
    file = in_mm(*CIRCLE[:3], "MEAS/CIRCLE,F(D1),4", "PTMEAS/CART,15,0,-30,1,0,0", "ENDMES", "ENDFIL")
    assert not file.inspections and "nothing measured" in remarks(file)[0][1]
    ((name, nominal, upper),) = [(c.name, c.nominal, c.upper_limit) for c in file.characteristics]
    assert (name, nominal, upper) == ("D1_DIAM", 30.0, 30.01)


@pytest.mark.corpus
def test_the_points_of_a_real_form_are_what_its_truth_says(corpus: Path) -> None:
    folder = corpus / "data" / "made" / "dmis"
    file = read_measured_file(folder / "modbas2-semifinish.dmo", StatedFacts())
    readings = by_name(file)
    points = {point.name: point for point in only_inspection(file).points}
    with (folder / "modbas2-semifinish.truth.csv").open(encoding="utf-8") as text:
        rows = list(csv.DictReader(text))
    assert len(rows) == len(points) == len(readings) and not file.remarks
    for row in rows:
        point, reading = points[row["feature"]], readings[f"{row['feature']}_PROFP"]
        nominal = (float(row["nominal_x_mm"]), 0.0, float(row["nominal_z_mm"]))
        assert point.nominal_mm == pytest.approx(nominal, abs=6e-5)  # the file has four decimals
        assert point.outward_normal == (float(row["normal_x"]), 0.0, float(row["normal_z"]))
        assert 1000 * reading.actual == pytest.approx(float(row["deviation_um"]), abs=1e-9)


@pytest.mark.corpus
def test_the_diameters_of_two_runs_are_what_their_truth_says(corpus: Path) -> None:
    folder = corpus / "data" / "made" / "dmis"
    file = read_measured_file(folder / "shaft-two-runs.dmo", StatedFacts())
    with (folder / "shaft-two-runs.truth.csv").open(encoding="utf-8") as text:
        expected = [
            (
                int(row["run"]),
                row["feature"],
                row["side"].lower(),
                *(float(row[name]) for name in ("nominal_diameter_mm", "actual_diameter_mm", "deviation_um")),
                row["in_tolerance"] == "True",
            )
            for row in csv.DictReader(text)
        ]
    found = []
    for run, inspection in enumerate(file.inspections, 1):
        for r in inspection.readings:
            if r.quantity is Quantity.DIAMETER and r.nominal is not None:
                assert r.lower_limit is not None and r.upper_limit is not None
                sizes = (round(r.nominal, 5), round(r.actual, 5), round(1000 * (r.actual - r.nominal), 2))
                found.append((run, r.feature, r.side, *sizes, r.lower_limit <= r.actual <= r.upper_limit))
    assert found == expected
    assert [text for _, text in remarks(file)] == [
        "1 of 4 features of run 1 has no actual: 'D9'",
        "1 of 4 features of run 2 has no actual: 'D9'",
    ]
