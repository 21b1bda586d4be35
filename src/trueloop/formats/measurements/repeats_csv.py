"""Repeats at one point right after fixturing as CSV, in their order: `what, reading_mm` or `what, reading_um`.

`what` names the point: the part, the tool probe, the part probe; one point without that column. A comment line
`# repeats_to_um 0.5` states what one reading repeats to.
"""

import re
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.measurements.measured_rows import read_measured
from trueloop.formats.measurements.rows import CsvFile, Rows
from trueloop.units import UM_PER_MM

READINGS: Final = {"reading_mm": 1.0, "reading_um": 1.0 / UM_PER_MM}
STATED: Final = re.compile(r"#\s*repeats_to_um\s+(\d{1,9}(?:\.\d*)?)\s*")


def read_repeats(path: Path, standard_u_mm: float | None = None) -> tuple[dict[str, Array], float]:
    """Readings in mm by what was fixed, in the order of the file, and what one repeats to: given, or as the file says.

    Raises MCH-FILE and MCH-UNIT.
    """
    file = read_measured(path)
    rows = file.rows(("what", *READINGS))
    values_mm = _readings(rows)
    names = np.array([name or "part" for name in rows.texts("what")])
    u_mm = _stated_mm(file) if standard_u_mm is None else standard_u_mm
    return {name: values_mm[names == name] for name in dict.fromkeys(names.tolist())}, u_mm


def _readings(rows: Rows) -> Array:
    column = next((name for name in READINGS if name in rows.header), "reading_mm")
    values: Array = rows.numbers(column) * READINGS[column]
    return values


def _stated_mm(file: CsvFile) -> float:
    found = [match[1] for _, text in file.comments if (match := STATED.fullmatch(text))]
    if len(found) != 1 or float(found[0]) <= 0.0:
        raise TrueloopError(
            Code.MCH_FILE,
            f"{len(found)} lines state what a reading repeats to",
            hint="write `# repeats_to_um 0.5` above the header, or give --repeats-to-um",
            place=Place(str(file.path), 1),
        )
    return float(found[0]) / UM_PER_MM
