"""Scans: meshes (STL, PLY, OBJ) by trimesh, and clouds of points in columns of text (XYZ, ASC, PTS, CSV, exports).

Columns of text are those that headings name, before or after `//` or `#`; without headings the first three numbers of a
line, after a column that counts the lines. Numbers have a decimal point, or a comma where that separates no columns.
"""

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, Place, TrueloopError
from trueloop.extras import install_command
from trueloop.formats.input_file import read_text, readable
from trueloop.formats.inspections.tables.header import role_of
from trueloop.formats.inspections.tables.headings import plain
from trueloop.formats.inspections.tables.roles import LENGTH_MM, NORMAL, POINT, Role, unit_in_heading, without_unit
from trueloop.formats.measurements.rows import MOST, number_of

MESHES: Final = frozenset((".stl", ".ply", ".obj"))
SEPARATORS: Final = (";", "\t", ",", None)
"""Between columns, in the order in which they are tried; None: blanks."""
HINT: Final = "a line a point, its coordinates in columns; gauging.columns = [1, 2, 3] names those of x, y and z"
MARKS: Final = re.compile(r"^\s*(?://|#)+\s*")


@dataclass(frozen=True, eq=False)
class Scan:
    """Points (n, 3) in mm, their normals (n, 3), unit vectors, and their lines (n,) where the file has them."""

    points_mm: Array
    normal: Array | None
    lines: Integers | None


def is_scan(path: Path) -> bool:
    """Returns whether a file is a mesh, or text whose first line that is no comment does not name `x_mm`."""
    if path.suffix.lower() in MESHES:
        return True
    lines = read_text(path, Code.SRF_FILE, hint=HINT).splitlines()
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "x_mm")
    return ("x_mm" not in first.lower() or MARKS.match(first) is not None) and bool(_cells_of_data(lines))


def read_scan(path: Path, mm_per_unit: float | None, columns: Sequence[int] | None = None) -> Scan:
    """Reads the points of a scan; `columns`, from 1, of x, y, z in a text.

    A unit in the heading of x counts before `mm_per_unit`. Raises SRF-FILE with the line for what is no number, where
    no column is named x, for a mesh that cannot be read; SRF-UNIT where neither file nor job states the unit.
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
        path.read_bytes()
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
    cells = [cell.strip().strip('"') for cell in line.split(separator)]
    return cells if separator == "," else [cell.replace(",", ".") for cell in cells]


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
    names = _names(path, lines[:first], lines[first], separator)
    where = _columns(path, names, [_cells(line, separator) for _, line in kept[:3]], columns, first)
    unit = "" if names is None else unit_in_heading(names[where[0]])
    factor = LENGTH_MM.get(unit) or _known(path, mm_per_unit)
    values = _values(path, kept, separator, where)
    normal = None
    if len(where) > len(POINT):
        length = np.linalg.norm(values[:, 3:], axis=1, keepdims=True)
        normal = values[:, 3:] / np.where(length > 0, length, np.nan)
    return Scan(values[:, :3] * factor, normal, np.array([k for k, _ in kept]))


def _names(path: Path, above: Sequence[str], data: str, separator: str | None) -> list[str] | None:
    """Returns the headings: the last line above the data that names x, y and z, whatever mark it begins with.

    Raises SRF-FILE for headings without a mark that name them not.
    """
    for number, line in reversed(list(enumerate(above, 1))):
        cells = [cell.strip().strip('"') for cell in MARKS.sub("", line).split(separator)]
        if set(POINT) <= {_role(cell) for cell in cells}:
            return cells
        if not MARKS.match(line) and not _numbers(cells) and len(cells) == len(_cells(data, separator)):
            listed = ", ".join(map(repr, cells[:12]))
            raise _refusal(path, f"none of its {len(cells)} columns, {listed}, is x, y and z each", number, HINT)
    return None


def _role(heading: str) -> Role | None:
    found = role_of(plain(without_unit(heading)), ())
    return None if found is None else found[0]


def _columns(
    path: Path,
    names: Sequence[str] | None,
    rows: Sequence[Sequence[str]],
    stated: Sequence[int] | None,
    above: int,
) -> list[int]:
    """Returns the columns of x, y, z and, where headings name them, of the normal, from 0."""
    if stated is not None:
        return [column - 1 for column in stated]
    if names is None:
        numbers = _numbers(rows[0])
        counted = [row[numbers[0]] for row in rows]
        ids = len(rows) > 1 and len(numbers) > len(POINT) and all(cell.isdigit() for cell in counted)
        ids = ids and all(int(b) - int(a) == 1 for a, b in itertools.pairwise(counted))
        return numbers[ids : ids + len(POINT)]
    roles = [_role(name) for name in names]
    for role in POINT:
        if roles.count(role) > 1:
            raise _refusal(path, f"{roles.count(role)} columns are named {role.value}", above, HINT)
    wanted = (*POINT, *NORMAL) if set(NORMAL) <= set(roles) else POINT
    return [roles.index(role) for role in wanted]


def _values(path: Path, kept: Sequence[tuple[int, str]], separator: str | None, where: Sequence[int]) -> Array:
    """Returns columns (n, k) of numbers. Raises SRF-FILE with the line."""
    texts = [line.replace('"', "") for _, line in kept]
    texts = texts if separator == "," else [text.replace(",", ".") for text in texts]
    try:
        values = np.loadtxt(texts, delimiter=separator, usecols=where, comments=None, ndmin=2)
    except ValueError:
        values = np.full((len(texts), len(where)), np.nan)
        for row, text in enumerate(texts):
            cells = [cell.strip() for cell in text.split(separator)]
            if len(cells) <= max(where) or len({*_numbers(cells)} & {*where}) < len(where):
                break
            values[row] = [number_of(cells[k]) for k in where]
    wrong = np.flatnonzero(~np.all(np.abs(values) <= MOST, axis=1))
    if len(wrong):
        line, text = kept[int(wrong[0])]
        named = ", ".join(str(k + 1) for k in where)
        why = f"{text.strip()[:60]!r} has no number in each of the columns {named}"
        raise _refusal(path, why, line, "take the line out, or name the columns: gauging.columns in the job")
    return np.asarray(values, float)
