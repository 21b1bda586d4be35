"""A log of temperatures and speeds as CSV: `time_s` ascending, and NAME_degC or NAME_rpm for each signal."""

from pathlib import Path

import numpy as np

from trueloop.formats.measured_rows import column, read_rows, signals_in, wrong
from trueloop.machine.history import History


def read_history(path: Path) -> History:
    """Reads a log. Raises MCH-FILE for times that do not ascend or no signal, MCH-UNIT for units other than these."""
    rows = read_rows(path)
    if "time_s" not in rows[0][1]:
        raise wrong(path, 1, f"none of its {len(rows[0][1])} columns is time_s")
    time_s, signals = column(rows, "time_s", path), signals_in(rows, path)
    late = np.flatnonzero(np.diff(time_s) <= 0)
    if len(late):
        raise wrong(
            path, rows[int(late[0]) + 1][0], f"time_s does not ascend: {time_s[late[0]]:g}, then the same or less"
        )
    if not signals:
        raise wrong(path, 1, "no column is a temperature (NAME_degC) or a speed (NAME_rpm)")
    return History(time_s, signals)
