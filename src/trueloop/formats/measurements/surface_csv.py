"""Deviations and patterns of surfaces as tables."""

import json
from dataclasses import asdict, dataclass
from io import StringIO
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.formats.measurements.rows import CsvKind, Rows, read_csv
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.pattern.pattern import PartMaps, Pattern
from trueloop.surface.separation.separate import Separation
from trueloop.surface.separation.spline_surface import Places
from trueloop.units import UM_PER_MM

HEADER: Final = "row,column,u,v,x_mm,y_mm,z_mm,nx,ny,nz,error_um"
PLACE: Final = ("u", "v", "x_mm", "y_mm", "z_mm")
NORMAL: Final = ("nx", "ny", "nz")
SHOWN: Final = (
    "measured_um", "deterministic_um", "random_um", "pattern_um", "predicted_um", "variability_um", "uncertainty_um",
)  # fmt: skip


def deviations_to_csv(deviations: SurfaceDeviations) -> bytes:
    """Returns a row a point: nominal point, outward normal, error in µm, positive where material was left on.

    Row and column are empty for scattered points; holes are left out. The first line states the alignment, and
    which motions it left.
    """
    kind, there = deviations.alignment.kind, np.flatnonzero(deviations.measured)
    left = "".join(f"; left with the datums: {motion}" for motion in deviations.alignment.left)
    head = [f"# {deviations.name}: {kind}, {len(there)} points{left}", HEADER]
    values = [deviations.u, deviations.v, deviations.nominal_mm, deviations.normal, deviations.error_mm * UM_PER_MM]
    rows, form = np.column_stack(values)[there], ",,%.9f,%.9f,%.6f,%.6f,%.6f,%.9f,%.9f,%.9f,%.4f"
    if deviations.shape is not None:
        place = np.stack(np.divmod(there, deviations.shape[1]), axis=1) + 1
        rows, form = np.concatenate([place, rows], axis=1), "%d,%d" + form[1:]
    return _lines(head, form, rows)


def separation_to_csv(name: str, apart: Separation) -> bytes:
    """Returns a row a place of one part: parameters on [0, 1], nominal point, and the separated errors, in µm."""
    columns = {"measured_um": apart.measured_mm, "deterministic_um": apart.measured_mm - apart.random_mm}
    return _table(name, apart.places, [], columns | {"random_um": apart.random_mm})


def maps_to_csv(maps: PartMaps, normal: Array) -> bytes:
    """Returns a row a place of one part: parameters on [0, 1], nominal point, outward normal (n, 3), maps in µm."""
    columns = {name: getattr(maps, name.replace("_um", "_mm")) for name in SHOWN}
    return _table(maps.name, maps.places, [normal], columns)


def _table(name: str, places: Places, more: list[Array], errors_mm: dict[str, Array]) -> bytes:
    head = ",".join([*PLACE, *NORMAL * len(more), *errors_mm])
    at = np.column_stack([places.u, places.v, places.points_mm, *more])
    errors = np.column_stack([values * UM_PER_MM for values in errors_mm.values()])
    form = ",".join(["%.9g"] * at.shape[1] + ["%.4f"] * errors.shape[1])
    first = f"# {name}: {len(places.u)} places; positive is material left on"
    return _lines([first, head], form, np.concatenate([at, errors], axis=1))


def _lines(head: list[str], form: str, rows: Array) -> bytes:
    """The head, then a line a row, formed by `%`: of a million rows no slower way is bearable."""
    text = StringIO()
    text.writelines(f"{line}\n" for line in head)
    text.writelines(f"{form}\n" % tuple(row) for row in rows.tolist())
    return text.getvalue().encode()


def pattern_to_json(pattern: Pattern) -> bytes:
    """Returns the pattern with its control values in µm, row by row, and those of every part."""
    document = {
        "size": asdict(pattern.mean.size),
        "size_of_parts_splines": asdict(pattern.size),
        "knots": "clamped, evenly spaced on [0, 1]",
        "sign": "positive: material left on, along the outward normal",
        "random_sigma_um": pattern.sigma_mm * UM_PER_MM,
        "parts": list(pattern.names),
        "outlying": [odd.name for odd in pattern.outlying],
        "control_um": (pattern.mean.coefficients_mm * UM_PER_MM).tolist(),
        "control_of_parts_um": {
            name: (model.coefficients_mm * UM_PER_MM).tolist()
            for name, model in zip(pattern.names, pattern.models, strict=True)
        },
    }
    return (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode()


COORDINATES: Final = ("x_mm", "y_mm", "z_mm")
GRID: Final = ("row", "column")
HINT: Final = (
    "the first line names the columns: x_mm,y_mm,z_mm and, for a grid, row,column; lengths in mm; "
    "a scan has a line a point"
)
KIND: Final = CsvKind(Code.SRF_FILE, Code.SRF_FILE, Code.SRF_FILE, HINT, any_case=True)
MOST_LINES: Final = 100_000


@dataclass(frozen=True, eq=False)
class PointsFile:
    """Points (n, 3) in mm, and the line of each; with a grid's shape row by row, nan and line 0 for its holes."""

    points_mm: Array
    lines: NDArray[np.int64]
    shape: tuple[int, int] | None = None


def read_points(path: Path) -> PointsFile:
    """Reads a file's points. Raises SRF-FILE with the line: no number, no column, a place of the grid twice."""
    file = read_csv(path, KIND)
    rows = file.rows((*GRID, *COORDINATES))
    points = PointsFile(np.column_stack([rows.numbers(name) for name in COORDINATES]), np.array(rows.lines))
    if not set(GRID) & set(file.header):
        return points
    return _gridded(rows, points, np.column_stack([rows.numbers(name) for name in GRID]))


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
