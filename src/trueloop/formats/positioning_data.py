"""Bidirectional positioning tests: CSV, and the assignments that ecmc's measuring scripts write.

CSV: `target_mm,approach,cycle,actual_mm` (or `target_deg`, `actual_deg`), approach `up` or `down`.
Assignments: `TGT_DATA[i]=…`, `REF_DATA_FWD[i,cycle]=…`, `REF_DATA_BWD[i,cycle]=…`, `UNIT=mm`.
"""

import csv
import re
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text
from trueloop.geometry.feature import Array
from trueloop.machine.positioning import Positioning, positioning
from trueloop.units import MM_PER_INCH

Table = dict[tuple[int, int], float]
SCALE: Final = {"mm": 1.0, "um": 1e-3, "in": MM_PER_INCH, "deg": float(np.pi / 180)}
HINT: Final = "CSV with target_mm,approach,cycle,actual_mm, or TGT_DATA/REF_DATA assignments"
_ASSIGNMENT: Final = re.compile(r"^\s*(TGT_DATA|REF_DATA_FWD|REF_DATA_BWD|UNIT)\s*(?:\[([\d, ]+)\])?\s*=\s*(\S+)\s*$")


def read_positioning(path: Path) -> Positioning:
    """Reads and analyses either format. Raises MCH-FILE for what cannot be read, MCH-DATA for an incomplete test."""
    text = read_text(path, Code.MCH_FILE, hint=HINT)
    with in_file(path):
        unit, targets, up, down = _assignments(text, path) if "TGT_DATA" in text else _csv(text, path)
        order = sorted(targets)
        target = np.array([targets[k] for k in order])
        return positioning(target, _rows(up, order, target), _rows(down, order, target), angular=unit == "deg")


def _assignments(text: str, path: Path) -> tuple[str, dict[int, float], Table, Table]:
    targets: dict[int, float] = {}
    tables: dict[str, Table] = {"REF_DATA_FWD": {}, "REF_DATA_BWD": {}}
    unit = "mm"
    for number, line in enumerate(text.splitlines(), 1):
        found = _ASSIGNMENT.match(line)
        if found is None:
            continue
        name, index, value = found.groups()
        if name == "UNIT":
            unit = value
            continue
        keys = [int(k) for k in (index or "").split(",") if k.strip()]
        if len(keys) != (1 if name == "TGT_DATA" else 2):
            raise _unreadable(path, number, f"{name} with {len(keys)} indices")
        if name == "TGT_DATA":
            targets[keys[0]] = _number(value, path, number)
        else:
            tables[name][keys[0], keys[1]] = _number(value, path, number)
    scale = _scale(unit, path)
    targets = {key: scale * value for key, value in targets.items()}
    up, down = ({key: scale * value for key, value in tables[name].items()} for name in tables)
    return unit, targets, up, down


def _csv(text: str, path: Path) -> tuple[str, dict[int, float], Table, Table]:
    rows = list(csv.reader(line for line in text.splitlines() if line.strip() and not line.startswith("#")))
    header = [cell.strip() for cell in rows[0]] if rows else []
    units = [cell.removeprefix("target_") for cell in header if cell.startswith("target_")]
    wanted = ["approach", "cycle", *(f"{kind}_{unit}" for unit in units for kind in ("target", "actual"))]
    if len(units) != 1 or not set(wanted) <= set(header):
        raise _unreadable(path, 1, f"the header {header} is not target, approach, cycle and actual in one unit")
    scale = _scale(units[0], path)
    targets: dict[int, float] = {}
    tables: dict[str, Table] = {"up": {}, "down": {}}
    for number, row in enumerate(rows[1:], 2):
        cells = dict(zip(header, row, strict=False))
        target = scale * _number(cells.get(f"target_{units[0]}", ""), path, number)
        key = round(target * 1e6)
        targets[key] = target
        approach = cells.get("approach", "").strip()
        if approach not in tables:
            raise _unreadable(path, number, f"approach {approach!r} is neither up nor down")
        cycle = int(_number(cells.get("cycle", ""), path, number))
        tables[approach][key, cycle] = scale * _number(cells.get(f"actual_{units[0]}", ""), path, number)
    return units[0], targets, tables["up"], tables["down"]


def _rows(actual: Table, order: list[int], target: Array) -> Array:
    cycles = sorted({cycle for _, cycle in actual})
    table = np.array([[actual.get((key, cycle), np.nan) for cycle in cycles] for key in order])
    deviation: Array = table.reshape(len(order), len(cycles)) - target[:, None]
    return deviation


def _scale(unit: str, path: Path) -> float:
    if unit not in SCALE:
        raise TrueloopError(
            Code.MCH_UNIT,
            f"unit {unit!r} is not one of the {len(SCALE)} known: {', '.join(SCALE)}",
            hint="name the unit of targets and readings, the same for both",
            place=Place(str(path)),
        )
    return SCALE[unit]


def _number(text: str, path: Path, line: int) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise _unreadable(path, line, f"{text!r} is no finite number")
    return value


def _unreadable(path: Path, line: int, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MCH_FILE,
        f"{path.name!r} line {line} cannot be read as a positioning test: {why}",
        hint=HINT,
        place=Place(str(path), line or None),
    )
