"""Files of measurements of machines: columns carry their unit, and signals are columns of any name."""

from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.measurements.rows import CsvFile, CsvKind, Rows, read_csv
from trueloop.units import SIGNALS

SIGNAL_UNITS: Final = tuple(SIGNALS)
WRONG_UNITS: Final = ("_in", "_degF", "_inch", "_ft", "_K", "_min", "_h", "_ms")
BARE: Final = (*"XYZABC", "reading", "u", "temperature", "time")
HINT: Final = "a header such as X_mm,travel_X,along,reading_um,T1_degC and a row a reading"
KIND: Final = CsvKind(Code.MCH_FILE, Code.MCH_FILE, Code.MCH_FILE, HINT)


def read_measured(path: Path) -> CsvFile:
    """The file with its units checked. Raises MCH-FILE, and MCH-UNIT for a column in a unit that is not used here."""
    file = read_csv(path, KIND)
    for name in file.header:
        if name.endswith(WRONG_UNITS) or name in BARE:
            why = f"column {name!r} is in a unit that is not mm, µm, µrad, °, °C, s, or says none"
            raise wrong_unit(path, why)
    return file


def signals_in(rows: Rows) -> dict[str, Array]:
    """Temperatures and speeds by name without unit, (n,)."""
    return {name: values for unit in SIGNAL_UNITS for name, values in named_by(unit, rows).items()}


def units_in(rows: Rows) -> dict[str, str]:
    """The units of those, by the same names."""
    return {name.removesuffix(end): unit for name in rows.header for end, unit in SIGNALS.items() if name.endswith(end)}


def named_by(unit: str, rows: Rows) -> dict[str, Array]:
    """Columns whose names end in that unit, by their name without it, (n,)."""
    return {name.removesuffix(unit): rows.numbers(name) for name in rows.header if name.endswith(unit)}


def vectors(rows: Rows, names: Iterable[str], otherwise: float | None = None) -> Array:
    """Three columns as vectors, (n, 3)."""
    return np.stack([rows.numbers(name, otherwise) for name in names], axis=-1)


def wrong_unit(path: Path, why: str) -> TrueloopError:
    """The refusal MCH-UNIT."""
    return TrueloopError(
        Code.MCH_UNIT,
        f"{path.name!r}: {why}",
        hint="name every column with its unit: X_mm, reading_um, T1_degC; one file, one kind of reading",
        place=Place(str(path), 1),
    )
