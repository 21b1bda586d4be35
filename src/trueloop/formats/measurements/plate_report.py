"""CMM reports of drilled plates: a header, then rows of measured x y, nominal x y, error x y, diameter, nominal, form.

Units are millimetres. Holes of one nominal diameter count as made by one tool; the smallest is the reference.
"""

from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.machine.standards.planar_field import Plate

COLUMNS: Final = 9
HINT: Final = "rows of nine numbers: measured x y, nominal x y, error x y, diameter, nominal diameter, form error"


def read_plate_report(path: Path) -> Plate:
    """Reads a report. Raises MCH-FILE when it holds no table of nine columns."""
    lines = read_text(path, Code.MCH_FILE, hint=HINT).splitlines()
    rows = [row for row in (_numbers(line) for line in lines) if row is not None]
    if not rows:
        why = f"{path.name!r} cannot be read as a plate report: none of {len(lines)} lines has {COLUMNS} numbers"
        raise TrueloopError(Code.MCH_FILE, why, hint=HINT, place=Place(str(path)))
    table = np.array(rows)
    _, tool = np.unique(table[:, 7], return_inverse=True)
    return Plate(table[:, 2:4], table[:, 0:2], tool.astype(np.float64))


def _numbers(line: str) -> list[float] | None:
    try:
        row = [float(cell) for cell in line.split()]
    except ValueError:
        return None
    return row if len(row) == COLUMNS else None
