"""Series as CSV: one row a part and characteristic."""

import csv
import io
from typing import Final

from trueloop.report.series.shapes import SeriesShape

COLUMNS: Final = (
    "part_type", "characteristic", "part", "measured_um", "correction_um", "left_um", "predicted_um", "band_um",
    "inside", "weight", "drift_um", "alarm", "tool_set",
)  # fmt: skip


def series_csv(series: SeriesShape) -> str:
    """Errors before (`measured_um`) and after correction (`left_um`), with what was predicted from earlier parts."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for of_it in series.characteristics:
        for one in of_it.parts:
            sizes = (one.before_um, one.correction_um, one.after_um, one.expected_um, one.band_um)
            writer.writerow([
                *(series.part_type, of_it.characteristic, one.serial),
                *("" if size is None else f"{size:.3f}" for size in sizes),
                *("" if one.inside is None else int(one.inside), f"{one.weight:.4f}"),
                *("" if one.drift_um is None else f"{one.drift_um:.3f}", int(one.alarm), int(one.tool_set)),
            ])  # fmt: skip
    return text.getvalue()
