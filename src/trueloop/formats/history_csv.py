"""Logs over time as CSV: `time_s` ascending; NAME_degC and NAME_rpm are signals, NAME_um displacements."""

from pathlib import Path

import numpy as np

from trueloop.formats.measured_rows import Rows, column, named_by, read_rows, signals_in, wrong
from trueloop.geometry.feature import Array
from trueloop.machine.drift import DriftTest
from trueloop.machine.history import History


def read_history(path: Path) -> History:
    """Temperatures and speeds. Raises MCH-FILE for times that do not ascend or no signal, MCH-UNIT for other units."""
    rows = read_rows(path)
    history = History(_times(rows, path), signals_in(rows, path))
    if not history.signals:
        raise wrong(path, 1, "no column is a temperature (NAME_degC) or a speed (NAME_rpm)")
    return history


def read_drift(path: Path) -> DriftTest:
    """A drift test: displacements, temperatures, speeds. Raises as `read_history`."""
    rows = read_rows(path)
    displacement = {name: 1e-3 * values for name, values in named_by("_um", rows, path).items()}
    if not displacement:
        raise wrong(path, 1, "no column is a displacement (NAME_um)")
    return DriftTest(_times(rows, path), displacement, named_by("_degC", rows, path), named_by("_rpm", rows, path))


def _times(rows: Rows, path: Path) -> Array:
    if "time_s" not in rows[0][1]:
        raise wrong(path, 1, f"none of its {len(rows[0][1])} columns is time_s")
    time_s = column(rows, "time_s", path)
    late = np.flatnonzero(np.diff(time_s) <= 0)
    if len(late):
        raise wrong(path, rows[int(late[0]) + 1][0], f"time_s does not ascend after {time_s[late[0]]:g}")
    return time_s
