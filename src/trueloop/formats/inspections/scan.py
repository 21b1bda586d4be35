"""Scans: meshes (STL, PLY, OBJ) by trimesh, and clouds of points in columns of text (XYZ, ASC, PTS, CSV, exports).

Columns of text are those that headings name, after `//` or `#` too; without headings the first three numbers of a line,
unless the first may count the points. Numbers have a decimal point, or a comma: in quotes where that separates columns.
"""

import csv
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, Place, TrueloopError
from trueloop.extras import install_command
from trueloop.formats.input_file import read_text, readable
from trueloop.formats.inspections.tables.header import role_of
from trueloop.formats.inspections.tables.headings import (
    LENGTH_MM,
    NORMAL,
    POINT,
    Role,
    plain,
    unit_in_heading,
    unit_named,
    unit_stated_in,
    without_unit,
)
from trueloop.formats.measurements.rows import MOST, number_of
from trueloop.units import MM_PER_INCH

MESHES: Final = frozenset((".stl", ".ply", ".obj"))
SEPARATORS: Final = (";", "\t", ",", None)
"""Between columns, in the order in which they are tried; None: blanks."""
OTHERS: Final = {b"ASTM-E57": "an E57 file", b"ISO-10303-21": "a STEP file", b"PK\x03\x04": "a ZIP archive"}
"""Files that hold neither a mesh nor columns of text, by their first bytes."""
HINT: Final = "a line a point, its coordinates in columns; gauging.columns = [1, 2, 3] names those of x, y and z"
EXPORT: Final = "export the scan as PLY or STL, or as text with a line a point (XYZ)"
STL_HEAD: Final = 84
STL_FACET: Final = 50
"""Bytes of a binary STL before its facets, the last four their count, and of each."""
MARKS: Final = re.compile(r"^\s*(?://|#)+\s*")


@dataclass(frozen=True, eq=False)
class Scan:
    """Points (n, 3) in mm, their normals (n, 3), unit vectors, and their lines (n,) where the file has them.

    `rounding_mm` is how far a point may be from where it was measured because its coordinates have few decimals.
    """

    points_mm: Array
    normal: Array | None
    lines: Integers | None
    rounding_mm: float = 0.0


def is_scan(path: Path) -> bool:
    """Returns whether a file is a mesh, or text whose first line that is not a comment does not name `x_mm`."""
    if path.suffix.lower() in MESHES:
        return True
    with readable(path, Code.SRF_FILE, hint="name the scan"), path.open("rb") as file:
        head = file.read(max(map(len, OTHERS)))
    for begins, kind in OTHERS.items():
        if head.startswith(begins):
            raise _refusal(path, f"{path.name!r} is {kind}: 0 points are read of it", hint=EXPORT)
    lines = read_text(path, Code.SRF_FILE, hint=HINT).splitlines()
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "x_mm")
    return ("x_mm" not in first.lower() or MARKS.match(first) is not None) and bool(_cells_of_data(lines))


def read_scan(path: Path, mm_per_unit: float | None, columns: Sequence[int] | None = None) -> Scan:
    """Reads the points of a scan; `columns`, from 1, of x, y, z in a text.

    Raises SRF-FILE with the line for anything that is not a number, where it is not certain which columns are x, y and
    z, for a mesh that cannot be read; SRF-UNIT where neither headings nor job state the unit, or the two contradict
    each other.
    """
    if path.suffix.lower() in MESHES:
        return _mesh(path, _known(path, mm_per_unit))
    return _cloud(path, mm_per_unit, columns)


def _known(path: Path, mm_per_unit: float | None) -> float:
    if mm_per_unit is None:
        raise Code.SRF_UNIT.refusal(
            f"{path.name!r} states no unit: its numbers may be mm (1 mm) or inch (25.4 mm)",
            hint='state it in the job: gauging.unit = "mm", or "inch"',
            place=Place(str(path)),
            values={"part": path.stem},
        )
    return mm_per_unit


def _mesh(path: Path, mm_per_unit: float) -> Scan:
    try:
        import trimesh  # optional, and slow to import
    except ImportError:
        raise Code.SRF_FILE.refusal(
            f"{path.name!r}: files {', '.join(sorted(MESHES))} need trimesh, which is not installed",
            hint=install_command("scans"),
            place=Place(str(path)),
        ) from None
    with readable(path, Code.SRF_FILE, hint="name the scan"):
        content = path.read_bytes()
    if path.suffix.lower() == ".stl" and not content.lstrip().startswith(b"solid"):
        facets, there = int.from_bytes(content[STL_HEAD - 4 : STL_HEAD], "little"), len(content) - STL_HEAD
        if 0 <= there < facets * STL_FACET:
            why = f"{path.name!r} is cut short: it holds {there // STL_FACET} of its {facets} facets"
            raise _refusal(path, why, hint="copy it again, or export the scan again")
    try:
        loaded: Any = trimesh.load(path, process=True, skip_materials=True)
        mesh: Any = loaded.to_geometry() if isinstance(loaded, trimesh.Scene) else loaded
        points = np.asarray(mesh.vertices, float).reshape(-1, 3) * mm_per_unit
        normal = np.asarray(mesh.vertex_normals, float) if isinstance(mesh, trimesh.Trimesh) and len(points) else None
    except Exception as error:
        raise _refusal(path, f"{path.name!r} cannot be read as {path.suffix[1:].upper()}: {error}") from error
    if not len(points) or not np.all(np.abs(points) <= MOST):
        wrong = "0 points" if not len(points) else f"coordinates that are no numbers, or beyond ±{MOST:g}"
        raise _refusal(path, f"{path.name!r} holds {wrong}")
    return Scan(points, normal, None)


def _refusal(path: Path, why: str, line: int | None = None, hint: str = "export the scan again") -> TrueloopError:
    return Code.SRF_FILE.refusal(why, hint=hint, place=Place(str(path), line))


def _cells(line: str, separator: str | None) -> list[str]:
    """Returns the cells of a line, their commas as decimal points: those that do not separate columns."""
    return [cell.replace(",", ".") for cell in _split(line, separator)]


def _split(line: str, separator: str | None) -> list[str]:
    """Returns the cells of a line without their quotes, and without empty ones at its end."""
    if separator is None:
        return [cell.strip('"') for cell in line.split()]
    try:
        (cells,) = csv.reader([line], delimiter=separator, skipinitialspace=True)
    except (csv.Error, ValueError):  # longer than a cell may be, or empty
        return []
    cells = [cell.strip() for cell in cells]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _numbers(cells: Sequence[str]) -> list[int]:
    """Returns which cells are numbers."""
    return [k for k, cell in enumerate(cells) if number_of(cell) == number_of(cell)]


def _separated(line: str) -> tuple[str | None, list[str]] | None:
    """Returns separator and cells of a line with three numbers at least, which are half of its cells."""
    for separator in SEPARATORS:
        cells = _cells(line, separator)
        if len(found := _numbers(cells)) >= len(POINT) and 2 * len(found) >= len(cells):
            return separator, cells
    return None


def _cells_of_data(lines: Sequence[str]) -> tuple[int, str | None] | None:
    """Returns index and separator of the first line of data; None without one."""
    for index, line in enumerate(lines[:1000]):
        if not MARKS.match(line) and (found := _separated(line)) is not None:
            return index, found[0]
    return None


def _cloud(path: Path, mm_per_unit: float | None, columns: Sequence[int] | None) -> Scan:
    lines = read_text(path, Code.SRF_FILE, hint=HINT).splitlines()
    begins = _cells_of_data(lines)
    if begins is None:
        raise _refusal(path, f"none of its first {min(len(lines), 1000)} lines has 3 numbers", 1, HINT)
    first, separator = begins
    kept = [(k, line) for k, line in enumerate(lines[first:], first + 1) if line.strip() and not MARKS.match(line)]
    rows = [_cells(line, separator) for _, line in kept[:1000]]
    headings = _headings(path, lines[:first], len(rows[0]), separator, columns is not None)
    where = (
        _columns(path, headings, rows, separator, first + 1) if columns is None else [column - 1 for column in columns]
    )
    units = {number: unit for number, line in enumerate(lines[:first], 1) if (unit := _stated_above(line))}
    factors = set(units.values())
    if len(factors | ({mm_per_unit} if mm_per_unit and factors else set())) > 1:
        job = "" if mm_per_unit is None else f", the job {mm_per_unit:g}"
        raise Code.SRF_UNIT.refusal(
            f"lines above the data of {path.name!r} state {', '.join(f'{one:g}' for one in factors)} mm a unit{job}",
            hint="correct gauging.unit in the job, or the file",
            place=Place(str(path), max(units)),
            values={"part": path.stem},
        )
    stated = mm_per_unit or next(iter(factors), None)
    factor = _factor(path, headings, where[: len(POINT)], len(rows[0]), stated)
    values = _values(path, kept, separator, where)
    normal = None
    if len(where) > len(POINT):
        length = np.linalg.norm(values[:, 3:], axis=1, keepdims=True)
        normal = values[:, 3:] / np.where(length > 0, length, np.nan)
    cells = [row[k] for row in rows for k in where[: len(POINT)] if k < len(row)]
    decimals = max(len(cell.partition(".")[2]) for cell in cells)
    rounding_mm = 0.5 * 10.0**-decimals * len(POINT) ** 0.5 * factor
    return Scan(values[:, :3] * factor, normal, np.array([k for k, _ in kept]), rounding_mm)


def _stated_above(line: str) -> float | None:
    """Returns mm per unit where a line that is marked as a comment states the unit of all lengths."""
    unit = unit_stated_in(line) if MARKS.match(line) else None
    return {"mm": 1.0, "inch": MM_PER_INCH, None: None}[unit]


@dataclass(frozen=True)
class _Headings:
    """The line of headings, from 1, and what it names."""

    line: int
    names: list[str]


def _headings(path: Path, above: Sequence[str], count: int, separator: str | None, stated: bool) -> _Headings | None:
    """Returns the headings: the last line above the data that names x, y and z, whatever mark it begins with.

    Where the job has `stated` the columns, any line of as many cells as the data have. Raises SRF-FILE for headings of
    which it is not certain which column each names.
    """
    for number, line in reversed(list(enumerate(above, 1))):
        text = MARKS.sub("", line)
        for other in (separator, *SEPARATORS):
            names = _named(text, other)
            if set(POINT) <= {_role(name) for name in names}:
                if len(names) != count and not stated:
                    raise _refusal(path, f"{len(names)} headings, {_listed(names)}, over {count} columns", number, HINT)
                return _Headings(number, names)
        names = _named(text, separator)
        if len(names) == count and not _numbers(names):
            if stated:
                return _Headings(number, names)
            if not MARKS.match(line):
                why = f"none of its {count} columns, {_listed(names)}, is x, y and z each"
                raise _refusal(path, why, number, HINT)
    return None


def _named(line: str, separator: str | None) -> list[str]:
    """Returns headings; at blanks a cell that is a unit belongs to the one before it: `X [mm] Y [mm]`, `X in mm`."""
    names: list[str] = []
    for cell in _split(line, separator):
        unit = unit_named(cell) if separator is None and names else ""
        if unit in LENGTH_MM:
            names[-1] = f"{names[-1].removesuffix(' [in]')} [{unit}]"
        else:
            names.append(cell)
    return names


def _listed(names: Sequence[str]) -> str:
    return ", ".join(map(repr, names[:12]))


def _factor(
    path: Path, headings: _Headings | None, where: Sequence[int], count: int, mm_per_unit: float | None
) -> float:
    """Returns mm per unit: as the headings of x, y and z have it, which are `where`, and as the job states it."""
    if headings is None:
        return _known(path, mm_per_unit)
    names = headings.names
    if len(names) == count and max(where) < count:
        names = [names[k] for k in where]
    else:
        names = [name for name in names if _role(name) in POINT]
    units = [unit for unit in map(unit_in_heading, names) if unit in LENGTH_MM]
    factors = {LENGTH_MM[unit] for unit in units}
    if len(factors | {mm_per_unit or factor for factor in factors}) > 1:
        job = "no unit" if mm_per_unit is None else f"{mm_per_unit:g} mm a unit"
        raise Code.SRF_UNIT.refusal(
            f"the headings {_listed(names)} of {path.name!r} state {', '.join(dict.fromkeys(units))}, the job {job}",
            hint="correct what is wrong: a heading, or gauging.unit in the job",
            place=Place(str(path), headings.line),
            values={"part": path.stem},
        )
    return factors.pop() if len(units) == len(names) == len(POINT) else _known(path, mm_per_unit)


def _role(heading: str) -> Role | None:
    found = role_of(plain(without_unit(heading)), ())
    return None if found is None else found[0]


def _columns(
    path: Path, headings: _Headings | None, rows: Sequence[Sequence[str]], separator: str | None, line: int
) -> list[int]:
    """Returns the columns of x, y, z and, where headings name them, of the normal, from 0.

    Without headings the first three numbers. Raises SRF-FILE, with the first line of the data, where there are more and
    the first may count the points, or commas may be decimal ones.
    """
    if headings is None:
        numbers = _numbers(rows[0])
        if len(numbers) > len(POINT):
            x, y, z, beyond = (k + 1 for k in numbers[: len(POINT) + 1])
            if _may_count([row[numbers[0]] for row in rows if len(row) > numbers[0]]):
                why = f"without headings, column {x} may be x, or count the points: it has whole numbers alone"
                hint = f"gauging.columns = [{x}, {y}, {z}] in the job, or [{y}, {z}, {beyond}]"
                raise _refusal(path, why, line, hint)
            if separator == "," and not any("." in cell for row in rows for cell in row):
                why = f"its commas may separate {len(numbers)} columns, or be decimal ones: no number has a point"
                raise _refusal(path, why, line, f"{HINT}, where commas separate columns")
        return numbers[: len(POINT)]
    roles = [_role(name) for name in headings.names]
    for role in POINT:
        if roles.count(role) > 1:
            raise _refusal(path, f"{roles.count(role)} columns are named {role.value}", headings.line, HINT)
    wanted = (*POINT, *NORMAL) if set(NORMAL) <= set(roles) else POINT
    return [roles.index(role) for role in wanted]


def _may_count(cells: Sequence[str]) -> bool:
    """Returns whether cells may be the numbers of points: whole, the first ones all different."""
    first = cells[:3]
    return all(re.fullmatch(r"\d+", cell) for cell in cells) and len(set(first)) == len(first) > 1


def _values(path: Path, kept: Sequence[tuple[int, str]], separator: str | None, where: Sequence[int]) -> Array:
    """Returns columns (n, k) of numbers. Raises SRF-FILE with the line."""
    texts = [line if separator == "," else line.replace(",", ".") for _, line in kept]
    values = np.empty((0, len(where)))
    mixed = separator != "," and any("," in line for _, line in kept) and any("." in line for _, line in kept)
    if not mixed:
        with suppress(ValueError):
            values = np.loadtxt(texts, delimiter=separator, usecols=where, comments=None, ndmin=2, quotechar='"')
    if len(values) != len(kept):
        values = np.full((len(kept), len(where)), np.nan)
        marks: set[str] = set()
        for row, (at, text) in enumerate(kept):
            cells = _split(text, separator)
            if len(cells) <= max(where):
                break
            used = [cells[k] for k in where]
            marks |= {mark for mark in ".," for cell in used if mark in cell}
            if len(marks) > 1:
                why = f"up to {text.strip()[:60]!r}, some numbers have a decimal point and some a comma"
                raise _refusal(path, why, at, "a comma of thousands, or two files in one? export the scan again")
            values[row] = [number_of(cell.replace(",", ".")) for cell in used]
    wrong = np.flatnonzero(~np.all(np.abs(values) <= MOST, axis=1))
    if len(wrong):
        line, text = kept[int(wrong[0])]
        named = ", ".join(str(k + 1) for k in where)
        why = f"{text.strip()[:60]!r} has no number in each of the columns {named}"
        raise _refusal(path, why, line, "take the line out, or name the columns: gauging.columns in the job")
    return np.asarray(values, float)
