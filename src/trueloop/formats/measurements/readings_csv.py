"""Characterization readings as CSV, one reading a row; columns carry their unit.

X_mm, Y_mm …, A_deg …   axis positions as commanded (X_in …); axes left out stand at 0
travel_X …              + or − (or 1, −1): the way the axis came; empty or left out: unknown
along                   X Y Z: the reading is a displacement along it; A B C: a rotation about it
along_x, along_y, along_z   instead of `along`: a direction, for instance of a ball bar from its centre to the tool
reading_um | reading_mm | reading_in | reading_urad | reading_arcsec     actual − commanded, tool as seen from the work
u_um | u_mm | u_in | u_urad | u_arcsec     standard uncertainty, if known
tool_x_mm, tool_y_mm, tool_z_mm   point of measurement from the frame of the last axis that carries the tool
run                     what was measured in one go
absolute                no (or empty, or no column): the instrument was zeroed, a straightedge laid by eye, for the run;
                        slope: against a square or the spindle, the zero alone is open; yes: nothing is;
                        length: a calibrated ball bar whose centre is open; centre: the length is open, not the centre
NAME_degC, NAME_rpm     signals, under NAME
note                    anything; no other columns
time_s                  when it was read, for lags; where no history is given the rows themselves are one
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.errors import Code, Place, in_file
from trueloop.formats.input_file import FilePath
from trueloop.formats.measurements.rows import (
    SIGNAL_UNITS,
    CsvFile,
    Rows,
    read_measured,
    signals_in,
    units_in,
    vectors,
    wrong_unit,
)
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.chain import COMPONENTS, Axis, AxisKind, Chain
from trueloop.machine.model.history import Clock, History, logged, units_of
from trueloop.machine.model.model import State
from trueloop.machine.model.validity import outside
from trueloop.units import COARSEST_U_UM, MM_PER_INCH, UM_PER_MM, URAD_PER_RAD

LENGTHS: Final = {"um": 1 / UM_PER_MM, "mm": 1.0, "in": MM_PER_INCH}
ANGLES: Final = {"urad": 1 / URAD_PER_RAD, "arcsec": math.radians(1 / 3600)}
READING: Final = {f"reading_{unit}": scale for unit, scale in (LENGTHS | ANGLES).items()}
MOST_ANGLE_U_RAD: Final = 0.01
"""Standard uncertainty of an angle above which nothing is measured: half a degree, of a protractor."""
UNCERTAINTY: Final = {f"u_{unit}": scale for unit, scale in (LENGTHS | ANGLES).items()}
ALONG: Final = ("along_x", "along_y", "along_z")
TOOL: Final = ("tool_x_mm", "tool_y_mm", "tool_z_mm")
OTHERS: Final = ("along", *ALONG, *TOOL, "run", "time_s", "absolute")
POSITION: Final = re.compile(r"[A-Z]_(mm|in|deg)")
ABSOLUTE: Final = {
    "": (True, True, False, False),
    "no": (True, True, False, False),
    "slope": (True, False, False, False),
    "yes": (False, False, False, False),
    "length": (False, False, True, False),
    "centre": (False, False, False, True),
}
"""Flags by the text of `absolute`, True where it is the run's own: zero and slope, a bar's centre alone, its length."""

WAYS: Final = {"+": 1.0, "-": -1.0, "−": -1.0, "1": 1.0, "-1": -1.0, "": 0.0, "0": 0.0, "+1": 1.0}


def read_readings(path: FilePath, chain: Chain, history: History | None = None) -> Observations:
    """Readings of a file in its order; signals that it lacks come from `history`, on the same clock.

    Raises MCH-FILE, MCH-UNIT (other units, or two of one kind), MCH-AXIS, MCH-TRAVEL for positions beyond travel,
    MCH-HISTORY for readings outside the history.

    >>> machine, _ = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> print(len(readings), readings.reading[:2], readings.state.signals["T1"][:2])  # mm
    66 [-8.00e-05  2.15e-03] [20. 20.]
    """
    path = Path(path)
    rows = _rows(read_measured(path, inches=True), chain)
    clock = _clock(rows, history)
    along, is_angle = _along(rows)
    reading, u = _readings(rows, is_angle)
    own_zero, own_slope, unknown = _own(rows, along)
    return Observations(
        state=_state(rows, chain, logged(clock) if history and clock else {}),
        along=along,
        reading=reading,
        is_angle=is_angle,
        standard_u=u,
        run=tuple(run or path.stem for run in rows.texts("run")),
        line=np.array(rows.lines),
        clock=clock,
        units={**units_of(clock), **units_in(rows)},
        own_zero=own_zero,
        own_slope=own_slope,
        unknown=unknown,
    )


def _rows(file: CsvFile, chain: Chain) -> Rows:
    """Raises MCH-AXIS for positions of an axis that the machine lacks, MCH-FILE for other columns not known."""
    for name in file.header:
        if POSITION.fullmatch(name) and name[0] not in chain.order:
            with in_file(file.path, 1):
                chain.axis(name[0])
    axes = [name for axis in chain.order for name in (*_position_columns(chain, axis), f"travel_{axis}")]
    return file.rows([*axes, *READING, *UNCERTAINTY, *OTHERS], SIGNAL_UNITS)


def _state(rows: Rows, chain: Chain, past: Mapping[str, Array]) -> State:
    """Where the axes stand, which way they came, and at which signals."""
    positions = {}
    for axis in chain.order:
        given = {name: scale for name, scale in _position_columns(chain, axis).items() if name in rows.header}
        if len(given) > 1:
            raise wrong_unit(rows.path, f"{len(given)} columns hold positions of {axis}: {' and '.join(given)}")
        for name, scale in given.items():
            positions[axis] = rows.numbers(name) * scale
            _check_reach(chain.axis(axis), positions[axis], rows)
    return State(
        np.broadcast_to(chain.positions(positions), (len(rows), len(chain.order))),
        np.stack([_ways(rows, f"travel_{name}") for name in chain.order], axis=-1),
        {**past, **signals_in(rows)},
        vectors(rows, TOOL, 0.0),
    )


def _readings(rows: Rows, is_angle: Flags) -> tuple[Array, Array]:
    """Readings and their standard uncertainties, mm or rad. Raises MCH-UNIT where lengths and angles are mixed up."""
    given = [name for name in READING if name in rows.header]
    if len(given) != 1:
        raise wrong_unit(rows.path, f"{len(given)} columns of {', '.join(READING)}; one is needed")
    reading, count = given[0], len(rows)
    uncertainties = [name for name in UNCERTAINTY if name in rows.header]
    for name in uncertainties:
        if _is_angle(name) != _is_angle(reading) or len(uncertainties) > 1:
            units = " and ".join(uncertainties)
            raise wrong_unit(rows.path, f"{count} readings are in {reading}, their standard uncertainty in {units}")
    if not np.all(is_angle == _is_angle(reading)):
        why = f"{int(is_angle.sum())} of {count} rows are rotations, but the readings are in {reading}"
        raise wrong_unit(rows.path, why)
    values = rows.numbers(reading) * READING[reading]
    if not uncertainties:
        return values, np.full(count, np.nan)
    u = rows.numbers(uncertainties[0]) * UNCERTAINTY[uncertainties[0]]
    most = MOST_ANGLE_U_RAD if _is_angle(reading) else COARSEST_U_UM / UM_PER_MM
    if np.any(u > most):
        k = int(np.argmax(u > most))
        value, limit = (1e6 * u[k], 1e6 * most) if _is_angle(reading) else (UM_PER_MM * u[k], COARSEST_U_UM)
        unit = "µrad" if _is_angle(reading) else "µm"
        raise wrong_unit(
            rows.path,
            f"line {rows.lines[k]} states a standard uncertainty of {value:g} {unit}, the limit is {limit:g} {unit}",
        )
    return values, u


def _is_angle(column: str) -> bool:
    return column.rpartition("_")[2] in ANGLES


def _check_reach(axis: Axis, position: Array, rows: Rows) -> None:
    """Raises MCH-TRAVEL with the line."""
    for k in np.flatnonzero(outside(position, axis.travel, axis.unit))[:1]:
        low, high = map(axis.shown, axis.travel)
        raise Code.MCH_TRAVEL.refusal(
            f"{axis.name} stands at {axis.shown(position[k])}, its travel is {low} to {high}",
            hint="positions are those the control shows, in machine coordinates; travel stands in the machine file",
            place=Place(str(rows.path), rows.lines[k]),
            values={"axis": axis.name, "travel": [axis.in_unit(end) for end in axis.travel], "unit": axis.unit},
        )


def _clock(rows: Rows, history: History | None) -> Clock | None:
    """Without a history the rows themselves are one: several readings at a time are one row of it."""
    if history is None and "time_s" not in rows.header:
        return None
    time_s = rows.numbers("time_s")
    if history is None:
        ascending, first = np.unique(time_s, return_index=True)
        history = History(ascending, {name: values[first] for name, values in signals_in(rows).items()}, units_in(rows))
    return Clock(time_s, np.zeros(len(time_s), dtype=np.intp), (history,))


def _position_columns(chain: Chain, axis: str) -> dict[str, float]:
    """Returns the columns that may hold an axis' positions, with their unit in mm or rad."""
    if chain.axis(axis).kind is AxisKind.ROTARY:
        return {f"{axis}_deg": math.pi / 180}
    return {f"{axis}_mm": 1.0, f"{axis}_in": MM_PER_INCH}


def _along(rows: Rows) -> tuple[Array, Flags]:
    """Unit directions, (n, 3), and which are axes of rotation."""
    if set(ALONG) <= set(rows.header):
        given = vectors(rows, ALONG)
        length = np.linalg.norm(given, axis=1, keepdims=True)
        for row in np.flatnonzero(length == 0)[:1]:
            raise rows.refusal(int(row), "a direction of length 0")
        return given / length, np.zeros(len(rows), dtype=bool)
    letters = rows.texts("along")
    for row, letter in enumerate(letters):
        if len(letter) != 1 or letter not in COMPONENTS:
            raise rows.refusal(row, f"along is {letter!r}, not one of X Y Z A B C")
    component = np.array([COMPONENTS.index(letter) for letter in letters])
    return np.eye(3)[component % 3], component >= 3


def _own(rows: Rows, along: Array) -> tuple[Flags, Flags, Array]:
    """Which readings have a zero, and which a slope, of their run's own; and each run's centre or length, (n, k)."""
    texts = rows.texts("absolute")
    for row, text in enumerate(texts):
        if text not in ABSOLUTE:
            raise rows.refusal(row, f"absolute is {text!r}, not {', '.join(filter(None, ABSOLUTE))}", "absolute")
    zero, slope, centre, length = np.array([ABSOLUTE[text] for text in texts], dtype=bool).T
    runs = np.array(rows.texts("run"))
    own = [np.zeros((len(rows), 0))]
    for flags, columns in ((centre, along), (length, np.ones((len(rows), 1)))):
        own += [np.where((flags & (runs == run))[:, None], columns, 0.0) for run in np.unique(runs[flags])]
    return zero, slope, np.hstack(own)


def _ways(rows: Rows, name: str) -> Array:
    texts = rows.texts(name)
    for row, text in enumerate(texts):
        if text not in WAYS:
            raise rows.refusal(row, f"{name} is {text!r}, not + or -", name)
    return np.array([WAYS[text] for text in texts])
