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
note                    anything; no other columns
time_s                  when it was read, for lags; where no history is given the rows themselves are one
"""

import math
import re
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.measured_rows import (
    Rows,
    check_columns,
    column,
    optional,
    read_rows,
    signals_in,
    wrong,
    wrong_unit,
)
from trueloop.geometry.feature import Array
from trueloop.machine.chain import Axis, AxisKind, Chain
from trueloop.machine.history import Clock, History, logged
from trueloop.machine.model import State
from trueloop.machine.names import COMPONENTS
from trueloop.machine.observations import Observations
from trueloop.machine.validity import outside

READING: Final = {"reading_um": 1e-3, "reading_mm": 1.0, "reading_urad": 1e-6}
UNCERTAINTY: Final = {"u_um": 1e-3, "u_mm": 1.0, "u_urad": 1e-6}
OTHERS: Final = (
    *("along", "along_x", "along_y", "along_z", "tool_x_mm", "tool_y_mm", "tool_z_mm"),
    *("run", "time_s", "note"),
)
POSITION: Final = re.compile(r"[A-Z]_(mm|deg)")
WAYS: Final = {"+": 1.0, "-": -1.0, "−": -1.0, "1": 1.0, "-1": -1.0, "": 0.0, "0": 0.0, "+1": 1.0}


def read_readings(path: Path, chain: Chain, history: History | None = None) -> Observations:
    """Readings of a file in its order; signals that it lacks come from `history`, on the same clock.

    Raises MCH-FILE, MCH-UNIT (other units, or two of one kind), MCH-AXIS, MCH-TRAVEL for positions beyond travel,
    MCH-HISTORY for readings outside the history.
    """
    rows = read_rows(path)
    _check_known(rows, chain, path)
    header = list(rows[0][1])
    if sum(name in header for name in READING) != 1:
        raise wrong_unit(
            path, f"{sum(name in header for name in READING)} columns of {', '.join(READING)}; one is needed"
        )
    count = len(rows)
    positions = {
        axis: column(rows, name, path) * scale
        for axis, name, scale in (_position_column(chain, axis) for axis in chain.order)
        if name in header
    }
    for axis, position in positions.items():
        _check_reach(chain.axis(axis), position, rows, path)
    clock = _clock(rows, path, history)
    state = State(
        np.broadcast_to(chain.positions(positions), (count, len(chain.order))),
        np.stack([_ways(rows, f"travel_{name}", path) for name in chain.order], axis=-1),
        (logged(clock) if history and clock else {}) | signals_in(rows, path),
        np.stack([optional(rows, f"tool_{c}_mm", path, 0.0) for c in "xyz"], axis=-1),
    )
    reading = next(name for name in READING if name in header)
    uncertainty = next((name for name in UNCERTAINTY if name in header), None)
    if uncertainty and ("rad" in uncertainty) != ("rad" in reading):
        raise wrong_unit(path, f"{count} readings are in {reading}, their standard uncertainty in {uncertainty}")
    along, is_angle = _along(rows, header, path)
    if is_angle.any() != (reading == "reading_urad") or (is_angle.any() and not is_angle.all()):
        raise wrong_unit(
            path, f"{int(is_angle.sum())} of {count} rows are rotations, but the readings are in {reading}"
        )
    return Observations(
        state,
        along,
        column(rows, reading, path) * READING[reading],
        is_angle,
        column(rows, uncertainty, path) * UNCERTAINTY[uncertainty] if uncertainty else np.full(count, np.nan),
        tuple((row.get("run") or path.stem).strip() for _, row in rows),
        np.array([line for line, _ in rows]),
        clock,
    )


def _check_known(rows: Rows, chain: Chain, path: Path) -> None:
    """Raises MCH-AXIS for positions of an axis that the machine lacks, MCH-FILE for other columns not known."""
    for name in rows[0][1]:
        if POSITION.fullmatch(name) and name[0] not in chain.order:
            with in_file(path, 1):
                chain.axis(name[0])
    axes = [name for axis in chain.order for name in (_position_column(chain, axis)[1], f"travel_{axis}")]
    check_columns(rows, [*axes, *READING, *UNCERTAINTY, *OTHERS], path)


def _check_reach(axis: Axis, position: Array, rows: Rows, path: Path) -> None:
    """Raises MCH-TRAVEL with the line."""
    beyond = np.flatnonzero(outside(position, axis.travel))
    for k in beyond[:1]:
        low, high = map(axis.shown, axis.travel)
        raise TrueloopError(
            Code.MCH_TRAVEL,
            f"{axis.name} stands at {axis.shown(position[k])}, its travel is {low} to {high}",
            hint="positions are those the control shows, in machine coordinates; travel stands in the machine file",
            place=Place(str(path), rows[k][0]),
        )


def _clock(rows: Rows, path: Path, history: History | None) -> Clock | None:
    """Without a history the rows themselves are one: several readings at a time are one row of it."""
    if "time_s" not in rows[0][1]:
        if history is not None:
            raise wrong(path, 1, f"its {len(rows)} readings have no time_s, which the history needs")
        return None
    time_s = column(rows, "time_s", path)
    if history is None:
        ascending, first = np.unique(time_s, return_index=True)
        history = History(ascending, {name: values[first] for name, values in signals_in(rows, path).items()})
    return Clock(time_s, np.zeros(len(time_s), dtype=np.intp), (history,))


def _position_column(chain: Chain, axis: str) -> tuple[str, str, float]:
    if chain.axis(axis).kind is AxisKind.ROTARY:
        return axis, f"{axis}_deg", math.pi / 180
    return axis, f"{axis}_mm", 1.0


def _along(rows: Rows, header: list[str], path: Path) -> tuple[Array, "np.ndarray[tuple[int], np.dtype[np.bool_]]"]:
    if {"along_x", "along_y", "along_z"} <= set(header):
        vectors = np.stack([column(rows, f"along_{c}", path) for c in "xyz"], axis=-1)
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        if np.any(length == 0):
            raise wrong(path, rows[int(np.argmin(length))][0], "a direction of length 0")
        return vectors / length, np.zeros(len(rows), dtype=bool)
    along, is_angle = np.zeros((len(rows), 3)), np.zeros(len(rows), dtype=bool)
    for k, (line, row) in enumerate(rows):
        letter = (row.get("along") or "").strip()
        if len(letter) != 1 or letter not in COMPONENTS:
            raise wrong(path, line, f"along is {letter!r}, not one of X Y Z A B C")
        along[k, COMPONENTS.index(letter) % 3] = 1.0
        is_angle[k] = COMPONENTS.index(letter) >= 3
    return along, is_angle


def _ways(rows: Rows, name: str, path: Path) -> Array:
    texts = [(line, (row.get(name) or "").strip()) for line, row in rows]
    for line, text in texts:
        if text not in WAYS:
            raise wrong(path, line, f"{name} is {text!r}, not + or -")
    return np.array([WAYS[text] for _, text in texts])
