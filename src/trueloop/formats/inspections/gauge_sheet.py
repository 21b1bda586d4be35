"""The file that a person fills in beside the part: what is to be measured, with an empty cell for each value."""

import csv
import io
from collections.abc import Sequence
from typing import Final, Literal

from trueloop.domain.characteristic import Characteristic
from trueloop.units import MM_PER_INCH

STATED: Final = ("serial", "instrument", "expanded_uncertainty_um", "operator", "measured_at", "temperature_c")
"""Columns that may be stated once for all rows, as comments."""
DECIMALS: Final = {"mm": 4, "inch": 5}


def gauge_sheet_csv(planned: Sequence[Characteristic], unit: Literal["mm", "inch"] = "mm") -> str:
    """Lengths and diameters as rows that `gauge_csv` reads once they have values; rows without are passed over."""
    per, ending = (1.0, "mm") if unit == "mm" else (MM_PER_INCH, "in")

    def number(value: float | None) -> str:
        return "" if value is None else f"{value / per:.{DECIMALS[unit]}f}"

    out = io.StringIO()
    out.write("".join(f"# {key}:\n" for key in STATED))
    writer = csv.writer(out, lineterminator="\n")
    limits = ("lower_limit", "upper_limit") if any(one.lower_limit or one.upper_limit for one in planned) else ()
    writer.writerow(
        ("characteristic", "feature", "from", "quantity", f"z_{ending}", "nominal", *limits, f"value_{ending}")
    )
    for one in planned:
        row = (one.name, one.feature, one.other, one.quantity.value, number(one.at_z_mm), number(one.nominal))
        writer.writerow((*row, *(number(getattr(one, name)) for name in limits), ""))
    return out.getvalue()
