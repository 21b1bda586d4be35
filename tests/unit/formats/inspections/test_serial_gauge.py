"""What a gauge sends over a serial line, kept in a file."""

from pathlib import Path

import pytest

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts


def _read(path: Path, text: str, **stated: object) -> MeasuredFile:
    file = path / "gauge.txt"
    file.write_bytes(text.encode())
    return read_measured_file(file, StatedFacts(**stated))  # type: ignore[arg-type]


def test_values_of_two_channels_with_faults_between_them(tmp_path: Path) -> None:
    file = _read(
        tmp_path, "01A+00012.345\r\n91102\r\n02A-00000.010\r\n01A+00012.347\r\n91201\r\n01B+00099.000\r\n", unit="mm"
    )
    (inspection,) = file.inspections
    found = [(one.characteristic, one.repeat, one.actual, one.line) for one in inspection.readings]
    assert found == [("01", 1, 12.345, 1), ("02", 1, -0.01, 3), ("01", 2, 12.347, 4)]
    assert [remark.line for remark in file.remarks] == [2, 5, 6]
    assert "911 of channel 02: no gauge" in file.remarks[0].text


def test_the_unit_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as refusal:
        _read(tmp_path, "01A+00000.5000\n")
    assert refusal.value.code is Code.MSR_UNIT
    assert _read(tmp_path, "01A+00000.5000\n", unit="inch").inspections[0].readings[0].actual == pytest.approx(12.7)


def test_a_mapping_states_what_a_channel_holds(tmp_path: Path) -> None:
    """In inches: a diameter at z = -4 in, and a length as the deviation from 3 in."""
    mapping = tmp_path / "gauge.toml"
    mapping.write_text(
        'unit = "inch"\n[variables.01]\nfeature = "seat"\nquantity = "diameter"\nz = -4.0\n[variables.02]\n'
        'feature = "shoulder"\nother = "end"\nquantity = "length"\nholds = "deviation"\nnominal = 3.0\n'
    )
    text = "01A+00001.7335\n02A-00000.0010\n01A+00001.7336\n"
    diameter, length, again = _read(tmp_path, text, mapping=mapping).inspections[0].readings
    assert (diameter.feature, diameter.quantity, again.repeat) == ("seat", Quantity.DIAMETER, 2)
    assert (diameter.actual, diameter.place_mm[0]) == pytest.approx((1.7335 * 25.4, -101.6))
    assert (length.other, length.quantity) == ("end", Quantity.LENGTH)
    assert (length.actual, length.nominal) == pytest.approx((2.999 * 25.4, 76.2))
    mapping.write_text(mapping.read_text().replace("variables.02", "variables.03"))
    with pytest.raises(TrueloopError, match="the channel '03'") as refusal:
        _read(tmp_path, text, mapping=mapping)
    assert refusal.value.code is Code.MSR_VALUE and refusal.value.hint == "its channels are 01, 02"


def test_limits_angles_and_an_x_read_as_a_diameter_have_their_own_factors(tmp_path: Path) -> None:
    """In inches: limits scale with the value, an angle and its limits do not, an X of 2 in across is 25.4 mm out."""
    mapping = tmp_path / "gauge.toml"
    mapping.write_text(
        'unit = "inch"\n[variables.01]\nquantity = "diameter"\nholds = "deviation"\nnominal = 2.0\n'
        'lower_limit = 1.5\nupper_limit = 2.5\n[variables.02]\nquantity = "angle"\nnominal = 30.0\nlower_limit = 29.5\n'
        'upper_limit = 30.5\n[variables.03]\nquantity = "position"\naxis = "x"\nx_is = "diameter"\nnominal = 1.9\n'
        '[variables.04]\nquantity = "position"\naxis = "x"\nx_is = "radius"\nnominal = 1.9\n'
        '[variables.05]\nquantity = "position"\naxis = "z"\n'
    )
    text = "01A-00000.1000\n02A+00030.2500\n03A+00002.0000\n04A+00002.0000\n05A+00002.0000\n"
    found = {one.characteristic: one for one in _read(tmp_path, text, mapping=mapping).inspections[0].readings}
    stated = {name: (one.actual, one.nominal, one.lower_limit, one.upper_limit) for name, one in found.items()}
    assert stated["01"] == pytest.approx((48.26, 50.8, 38.1, 63.5))
    assert stated["02"] == (30.25, 30.0, 29.5, 30.5)
    assert stated["03"][:2] == pytest.approx((25.4, 24.13))
    assert stated["04"][:2] == pytest.approx((50.8, 48.26))
    assert stated["05"][:2] == (50.8, None)


def test_a_line_that_was_cut_is_reported(tmp_path: Path) -> None:
    file = _read(tmp_path, "01A+00012.345\n" * 30 + "01A+000\x00\n", unit="mm")
    assert file.inspections[0].count == 30
    assert "not understood" in file.remarks[0].text
