"""The points of a measuring plan as CSV, written and read: place and outward normal in the part's frame."""

import csv
import io
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from trueloop.errors import Code
from trueloop.formats.measurements.rows import CsvKind, read_csv
from trueloop.probing.cmm_plan import CmmTouch

COLUMNS: Final = ("point", "feature", "angle_deg", "x_mm", "y_mm", "z_mm", "normal_x", "normal_y", "normal_z")

HINT: Final = "a list of points as `trueloop measure next` and `trueloop measure plan` write it: point,feature,x_mm, …"
KIND: Final = CsvKind(Code.TCH_FILE, Code.TCH_COLUMN, Code.TCH_NUMBER, HINT)


def read_cmm_plan(path: Path) -> tuple[CmmTouch, ...]:
    """Returns a list's points in the profile's half plane, at 0 degrees. Raises TCH errors with the line."""
    file = read_csv(path, KIND)
    rows = file.rows(COLUMNS)
    if missing := [
        name for name in ("point", "feature", "x_mm", "z_mm", "normal_x", "normal_z") if name not in rows.header
    ]:
        raise file.refusal(f"the header {list(rows.header)} has no column {missing[0]!r}", hint=HINT)
    if file.header and any(rows.numbers("angle_deg", 0.0)):
        raise file.refusal(
            "points at other angles than 0 degrees are not on the profile", hint="plan them at --angle 0"
        )
    numbers = (rows.numbers(name).tolist() for name in ("x_mm", "z_mm", "normal_x", "normal_z"))
    named = zip(rows.texts("point"), rows.texts("feature"), *numbers, strict=True)
    return tuple(CmmTouch(point, feature, (x, z), (n_x, n_z)) for point, feature, x, z, n_x, n_z in named)


def cmm_plan_to_csv(touches: Iterable[CmmTouch]) -> str:
    """Returns one row a point; lengths to 0.1 µm, normals to 1e-6."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    for point in touches:
        place = [_fixed(value, 4) for value in point.nominal_mm]
        normal = [_fixed(value, 6) for value in point.outward_normal]
        rows.writerow([point.name, point.feature, f"{point.angle_deg:g}", *place, *normal])
    return text.getvalue()


def _fixed(value: float, decimals: int) -> str:
    """Returns a number with fixed decimals, never `-0.0000`."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}"
