"""Points measured on a surface, as CSV: x_mm, y_mm, z_mm, and row and column (from 1) where they form a grid."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.formats.measurements.rows import CsvKind, Rows, read_csv

COORDINATES: Final = ("x_mm", "y_mm", "z_mm")
GRID: Final = ("row", "column")
HINT: Final = "the first line names the columns: x_mm,y_mm,z_mm and, for a grid, row,column; lengths in mm"
KIND: Final = CsvKind(Code.SRF_FILE, Code.SRF_FILE, Code.SRF_FILE, HINT, any_case=True)
MOST_LINES: Final = 100_000


@dataclass(frozen=True, eq=False)
class PointsFile:
    """Points (n, 3) in mm, and the line of each; with a grid's shape row by row, nan and line 0 for its holes."""

    points_mm: Array
    lines: NDArray[np.int64]
    shape: tuple[int, int] | None = None


def read_points(path: Path) -> PointsFile:
    """Reads the points of a file. Raises SRF-FILE with the line for what is no number, a missing column, a place of the
    grid given twice.
    """
    file = read_csv(path, KIND)
    rows = file.rows((*GRID, *COORDINATES))
    points = PointsFile(np.column_stack([rows.numbers(name) for name in COORDINATES]), np.array(rows.lines))
    if not set(GRID) & set(file.header):
        return points
    return _gridded(rows, points, np.column_stack([rows.numbers(name) for name in GRID]))


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


def _gridded(rows: Rows, points: PointsFile, places: Array) -> PointsFile:
    index = places.astype(int)
    for k in np.flatnonzero(np.any((index != places) | (index < 1) | (index > MOST_LINES), axis=1))[:1]:
        raise rows.refusal(int(k), f"row {places[k, 0]:g}, column {places[k, 1]:g} is no place of a grid")
    height, width = (int(most) for most in index.max(axis=0))
    if height * width > 10 * len(points.lines) + 100:
        last = int(np.argmax(index.max(axis=1)))
        raise rows.refusal(last, f"{len(points.lines)} points in a grid of {height} × {width}")
    flat = (index[:, 0] - 1) * width + index[:, 1] - 1
    twice = np.setdiff1d(np.arange(len(flat)), np.unique(flat, return_index=True)[1])
    for k in twice[:1]:
        raise rows.refusal(int(k), f"row {index[k, 0]}, column {index[k, 1]} is given twice")
    grid, lines = np.full((height * width, 3), np.nan), np.zeros(height * width, int)
    grid[flat], lines[flat] = points.points_mm, points.lines
    return PointsFile(grid, lines, (height, width))
