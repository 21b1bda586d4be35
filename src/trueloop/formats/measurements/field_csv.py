"""A field of displacements as a table: a row a node of a grid, in any order.

Columns x_mm, y_mm, z_mm say where (one that is missing: nothing depends on it), dx, dy, dz by how much, in mm or µm as
their names say: dx_mm or dx_um (one that is missing is zero). Lines that start with # are comments.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code, Place
from trueloop.formats.input_file import FilePath
from trueloop.formats.measurements.rows import CsvKind, Rows, read_csv, vectors
from trueloop.machine.standards import LeftOut
from trueloop.nc.field import Field, table_field
from trueloop.units import UM_PER_MM

_POSITIONS: Final = ("x_mm", "y_mm", "z_mm")
_UNITS: Final = {"mm": 1.0, "um": 1.0 / UM_PER_MM}
_DISPLACEMENTS: Final = {f"d{axis}_{unit}": (k, unit) for k, axis in enumerate("xyz") for unit in _UNITS}
_OF_PLATES: Final = "# trueloop machine plates"
_LEFT_OUT: Final = re.compile(r"# left out: ([0-9.]+) -> ([0-9.]+) um RMS, (.*)")
_HINT: Final = "write columns x_mm, y_mm, z_mm and dx_um, dy_um, dz_um (or dx_mm …), a row a node"
_KIND: Final = CsvKind(Code.NC_FIELD, Code.NC_FIELD, Code.NC_FIELD, _HINT, any_case=True)


def read_field(path: FilePath) -> Field:
    """Reads the field of a table. Raises NC-FIELD with the line where it is no grid, or not in a known unit.

    >>> field = trueloop.read_field(trueloop.example("machine/field.csv"))
    >>> field.displacement_mm(np.array([[125.0, 0.0, 0.0]]))
    array([[-0.005,  0.   ,  0.   ]])
    """
    path = Path(path)
    file = read_csv(path, _KIND)
    rows = file.rows((*_POSITIONS, *_DISPLACEMENTS))
    given = [name for name in _DISPLACEMENTS if name in file.header]
    axes = [_DISPLACEMENTS[name][0] for name in given]
    if not given or len(set(axes)) < len(axes):
        raise file.refusal(f"no table of displacements: {len(given)} columns {', '.join(given)}")
    position = vectors(rows, _POSITIONS, 0.0)
    displacement = np.zeros_like(position)
    for name in given:
        axis, unit = _DISPLACEMENTS[name]
        displacement[:, axis] = rows.numbers(name) * _UNITS[unit]
    field = _on_grid(rows, position, displacement)
    content = np.hstack([position, displacement]).tobytes()
    return replace(field, identity=field.identity | {"table": sha256(content).hexdigest()})


def plane_csv(x_mm: Array, y_mm: Array, displacement_mm: Array, left: Sequence[LeftOut] = ()) -> str:
    """Displacements (nx, ny, 2) in X and Y at the nodes of a plane's grid as such a table, and what judged them."""
    rows = [
        f"{x!r},{y!r},{UM_PER_MM * dx:.4f},{UM_PER_MM * dy:.4f}"
        for x, column in zip(x_mm.tolist(), displacement_mm.tolist(), strict=True)
        for y, (dx, dy) in zip(y_mm.tolist(), column, strict=True)
    ]
    judged = [
        f"# left out: {UM_PER_MM * of.before_mm:.3f} -> {UM_PER_MM * of.after_mm:.3f} um RMS, {of.plate}" for of in left
    ]
    return "\n".join([_OF_PLATES, *judged, "x_mm,y_mm,dx_um,dy_um", *rows, ""])


def read_left_out(path: Path) -> list[LeftOut] | None:
    """Reads the RMS of plates left out of a table, before and after it; None if `plane_csv` did not write the table."""
    comments = [text for _, text in read_csv(path, _KIND).comments]
    if _OF_PLATES not in comments:
        return None
    found = [match for text in comments if (match := _LEFT_OUT.fullmatch(text))]
    return [LeftOut(one[3], float(one[1]) / UM_PER_MM, float(one[2]) / UM_PER_MM) for one in found]


def _on_grid(rows: Rows, position: Array, displacement: Array) -> Field:
    """The rows put into the order of the grid's nodes; each node must be there once."""
    axes, indices = zip(*(np.unique(position[:, k], return_inverse=True) for k in range(3)), strict=True)
    shape = tuple(map(len, axes))
    node = np.ravel_multi_index(indices, shape)
    known, first = np.unique(node, return_index=True)
    for row in np.setdiff1d(np.arange(len(node)), first)[:1]:
        raise rows.refusal(int(row), f"the node {position[row].tolist()} mm is there twice")
    if len(known) < math.prod(shape):
        missing = _first_missing(known)
        at = [float(axis[k]) for axis, k in zip(axes, np.unravel_index(missing, shape), strict=True)]
        why = f"{len(known)} of {math.prod(shape)} nodes are there; one that is missing: {at} mm"
        raise Code.NC_FIELD.refusal(why, hint=_HINT, place=Place(str(rows.path)))
    return table_field(axes[0], axes[1], axes[2], displacement[np.argsort(node)])


def _first_missing(integers: Integers) -> int:
    """The least number from 0 that is not in an ascending list."""
    late = np.flatnonzero(integers != np.arange(len(integers)))
    return int(late[0]) if len(late) else len(integers)
