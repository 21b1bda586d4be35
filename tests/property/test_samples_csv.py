"""samples.csv: what is written comes back to a nanometre's thousandth; what is none is refused where it is wrong."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.refusals import refused
from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.formats.realtime.samples_csv import header, lines, read_samples, samples_csv
from trueloop.realtime.samples import AXES, COUNTS, TIMES_NS, Samples, column_names, signal_columns

LENGTHS = st.floats(-1e4, 1e4) | st.sampled_from([0.0, -0.0, 1e-9, -1e-9, float("nan")])
SIGNALS = st.lists(st.tuples(st.text(max_size=6), st.sampled_from(["°C", "degC", "rev/min", "", "mm"])), max_size=3)


@st.composite
def records(draw: st.DrawFn) -> Samples:
    axes = draw(st.sampled_from(["x", "xz", "xyz", "z"]))
    signals = signal_columns(draw(SIGNALS))
    period_s = draw(st.sampled_from([1e-3, 0.25e-3, 0.999877e-3]))
    steps = [1, *draw(st.lists(st.integers(1, 30), max_size=40))]
    count = np.cumsum([0, *steps])
    columns = {}
    for name in column_names(axes, signals):
        values = st.integers(-(2**31), 2**31 - 1) if name in (*COUNTS, *TIMES_NS) else LENGTHS
        columns[name] = np.array(draw(st.lists(values, min_size=len(count), max_size=len(count))), np.float64)
    return Samples(period_s, axes, signals, columns | {"time_s": count * period_s})


@settings(max_examples=60, deadline=None)
@given(records())
def test_record_comes_back(tmp_path_factory: pytest.TempPathFactory, written: Samples) -> None:
    file = tmp_path_factory.mktemp("samples") / "samples.csv"
    file.write_bytes(samples_csv(written))
    read = read_samples(file)
    assert (read.axes, read.signals) == (written.axes, written.signals)
    counts = np.round(written.time_s / written.period_s).astype(int).tolist()
    assert read.lost == written.lost == len(set(range(counts[0], counts[-1] + 1)) - set(counts))
    assert read.period_s == pytest.approx(written.period_s, rel=1e-6)
    for name, column in written.columns.items():
        most = 0.51e-9 if name.endswith("_mm") or name == "time_s" else 0.51e-6
        np.testing.assert_allclose(read.columns[name], column, atol=most, rtol=1e-12)


@settings(max_examples=30, deadline=None)
@given(records(), st.integers(0, 40))
def test_parts_make_the_same_file_as_the_whole(written: Samples, cut: int) -> None:
    parts = [written.rows(slice(0, cut)), written.rows(slice(cut, None))]
    pieces = [b"".join(lines(part)) for part in parts]
    assert header(written.axes, written.signals) + b"".join(pieces) == samples_csv(written)


@settings(max_examples=40, deadline=None)
@given(records(), st.data())
def test_cut_file_is_read_up_to_its_last_whole_line(
    tmp_path_factory: pytest.TempPathFactory, written: Samples, data: st.DataObject
) -> None:
    content = samples_csv(written)
    ends = [k + 1 for k, byte in enumerate(content) if byte == ord("\n")]
    at = data.draw(st.integers(ends[2], len(content)))
    file = tmp_path_factory.mktemp("samples") / "samples.csv"
    file.write_bytes(content[:at])
    assert len(read_samples(file)) == sum(end <= at for end in ends) - 1


@given(SIGNALS)
def test_columns_of_signals_are_plain_and_apart(named: list[tuple[str, str]]) -> None:
    columns = column_names(AXES, signal_columns(named))
    assert len(set(columns)) == len(columns)
    assert all(column.isidentifier() or column.replace("_", "a").isalnum() for column in columns)


def test_a_spreadsheet_reads_it() -> None:
    """By Python's own reader: x, z, correction and drive of a row, as the page says."""
    names = column_names("xz", ("T1_degC",))
    columns: dict[str, Array] = {name: np.zeros(2) for name in names}
    columns |= {"time_s": np.array([0.0, 0.001]), "command_x_mm": np.array([12.5, 12.501])}
    columns |= {"correction_x_um": np.array([1.25, 1.5]), "drive_x_mm": np.array([12.50125, 12.5025])}
    columns |= {"T1_degC": np.array([20.5, 20.625])}
    samples = Samples(1e-3, "xz", ("T1_degC",), columns)
    rows = list(csv.DictReader(io.StringIO(samples_csv(samples).decode())))
    for row in rows:
        added = float(row["drive_x_mm"]) - float(row["command_x_mm"])
        assert 1e3 * added == pytest.approx(float(row["correction_x_um"]), abs=1e-6)
    assert [row["T1_degC"] for row in rows] == ["20.500000", "20.625000"]
    np.testing.assert_allclose(samples.mm("correction")[:, 0], samples.mm("drive")[:, 0] - samples.mm("command")[:, 0])
    assert not samples.mm("correction")[:, 1:].any()


def _changed(tmp_path: Path, line: int, column: str, value: str) -> Path:
    """Five good rows with one cell changed."""
    names = column_names("xz", ())
    columns: dict[str, Array] = {name: np.zeros(5) for name in names}
    columns["time_s"] = np.asarray(np.arange(5) * 1e-3, np.float64)
    rows = [row.split(",") for row in samples_csv(Samples(1e-3, "xz", (), columns)).decode().splitlines()]
    rows[line - 1][names.index(column)] = value
    file = tmp_path / "samples.csv"
    file.write_text("".join(",".join(row) + "\n" for row in rows))
    return file


@pytest.mark.parametrize(
    ("line", "column", "value", "said"),
    [
        (3, "drive_z_mm", "twelve", "'twelve' in column 5"),
        (3, "drive_z_mm", "1_2", "'1_2' in column 5"),
        (4, "time_s", "0.001000000", "goes from 0.001"),
        (6, "time_s", "0.004300000", "no whole number of periods"),
        (2, "time_s", "nan", "no finite number"),
        (3, "phase", "2.5", "no whole number"),
        (1, "command_x_mm", "command_y_mm", "correction_y_um"),
        (1, "model_x_um", "model_z_um", "model_x_um"),
        (1, "drive_x_mm", "", "drive_x_mm"),
        (1, "drive_x_mm", "table_y_um", "drive_x_mm"),
    ],
)
def test_wrong_cell_is_named(tmp_path: Path, line: int, column: str, value: str, said: str) -> None:
    error = refused(read_samples, _changed(tmp_path, line, column, value))
    assert error.code is Code.RTC_SAMPLES
    assert error.place.line == line
    assert error.hint
    assert said in error.message


def test_row_of_another_length_is_named(tmp_path: Path) -> None:
    file = _changed(tmp_path, 3, "line", "0,0")
    error = refused(read_samples, file)
    names = len(column_names("xz", ()))
    assert (error.place.line, error.code) == (3, Code.RTC_SAMPLES)
    assert f"{names + 1} values where the header names {names}" in error.message


@pytest.mark.parametrize(("column", "said"), [("table_y_um", "'table_y_um'"), ("line", "'line'"), ("", "no name")])
def test_wrong_column_is_named(tmp_path: Path, column: str, said: str) -> None:
    names = [*column_names("xz", ()), column]
    file = tmp_path / "samples.csv"
    file.write_text(",".join(names) + "\n" + "".join(f"0.00{k}" + ",0" * (len(names) - 1) + "\n" for k in range(3)))
    error = refused(read_samples, file)
    assert (error.code, error.place.line, error.place.column) == (Code.RTC_SAMPLES, 1, len(names))
    assert said in error.message
