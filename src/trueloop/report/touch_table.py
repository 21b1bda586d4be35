"""The numbers: every touch with what was measured, fitted and predicted, as a table and as CSV."""

import csv
import io
from typing import Any, Final

import numpy as np

from trueloop.loops.process_intermittent import Correction
from trueloop.report.markup import esc, table
from trueloop.report.style import plain, signed
from trueloop.units import UM_PER_MM

COLUMNS: Final = (
    "feature",
    "point",
    "nominal_x_mm",
    "nominal_z_mm",
    "arc_length_mm",
    "error_before_um",
    "gauging_standard_u_um",
    "fitted_um",
    "predicted_after_um",
    "leave_one_out_um",
    "predicted_standard_u_um",
)
HEADINGS: Final = (
    "feature", "point", "x, radius<br>mm", "z<br>mm", "arc length<br>mm", "before<br>µm", "u gauging<br>µm",
    "fitted<br>µm", "after<br>µm", "left out<br>µm", "u after<br>µm",
)  # fmt: skip
MM: Final = 4
UM: Final = 2


def touch_rows(correction: Correction) -> list[tuple[str, str, *tuple[float, ...]]]:
    """One row a touch in the order of `COLUMNS`, mm with 4 and µm with 2 decimals; x is a radius."""
    touches, prediction = correction.touches, correction.prediction
    fitted = np.array(
        [
            correction.model.curves[i].value_mm(s)[0]
            for i, s in zip(touches.feature_index, touches.arc_length_mm, strict=True)
        ]
    )
    lengths = np.column_stack([touches.nominal_mm, touches.arc_length_mm])
    errors = UM_PER_MM * np.column_stack(
        [
            touches.error_mm, touches.standard_u_mm, fitted,
            prediction.after_mm, prediction.leave_one_out_mm, prediction.standard_u_mm,
        ]
    )  # fmt: skip
    names = correction.profile.names
    numbers: Any = np.column_stack([np.round(lengths, MM), np.round(errors, UM)]) + 0.0  # no negative zeros
    return [
        (names[feature], point, *row)
        for feature, point, row in zip(touches.feature_index, touches.point, numbers.tolist(), strict=True)
    ]


def touches_csv(correction: Correction) -> str:
    """The rows with the column names as header; lines end with CR LF as RFC 4180 wants it."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(COLUMNS)
    writer.writerows(touch_rows(correction))
    return text.getvalue()


def touches_table(correction: Correction) -> str:
    """The rows as HTML, errors to 0.1 µm."""
    rows = []
    for row, reference in zip(touch_rows(correction), correction.touches.at_reference, strict=True):
        feature, point, *numbers = row
        x, z, s, before, u, fitted, after, left_out, u_after = numbers
        mark = ' <abbr title="the part\'s z was taken from here">z ref.</abbr>' if reference else ""
        lengths = [plain(value, 3) for value in (x, z, s)]
        errors = [signed(before), plain(u, 2), signed(fitted), signed(after), signed(left_out), plain(u_after, 2)]
        rows.append([esc(feature), esc(point) + mark, *lengths, *errors])
    return table(HEADINGS, rows, words=(0, 1), name="touches")
