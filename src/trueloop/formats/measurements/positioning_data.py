"""Bidirectional positioning tests: CSV, and the assignments that ecmc's measuring scripts write.

CSV: `target_mm,approach,cycle,actual_mm` (or `_in`, `_deg`, each its own), approach `up` or `down`; both, or one
alone. In place of the position reached, `deviation_um` (`_mm`, `_in`; `_arcsec`, `_deg`): it less the target.
Assignments: `TGT_DATA[i]=…`, `REF_DATA_FWD[i,cycle]=…`, `REF_DATA_BWD[i,cycle]=…`, `UNIT=mm`. Each is given once.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text
from trueloop.formats.measurements.rows import MOST, CsvKind, csv_of, number_of
from trueloop.machine.standards import Plate, Positioning, positioning
from trueloop.units import MM_PER_INCH, UM_PER_MM

COLUMNS: Final = 9
PLATE_HINT: Final = "rows of nine numbers: measured x y, nominal x y, error x y, diameter, nominal diameter, form error"


def read_plate_report(path: Path) -> Plate:
    """Reads a report. Raises MCH-FILE when it holds no table of nine columns."""
    lines = read_text(path, Code.MCH_FILE, hint=PLATE_HINT).splitlines()
    rows = [row for row in (_numbers(line) for line in lines) if row is not None]
    if not rows:
        why = f"{path.name!r} cannot be read as a plate report: none of {len(lines)} lines has {COLUMNS} numbers"
        raise Code.MCH_FILE.refusal(why, hint=PLATE_HINT, place=Place(str(path)))
    table = np.array(rows)
    _, tool = np.unique(table[:, 7], return_inverse=True)
    return Plate(table[:, 2:4], table[:, 0:2], tool.astype(np.float64))


def _numbers(line: str) -> list[float] | None:
    try:
        row = [float(cell) for cell in line.split()]
    except ValueError:
        return None
    return row if len(row) == COLUMNS else None


Numbered: TypeAlias = dict[int, float]
"""Targets by what they go by: their number, or where they are."""

Table: TypeAlias = dict[tuple[int, int], float]
"""Positions reached by target and cycle."""

Test: TypeAlias = tuple[str, Numbered, Table, Table]
"""Unit, targets, positions reached from below and from above, in that unit."""

SCALE: Final = {"mm": 1.0, "um": 1 / UM_PER_MM, "in": MM_PER_INCH, "deg": float(np.pi / 180)}
ARCSECONDS: Final = {"arcsec": float(np.pi / 180 / 3600)}
HINT: Final = "CSV with target_mm,approach,cycle,actual_mm or deviation_um, or TGT_DATA/REF_DATA assignments"
KIND: Final = CsvKind(Code.MCH_FILE, Code.MCH_FILE, Code.MCH_FILE, HINT)
WAYS: Final = ("up", "down")
_BEGINNING: Final = re.compile(r"\s*(TGT_DATA|REF_DATA_FWD|REF_DATA_BWD|UNIT)\b")
_INDEX: Final = r"\[\s*(\d{1,9})\s*(?:,\s*(\d{1,9})\s*)?\]"
_ASSIGNMENT: Final = re.compile(rf"\s*(\w+)\s*(?:{_INDEX})?\s*=\s*(\S+)\s*")
_INDICES: Final = {"UNIT": 0, "TGT_DATA": 1, "REF_DATA_FWD": 2, "REF_DATA_BWD": 2}


def read_positioning(path: Path, unit: str | None = None) -> Positioning:
    """Reads and analyses either format. `unit` is that of the readings in place of the one their heading states.

    Raises MCH-FILE for what cannot be read, MCH-DATA for an incomplete test, MCH-UNIT for readings that are not
    plausible in the unit of their heading.
    """
    text = read_text(path, Code.MCH_FILE, hint=HINT)
    of_targets, targets, up, down = _assignments(text, path, unit) if "TGT_DATA" in text else _csv(text, path, unit)
    order, angular = sorted(targets), of_targets == "deg"
    target = SCALE[of_targets] * np.array([targets[key] for key in order])
    deviations = [SCALE[of_targets] * _table(actual, order) - target[:, None] for actual in (up, down)]
    with in_file(path):
        _check_size(deviations, angular)
        if unit is None and of_targets == "um" and np.ptp(target) < SHORTEST_MM:
            raise implausible(f"the targets span {np.ptp(target) * UM_PER_MM:g}", "um", ["mm"])
        return positioning(target, *deviations, angular=angular)


SHORTEST_MM: Final = 1.0
"""Targets in micrometers that span less are taken for millimetres."""
LARGEST: Final = {False: (1.0, 1.0, "mm"), True: (float(np.pi / 180), float(180 / np.pi), "°")}
"""Deviation, mm or rad, that no axis in use has: its unit is another, or it is read as a position; how it is shown."""
PLAUSIBLE: Final = {False: (0.2e-3, 0.3), True: (0.03 * np.pi / 180 / 3600, 0.1 * np.pi / 180)}
"""Between these, mm or rad, lies the largest deviation of a test: below, instruments do not resolve it."""


def require_plausible(values: Array, unit: str, scales: Mapping[str, float], angular: bool = False) -> None:
    """Refuses deviations (n,) in `unit` (MCH-UNIT) whose largest is not plausible in it, and is in another unit."""
    least, most = PLAUSIBLE[angular]
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if largest == 0.0 or least <= largest * scales[unit] <= most:
        return
    others = [other for other, scale in scales.items() if least <= largest * scale <= most]
    if others:
        raise implausible(f"the largest of {len(values)} deviations is {largest:g}", unit, others)


def implausible(what: str, unit: str, others: Sequence[str]) -> TrueloopError:
    """Returns the refusal of values that are not plausible in the unit of their heading, and are in others."""
    stated, either = SHOWN.get(unit, unit), " or ".join(SHOWN.get(other, other) for other in others)
    return Code.MCH_UNIT.refusal(
        f"{what} {stated} as the heading states: not plausible for a machine; it is in {either}",
        hint=f"state the unit of the readings: --unit {others[0]}, or --unit {unit} where the heading is right",
        override="--unit",
    )


SHOWN: Final = {"um": "µm", "in": "inch"}


def _check_size(deviations: list[Array], angular: bool) -> None:
    limit, scale, unit = LARGEST[angular]
    largest = max((float(np.nanmax(np.abs(deviation), initial=0.0)) for deviation in deviations), default=0.0)
    if largest > limit:
        raise Code.MCH_UNIT.refusal(
            f"a position reached is {scale * largest:.4g} {unit} off its target, beyond 1 {unit}",
            hint="actual_mm is the position reached; deviations stand in a column of their own, deviation_um; --unit "
            "states the unit of the readings",
        )


def _assignments(text: str, path: Path, unit: str | None) -> Test:
    found: dict[str, dict[tuple[int, ...], str]] = {name: {} for name in _INDICES}
    for number, line in enumerate(text.splitlines(), 1):
        if not (beginning := _BEGINNING.match(line)):
            continue
        assigned, name = _ASSIGNMENT.fullmatch(line), beginning[1]
        index = tuple(int(k) for k in assigned.groups()[1:3] if k) if assigned else ()
        if not assigned or len(index) != _INDICES[name] or index in found[name]:
            why = "given twice" if index in found[name] else f"not {name} with {_INDICES[name]} indices"
            raise _unreadable(path, number, f"{line.strip()!r} is {why}")
        if name != "UNIT" and not abs(number_of(assigned[4])) <= MOST:
            raise _unreadable(path, number, f"{assigned[4]!r} is no finite number")
        found[name][index] = assigned[4]
    unit = unit or found["UNIT"].get((), "mm")
    _check_unit(unit, path)
    targets = {key: float(value) for (key,), value in found["TGT_DATA"].items()}
    up, down = (
        {(key, cycle): float(value) for (key, cycle), value in found[name].items()}
        for name in ("REF_DATA_FWD", "REF_DATA_BWD")
    )
    return unit, targets, up, down


def _csv(text: str, path: Path, unit: str | None) -> Test:
    file = csv_of(text, path, KIND)
    units = [name.removeprefix("target_") for name in file.header if name.startswith("target_")]
    if len(units) != 1:
        raise file.refusal(f"{len(units)} of its {len(file.header)} columns are target_mm or the like; one is needed")
    _check_unit(units[0], path)
    target, angular = f"target_{units[0]}", units[0] == "deg"
    scales = {one: by for one, by in (SCALE | ARCSECONDS).items() if (one in ("deg", "arcsec")) == angular}
    if unit is not None and unit not in scales:
        raise file.refusal(f"--unit {unit}: {target} is in another kind of unit", None, f"one of {', '.join(scales)}")
    readings = [f"{kind}_{scale}" for kind in ("actual", "deviation") for scale in (units[0], *scales)]
    given = [name for name in dict.fromkeys(file.header) if name in readings]
    if len(given) > 1:
        raise file.refusal(f"{len(given)} of its columns are readings: {', '.join(given)}; one is needed")
    reading = given[0] if given else readings[0]
    rows = file.rows((target, "approach", "cycle", *readings))
    targets: Numbered = {}
    tables: dict[str, Table] = {way: {} for way in WAYS}
    columns = (rows.numbers(target), rows.texts("approach"), rows.numbers("cycle"), rows.numbers(reading))
    stated, deviates = reading.partition("_")[2], reading.startswith("deviation_")
    if unit is None and deviates:
        with in_file(path):
            require_plausible(columns[3], stated, scales, angular)
    alone = deviates or stated != units[0]  # positions in the unit of the targets share what `unit` states
    of_reading = scales[unit or stated] / SCALE[units[0]] if alone else 1.0
    of_target = (unit if unit in SCALE and not alone else None) or units[0]
    for row, (at, way, cycle, reached) in enumerate(zip(*columns, strict=True)):
        if way not in WAYS or cycle % 1:
            raise rows.refusal(row, f"approach {way!r}, cycle {cycle:g}: not up or down and a whole number")
        key = (round(at * SCALE[units[0]] * 1e6), int(cycle))
        if key in tables[way]:
            raise rows.refusal(row, f"target {at:g}, approach {way}, cycle {cycle:g} is given twice")
        targets[key[0]] = at
        tables[way][key] = of_reading * reached + (at if deviates else 0.0)
    return of_target, targets, tables["up"], tables["down"]


def _table(actual: Table, order: list[int]) -> Array:
    """A row a target, a column a cycle; nan where there is none."""
    cycles = sorted({cycle for _, cycle in actual})
    table: Array = np.array([[actual.get((key, cycle), np.nan) for cycle in cycles] for key in order])
    return table.reshape(len(order), len(cycles))


def _check_unit(unit: str, path: Path) -> None:
    if unit not in SCALE:
        raise Code.MCH_UNIT.refusal(
            f"unit {unit!r} is not one of the {len(SCALE)} known: {', '.join(SCALE)}",
            hint="name the unit of targets and readings, the same for both",
            place=Place(str(path)),
        )


def _unreadable(path: Path, line: int, why: str) -> TrueloopError:
    return Code.MCH_FILE.refusal(why, hint=HINT, place=Place(str(path), line))
