"""Files as instruments write them: a laser's `.rtl`, a ball bar's CSV, touches of a sphere as a control logs them.

Signs: a laser's deviation is position reached − target, positive where the axis travelled too far; a ball bar's is
length − nominal radius, positive where the tool is too far from the centre; a touch is where the stylus ball's centre
stood. None of them holds where the machine's other axes stood: `instruments_toml.py` reads that.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_input
from trueloop.formats.measurements.positioning_data import require_plausible
from trueloop.formats.measurements.rows import KIND, MOST, CsvFile, csv_of, number_of
from trueloop.machine.circular import Circle
from trueloop.units import UM_PER_MM

Lines = NDArray[np.intp]

HINT: Final = "a laser's .rtl, a ball bar's CSV with angle_deg, or nine coordinates a touch"
LOG_COLUMNS: Final = 9
"""X Y Z A B C U V W of LinuxCNC's PROBEOPEN."""

SECTIONS: Final = re.compile(r"\s*([A-Z][A-Z -]*)::\s*")
ROTARY: Final = "ABC"


@dataclass(frozen=True)
class LaserFile:
    """Deviations (n,) in mm along the axis at targets in mm, `run` from 1 and the way (1, −1) of each."""

    axis: str
    target_mm: Array
    deviation_mm: Array
    run: Lines
    way: Array
    line: Lines


@dataclass(frozen=True)
class TouchLog:
    """Centres of the stylus ball at touches (n, 3) in the log's unit, and A, B, C (n, 3) there in rad."""

    point: Array
    rotary_rad: Array
    line: Lines


def read_instrument(path: Path) -> LaserFile | tuple[Circle, ...] | TouchLog | None:
    """Returns what the file holds, None for one that no instrument wrote. Raises MCH-FILE and MCH-UNIT."""
    text = read_input(path, Code.MCH_FILE, hint=HINT).decode("utf-8-sig", "replace")
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    first = lines[0][1] if lines else ""
    if first.upper().startswith("HEADER::"):
        return _laser(path, lines)
    if "angle_deg" in first and "deviation" in first:
        return _circles(csv_of(text, path, KIND))
    if len(numbers := first.split()) == LOG_COLUMNS and not np.isnan([number_of(one) for one in numbers]).any():
        return _touches(path, lines)
    return None


def read_circles(path: Path, unit: str | None = None) -> tuple[Circle, ...]:
    """Returns the circles of a ball bar's file; `unit`, mm or um, counts in place of that of the deviations' heading.

    Raises MCH-FILE, also for another file, and MCH-UNIT, also for deviations that are not plausible in their unit.
    """
    found = read_instrument(path)
    if not isinstance(found, tuple):
        columns = ", ".join((*OTHERS[3:], *UNITS))
        raise _unreadable(path, 1, f"{path.name!r} is not a ball bar's file: its header lacks some of {columns}")
    file = csv_of(read_input(path, Code.MCH_FILE, hint=HINT).decode("utf-8-sig", "replace"), path, KIND)
    heading = next(name for name in UNITS if name in file.header)
    if unit is not None:
        scale = UNITS[f"deviation_{unit}"] / UNITS[heading]
        return tuple(replace(circle, deviation_mm=scale * circle.deviation_mm) for circle in found)
    if "radius_measured_mm" not in file.header:
        scales = {name.removeprefix("deviation_"): scale for name, scale in UNITS.items()}
        values = np.concatenate([circle.deviation_mm for circle in found]) / UNITS[heading]
        with in_file(path):
            require_plausible(values, heading.removeprefix("deviation_"), scales)
    return found


def _laser(path: Path, lines: list[tuple[int, str]]) -> LaserFile:
    section, keys, targets, rows = "", dict[str, str](), list[float](), list[tuple[int, list[float]]]()
    for number, line in lines:
        if heading := SECTIONS.fullmatch(line):
            section = heading[1]
        elif section == "DEVIATIONS" and not line.startswith("Run Target"):
            rows.append((number, _numbers(path, number, line, 3)))
        elif section == "TARGET DATA" and ":" not in line:
            targets += _numbers(path, number, line)
        else:
            name, _, value = line.partition(":")
            keys.setdefault(name.strip().lower(), value.strip())
    if keys.get("owner", "").lower() != "linear":
        raise _unreadable(path, 1, f"a laser's file of the kind {keys.get('owner', '')!r}: only Linear is read")
    axis = keys.get("axis", "").upper()
    if axis not in ("X", "Y", "Z", "U", "V", "W"):
        raise _unreadable(path, 1, f"Axis is {axis!r}, not the letter of a linear axis")
    if len(targets) != number_of(keys.get("target-count", "")) or not rows:
        counted = f"{len(targets)} targets where Target-count is {keys.get('target-count')}, {len(rows)} deviations"
        raise _unreadable(path, 1, counted)
    flags = keys.get("flags", "").split()
    one_way = len(flags) > 1 and flags[1] == "1"
    table = np.array([row for _, row in rows])
    run, place = table[:, 0].astype(np.intp), table[:, 1].astype(np.intp) - 1
    if (table[:, :2] % 1).any() or place.min() < 0 or place.max() >= len(targets):
        raise _unreadable(path, rows[0][0], f"its {len(rows)} rows are not run, target and deviation")
    kept, way = np.ones(len(rows), bool), np.ones(len(rows))
    for own in (run == one for one in np.unique(run)):
        number, at_line = int(run[own][0]), rows[int(np.flatnonzero(own)[0])][0]
        padded = not table[own, 2].any()
        if padded and not (one_way and number % 2 == 0):
            raise _unreadable(path, at_line, f"run {number}: all {np.count_nonzero(own)} deviations are 0")
        steps = np.diff(np.array(targets)[place[own]])
        if not padded and not (len(steps) and (np.all(steps > 0) or np.all(steps < 0))):
            raise _unreadable(path, at_line, f"run {number}: its {len(steps) + 1} targets do not go one way")
        kept[own], way[own] = not padded, 1.0 if padded or steps[0] > 0 else -1.0
    number_line = np.array([number for number, _ in rows], dtype=np.intp)
    at, deviation = np.array(targets)[place], table[:, 2] / UM_PER_MM
    return LaserFile(
        axis=axis,
        target_mm=at[kept],
        deviation_mm=deviation[kept],
        run=run[kept],
        way=way[kept],
        line=number_line[kept],
    )


UNITS: Final = {"deviation_mm": 1.0, "deviation_um": 1 / UM_PER_MM}
OTHERS: Final = ("timestamp", "machine_id", "operator", "test_id", "axis", "angle_deg", "radius_nominal_mm")
ROUNDING_MM: Final = 2e-5
"""Difference that writing a deviation and a length with six digits can make."""


def _circles(file: CsvFile) -> tuple[Circle, ...]:
    rows = file.rows((*OTHERS, "radius_measured_mm", *UNITS))
    given = [name for name in UNITS if name in rows.header]
    if len(given) != 1:
        raise file.refusal(f"{len(given)} of its columns are {' or '.join(UNITS)}; one is needed")
    angle, nominal = np.radians(rows.numbers("angle_deg")), rows.numbers("radius_nominal_mm")
    deviation = rows.numbers(given[0]) * UNITS[given[0]]
    if "radius_measured_mm" in rows.header:
        off = np.abs(rows.numbers("radius_measured_mm") - nominal - deviation)
        for row in np.flatnonzero(off > ROUNDING_MM)[:1]:
            why = f"{given[0]} is {off[row]:.4g} mm off radius_measured_mm − radius_nominal_mm"
            raise rows.refusal(int(row), why, given[0], "deviations are measured − nominal, in the unit of the column")
    tests, planes = np.array(rows.texts("test_id")), np.array([text.upper() for text in rows.texts("axis")])
    found = []
    for test in dict.fromkeys(tests.tolist()):
        own = np.flatnonzero(tests == test)
        turned, plane, first = np.unwrap(angle[own]), str(planes[own[0]]), int(own[0])
        steps = np.diff(turned)
        if not len(steps) or not (np.all(steps > 0) or np.all(steps < 0)):
            raise rows.refusal(first, f"test {test!r}: its {len(own)} angles do not go one way round", "angle_deg")
        if len(plane) != 2 or plane[0] == plane[1] or not set(plane) <= set("XYZ") or len(set(planes[own])) > 1:
            raise rows.refusal(first, f"test {test!r}: axis is {plane!r}, not a plane such as XY")
        if np.ptp(nominal[own]) or nominal[first] <= 0:
            raise rows.refusal(first, f"test {test!r}: radius_nominal_mm is not one positive length")
        lines = np.array(rows.lines)[own]
        circle = Circle(
            name=str(test),
            plane=plane,
            radius_mm=float(nominal[first]),
            angle_rad=turned,
            deviation_mm=deviation[own],
            line=lines,
        )
        _check_way(circle, rows.refusal(first, f"test {test!r}: its angles {_words(circle.sense)}"))
        found.append(circle)
    return tuple(found)


def _check_way(circle: Circle, refusal: TrueloopError) -> None:
    """Refuses a test whose name states the other way round: servo mismatch and backlash change their sign with it."""
    named = {"ccw": 1.0, "cw": -1.0}.get(circle.name.lower())
    if named is not None and named != circle.sense:
        raise refusal


def _words(sense: float) -> str:
    return "grow: counter-clockwise" if sense > 0 else "fall: clockwise"


def _touches(path: Path, lines: list[tuple[int, str]]) -> TouchLog:
    table = np.array([_numbers(path, number, line, LOG_COLUMNS) for number, line in lines])
    return TouchLog(table[:, :3], np.radians(table[:, 3:6]), np.array([number for number, _ in lines], dtype=np.intp))


def places(log: TouchLog) -> Iterator[NDArray[np.intp]]:
    """Yields the rows of touches that follow each other with the rotary axes at one place."""
    moved = np.flatnonzero(np.abs(np.diff(log.rotary_rad, axis=0)).max(axis=1) > 1e-9) + 1
    yield from np.split(np.arange(len(log.point)), moved)


def _numbers(path: Path, line: int, text: str, count: int | None = None) -> list[float]:
    found = [number_of(cell) for cell in text.split()]
    if (count is not None and len(found) != count) or not all(abs(one) <= MOST for one in found):
        raise _unreadable(path, line, f"{text!r} is not {count or 'some'} finite numbers")
    return found


def _unreadable(path: Path, line: int, why: str) -> TrueloopError:
    return Code.MCH_FILE.refusal(why, hint=HINT, place=Place(str(path), line))
