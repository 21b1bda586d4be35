"""CMM reports of drilled plates: a header, then rows of measured x y, nominal x y, error x y, diameter, nominal, form.

Units are millimetres. Holes of one nominal diameter count as made by one tool; the smallest is the reference.
"""

from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.machine.planar_field import Plate

COLUMNS: Final = 9


def read_plate_report(path: Path) -> Plate:
    """Reads a report. Raises MCH-FILE when it holds no table of nine columns."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise _unreadable(path, f"{error}") from error
    rows = [row for row in (_numbers(line) for line in lines) if row is not None]
    if not rows:
        raise _unreadable(path, f"none of {len(lines)} lines has {COLUMNS} numbers")
    table = np.array(rows)
    _, tool = np.unique(table[:, 7], return_inverse=True)
    return Plate(table[:, 2:4], table[:, 0:2], tool.astype(np.float64))


def _numbers(line: str) -> list[float] | None:
    try:
        row = [float(cell) for cell in line.split()]
    except ValueError:
        return None
    return row if len(row) == COLUMNS else None


def _unreadable(path: Path, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MCH_FILE,
        f"{path.name!r} cannot be read as a plate report: {why}",
        hint="rows of nine numbers: measured x y, nominal x y, error x y, diameter, nominal diameter, form error",
        place=Place(str(path)),
    )
