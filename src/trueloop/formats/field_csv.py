"""A field of displacements as a table: a row a node of a grid, in any order.

Columns x_mm, y_mm, z_mm say where (one that is missing: nothing depends on it), dx, dy, dz by how much, in mm or µm as
their names say: dx_mm or dx_um (one that is missing is zero). Lines that start with # are comments.
"""

import csv
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.nc.field import Field, table_field
from trueloop.nc.tool_path import Array
from trueloop.units import UM_PER_MM

_POSITIONS: Final = ("x_mm", "y_mm", "z_mm")
_UNITS: Final = {"mm": 1.0, "um": 1.0 / UM_PER_MM}
_DISPLACEMENTS: Final = {f"d{axis}_{unit}": (k, unit) for k, axis in enumerate("xyz") for unit in _UNITS}
_HINT: Final = "write columns x_mm, y_mm, z_mm and dx_um, dy_um, dz_um (or dx_mm …), a row a node"


def read_field(path: Path) -> Field:
    """The field of a table. Raises NC-FIELD with the line where it is no grid, or not in a known unit."""
    text = read_text(path, Code.NC_FIELD, hint=_HINT)
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"]
    rows = [(number, next(csv.reader([line]))) for number, line in lines]
    names = [cell.strip().lower() for cell in rows[0][1]] if rows else []
    unknown = [name for name in names if name not in (*_POSITIONS, *_DISPLACEMENTS)]
    if unknown or len(set(names)) < len(names) or not any(name in _DISPLACEMENTS for name in names):
        what = f"columns {', '.join(map(repr, names))}" if names else f"{len(rows)} rows"
        raise _refusal(path, rows[0][0] if rows else 1, f"no table of displacements: {what}")
    values = np.array([_numbers(path, number, cells, len(names)) for number, cells in rows[1:]], dtype=np.float64)
    values = values.reshape(-1, len(names))
    position, displacement = np.zeros((len(values), 3)), np.zeros((len(values), 3))
    for column, name in enumerate(names):
        if name in _POSITIONS:
            position[:, _POSITIONS.index(name)] = values[:, column]
        else:
            axis, unit = _DISPLACEMENTS[name]
            displacement[:, axis] = values[:, column] * _UNITS[unit]
    field = _on_grid(path, [number for number, _ in rows[1:]], position, displacement)
    return replace(field, told=field.told | {"table": path.name})


def _numbers(path: Path, line: int, cells: list[str], count: int) -> list[float]:
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise _refusal(path, line, f"{','.join(cells)!r} is not {count} numbers")
    return numbers


def _on_grid(path: Path, lines: list[int], position: Array, displacement: Array) -> Field:
    """The rows put into the order of the grid's nodes; each node must be there once."""
    axes, indices = zip(*(np.unique(position[:, k], return_inverse=True) for k in range(3)), strict=True)
    shape = tuple(map(len, axes))
    node = np.ravel_multi_index(indices, shape) if len(position) else np.zeros(0, dtype=np.int64)
    known, first = np.unique(node, return_index=True)
    if len(known) < len(node):
        twice = int(np.setdiff1d(np.arange(len(node)), first)[0])
        raise _refusal(path, lines[twice], f"the node {position[twice].tolist()} mm is there twice")
    if not len(node) or len(known) < np.prod(shape):
        missing = int(np.setdiff1d(np.arange(np.prod(shape)), known)[0]) if len(node) else 0
        at = (
            [float(axis[k]) for axis, k in zip(axes, np.unravel_index(missing, shape), strict=True)]
            if len(node)
            else []
        )
        raise _refusal(path, None, f"{len(node)} of {np.prod(shape)} nodes are there; one that is missing: {at} mm")
    return table_field(axes[0], axes[1], axes[2], displacement[np.argsort(node)])


def _refusal(path: Path, line: int | None, message: str) -> TrueloopError:
    return TrueloopError(Code.NC_FIELD, message, hint=_HINT, place=Place(str(path), line))
