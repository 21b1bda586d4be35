"""Dumps, logs and print-outs of controls: values, units, radius and diameter, what is empty, what is refused."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Reading
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.controls.variables import value_of
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts

VARIABLES = """
unit = "mm"
[variables.500]
feature = "journal"
quantity = "diameter"
z = -20.0
nominal = 30.0
lower_limit = 29.98
upper_limit = 30.0
[variables.501]
feature = "bearing"
quantity = "diameter"
holds = "deviation"
nominal_in = "502"
"""
POINTS = """
[variables.510]
quantity = "position"
point = "P1"
axis = "x"
x_is = "diameter"
[variables.511]
quantity = "position"
point = "P1"
axis = "z"
"""
RENISHAW = """%
-------------------------------------------------------------------
   COMPONENT NO 4                    FEATURE NO 2
-------------------------------------------------------------------
SIZE D25.0000   ACTUAL 25.0732   TOL 0.0500   DEV 0.0732

          +++++OUT OF TOL+++++ ERROR  0.0232

POSN X10.0000   ACTUAL 10.0200   TOL TP 0.0300   DEV 0.0200
POSN Y-5.0000   ACTUAL -5.0100   DEV -0.0100
          +++++OUT OF POS+++++ ERROR TP 0.0100 RADIAL
   COMPONENT NO 4                    FEATURE NO 3
ANG 45.0000   ACTUAL 45.1000   TOL 0.2000   DEV 0.1000
SIZE 12.0000   ACTUAL 12.0040   DEV 0.0040
POSN X NaN   ACTUAL NaN   DEV NaN
   COMPONENT NO 5                    FEATURE NO 2
SIZE D25.0000   ACTUAL 25.0010   TOL 0.0500   DEV -0.0010
%
"""
HEIDENHAIN = """Measuring log from touch probe cycle 421 Hole Measuring
Date: 30-06-2026
Time: 6:55:04
Measuring program: TNC:\\GEH35712\\CHECK1.H
Nominal values:
Center in reference axis: 50.0000
Diameter: 12.0000
Given limit values:
Maximum limit for center in reference axis: 50.1000
Minimum limit for center in reference axis: 49.9000
Maximum dimension for hole: 12.0450
Minimum dimension for hole: 12.0000
Actual values:
Center in reference axis: 50.0810
Diameter: 12,0259
Deviations:
Center in reference axis: 0.0810
Diameter: 0.0259
Further measuring results: Measuring height: -5.0000
End of measuring log
"""


def read(folder: Path, content: str, mapping: str = "", unit: str | None = None, name: str = "out.txt") -> MeasuredFile:
    file, stated = folder / name, folder / "meaning.toml"
    file.write_bytes(content.encode())
    stated.write_text(mapping, encoding="utf-8")
    return read_measured_file(file, StatedFacts(unit, stated if mapping else None))  # type: ignore[arg-type]


def readings(file: MeasuredFile, part: int = 0) -> dict[str, Reading]:
    return {one.characteristic: one for one in file.inspections[part].readings}


def refused(code: Code, folder: Path, content: str, mapping: str = "", unit: str | None = None) -> TrueloopError:
    with pytest.raises(TrueloopError) as caught:
        read(folder, content, mapping, unit)
    assert caught.value.code is code
    return caught.value


@given(
    st.integers(-(2**20), 2**20),
    st.integers(1, 2**16),
    st.integers(0, 2**16),
    st.sampled_from([1, 3, 65536, 134217728]),
)
def test_an_expression_has_the_value_that_arithmetic_gives(a: int, b: int, c: int, d: int) -> None:
    assert value_of(f"[{a}*{b}+{c}]/{d}") == (a * b + c) / d
    assert value_of(f"{a}-{b}-{c}") == a - b - c
    assert value_of(f"[[{a}]-[{b}-{c}]]") == a - (b - c)


@pytest.mark.parametrize(
    "text", ["", "[", "1/0", "[1", "1]", "2**3", "abs(1)", "__import__('os')", "1 2", "[" * 99 + "1" + "]" * 99]
)
def test_what_is_no_expression_has_no_value(text: str) -> None:
    assert value_of(text) is None


def test_variables_are_what_the_mapping_says_and_an_empty_one_is_not_zero(tmp_path: Path) -> None:
    dump = "%\nO9999\n#500=29.9912(DIA 1)\n#501=.004\n#502=[25283*65536+65536]/134217728\n#503=0.\n#3002=17.25\n%\n"
    file = read(tmp_path, dump, VARIABLES)
    journal, bearing = readings(file)["journal diameter"], readings(file)["bearing diameter"]
    assert (journal.actual, journal.nominal, journal.lower_limit, journal.upper_limit) == (29.9912, 30.0, 29.98, 30.0)
    assert (journal.place_mm, journal.line) == ((-20.0,), 3)
    assert bearing.nominal == pytest.approx(25284 * 65536 / 2**27)
    assert bearing.actual == pytest.approx(25284 * 65536 / 2**27 + 0.004, abs=1e-12)  # deviation = actual − nominal
    assert any("2 of 5 variables are not in the mapping" in one.text for one in file.remarks)
    empty = read(tmp_path, "#500=\n#501=0.\n#502=12.\n", VARIABLES)
    assert "journal diameter" not in readings(empty)
    assert readings(empty)["bearing diameter"].actual == 12.0
    assert any(
        one.text == "#500 is empty: 'journal diameter' was not measured" and one.line == 1 for one in empty.remarks
    )


def test_variables_in_inch_are_millimetres_inside_and_x_of_a_point_is_halved_where_it_is_a_diameter(
    tmp_path: Path,
) -> None:
    file = read(tmp_path, "#510=2.\n#511=-0.5\n", POINTS, unit="inch")
    assert file.unit == "inch"
    assert file.inspections[0].points == (CmmPoint((25.4, 0.0, -12.7), name="P1"),)
    radius = read(tmp_path, "#510=2.\n#511=-0.5\n", POINTS.replace('"diameter"', '"radius"'), unit="inch")
    assert radius.inspections[0].points[0].measured_mm[0] == pytest.approx(50.8)


def test_siemens_and_heidenhain_variables(tmp_path: Path) -> None:
    mapping = 'unit = "mm"\n[variables."_OVR[4]"]\nquantity = "diameter"\nnominal_in = "_OVR[0]"\n'
    mapping += '[variables.R7]\nquantity = "runout"\n[variables.Q153]\nquantity = "length"\n'
    mapping += '[variables.VC1]\nquantity = "form"\n'
    file = read(tmp_path, "VC1 = .002\n_OVR[0]=30 ; set\n_OVR[4]=30.012\nR[7]=0.004\nN10 Q153=+12.5\n", mapping)
    found = readings(file)
    assert (found["_OVR[4]"].nominal, found["_OVR[4]"].actual) == (30.0, 30.012)
    assert found["R7"].quantity is Quantity.RUNOUT
    assert found["Q153"].actual == 12.5
    assert found["VC1"].actual == 0.002


def test_a_dump_whose_meaning_is_not_stated_is_refused_with_an_example(tmp_path: Path) -> None:
    error = refused(Code.MSR_MEANING, tmp_path, "#500=1.\n#501=2.\n", unit="mm")
    assert "[variables.500]" in error.hint
    assert "#500, #501" in error.message


def test_a_variable_twice_one_that_is_not_there_and_one_that_is_no_number(tmp_path: Path) -> None:
    assert refused(Code.MSR_VALUE, tmp_path, "#500=1.\n#501=0.\n#502=1.\n#500=2.\n", VARIABLES).place.line == 4
    assert "'501'" in refused(Code.MSR_VALUE, tmp_path, "#500=1.\n", VARIABLES).message
    assert refused(Code.MSR_NUMBER, tmp_path, "#501=1.\n#500=#501\n", VARIABLES).place.line == 2


def test_dprnt_words_blanks_and_runs(tmp_path: Path) -> None:
    log = "%\nX 12.345Z-  3.000\nX-.5 Z10.\n%\n%\nX    1.0000Z    2.0000\n%\n"
    mapping = 'unit = "mm"\n[log]\nx_is = "diameter"\nball_radius = 1.5\n'
    first, second = read(tmp_path, log, mapping).inspections
    assert [one.measured_mm for one in first.points] == [(6.1725, 0.0, -3.0), (-0.25, 0.0, 10.0)]
    assert [one.measured_mm for one in second.points] == [(0.5, 0.0, 2.0)]
    assert first.ball_radius_mm == 1.5
    assert "x_is" in refused(Code.MSR_MEANING, tmp_path, log, unit="mm").hint


def test_a_line_of_a_log_that_is_no_touch_is_named(tmp_path: Path) -> None:
    log = "".join(f"X 44.0{k}1Z-10{k}.000\n" for k in range(5)) + "X *****Z-85.000\n"
    found = refused(Code.MSR_VALUE, tmp_path, log, '[log]\nx_is = "diameter"\n', "mm")
    assert found.place.line == 6 and "'X *****Z-85.000': no touch" in found.message


def test_siemens_log_has_exponents_and_says_a_missed_touch(tmp_path: Path) -> None:
    file = read(tmp_path, "X1.25EX1 Z-3\nMISSED\n", '[log]\nx_is = "radius"\n', "mm")
    assert file.inspections[0].points[0].measured_mm == (12.5, 0.0, -3.0)
    assert [(one.text, one.line) for one in file.remarks] == [("a touch was missed", 2)]


def test_linuxcnc_writes_nine_numbers_of_which_x_is_a_radius(tmp_path: Path) -> None:
    file = read(tmp_path, "1.0 0.5 -2.0 0 0 0 0 0 0\n", unit="inch")
    assert file.inspections[0].points[0].measured_mm == pytest.approx((25.4, 12.7, -50.8))
    assert refused(Code.MSR_UNIT, tmp_path, "1.0 0.5 -2.0 0 0 0 0 0 0\n").hint.startswith("state it once")


def test_a_unit_stated_twice_and_differently_is_refused(tmp_path: Path) -> None:
    refused(Code.MSR_UNIT, tmp_path, "#500=1.\n#501=0.\n#502=1.\n", VARIABLES, "inch")


def test_columns_of_heidenhain_with_commas_and_points(tmp_path: Path) -> None:
    log = " -117,642  -81,681  -330.075\n-9999  +0  +1.0\n"
    mapping = '[log]\ncolumns = ["x", "y", "z"]\nx_is = "radius"\nlines = [1, 1]\n'
    file = read(tmp_path, log, mapping, "mm")
    assert [one.measured_mm for one in file.inspections[0].points] == [(-117.642, -81.681, -330.075)]
    assert "columns" in refused(Code.MSR_MEANING, tmp_path, log, unit="mm").hint


def test_a_print_out_has_sizes_positions_angles_and_what_is_out(tmp_path: Path) -> None:
    file = read(tmp_path, RENISHAW, unit="mm")
    found = readings(file)
    size = found["2 SIZE D"]
    assert (size.quantity, size.actual, size.nominal) == (Quantity.DIAMETER, 25.0732, 25.0)
    assert size.lower_limit == pytest.approx(24.95)
    assert size.upper_limit == pytest.approx(25.05)
    assert found["3 SIZE"].quantity is Quantity.LENGTH
    assert found["3 ANG"].upper_limit == pytest.approx(45.2)
    x, y = found["2 POSN X"], found["2 POSN Y"]
    assert (x.axis, x.upper_limit, y.actual) == ("x", None, -5.01)  # TP is the diameter of a zone: no limit of one axis
    assert [one.part.serial for one in file.inspections] == ["", ""]  # a component number is no serial number
    said = [one.text for one in file.remarks]
    assert any("was not measured" in text for text in said)
    assert any("counted the other way" in text for text in said)
    assert any("2 component numbers" in text for text in said)
    assert readings(read(tmp_path, RENISHAW, unit="inch"))["2 SIZE D"].actual == pytest.approx(25.0732 * 25.4)
    assert readings(read(tmp_path, RENISHAW, unit="inch"))["3 ANG"].actual == 45.1


@pytest.mark.parametrize("unit", ["mm", "inch"])
def test_deviations_that_fit_are_not_reported(tmp_path: Path, unit: str) -> None:
    file = read(tmp_path, RENISHAW.replace("DEV -0.0010", "DEV 0.0010"), unit=unit)
    assert not [one.text for one in file.remarks if "deviations" in one.text]


def test_a_results_file_has_nominal_points_normals_and_the_ball(tmp_path: Path) -> None:
    nominal, touched = "G800 N1 X10. Y0. Z-5. I2. J0. K0. O0. U0.01 L0.01", "G801 N1 X11.503 Y.0 Z-5. R1.5"
    content = f"START\nTOOLPATH Sleeve\n{nominal}\n{touched}\nEND\n"
    inspection = read(tmp_path, content, unit="mm").inspections[0]
    (point,) = inspection.points
    assert (point.nominal_mm, point.outward_normal, inspection.ball_radius_mm) == (
        (10.0, 0.0, -5.0),
        (1.0, 0.0, 0.0),
        1.5,
    )
    assert point.measured_mm == (11.503, 0.0, -5.0)
    half = content.replace("G801 N1", "G801 N2")
    assert refused(Code.MSR_VALUE, tmp_path, half, unit="mm").place.line == 4


def test_a_measuring_log_of_heidenhain(tmp_path: Path) -> None:
    file = read(tmp_path, HEIDENHAIN, unit="mm")
    found = readings(file)
    hole = found["Diameter"]
    assert (hole.actual, hole.nominal, hole.lower_limit, hole.upper_limit) == (12.0259, 12.0, 12.0, 12.045)
    centre = found["Center in reference axis"]
    assert (centre.axis, centre.lower_limit, centre.upper_limit) == ("x", 49.9, 50.1)
    assert not [one for one in file.remarks if "deviations" in one.text]
    wrong = read(tmp_path, HEIDENHAIN.replace("Diameter: 0.0259", "Diameter: -0.0259"), unit="mm")
    assert any("counted the other way" in one.text for one in wrong.remarks)
    german = (
        HEIDENHAIN.replace("Measuring log from touch probe cycle", "Messprotokoll Tastsystemzyklus")
        .replace("Nominal values", "Sollwerte")
        .replace("Given limit values", "Vorgegebene Grenzwerte")
        .replace("Actual values", "Istwerte")
        .replace("Deviations", "Abweichungen")
        .replace("Maximum dimension for hole", "Größtmaß Bohrung")
        .replace("Minimum dimension for hole", "Kleinstmaß Bohrung")
        .replace("Diameter", "Durchmesser")
    )
    bore = readings(read(tmp_path, german, unit="mm"))["Durchmesser"]
    assert (bore.quantity, bore.lower_limit, bore.upper_limit) == (Quantity.DIAMETER, 12.0, 12.045)
    moment = file.inspections[0].measured_at
    assert moment is not None
    assert (moment.year, moment.month, moment.day, moment.hour) == (2026, 6, 30, 6)


@pytest.mark.parametrize(
    "content", ["", "G0 X10. Z5.\nG1 Z-5. F0.1\nM30\n", "a letter\n", "T1 P1 X0.1 Z0.1 D0.8 Q2 ;OD\n"]
)
def test_what_is_no_output_of_a_control_is_not_recognised(tmp_path: Path, content: str) -> None:
    refused(Code.MSR_FORMAT if content else Code.MSR_FILE, tmp_path, content)


@given(
    st.sampled_from(
        [RENISHAW, HEIDENHAIN, "#500=1.\n#501=.004\n#502=[2*3]/4\n", "1 2 3 0 0 0 0 0 0\n", "X 1.5Z-  3.0\n"]
    ),
    st.lists(
        st.tuples(st.integers(0, 2000), st.text("0123456789.,+-[]/*=#XYZNG \n%(nan1e999", max_size=8)), max_size=6
    ),
)
def test_whatever_a_file_holds_it_is_read_with_finite_numbers_or_refused(
    tmp_path_factory: pytest.TempPathFactory, content: str, edits: list[tuple[int, str]]
) -> None:
    for at, text in edits:
        k = at % (len(content) + 1)
        content = content[:k] + text + content[k + len(text) // 2 :]
    mapping = VARIABLES + '[log]\nx_is = "radius"\ncolumns = ["x", "z"]\n'
    try:
        file = read(tmp_path_factory.mktemp("mutated"), content, mapping)
    except TrueloopError as error:
        assert error.code.startswith("MSR-")
        return
    for one in file.inspections:
        numbers = [number for point in one.points for number in point.measured_mm]
        numbers += [number for each in one.readings for number in (each.actual, each.nominal or 0.0)]
        assert all(map(math.isfinite, numbers))


@pytest.mark.corpus
def test_a_circle_touched_on_a_heidenhain_has_its_known_centre_and_radius(corpus: Path, tmp_path: Path) -> None:
    mapping = tmp_path / "meaning.toml"
    mapping.write_text('[log]\ncolumns = ["x", "y", "z"]\nx_is = "radius"\nlines = [2, 6]\n', encoding="utf-8")
    file = corpus / "data" / "public" / "probe" / "heidenhain-circle.a"
    points = read_measured_file(file, StatedFacts("mm", mapping)).inspections[0].points
    centre, radius = (-200.6634, -193.7836), 139.499  # SOURCES.tsv
    away = [math.dist(one.measured_mm[:2], centre) - radius for one in points]
    assert len(points) == 5
    assert max(map(abs, away)) < 0.002 + 0.001  # residuals there, and how the centre is rounded
