"""Readings as the CSV that gauge readings are read from: a row a reading, on features of the part."""

import csv
import io
from collections.abc import Iterable
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading

COLUMNS: Final = (
    *("characteristic", "feature", "from", "quantity", "z_mm", "x_mm", "value_mm", "value_deg"),
    *("nominal", "lower_limit", "upper_limit", "serial", "measured_at", "temperature_c"),
)


def readings_to_csv(inspections: Iterable[tuple[Inspection, Iterable[Reading]]]) -> str:
    """The readings of inspections; mm, angles in degrees, x a radius. Limits are absolute."""
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(COLUMNS)
    for inspection, readings in inspections:
        for reading in readings:
            out.writerow(_row(inspection, reading))
    return text.getvalue()


def _row(inspection: Inspection, reading: Reading) -> list[str]:
    """One reading; what is not stated is empty."""
    value, angle = _number(reading.actual), reading.quantity is Quantity.ANGLE
    place = reading.place_mm[-2:]
    moment = reading.measured_at or inspection.measured_at
    return [
        *(reading.characteristic, reading.feature, reading.other, reading.quantity.value),
        _number(place[-1]) if place else "",
        _number(place[0]) if len(place) == 2 else "",
        *(("", value) if angle else (value, "")),
        *(_number(one) for one in (reading.nominal, reading.lower_limit, reading.upper_limit)),
        inspection.part.serial,
        "" if moment is None else moment.isoformat(),
        _number(reading.temperature_c),
    ]


def _number(value: float | None) -> str:
    """To a nanometre: below what any gauge reads."""
    return "" if value is None else f"{value:.6f}".rstrip("0").rstrip(".")
