"""Characterization readings as CSV, one reading a row; columns carry their unit.

X_mm, Y_mm …, A_deg …   axis positions as commanded; axes left out stand at 0
travel_X …              + or − (or 1, −1): the way the axis came; empty or left out: unknown
along                   X Y Z: the reading is a displacement along it; A B C: a rotation about it
along_x, along_y, along_z   instead of `along`: a direction, for instance of a ball bar from its centre to the tool
reading_um | reading_mm | reading_urad     actual − commanded, tool as seen from the work
u_um | u_urad           standard uncertainty, if known
tool_x_mm, tool_y_mm, tool_z_mm   point of measurement from the frame of the last axis that carries the tool
run                     what was measured in one go
NAME_degC, NAME_rpm     signals, under NAME
"""

import csv
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.chain import AxisKind, Chain
from trueloop.machine.model import State
from trueloop.machine.names import COMPONENTS
from trueloop.machine.observations import Observations

READING: Final = {"reading_um": 1e-3, "reading_mm": 1.0, "reading_urad": 1e-6}
UNCERTAINTY: Final = {"u_um": 1e-3, "u_mm": 1.0, "u_urad": 1e-6}
SIGNAL_UNITS: Final = ("_degC", "_rpm")
WRONG_UNITS: Final = ("_in", "_degF", "_inch", "_ft")
WAYS: Final = {"+": 1.0, "-": -1.0, "−": -1.0, "1": 1.0, "-1": -1.0, "": 0.0, "0": 0.0, "+1": 1.0}

Rows = list[tuple[int, dict[str, str]]]


def read_readings(path: Path, chain: Chain) -> Observations:
    """Readings of a file in its order. Raises MCH-FILE, MCH-UNIT (other units, or two of one kind) and MCH-AXIS."""
    rows = _rows(path)
    header = list(rows[0][1])
    _check_units(header, path)
    count = len(rows)
    positions = {
        axis: _column(rows, name, path) * scale
        for axis, name, scale in (_position_column(chain, axis) for axis in chain.order)
        if name in header
    }
    for name in header:
        if name.endswith(("_mm", "_deg")) and len(name.split("_")[0]) == 1 and name[0].isupper():
            chain.axis(name[0])
    state = State(
        np.broadcast_to(chain.positions(positions), (count, len(chain.order))),
        np.stack([_ways(rows, f"travel_{name}", path) for name in chain.order], axis=-1),
        {n[: -len(u)]: _column(rows, n, path) for n in header for u in SIGNAL_UNITS if n.endswith(u)},
        np.stack([_optional(rows, f"tool_{c}_mm", path, 0.0) for c in "xyz"], axis=-1),
    )
    reading = next(name for name in READING if name in header)
    uncertainty = next((name for name in UNCERTAINTY if name in header), None)
    along, is_angle = _along(rows, header, path)
    if is_angle.any() != (reading == "reading_urad") or (is_angle.any() and not is_angle.all()):
        raise _unit(path, f"{int(is_angle.sum())} of {count} rows are rotations, but the readings are in {reading}")
    return Observations(
        state,
        along,
        _column(rows, reading, path) * READING[reading],
        is_angle,
        _column(rows, uncertainty, path) * UNCERTAINTY[uncertainty] if uncertainty else np.full(count, np.nan),
        tuple((row.get("run") or path.stem).strip() for _, row in rows),
        np.array([line for line, _ in rows]),
    )


def _position_column(chain: Chain, axis: str) -> tuple[str, str, float]:
    if chain.axis(axis).kind is AxisKind.ROTARY:
        return axis, f"{axis}_deg", math.pi / 180
    return axis, f"{axis}_mm", 1.0


def _rows(path: Path) -> Rows:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise _wrong(path, 0, str(error)) from error
    kept = [(k + 1, line) for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    if len(kept) < 2:
        raise _wrong(path, 0, f"it has {len(kept)} rows")
    cells = list(csv.reader(line for _, line in kept))
    header = [cell.strip() for cell in cells[0]]
    if sum(name in header for name in READING) != 1:
        raise _unit(path, f"{sum(name in header for name in READING)} columns of {', '.join(READING)}; one is needed")
    return [(kept[k][0], dict(zip(header, row, strict=False))) for k, row in enumerate(cells) if k]


def _check_units(header: list[str], path: Path) -> None:
    wrong = [name for name in header if name.endswith(WRONG_UNITS)]
    bare = [name for name in header if name in (*"XYZABC", "reading", "u", "temperature")]
    if wrong or bare:
        raise _unit(path, f"column {(wrong + bare)[0]!r} is in a unit that is not mm, µm, µrad, °, °C, or says none")


def _along(rows: Rows, header: list[str], path: Path) -> tuple[Array, "np.ndarray[tuple[int], np.dtype[np.bool_]]"]:
    if {"along_x", "along_y", "along_z"} <= set(header):
        vectors = np.stack([_column(rows, f"along_{c}", path) for c in "xyz"], axis=-1)
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        if np.any(length == 0):
            raise _wrong(path, rows[int(np.argmin(length))][0], "a direction of length 0")
        return vectors / length, np.zeros(len(rows), dtype=bool)
    along, is_angle = np.zeros((len(rows), 3)), np.zeros(len(rows), dtype=bool)
    for k, (line, row) in enumerate(rows):
        letter = (row.get("along") or "").strip()
        if len(letter) != 1 or letter not in COMPONENTS:
            raise _wrong(path, line, f"along is {letter!r}, not one of X Y Z A B C")
        along[k, COMPONENTS.index(letter) % 3] = 1.0
        is_angle[k] = COMPONENTS.index(letter) >= 3
    return along, is_angle


def _ways(rows: Rows, name: str, path: Path) -> Array:
    texts = [(line, (row.get(name) or "").strip()) for line, row in rows]
    for line, text in texts:
        if text not in WAYS:
            raise _wrong(path, line, f"{name} is {text!r}, not + or -")
    return np.array([WAYS[text] for _, text in texts])


def _optional(rows: Rows, name: str, path: Path, otherwise: float) -> Array:
    return _column(rows, name, path) if name in rows[0][1] else np.full(len(rows), otherwise)


def _column(rows: Rows, name: str, path: Path) -> Array:
    return np.array([_number(row, name, line, path) for line, row in rows])


def _number(row: Mapping[str, str], name: str, line: int, path: Path) -> float:
    try:
        value = float(row.get(name) or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _wrong(path, line, f"{name} is {row.get(name)!r}, not a finite number")
    return value


def _unit(path: Path, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MCH_UNIT,
        f"{path.name!r}: {why}",
        hint="name every column with its unit: X_mm, reading_um, T1_degC; one file, one kind of reading",
        place=Place(str(path), 1),
    )


def _wrong(path: Path, line: int, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MCH_FILE,
        f"{path.name!r} line {line} cannot be read as readings: {why}",
        hint="a header such as X_mm,travel_X,along,reading_um,T1_degC and a row a reading",
        place=Place(str(path), line or None),
    )
