"""Logs over time as CSV: `time_s` ascending; NAME_degC and NAME_rpm are signals, NAME_um displacements."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.input_file import FilePath
from trueloop.formats.measurements.rows import (
    SIGNAL_UNITS,
    CsvFile,
    Rows,
    named_by,
    read_measured,
    signals_in,
    units_in,
)
from trueloop.machine.drift import DriftTest
from trueloop.machine.model.history import History
from trueloop.units import UM_PER_MM

DISPLACEMENT: Final = "_um"


def read_history(path: FilePath) -> History:
    """Temperatures and speeds. Raises MCH-FILE for times that do not ascend or no signal, MCH-UNIT for other units.

    >>> log = trueloop.read_history(trueloop.example("machine/temperatures.csv"))
    >>> print(log.time_s, log.signals["T1"])
    [  0. 300. 600.] [20.  22.5 24.5]
    """
    path = Path(path)
    file, rows = _read(path)
    history = History(_times(rows), signals_in(rows), units_in(rows))
    if not history.signals:
        raise file.refusal("no column is a temperature (NAME_degC) or a speed (NAME_rpm)")
    return history


def read_drift(path: Path, *, displacements: bool = True) -> DriftTest:
    """Reads a drift test: temperatures, speeds, displacements (needed if `displacements`). Raises as `read_history`."""
    file, rows = _read(path)
    displacement_mm = {name: values / UM_PER_MM for name, values in named_by(DISPLACEMENT, rows).items()}
    if displacements and not displacement_mm:
        raise file.refusal("no column is a displacement (NAME_um)")
    return DriftTest(_times(rows), displacement_mm, named_by("_degC", rows), named_by("_rpm", rows))


def drift_csv(time_s: Array, displacement_um: Mapping[str, Array]) -> str:
    """Displacements over time as such a log."""
    names = [f"{name}{DISPLACEMENT}" for name in displacement_um]
    rows = [
        f"{t!r},{','.join(f'{v:.4f}' for v in row)}"
        for t, *row in zip(time_s.tolist(), *displacement_um.values(), strict=True)
    ]
    return "\n".join([",".join(["time_s", *names]), *rows, ""])


def _read(path: Path) -> tuple[CsvFile, Rows]:
    file = read_measured(path)
    return file, file.rows(("time_s",), (*SIGNAL_UNITS, DISPLACEMENT))


def _times(rows: Rows) -> Array:
    time_s = rows.numbers("time_s")
    for row in np.flatnonzero(np.diff(time_s) <= 0)[:1]:
        raise rows.refusal(int(row) + 1, f"time_s does not ascend after {time_s[row]:g}", "time_s")
    return time_s
