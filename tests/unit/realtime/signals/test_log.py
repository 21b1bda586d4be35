"""The log of signals: goes on after a restart, is begun anew when full, survives half a row."""

from pathlib import Path

import numpy as np
import pytest

from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.realtime.samples_csv import KEPT, SignalLog

COLUMNS = ("T1_degC", "spindle_rpm")


def log_in(folder: Path, keep_s: float = 50.0, most_rows: int = 100) -> SignalLog:
    return SignalLog(folder / "signals.csv", COLUMNS, keep_s, most_rows)


def written(log: SignalLog, times: range) -> None:
    for time_s in times:
        log.append(float(time_s), (20 + time_s / 100, 3.0 * time_s))


def test_what_is_written_is_a_history(tmp_path: Path) -> None:
    log = log_in(tmp_path)
    assert log.begin(0.0) is None
    written(log, range(10, 20))
    history = read_history(log.path)
    np.testing.assert_array_equal(history.time_s, np.arange(10.0, 20.0))
    np.testing.assert_allclose(history.signals["T1"], 20 + np.arange(10, 20) / 100, atol=1e-9)
    np.testing.assert_array_equal(history.signals["spindle"], 3.0 * np.arange(10, 20))
    assert history.units == {"T1": "°C", "spindle": "rev/min"}


def test_a_log_goes_on_after_a_restart(tmp_path: Path) -> None:
    written_by_first = log_in(tmp_path)
    written_by_first.begin(0.0)
    written(written_by_first, range(10, 20))
    second = log_in(tmp_path)
    history = second.begin(25.0)
    assert history is not None
    assert history.time_s[-1] == 19
    written(second, range(25, 30))
    assert read_history(second.path).time_s.tolist() == [*range(10, 20), *range(25, 30)]
    assert not (tmp_path / "signals.1.csv").exists()


@pytest.mark.parametrize("cut", range(1, 12))
def test_half_a_row_is_dropped(tmp_path: Path, cut: int) -> None:
    log = log_in(tmp_path)
    log.begin(0.0)
    written(log, range(10, 13))
    log.path.write_bytes(log.path.read_bytes()[:-cut])
    history = log_in(tmp_path).begin(25.0)
    assert history is not None
    assert history.time_s.tolist() == [10, 11]


@pytest.mark.parametrize(
    "content",
    [
        b"time_s,T1_degC\n1,20\n",
        b"time_s,T1_degC,spindle_rpm\n1,20,warm\n",
        b"time_s,T1_degC,spindle_rpm\n2,20,0\n1,20,0\n",
        b"time_s,T1_degC,spindle_rpm\n99,20,0\n",
        b"time_s,T1_degC,spindle_rpm\n",
        b"\xff\xfe\n",
        b"",
    ],
)
def test_a_log_that_cannot_be_gone_on_with_is_kept_beside(tmp_path: Path, content: bytes) -> None:
    """Of other signals, no numbers, not ascending, of the future, empty, no text."""
    log = log_in(tmp_path)
    log.path.write_bytes(content)
    assert log.recorded(50.0) is None
    assert log.begin(50.0) is None
    assert (tmp_path / "signals.1.csv").read_bytes() == content
    written(log, range(50, 52))
    assert read_history(log.path).time_s.tolist() == [50, 51]


def test_a_full_log_is_begun_anew_with_its_last_rows_and_nothing_is_lost(tmp_path: Path) -> None:
    log = log_in(tmp_path)
    log.begin(0.0)
    written(log, range(1, 161))
    files = ("signals.2.csv", "signals.1.csv", "signals.csv")
    oldest, before, now = (read_history(tmp_path / name).time_s.tolist() for name in files)
    assert oldest == list(range(1, 101))
    assert sorted({*oldest, *before, *now}) == list(range(1, 161))
    for begun, time_s in ((before, 101), (now, 151)):
        assert begun == list(range(time_s - 50, int(begun[-1]) + 1)), "it reaches back by what lags need, and is whole"


def test_so_many_logs_are_kept(tmp_path: Path) -> None:
    for number in range(KEPT + 3):
        log_in(tmp_path).path.write_bytes(b"%d" % number)
        log_in(tmp_path).begin(0.0)
    held = {file.name: file.read_bytes() for file in tmp_path.iterdir() if file.name != "signals.csv"}
    assert held == {f"signals.{k}.csv": b"%d" % (KEPT + 3 - k) for k in range(1, KEPT + 1)}


def test_a_time_that_is_not_later_is_left_out(tmp_path: Path) -> None:
    log = log_in(tmp_path)
    log.begin(0.0)
    for time_s in (10.0, 10.0, 9.0, 11.0):
        log.append(time_s, (20.0, 0.0))
    assert read_history(log.path).time_s.tolist() == [10, 11]


def test_looking_at_a_log_changes_nothing(tmp_path: Path) -> None:
    log = log_in(tmp_path)
    assert log.recorded(0.0) is None
    assert not list(tmp_path.iterdir())
