"""Q-DAS read: pieces, parts, limits, units, what is not valid, and what is counted."""

from datetime import datetime
from pathlib import Path

import pytest

from tests.support.qdas import HEAD, characteristic, value_line
from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts


def _read(folder: Path, text: str | bytes, stated: StatedFacts | None = None, name: str = "part.dfq") -> MeasuredFile:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_measured_file(path, stated or StatedFacts())


def _refused(folder: Path, text: str, code: Code, says: str) -> TrueloopError:
    with pytest.raises(TrueloopError, match=says) as caught:
        _read(folder, text)
    assert caught.value.code is code
    return caught.value


TWO = HEAD + characteristic(1) + characteristic(2, "Length 2", "50", ("49.9", "50.1"))


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_every_line_of_values_is_a_piece(tmp_path: Path, ending: str) -> None:
    lines = value_line(("1.0010E+1", "0", "19.04.1998/19:08:00", "1", "#B7"), ("50,02", "0")) + value_line(
        ("10.02", "0", "01.01.1970/00:00:00"), ("49.98",)
    )
    found = _read(tmp_path, (TWO + lines).replace("\n", ending))
    first, second = found.inspections
    assert [(one.actual, one.nominal) for one in first.readings] == [(10.01, 10.0), (50.02, 50.0)]
    assert [one.actual for one in second.readings] == [10.02, 49.98]
    assert [one.quantity for one in first.readings] == [Quantity.DIAMETER, Quantity.LENGTH]
    assert (first.readings[0].lower_limit, first.readings[0].upper_limit) == (9.99, 10.03)
    assert first.measured_at == datetime(1998, 4, 19, 19, 8) and second.measured_at is None
    assert (first.part.part_type.name, first.part.part_type.revision) == ("4711", "b")
    assert [one.name for one in found.characteristics] == ["Diameter 1", "Length 2"]
    assert found.unit == "mm" and found.remarks == ()


def test_fields_between_the_lines_belong_to_the_values_before_them(tmp_path: Path) -> None:
    lines = value_line("10.01", "50.01") + "K0014/0 S1\nK0053/1 615\n" + value_line("10.02", "50.02") + "K0014/1 S2\n"
    assert [one.part.serial for one in _read(tmp_path, TWO + lines).inspections] == ["S1", "S2"]


def test_values_in_fields_of_their_own(tmp_path: Path) -> None:
    fields = (
        "K0001/1 10.01\nK0004/1 01.02.2013/15:18:31\nK0014/1 S1\nK0001/1 10.02\nK0002/1 255\n"
        "K0001/2 50.01\nK0001/2 50.02\nK0014/2 S2\nK0001/2 50.03\n"
    )
    found = _read(tmp_path, TWO + fields)
    assert [[one.actual for one in piece.readings] for piece in found.inspections] == [[10.01, 50.01], [50.02], [50.03]]
    assert [one.part.serial for one in found.inspections] == ["S1", "S2", ""]
    assert any("different counts" in remark.text for remark in found.remarks)


@pytest.mark.parametrize(("attribute", "kept"), [("0", True), ("", True), ("255", False), ("3", False), ("256", False)])
def test_only_valid_values_are_read(tmp_path: Path, attribute: str, kept: bool) -> None:
    found = _read(tmp_path, TWO + value_line(("10.01", attribute), "50.01"))
    assert [one.actual for one in found.inspections[0].readings] == ([10.01, 50.01] if kept else [50.01])
    assert bool(found.remarks) is (attribute in {"3", "256"})


def test_a_line_without_any_value_is_no_piece(tmp_path: Path) -> None:
    found = _read(tmp_path, TWO + value_line(("0", "255"), ("0", "255")) + value_line("10.01"))
    assert [[one.actual for one in piece.readings] for piece in found.inspections] == [[10.01]]


def test_characteristics_belong_to_the_part_before_them(tmp_path: Path) -> None:
    second = "K1001/2 4712\n" + characteristic(3, "Diameter 3", "7", ("6.9", "7.1"))
    found = _read(tmp_path, TWO + second + value_line("10.01", "50.01", "7.01"))
    assert [(one.part.part_type.name, len(one.readings)) for one in found.inspections] == [("4711", 2), ("4712", 1)]


@pytest.mark.parametrize(
    ("more", "limits"),
    [
        ({}, (9.99, 10.03)),
        ({"K2120": "1", "K2121": "1"}, (9.99, 10.03)),
        ({"K2120": "2"}, (None, 10.03)),
        ({"K2121": "2"}, (9.99, None)),
        ({"K2110": "", "K2111": "", "K2112": "-0.02", "K2113": "0.05"}, (9.98, 10.05)),
    ],
)
def test_limits_are_absolute_and_natural_ones_are_none(
    tmp_path: Path, more: dict[str, str], limits: tuple[float | None, float | None]
) -> None:
    (reading,) = (
        _read(
            tmp_path,
            HEAD
            + characteristic(1)
            + "".join(f"{key}/1 {value}\n" for key, value in more.items())
            + value_line("10.01"),
        )
        .inspections[0]
        .readings
    )
    assert (reading.lower_limit, reading.upper_limit) == pytest.approx(limits, abs=1e-12)


@pytest.mark.parametrize(
    ("unit", "mm"),
    [
        ("mm", 1.0),
        ("cm", 10.0),
        ("µm", 0.001),
        ("μm", 0.001),
        ("inch", 25.4),
        ('"', 25.4),
        ("Zoll", 25.4),
        ("m", 1000.0),
    ],
)
def test_units_of_length(tmp_path: Path, unit: str, mm: float) -> None:
    text = HEAD + characteristic(1, unit=unit, nominal="3", limits=("2", "4")) + value_line("3.5")
    found = _read(tmp_path, text)
    (reading,) = found.inspections[0].readings
    numbers = (reading.actual, reading.nominal, reading.lower_limit, reading.upper_limit)
    assert numbers == pytest.approx((3.5 * mm, 3 * mm, 2 * mm, 4 * mm), rel=1e-12)
    assert found.unit == {1.0: "mm", 25.4: "inch"}.get(mm)


@pytest.mark.parametrize(("unit", "degrees"), [("°", 30.0), ("Grad", 30.0), ("'", 0.5), ("rad", 1718.8733853924696)])
def test_angles(tmp_path: Path, unit: str, degrees: float) -> None:
    text = HEAD + characteristic(1, "Winkel", "30", ("", ""), unit) + value_line("30")
    found = _read(tmp_path, text.encode("cp1252"))
    (reading,) = found.inspections[0].readings
    assert reading.actual == pytest.approx(degrees) and reading.quantity is Quantity.ANGLE


def test_a_unit_is_asked_for_and_others_than_of_length_are_left_out(tmp_path: Path) -> None:
    force = characteristic(2, "Force", "5", unit="N")
    text = HEAD + characteristic(1, unit="") + force + value_line("0.4", "5")
    assert _refused(tmp_path, text, Code.MSR_UNIT, "no unit").place
    found = _read(tmp_path, text, StatedFacts("inch"))
    (reading,) = found.inspections[0].readings
    assert reading.actual == pytest.approx(10.16) and any("'Force' is in 'N'" in one.text for one in found.remarks)


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("Rundheit Durchmesser 3", Quantity.FORM), ("Ø 12 H7", Quantity.DIAMETER), ("Rundlauf A", Quantity.RUNOUT),
        ("Radius R2", Quantity.RADIUS), ("Abstand", Quantity.LENGTH), ("Parallelität", Quantity.FORM),
        ("Merkmal 7", Quantity.OTHER), ("Winkelmaß", Quantity.OTHER),
    ],
)  # fmt: skip
def test_what_the_name_says(tmp_path: Path, name: str, quantity: Quantity) -> None:
    found = _read(tmp_path, (HEAD + characteristic(1, name) + value_line("10")).encode("cp1252"))
    assert found.inspections[0].readings[0].quantity is quantity
    assert found.inspections[0].readings[0].characteristic == name


def test_counted_characteristics_are_refused_or_left_out_beside_measured_ones(tmp_path: Path) -> None:
    counted = characteristic(1, "Cracks", K2004="1")
    error = _refused(tmp_path, HEAD + counted + "K0020/1 100\nK0021/1 3\n", Code.MSR_COUNTED, "K2004 1")
    assert error.place is not None and error.place.line == (HEAD + counted).splitlines().index("K2004/1 1") + 1
    found = _read(tmp_path, HEAD + counted + characteristic(2, "Diameter 2") + value_line("3", "10.01"))
    assert [one.actual for one in found.inspections[0].readings] == [10.01]
    assert any("K2004 1" in remark.text for remark in found.remarks)


@pytest.mark.parametrize("named", ["Part.dfd", "part.DFX"])
def test_plan_and_values_in_two_files(tmp_path: Path, named: str) -> None:
    (tmp_path / "Part.dfd").write_text(TWO)
    (tmp_path / "part.DFX").write_text(value_line("10.01", "50.01"))
    found = read_measured_file(tmp_path / named, StatedFacts())
    assert [one.actual for one in found.inspections[0].readings] == [10.01, 50.01]
    (tmp_path / "part.DFX").unlink()
    if named == "Part.dfd":
        with pytest.raises(TrueloopError, match="half of a pair") as caught:
            read_measured_file(tmp_path / named, StatedFacts())
        assert caught.value.code is Code.MSR_FILE


@pytest.mark.parametrize(
    ("text", "code", "says"),
    [
        (TWO + value_line("1", "2", "3"), Code.MSR_VALUE, "3 values, the file 2 characteristics"),
        (TWO + "measured by hand\n", Code.MSR_FILE, "neither"),
        (TWO + value_line("1,234.5"), Code.MSR_NUMBER, "1,234.5"),
        (HEAD + characteristic(1, nominal="ten") + value_line("1"), Code.MSR_NUMBER, "ten"),
    ],
)
def test_what_is_refused_has_its_line(tmp_path: Path, text: str, code: Code, says: str) -> None:
    error = _refused(tmp_path, text, code, says)
    assert error.place is not None and error.place.line


def test_fields_stated_twice_or_without_a_value_are_reported(tmp_path: Path) -> None:
    found = _read(tmp_path, "K0014/1 S1\n" + TWO + "K2101/1 11\n" + value_line("10.01", "50.01"))
    said = [remark.text for remark in found.remarks]
    assert any("K2101/1" in text for text in said) and any("before any value" in text for text in said)
    assert found.inspections[0].readings[0].nominal == 11.0 and found.inspections[0].part.serial == ""


@pytest.mark.corpus
def test_a_gauge_s_file(corpus: Path) -> None:
    """Values as they stand in the file, in cm."""
    found = read_measured_file(corpus / "data/public/qdas/aqdef-reader-testmeasures.dfq", StatedFacts())
    assert [[one.actual for one in piece.readings] for piece in found.inspections] == [
        pytest.approx([2499.6, 2495.7]),
        pytest.approx([2498.3, 2494.0]),
        pytest.approx([2499.3, 2494.9]),
        pytest.approx([2498.8, 2495.4]),
        pytest.approx([2497.8, 2493.4]),
    ]
    first = found.inspections[0].readings[0]
    assert (first.nominal, first.lower_limit, first.upper_limit) == (2500.0, 2000.0, 3000.0)
    assert found.inspections[0].part.part_type.name == "Teil 123.456.789"


@pytest.mark.corpus
def test_three_parts_and_a_file_of_counts(corpus: Path) -> None:
    found = read_measured_file(corpus / "data/public/qdas/diribet-three-parts.dfq", StatedFacts("mm"))
    parts = [one.part.part_type.name for one in found.inspections]
    assert [parts.count(f"<part_number_{k}>") for k in (1, 2, 3)] == [8, 1, 3] and len(found.characteristics) == 9
    assert [one.actual for one in found.inspections[-1].readings] == [1.8, 3.3, 4.8, 6.3, 7.8]
    with pytest.raises(TrueloopError, match="K2004 1") as caught:
        read_measured_file(corpus / "data/public/qdas/diribet-attributive.dfq", StatedFacts("mm"))
    assert caught.value.place is not None and caught.value.place.line == 7
