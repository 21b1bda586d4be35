"""Points measured on a surface, as CSV: x_mm, y_mm, z_mm, and row and column (from 1) where they form a grid."""

import io
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.geometry.feature import Array

COORDINATES: Final = ("x_mm", "y_mm", "z_mm")
GRID: Final = ("row", "column")
HINT: Final = "the first line names the columns: x_mm,y_mm,z_mm and, for a grid, row,column; lengths in mm"


def read_points(path: Path) -> tuple[Array, tuple[int, int] | None]:
    """Points (n, 3) in mm and the grid's shape: row by row with nan for holes; None for scattered points.

    Raises SRF-FILE with the line for what is no number, a missing column, a place of the grid given twice.
    """
    text = read_text(path, Code.SRF_FILE, hint=HINT)
    head, _, body = text.partition("\n")
    names = [name.strip().lower() for name in head.strip().split(",")]
    for name in COORDINATES:
        if name not in names:
            raise _refusal(path, 1, f"no column {name!r} among {', '.join(map(repr, names))}")
    rows = _numbers(path, body, len(names))
    points = rows[:, [names.index(name) for name in COORDINATES]]
    if not all(name in names for name in GRID):
        return points, None
    return _gridded(path, points, rows[:, [names.index(name) for name in GRID]])


def points_to_csv(points_mm: Array, shape: tuple[int, int] | None = None) -> bytes:
    """Points as `read_points` reads them, to a nanometre."""
    grid = shape is not None
    lines = [",".join((*GRID, *COORDINATES) if grid else COORDINATES)]
    columns = shape[1] if shape is not None else 1
    for k, point in enumerate(points_mm):
        if np.all(np.isfinite(point)):
            place = f"{k // columns + 1},{k % columns + 1}," if grid else ""
            lines.append(place + ",".join(f"{value:.6f}" for value in point))
    return ("\n".join(lines) + "\n").encode()


def _numbers(path: Path, body: str, width: int) -> Array:
    if not body.strip():
        raise _refusal(path, 1, "0 points")
    try:
        rows = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2, comments="#")
    except ValueError:
        raise _first_bad_line(path, body, width) from None
    if rows.shape[1] != width or not np.all(np.isfinite(rows)):
        raise _first_bad_line(path, body, width)
    return rows


def _first_bad_line(path: Path, body: str, width: int) -> TrueloopError:
    for number, line in enumerate(body.splitlines(), 2):
        cells = [cell.strip() for cell in line.split("#")[0].split(",")]
        if cells == [""]:
            continue
        if len(cells) != width:
            return _refusal(path, number, f"{len(cells)} values in a line of {width} columns")
        for cell in cells:
            try:
                finite = bool(np.isfinite(float(cell)))
            except ValueError:
                finite = False
            if not finite:
                return _refusal(path, number, f"{cell!r} is no number")
    return _refusal(path, 1, "0 points")


def _gridded(path: Path, points: Array, places: Array) -> tuple[Array, tuple[int, int]]:
    index = places.astype(int)
    if np.any(index != places) or np.any(index < 1) or np.any(index > 100_000):
        raise _refusal(
            path, 2, f"row {np.max(places[:, 0]):g} or column {np.max(places[:, 1]):g} is no place of a grid"
        )
    rows, columns = (int(most) for most in index.max(axis=0))
    if rows * columns > 10 * len(points) + 100:
        raise _refusal(path, 2, f"{len(points)} points in a grid of {rows} × {columns}")
    flat = (index[:, 0] - 1) * columns + index[:, 1] - 1
    order = np.argsort(flat, kind="stable")
    if np.any(twice := np.diff(flat[order]) == 0):
        k = order[1:][twice][0]
        raise _refusal(path, int(k) + 2, f"row {index[k, 0]}, column {index[k, 1]} is given twice")
    grid = np.full((rows * columns, 3), np.nan)
    grid[flat] = points
    return grid, (rows, columns)


def _refusal(path: Path, line: int, message: str) -> TrueloopError:
    return TrueloopError(Code.SRF_FILE, message, hint=HINT, place=Place(str(path), line))
