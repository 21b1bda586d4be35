"""The points of a measuring plan as CSV: place and outward normal in the part's frame."""

import csv
import io
from collections.abc import Iterable
from typing import Final

from trueloop.probing.cmm_plan import CmmTouch

COLUMNS: Final = ("point", "feature", "angle_deg", "x_mm", "y_mm", "z_mm", "normal_x", "normal_y", "normal_z")


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
