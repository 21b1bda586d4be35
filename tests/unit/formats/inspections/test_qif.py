"""QIF read: numbers with their units and limits, several sets, what refers to nothing, and what is hostile."""

import math
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.support.qif import INCH, UNITS, characteristic, document, measured, results
from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts

BALL = "<Compensated>false</Compensated><ProbeRadius>2</ProbeRadius>"
ABSOLUTE = "<MaxValue>10.03</MaxValue><MinValue>9.99</MinValue><DefinedAsLimit>true</DefinedAsLimit>"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path


def _read(folder: Path, text: str | bytes, stated: StatedFacts | None = None) -> MeasuredFile:
    path = folder / "part.qif"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_measured_file(path, stated or StatedFacts())


def _refused(folder: Path, text: str | bytes, code: Code, says: str) -> TrueloopError:
    with pytest.raises(TrueloopError, match=says) as caught:
        _read(folder, text)
    assert caught.value.code is code
    return caught.value


def test_limits_defined_as_allowances_that_hold_the_nominal_are_absolute(folder: Path) -> None:
    """9.99 to 10.03 beside 10, where `DefinedAsLimit` false would make them 19.99 to 20.03."""
    zone = "<MaxValue>10.03</MaxValue><MinValue>9.99</MinValue><DefinedAsLimit>false</DefinedAsLimit>"
    found = _read(
        folder, document(results(measured("3", "10.02")), characteristics=[characteristic(1, tolerance=zone)])
    )
    (reading,) = found.inspections[0].readings
    assert (reading.lower_limit, reading.upper_limit) == pytest.approx((9.99, 10.03), abs=1e-12)
    assert "limits exclude the nominal value as DefinedAsLimit has them" in found.remarks[0].text


@pytest.mark.parametrize("asked", [characteristic(1), characteristic(1, tolerance=ABSOLUTE)])
def test_limits_are_absolute_whichever_way_they_are_defined(folder: Path, asked: tuple[str, str, str]) -> None:
    """10 +0.03 −0.01, and 9.99 to 10.03."""
    found = _read(folder, document(results(measured("3", "10.02")), characteristics=[asked]))
    (inspection,) = found.inspections
    (reading,) = inspection.readings
    assert (reading.actual, reading.nominal) == (10.02, 10.0)
    assert (reading.lower_limit, reading.upper_limit) == pytest.approx((9.99, 10.03), abs=1e-12)
    assert reading.quantity is Quantity.DIAMETER and reading.characteristic == "D1"
    assert (inspection.part.serial, inspection.part.part_type.name) == ("A01", "cover")
    assert found.unit == "mm" and found.remarks == () and found.characteristics[0].nominal == 10.0


def test_inch_is_converted_and_a_value_may_have_its_own_unit(folder: Path) -> None:
    one = characteristic(1, target="0.4", tolerance="<MaxValue>0.002</MaxValue><DefinedAsLimit>false</DefinedAsLimit>")
    value = '<Value linearUnit="mm" combinedUncertainty="0.001">10.17</Value>'
    text = document(results(measured("3", "0.401"), measured("3", value)), characteristics=[one], units=INCH)
    first, second = _read(folder, text).inspections[0].readings
    assert (first.actual, first.nominal) == pytest.approx((0.401 * 25.4, 0.4 * 25.4), abs=1e-12)
    assert first.upper_limit == pytest.approx(0.402 * 25.4, abs=1e-12) and first.lower_limit is None
    assert (second.actual, second.standard_u, second.repeat) == (10.17, 0.001, 2)


def test_an_uncertainty_is_in_the_unit_of_its_value(folder: Path) -> None:
    value = '<Value combinedUncertainty="0.0001" meanError="0">0.401</Value>'
    text = document(results(measured("3", value)), characteristics=[characteristic(1)], units=INCH)
    (reading,) = _read(folder, text).inspections[0].readings
    assert reading.standard_u == pytest.approx(0.00254, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "definition", "limits"),
    [
        ("Flatness", "<ToleranceValue>0.05</ToleranceValue>", (None, 0.05)),
        ("PointProfile", "<ToleranceValue>4</ToleranceValue>", (-2.0, 2.0)),
        ("PointProfile", "<ToleranceValue>1.5</ToleranceValue><OuterDisposition>1</OuterDisposition>", (-0.5, 1.0)),
        ("Position", "<ToleranceValue>1</ToleranceValue><MaterialCondition>MAXIMUM</MaterialCondition>", (None, None)),
        ("Position", "<ToleranceValue>1</ToleranceValue><MaterialCondition>NONE</MaterialCondition>", (None, 1.0)),
    ],
)
def test_limits_of_zones(folder: Path, kind: str, definition: str, limits: tuple[float | None, float | None]) -> None:
    """A zone's width; of a point half of it to each side, or what is disposed outside and the rest inside."""
    asked = characteristic(1, kind, "", definition)
    found = _read(folder, document(results(measured("3", "0.01", kind)), characteristics=[asked]))
    (reading,) = found.inspections[0].readings
    assert (reading.lower_limit, reading.upper_limit) == limits


@pytest.mark.parametrize(("unit", "radians"), [("degree", "0.017453292519943"), ("radian", "1")])
def test_angles_are_in_degrees(folder: Path, unit: str, radians: str) -> None:
    units = UNITS.format(angle=unit, radians=radians, length="mm", metres="0.001")
    written = "30" if unit == "degree" else str(math.pi / 6)
    asked = characteristic(1, "Angle", written, "")
    found = _read(folder, document(results(measured("3", written, "Angle")), characteristics=[asked], units=units))
    (reading,) = found.inspections[0].readings
    assert (reading.actual, reading.nominal) == pytest.approx((30.0, 30.0), abs=1e-9)
    assert reading.quantity is Quantity.ANGLE


def test_a_unit_of_the_user_s_own(folder: Path) -> None:
    units = UNITS.format(angle="degree", radians="0.017453292519943", length="thou", metres="0.0000254")
    found = _read(folder, document(results(measured("3", "400")), characteristics=[characteristic(1)], units=units))
    assert found.inspections[0].readings[0].actual == pytest.approx(10.16, abs=1e-9)
    assert found.unit is None


def test_a_unit_that_is_not_stated_is_asked_for(folder: Path) -> None:
    angle = characteristic(11, "Angle", "30", "", "A1")
    text = document(
        results(measured("3", "0.4"), measured("13", "30", "Angle")),
        characteristics=[characteristic(1), angle],
        units="",
    )
    assert "--unit" in (_refused(folder, text, Code.MSR_UNIT, "no unit of length").hint or "")
    found = _read(folder, text, StatedFacts("inch"))
    (reading,) = found.inspections[0].readings
    assert reading.actual == pytest.approx(10.16)
    assert any("degrees or radians" in remark.text for remark in found.remarks), "angles are no lengths"


@pytest.mark.parametrize(
    ("units", "says"),
    [
        (UNITS.format(angle="degree", radians="0.0174532925", length="mm", metres="0.0254"), "'mm' is defined as 25.4"),
        (UNITS.format(angle="degree", radians="1", length="mm", metres="0.001"), "'degree' is defined"),
        (UNITS.format(angle="degree", radians="0.0174532925", length="ell", metres="-1"), "backwards"),
        (INCH.replace("<UnitConversion>", "<X>").replace("</UnitConversion>", "</X>").replace("inch", "ell"), "'ell'"),
    ],
)
def test_units_that_contradict_their_names_are_refused(folder: Path, units: str, says: str) -> None:
    _refused(folder, document(results(measured("3", "1")), units=units), Code.MSR_UNIT, says)


def test_a_unit_stated_twice_must_agree(folder: Path) -> None:
    text = document(results(measured("3", "1")), characteristics=[characteristic(1)])
    assert _read(folder, text, StatedFacts("mm")).unit == "mm"
    with pytest.raises(TrueloopError, match="it states 1 mm"):
        _read(folder, text, StatedFacts("inch"))


def test_every_part_of_every_result_set_is_an_inspection(folder: Path) -> None:
    parts = "".join(
        f'<ActualComponent id="{900 + k}"><SerialNumber>S{k}</SerialNumber></ActualComponent>' for k in (1, 2)
    )
    both = results(
        measured("3", "10.01", more="<ActualComponentId>901</ActualComponentId>"),
        measured("3", "10.02", more="<ActualComponentId>902</ActualComponentId>"),
    )
    start = "<InspectionTraceability><InspectionStart>2024-05-06T07:08:09Z</InspectionStart></InspectionTraceability>"
    text = document(
        both,
        results(measured("3", "9.98"), component="902", before=start),
        characteristics=[characteristic(1)],
        components=parts,
    )
    found = _read(folder, text)
    assert [(one.part.serial, one.readings[0].actual) for one in found.inspections] == [
        ("S1", 10.01),
        ("S2", 10.02),
        ("S2", 9.98),
    ]
    assert found.inspections[2].measured_at is not None and found.inspections[2].measured_at.isoformat().startswith(
        "2024-05-06T07:08:09"
    )
    assert any("verdict" in remark.text for remark in found.remarks), "9.98 is below 9.99 and stated as good"


def test_references_that_lead_nowhere_are_reported(folder: Path) -> None:
    value = measured("3", "10.01") + measured("77", "5")
    elsewhere = measured("3", "10.02").replace("<CharacteristicItemId>", '<CharacteristicItemId xId="3">')
    found = _read(folder, document(results(value, elsewhere, component="5"), characteristics=[characteristic(1)]))
    known, unknown, external = found.inspections[0].readings
    assert known.nominal == 10.0 and unknown.nominal is None and external.nominal is None
    assert external.quantity is Quantity.OTHER, "an item of another file with the same number"
    said = " ".join(remark.text for remark in found.remarks)
    assert "not in this file: no nominal value, no limits (2 in all)" in said and "no serial number" in said


def test_what_is_no_measured_size_is_left_out_and_reported(folder: Path) -> None:
    asked = [
        characteristic(1),
        characteristic(11, "UserDefinedLinear", "1", "", "Part Number"),
        characteristic(21, "Diameter", "8", "<NonTolerance>SET</NonTolerance>", "D2"),
        characteristic(31, "SurfaceTexture", "", "", "Ra"),
    ]
    values = (
        measured("3", ""),
        measured("13", "7", "UserDefinedLinear"),
        measured("23", "8"),
        measured("33", "0.8", "SurfaceTexture"),
        measured("3", "10.01"),
    )
    text = document(results(*values), characteristics=asked, components='<ActualComponent id="900"/>')
    found = _read(folder, text)
    assert [one.actual for one in found.inspections[0].readings] == [10.01]
    assert found.inspections[0].part.serial == "7", "nothing else numbers the part"
    said = " ".join(remark.text for remark in found.remarks)
    for words in (
        "no value but a verdict, PASS",
        "'Part Number' numbers the parts",
        "set to their nominal",
        "no lengths or angles",
    ):
        assert words in said


def test_diameters_that_are_all_nominal_were_filled_in(folder: Path) -> None:
    found = _read(
        folder, document(results(measured("3", "10"), measured("3", "10.000")), characteristics=[characteristic(1)])
    )
    assert "filled in, not measured: all 2 diameters of part 'A01'" in found.remarks[-1].text


def test_points_of_a_set_have_their_feature_and_ball(folder: Path) -> None:
    features = (
        '<Features><FeatureNominals><PointFeatureNominal id="50"><Location>1 2 3</Location><Normal>0 0 1</Normal>'
        '</PointFeatureNominal></FeatureNominals><FeatureItems><PointFeatureItem id="51"><FeatureNominalId>50'
        '</FeatureNominalId><FeatureName>P</FeatureName></PointFeatureItem><CircleFeatureItem id="52">'
        "<FeatureName>C</FeatureName></CircleFeatureItem></FeatureItems></Features>"
    )
    sets = (
        '<MeasuredFeatures><PointFeatureMeasurement id="60"><FeatureItemId>51</FeatureItemId><PointList>'
        "<WholePointSetId>70</WholePointSetId></PointList><Location>9 9 9</Location></PointFeatureMeasurement>"
        '<CircleFeatureMeasurement id="61"><FeatureItemId>52</FeatureItemId><PointList><WholePointSetId>71'
        "</WholePointSetId><WholePointSetId>72</WholePointSetId></PointList></CircleFeatureMeasurement></MeasuredFeatures>"
        f'<MeasuredPointSets><MeasuredPointSet id="70" count="1"><Points>1 2 3.01</Points>{BALL}</MeasuredPointSet>'
        f'<MeasuredPointSet id="71" count="2"><Points>0 0 0\n 1 1 1</Points>{BALL}</MeasuredPointSet>'
        "</MeasuredPointSets>"
    )
    found = _read(folder, document(results(before=sets), units=INCH, more=features))
    (inspection,) = found.inspections
    assert inspection.ball_radius_mm == 50.8 and inspection.measured == "CMM points" and inspection.count == 3
    first, second, third = inspection.points
    assert (first.name, second.name, third.name) == ("P", "C.1", "C.2")
    assert first.measured_mm == pytest.approx((25.4, 50.8, 3.01 * 25.4))
    assert first.nominal_mm == pytest.approx((25.4, 50.8, 76.2)) and first.outward_normal == (0.0, 0.0, 1.0)
    assert any("'72'" in remark.text for remark in found.remarks)


@pytest.mark.parametrize(
    ("points", "kept", "says"),
    [
        ('count="2"><Points>1 2 3 4 5 6</Points>', 2, ""),
        ("><Points>1 2 3</Points>", 1, ""),
        ('count="2"><Points>1 2 3 4 5</Points>', 0, "count of coordinates"),
        ('count="2"><PointsBinary>AAAA</PointsBinary>', 0, "binary"),
        (f'count="500001"><Points>{"1 2 3 " * 500_001}</Points>', 0, "counted, not kept"),
    ],
)
def test_points_that_cannot_be_kept_are_reported(folder: Path, points: str, kept: int, says: str) -> None:
    sets = f'<MeasuredPointSets><MeasuredPointSet id="70" {points}</MeasuredPointSet></MeasuredPointSets>'
    found = _read(folder, document(results(measured("3", "10.01"), before=sets), characteristics=[characteristic(1)]))
    (inspection,) = found.inspections
    assert len(inspection.points) == kept and len(inspection.readings) == 1
    assert inspection.count == 1 + (500_001 if "not kept" in says else kept)
    assert [says in remark.text for remark in found.remarks] == ([True] if says else [])


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "latin-1", "utf-8-sig", "gb18030"])
def test_any_encoding_that_is_marked_or_declared(folder: Path, encoding: str) -> None:
    name = "直径" if encoding == "gb18030" else "Ø größer"
    declared = {"utf-8-sig": "utf-8", "utf-16-le": "utf-16"}.get(encoding, encoding)
    text = document(
        results(measured("3", "10.02")),
        characteristics=[characteristic(1, name=name)],
        head=f'<?xml version="1.0" encoding="{declared}"?>\n',
    )
    assert _read(folder, text.encode(encoding)).inspections[0].readings[0].characteristic == name


def test_the_prefix_of_the_namespace_does_not_matter(folder: Path) -> None:
    text = document(results(measured("3", "10.02")), characteristics=[characteristic(1)])
    prefixed = text.replace("</", "</q:").replace("<", "<q:").replace("<q:/q:", "</q:").replace("xmlns=", "xmlns:q=")
    assert prefixed.startswith("<q:QIFDocument xmlns:q=")
    assert _read(folder, prefixed).inspections[0].readings == _read(folder, text).inspections[0].readings


BOMB = '<!DOCTYPE b [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>\n'
OUTSIDE = '<!DOCTYPE b [<!ENTITY a SYSTEM "file:///etc/hostname">]>\n'


@pytest.mark.parametrize("head", [BOMB, OUTSIDE])
def test_entities_are_refused(folder: Path, head: str) -> None:
    text = document(results(measured("3", "1")), head=head)
    assert _refused(folder, text, Code.MSR_FILE, "DOCTYPE").place.line == 1


@pytest.mark.parametrize("keep", [0.3, 0.6, 0.99])
def test_a_file_cut_short_is_refused_with_its_line(folder: Path, keep: float) -> None:
    text = document(results(measured("3", "10.02")), characteristics=[characteristic(1)])
    error = _refused(folder, text[: int(keep * len(text))], Code.MSR_FILE, "no whole XML")
    assert error.place is not None and error.place.line


@pytest.mark.parametrize(
    ("text", "code", "says"),
    [
        ("<QIFDocument>" + "<a>" * 300, Code.MSR_SIZE, "more than 200 deep"),
        (b"<QIFDocument><a>\xff\xfe</a></QIFDocument>", Code.MSR_FILE, "ff"),
        ('<?xml version="1.0" encoding="klingon"?><QIFDocument/>', Code.MSR_FILE, "klingon"),
        (document(results(measured("3", "1,234.5")), characteristics=[characteristic(1)]), Code.MSR_NUMBER, "1,234.5"),
        (document(results(measured("3", "nan")), characteristics=[characteristic(1)]), Code.MSR_NUMBER, "nan"),
        (document(results(measured("3", "1e999")), characteristics=[characteristic(1)]), Code.MSR_NUMBER, "1e999"),
    ],
)
def test_what_cannot_be_read_is_refused(folder: Path, text: str | bytes, code: Code, says: str) -> None:
    _refused(folder, text, code, says)


@pytest.mark.corpus
def test_the_twenty_covers_value_by_value(corpus: Path) -> None:
    """Against a walk of the whole tree: actual → item → nominal → definition, and the published means."""
    path = corpus / "data/public/qif/nist-cover-20-parts.QIF"
    found = read_measured_file(path, StatedFacts("mm"))
    assert [one.part.serial for one in found.inspections] == [str(k) for k in range(1, 21)]
    root = ElementTree.parse(path).getroot()
    by_id = {one.get("id"): one for one in root.iter() if one.get("id")}

    def text(element: ElementTree.Element, *names: str) -> str | None:
        return element.findtext("/".join(f"{{http://qifstandards.org/xsd/qif2}}{name}" for name in names))

    sets = root.iter("{http://qifstandards.org/xsd/qif2}MeasurementResults")
    for inspection, one in zip(found.inspections, sets, strict=True):
        (actuals,) = one.iter("{http://qifstandards.org/xsd/qif2}CharacteristicActuals")
        walked = [(actual, by_id[text(actual, "CharacteristicItemId")]) for actual in actuals]
        sizes = [(actual, item) for actual, item in walked if text(item, "Name") != "Part Number"]
        assert len(walked) == 28 and len(sizes) == 27
        for reading, (actual, item) in zip(inspection.readings, sizes, strict=True):
            nominal = by_id[text(item, "CharacteristicNominalId")]
            definition = by_id[text(nominal, "CharacteristicDefinitionId")]
            assert reading.characteristic == text(item, "Name")
            assert reading.actual == float(text(actual, "Value") or "nan")
            target, lower = text(nominal, "TargetValue"), text(definition, "Tolerance", "MinValue")
            assert reading.nominal == (None if target is None else float(target))
            assert reading.lower_limit == (None if lower is None else float(lower))
            upper = text(definition, "Tolerance", "MaxValue") or text(definition, "ToleranceValue")
            assert reading.upper_limit == float(upper or "nan")
    holes = {
        k: [r.actual for i in found.inspections for r in i.readings if r.characteristic == f"Diameter {k}"]
        for k in range(1, 21)
    }
    first = [value for k in (1, 5, 6, 7) for value in holes[k]]
    rest = [value for k in holes if k not in {1, 5, 6, 7} for value in holes[k]]
    assert sum(first) / len(first) == pytest.approx(4.5329, abs=5e-5)
    assert sum(rest) / len(rest) == pytest.approx(4.5284, abs=5e-5)
    assert [remark.line for remark in found.remarks] == [685]


@pytest.mark.corpus
def test_points_and_results_of_a_sample_of_the_standard(corpus: Path) -> None:
    found = read_measured_file(corpus / "data/public/qif/pts-sample.QIF", StatedFacts())
    (inspection,) = found.inspections
    counts = (219, 219, 219, 18, 8, 2, 1, 1, 1, 1, 1, 1)
    assert len(inspection.points) == sum(counts) and len(inspection.readings) == 27
    assert inspection.ball_radius_mm == pytest.approx(2.49978271104)
    assert inspection.points[0].measured_mm == (3.54516458565, 0.0037440421, -1.82916012241)
    assert inspection.points[0].name == "DATUMB.1" and inspection.device == "CMM"
    assert any("'828'" in remark.text for remark in found.remarks), "a reference of the sample that leads nowhere"
