"""Rows of a CSV file of measurements: a header whose columns carry their unit, and what is said about others."""

import csv
import difflib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.geometry.feature import Array

SIGNAL_UNITS: Final = ("_degC", "_rpm")
WRONG_UNITS: Final = ("_in", "_degF", "_inch", "_ft", "_K", "_min", "_h", "_ms")
HINT: Final = "a header such as X_mm,travel_X,along,reading_um,T1_degC and a row a reading"

Rows = list[tuple[int, dict[str, str]]]
"""Line in the file and cells by column."""


def read_rows(path: Path) -> Rows:
    """The rows under the header; empty lines and those that start with # are left out. Raises MCH-FILE, MCH-UNIT."""
    lines = read_text(path, Code.MCH_FILE, hint=HINT).splitlines()
    kept = [(k + 1, line) for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    if len(kept) < 2:
        raise wrong(path, 1, "it has a header and no rows" if kept else "it is empty")
    cells = list(csv.reader(line for _, line in kept))
    header = [cell.strip() for cell in cells[0]]
    foreign = [name for name in header if name.endswith(WRONG_UNITS)]
    bare = [name for name in header if name in (*"XYZABC", "reading", "u", "temperature", "time")]
    if foreign or bare:
        raise wrong_unit(
            path, f"column {(foreign + bare)[0]!r} is in a unit that is not mm, µm, µrad, °, °C, s, or says none"
        )
    for (line, _), row in zip(kept, cells, strict=True):
        if len(row) != len(header):
            raise wrong(path, line, f"{len(row)} cells under {len(header)} columns (decimal points, not commas?)")
    return [(kept[k][0], dict(zip(header, row, strict=True))) for k, row in enumerate(cells) if k]


def check_columns(rows: Rows, known: Sequence[str], path: Path) -> None:
    """Raises MCH-FILE for a column that is none of these, nor a signal: mistyped, it would be a column ignored."""
    for name in rows[0][1]:
        if name not in known and not name.endswith(SIGNAL_UNITS):
            lowered = {other.lower(): other for other in known}
            near = difflib.get_close_matches(name.lower(), lowered, n=1)
            hint = f"did you mean {lowered[near[0]]!r}?" if near else f"take it out; known are {', '.join(known)}"
            raise wrong(path, 1, f"column {name!r} is not one of {len(known)} known", hint)


def signals_in(rows: Rows, path: Path) -> dict[str, Array]:
    """Temperatures and speeds by name without unit, (n,)."""
    return {name: values for unit in SIGNAL_UNITS for name, values in named_by(unit, rows, path).items()}


def named_by(unit: str, rows: Rows, path: Path) -> dict[str, Array]:
    """Columns whose names end in that unit, by their name without it, (n,)."""
    return {name.removesuffix(unit): column(rows, name, path) for name in rows[0][1] if name.endswith(unit)}


def optional(rows: Rows, name: str, path: Path, otherwise: float) -> Array:
    """A column, or one value for all rows where the file lacks it."""
    return column(rows, name, path) if name in rows[0][1] else np.full(len(rows), otherwise)


def column(rows: Rows, name: str, path: Path) -> Array:
    """A column of finite numbers, (n,). Raises MCH-FILE with the line."""
    if name not in rows[0][1]:
        raise wrong(path, 1, f"none of its {len(rows[0][1])} columns is {name}")
    return np.array([number_in(row, name, line, path) for line, row in rows])


def number_in(row: Mapping[str, str], name: str, line: int, path: Path) -> float:
    """One cell. Raises MCH-FILE."""
    try:
        value = float(row.get(name) or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise wrong(path, line, f"{name} is {row.get(name)!r}, not a finite number")
    return value


def wrong_unit(path: Path, why: str) -> TrueloopError:
    """The refusal MCH-UNIT."""
    return TrueloopError(
        Code.MCH_UNIT,
        f"{path.name!r}: {why}",
        hint="name every column with its unit: X_mm, reading_um, T1_degC; one file, one kind of reading",
        place=Place(str(path), 1),
    )


def wrong(path: Path, line: int, why: str, hint: str = HINT) -> TrueloopError:
    """The refusal MCH-FILE."""
    return TrueloopError(
        Code.MCH_FILE,
        f"{path.name!r} line {line} cannot be read: {why}",
        hint=hint,
        place=Place(str(path), line),
    )
