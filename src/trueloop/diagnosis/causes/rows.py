"""All feature errors of a series as rows: what hypotheses have to explain."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.causes.catalogue import SIZES_OF_FORM
from trueloop.diagnosis.causes.seen_part import SeenBy, SeenPart, SeenSeries
from trueloop.diagnosis.features.feature_error import ErrorKind

FLOOR_MM: Final = 0.0003
"""By what devices differ beyond their stated uncertainties: frames, form between the points, dirt."""
OF_SHAFTS: Final = frozenset({ErrorKind.RADIUS, ErrorKind.SHAFT_TAPER})


@dataclass(frozen=True)
class Row:
    """One error: of which part (its place in the series), which feature and kind, who saw it.

    `corrected_mm` is what corrections took off it as recorded. `normal_x` is +1 outside, −1 in a bore.
    """

    part: int
    feature: str
    other: str
    kind: ErrorKind
    seen_by: SeenBy
    value_mm: float
    u_mm: float
    corrected_mm: float
    normal_x: float


def rows_of(series: SeenSeries) -> tuple[Row, ...]:
    """Those of the series, sizes of form too; radii and tapers of shafts and bores alone, not of cones."""
    return tuple(row for place, part in enumerate(series.parts) for row in _of_part(series, place, part))


def signed(rows: tuple[Row, ...]) -> tuple[Row, ...]:
    """Radii, lengths and tapers."""
    return tuple(row for row in rows if row.kind not in SIZES_OF_FORM)


def sizes(rows: tuple[Row, ...]) -> tuple[Row, ...]:
    """Straightness, waviness, roundness: never negative."""
    return tuple(row for row in rows if row.kind in SIZES_OF_FORM)


def values_mm(rows: tuple[Row, ...], gain: float) -> Array:
    """What the errors had been without correction, if `gain` of what is recorded arrived on the parts: E = F + g C."""
    return np.array([row.value_mm + gain * row.corrected_mm for row in rows])


def _of_part(series: SeenSeries, place: int, part: SeenPart) -> Iterator[Row]:
    for seen_by, errors in part.errors.items():
        for one in errors:
            where = series.features.get(one.feature)
            shaft = where is None or where.kind == "shaft"
            if one.kind is ErrorKind.EDGE or (one.kind in OF_SHAFTS and not shaft):
                continue
            u_mm = float(np.hypot(one.standard_u_mm, FLOOR_MM))
            taken = 0.0 if part.standard else part.correction_mm.get((one.feature, str(one.kind)), 0.0)
            side = -1.0 if one.more.get("normal_x", 1.0) < 0 else 1.0
            yield Row(place, one.feature, one.other, one.kind, seen_by, one.value_mm, u_mm, taken, side)
