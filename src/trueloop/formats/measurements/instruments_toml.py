"""A readings file as TOML: instruments' own files, and what those do not hold.

[[readings]]
file = "laser_x.rtl"              # beside this file
at = { X = 0, Y = 150, Z = -80 }  # machine coordinates, mm and °: of the moved axis at target 0, of a circle's centre,
                                  # of a log's zero
tool_mm = [0, 0, -120]            # point of measurement from the frame of the last axis that carries the tool
u_um = 0.3                        # standard uncertainty of a reading; left out: not known
signals = { T1 = 21.5 }           # temperatures and speeds during it

length = "calibrated"             # of a ball bar, or "unknown"
centre = "unknown"                # of its circle, or "known"

unit = "mm"                       # of a log of touches, or "inch"
ball_radius_mm = 12.7             # of the sphere
stylus_radius_mm = 2.9985         # effective: with the pre-travel
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

import numpy as np
from pydantic import Field

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.measurements.instrument_files import ROTARY, LaserFile, TouchLog, places, read_instrument
from trueloop.formats.toml_tables import Finite, MeasuringUm, Positive, Table, Vector, read_located
from trueloop.machine.circular import Circle
from trueloop.machine.identify.observations import Observations, joined
from trueloop.machine.model.chain import AxisKind, Chain
from trueloop.machine.model.kinematics import tool_in_work_mm
from trueloop.machine.model.model import State
from trueloop.units import MM_PER_INCH, UM_PER_MM

SUFFIX: Final = ".toml"
"""A file of readings with this ending names instruments' files."""

HINT: Final = "docs/machine.md shows every key of a readings file"


class InstrumentTable(Table):
    """One instrument's file, and what it does not hold."""

    file: str
    """The instrument's file, beside this one."""
    at: dict[str, Finite] | None = None
    """Machine coordinates, mm and °: of the moved axis at target 0, of a circle's centre, of a log's zero; and of every
    other axis."""
    tool_mm: Vector | None = None
    """Point of measurement from the frame of the last axis that carries the tool."""
    u_um: MeasuringUm | None = None
    """Standard uncertainty of a reading; left out, it is not known."""
    signals: dict[str, Finite] = Field(default_factory=dict)
    """Temperatures and speeds during it, by the names of the model's signals."""
    length: Literal["calibrated", "unknown"] | None = None
    """Length of a ball bar: only a calibrated bar measures scales, another one their difference."""
    centre: Literal["known", "unknown"] | None = None
    """Centre of a ball bar's circle: `at` itself, or only near it."""
    unit: Literal["mm", "inch"] | None = None
    """Unit of a log of touches."""
    ball_radius_mm: Positive | None = None
    """Radius of the sphere that was touched."""
    stylus_radius_mm: Positive | None = None
    """Effective radius of the stylus, with its pre-travel."""


class ReadingsFile(Table):
    """Instruments' files of one calibration."""

    readings: tuple[InstrumentTable, ...] = Field(min_length=1)


NEEDED: Final = {
    "at": "machine coordinates of {at}, and of every other axis: at = {{ X = 0, Y = 150, Z = -80 }}",
    "tool_mm": "point of measurement from the frame of the last axis that carries the tool: tool_mm = [0, 0, -120]",
    "length": 'length of the bar: length = "calibrated", or "unknown"',
    "centre": 'centre of the circle: centre = "unknown", or "known" where `at` is measured',
    "unit": 'unit of the log: unit = "mm", or "inch"',
    "ball_radius_mm": "radius of the sphere: ball_radius_mm = 12.7",
    "stylus_radius_mm": "effective radius of the stylus: stylus_radius_mm = 3.0",
}
OWN_KEYS: Final[dict[type, tuple[str, ...]]] = {
    LaserFile: (),
    tuple: ("length", "centre"),
    TouchLog: ("unit", "ball_radius_mm", "stylus_radius_mm"),
}
ORIGIN: Final[dict[type, str]] = {LaserFile: "target 0", tuple: "the circle's centre", TouchLog: "the log's zero"}
KINDS: Final[dict[type, str]] = {LaserFile: "a laser's file", tuple: "a ball bar's file", TouchLog: "a log of touches"}

FURTHEST_MM: Final = 1.0
"""A ball further off than any machine's error: the sense or the line of a rotary axis is another."""


def refuse_alone(path: Path) -> None:
    """Raises MCH-FILE for an instrument's own file that no readings file describes."""
    found = read_instrument(path)
    if found is None:
        return
    raise Code.MCH_FILE.refusal(
        f"{path.name!r} is {KINDS[type(found)]}: where the machine stood is not in it, 0 of its "
        f"{len(OWN_KEYS[type(found)]) + 2} keys are given",
        hint="write a readings file, readings.toml: [[readings]], file = "
        f'"{path.name}", at = …, {", ".join(["tool_mm = …", *(f"{key} = …" for key in OWN_KEYS[type(found)])])}',
        place=Place(str(path)),
    )


def read_instruments(path: Path, chain: Chain) -> Observations:
    """Readings of every file that a readings file names. Raises MCH-FILE, MCH-AXIS, MCH-UNIT, MCH-DATA, MCH-SIGNAL."""
    file = read_located(path, ReadingsFile, Code.MCH_FILE, hint=HINT)
    found = []
    for k, table in enumerate(file.model.readings):
        source = path.parent / table.file
        with file.at("readings", k):
            content = read_instrument(source)
            if content is None:
                why = f"{table.file!r} is of an unknown kind; kinds of file are: {', '.join(KINDS.values())}"
                raise Code.MCH_FILE.refusal(why, hint="readings as CSV are given beside this file")
            _require_keys(table, content, chain)
        with in_file(source):
            found.append(_observations(table, content, chain, source.stem))
    with in_file(path):
        return joined(found)


def files_of(path: Path) -> list[Path]:
    """Returns a file of readings, and the instruments' files that it names. Raises MCH-FILE."""
    if path.suffix != SUFFIX:
        return [path]
    named = read_located(path, ReadingsFile, Code.MCH_FILE, hint=HINT).model.readings
    return [path, *(path.parent / table.file for table in named)]


def _require_keys(table: InstrumentTable, content: object, chain: Chain) -> None:
    """Raises MCH-FILE for a key that is missing, or is of another kind of file."""
    kind = type(content)
    needed = ("at", "tool_mm", *OWN_KEYS[kind])
    for key, meaning in NEEDED.items():
        if (getattr(table, key) is None) == (key in needed):
            what = "needs the key" if key in needed else "has no use for the key"
            hint = meaning.format(at=ORIGIN[kind]) if key in needed else "take it out: it would be ignored"
            why = f"{table.file!r}, {KINDS[kind]}, {what} {key!r}: {len(needed)} keys are its own"
            raise Code.MCH_FILE.refusal(why, hint=hint)
    at = table.at or {}
    for name in at:
        chain.axis(name)
    axes = [name for name in chain.order if not (kind is TouchLog and name in ROTARY)]
    if set(at) != set(axes):
        wrong = sorted(set(at) ^ set(axes))
        raise Code.MCH_FILE.refusal(
            f"{table.file!r}: 'at' has to name {' '.join(axes)}, {len(wrong)} differ: {' '.join(wrong)}",
            hint="a log of touches holds the rotary axes itself" if kind is TouchLog else "mm, and ° of rotary axes",
        )


def _observations(table: InstrumentTable, content: object, chain: Chain, stem: str) -> Observations:
    if isinstance(content, LaserFile):
        return _laser(table, content, chain, stem)
    if isinstance(content, TouchLog):
        return _sphere(table, content, chain, stem)
    assert isinstance(content, tuple)
    return _ball_bar(table, content, chain, stem)


def _laser(table: InstrumentTable, laser: LaserFile, chain: Chain, stem: str) -> Observations:
    """A zero and a drift of the beam, the latter a length a run, are unknown to the whole file; of two runs alone the
    drift is not separable from the reversal and taken as 0. A run up and the one down after it are one of the fit's.
    """
    positions = _positions(table, chain, {laser.axis: laser.target_mm})
    travel = np.zeros_like(positions)
    travel[:, chain.order.index(laser.axis)] = laser.way
    ahead = _moved(positions, chain, {laser.axis: 1.0})
    both = bool(np.ptp(laser.way))
    cycles = [f"{stem} {(int(run) + 1) // 2 if both else int(run)}" for run in laser.run]
    unknown = [np.ones(len(laser.run)), laser.run - laser.run.mean()][: 2 if np.ptp(laser.run) > 1 else 1]
    along = _direction(chain, positions, ahead)
    return _made(table, (positions, travel), along, laser.deviation_mm, cycles, laser.line, np.stack(unknown, axis=1))


def _ball_bar(table: InstrumentTable, circles: tuple[Circle, ...], chain: Chain, stem: str) -> Observations:
    """Length and centre are unknown to the whole file; so is the effect of different lags of the servos, which belongs
    to the speed and not to the place: sin 2θ, the other way in the other sense.
    """
    parts = []
    for circle in circles:
        first, second = circle.plane[0], circle.plane[1]
        cosine, sine = np.cos(circle.angle_rad), np.sin(circle.angle_rad)
        centre = _positions(table, chain, {first: np.zeros(len(cosine))})
        positions = _moved(centre, chain, {first: circle.radius_mm * cosine, second: circle.radius_mm * sine})
        travel = np.zeros_like(positions)
        travel[:, chain.order.index(first)] = -circle.sense * np.sign(np.round(sine, 12))
        travel[:, chain.order.index(second)] = circle.sense * np.sign(np.round(cosine, 12))
        along = _direction(chain, centre, positions)
        unknown = [circle.sense * sine * cosine]
        unknown += [np.ones(len(cosine))] if table.length == "unknown" else []
        unknown += [cosine, sine] if table.centre == "unknown" else []
        runs, values = [f"{stem} {circle.name}"] * len(cosine), circle.deviation_mm
        parts.append(_made(table, (positions, travel), along, values, runs, circle.line, np.stack(unknown, axis=1)))
    return replace(joined(parts), unknown=np.vstack([part.unknown for part in parts]))


def _sphere(table: InstrumentTable, log: TouchLog, chain: Chain, stem: str) -> Observations:
    """Each place of the rotary axes gives the centre of the sphere, along the machine's X, Y and Z; its place on the
    work is unknown. A run are the places at which the same rotary axes stand away from the first place.
    """
    assert table.ball_radius_mm is not None and table.stylus_radius_mm is not None
    points = log.point * (MM_PER_INCH if table.unit == "inch" else 1.0)
    reach, groups = table.ball_radius_mm + table.stylus_radius_mm, list(places(log))
    _require_axes(log, chain)
    fits = [_centre(points[rows], reach, int(log.line[rows[0]])) for rows in groups]
    _check_reach(float(np.mean([off for _, _, off in fits])), table)
    first = np.array([rows[0] for rows in groups])
    centre = np.array([point for point, _, _ in fits])
    angles = {name: log.rotary_rad[first, ROTARY.index(name)] for name in ROTARY if name in chain.order}
    positions = _positions(table, chain, {**dict(zip("XYZ", centre.T, strict=True)), **angles})
    nominal = _tool(chain, positions, table)
    along = np.stack([_direction(chain, positions, _moved(positions, chain, {axis: 1.0})) for axis in "XYZ"], axis=1)
    reading = np.einsum("nki,ni->nk", along, nominal[0] - nominal)
    if (furthest := float(np.abs(reading).max())) > FURTHEST_MM:
        worst = int(np.abs(reading).max(axis=1).argmax())
        stands = " ".join(f"{name}{math.degrees(values[worst]):g}" for name, values in angles.items())
        raise Code.MCH_DATA.refusal(
            f"at {stands} the sphere lies {furthest:.4g} mm off where the machine file places it: no error is so large",
            hint="state the sense in which each rotary axis turns, [axes.C] sense, and where its line is, offset_mm; "
            "tool point control has to be off",
            place=Place(line=int(log.line[first[worst]])),
        )
    away = [[name for name, values in angles.items() if abs(values[k] - values[0]) > 1e-9] for k in range(len(first))]
    names = [f"{stem} {''.join(letters) or ''.join(angles)[-1:]}".strip() for letters in away]
    u = np.sqrt(np.array([spread for _, spread, _ in fits]))
    flat = along.reshape(-1, 3)
    return _made(
        table,
        (np.repeat(positions, 3, axis=0), np.zeros((len(flat), len(chain.order)))),
        flat,
        reading.ravel(),
        [name for name in names for _ in range(3)],
        np.repeat(log.line[first], 3),
        flat,
        u.ravel(),
    )


def _require_axes(log: TouchLog, chain: Chain) -> None:
    for name, values in zip(ROTARY, log.rotary_rad.T, strict=True):
        if values.any():
            chain.axis(name)


def _centre(points: Array, reach_mm: float, line: int) -> tuple[Array, Array, float]:
    """Returns the centre of a sphere from stylus centres (n, 3) at `reach_mm` of it, its variance along X, Y and Z for
    touches of variance 1, and by how much `reach_mm` is too small on the average.
    """
    if len(points) < 4:
        raise _no_centre(f"{len(points)} touches at a place do not determine a centre and show whether they fit", line)
    rows = np.column_stack([2 * points, np.ones(len(points))])
    centre: Array = np.linalg.lstsq(rows - rows.mean(axis=0), _about(np.sum(points**2, axis=1)), rcond=None)[0][:3]
    normal = np.empty_like(points)
    for _ in range(20):
        away = points - centre
        distance = np.linalg.norm(away, axis=1)
        normal = away / distance[:, None]
        if np.linalg.matrix_rank(normal, tol=0.1) < 3:
            raise _no_centre(f"{len(points)} touches at a place are from too few directions", line)
        centre = centre + np.linalg.lstsq(normal, distance - reach_mm, rcond=None)[0]
    rest = np.linalg.norm(points - centre, axis=1) - reach_mm
    if (off := float(np.abs(rest).max())) > TOUCH_OFF_MM:
        raise _no_centre(f"{len(points)} touches at a place are up to {off:.4g} mm off a sphere of these radii", line)
    level = np.linalg.lstsq(np.column_stack([normal, np.ones(len(points))]), rest, rcond=None)[0][3]
    return centre, np.diag(np.linalg.inv(normal.T @ normal)), float(level)


def _check_reach(off_mm: float, table: InstrumentTable) -> None:
    """Refuses radii that the touches contradict: what cancels in X and Y would be an error in Z."""
    if abs(off_mm) > REACH_OFF_MM:
        assert table.stylus_radius_mm is not None
        raise Code.MCH_DATA.refusal(
            f"touches show ball_radius_mm + stylus_radius_mm to be {UM_PER_MM * off_mm:+.1f} µm larger",
            hint=f"with this sphere the stylus' effective radius is {table.stylus_radius_mm + off_mm:.4f} mm",
        )


TOUCH_OFF_MM: Final = 0.1
"""A touch further off the sphere than any probe errs: a radius, or the unit, is another."""


REACH_OFF_MM: Final = 0.002
"""Difference of the radii from those that the touches show, from which they are refused."""


def _about(values: Array) -> Array:
    centred: Array = values - values.mean()
    return centred


def _no_centre(why: str, line: int) -> TrueloopError:
    hint = "look at ball_radius_mm, stylus_radius_mm and unit; a place wants touches from X, Y and Z, five in all"
    return Code.MCH_DATA.refusal(why, hint=hint, place=Place(line=line))


def _positions(table: InstrumentTable, chain: Chain, moved: Mapping[str, Array]) -> Array:
    """Returns positions (n, axes), mm and rad: `at`, to which the moved linear axes add."""
    rotary = {axis.name for axis in chain.axes if axis.kind is AxisKind.ROTARY}
    at: dict[str, Array | float] = {
        name: math.radians(value) if name in rotary else value for name, value in (table.at or {}).items()
    }
    return chain.positions({**at, **{name: at.get(name, 0.0) + values for name, values in moved.items()}})


def _moved(positions: Array, chain: Chain, by: Mapping[str, Array | float]) -> Array:
    found = positions.copy()
    for name, length in by.items():
        found[:, chain.order.index(chain.axis(name).name)] += length
    return found


def _direction(chain: Chain, start: Array, end: Array) -> Array:
    """Returns unit vectors (n, 3) of the tool's way from one position to another, as seen from the work."""
    way = tool_in_work_mm(chain, end, np.zeros(3)) - tool_in_work_mm(chain, start, np.zeros(3))
    along: Array = way / np.linalg.norm(way, axis=1, keepdims=True)
    return along


def _tool(chain: Chain, positions: Array, table: InstrumentTable) -> Array:
    return tool_in_work_mm(chain, positions, np.array(table.tool_mm))


def _made(
    table: InstrumentTable,
    state: tuple[Array, Array],
    along: Array,
    reading: Array,
    run: list[str],
    line: Integers,
    unknown: Array,
    spread: Array | float = 1.0,
) -> Observations:
    count = len(reading)
    signals = {name: np.full(count, value) for name, value in table.signals.items()}
    u = np.full(count, np.nan if table.u_um is None else table.u_um / UM_PER_MM) * spread
    tool = np.broadcast_to(np.array(table.tool_mm), (count, 3))
    return Observations(
        state=State(*state, signals, tool),
        along=along,
        reading=reading,
        is_angle=np.zeros(count, dtype=bool),
        standard_u=u,
        run=tuple(run),
        line=line.astype(np.intp),
        own_zero=np.zeros(count, dtype=bool),
        own_slope=np.zeros(count, dtype=bool),
        unknown=unknown,
    )
