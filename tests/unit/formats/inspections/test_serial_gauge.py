"""What a gauge sends over a serial line, kept in a file."""

from pathlib import Path

import pytest

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


def test_a_line_that_was_cut_is_reported(tmp_path: Path) -> None:
    file = _read(tmp_path, "01A+00012.345\n" * 30 + "01A+000\x00\n", unit="mm")
    assert file.inspections[0].count == 30
    assert "not understood" in file.remarks[0].text
