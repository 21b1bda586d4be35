"""Values of inspections as rows: touches, readings and points of a measuring machine, each in a table of its own.

A row comes back as the value it was made from, to the last bit. What a database cannot hold in its columns (SQLite
stores −0.0 as 0.0 and no NaN, PostgreSQL no U+0000) is written as JSON into the column `exact` as well, and read from
there.
"""

import json
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Reading, Touch, Values
from trueloop.domain.values import CODEC
from trueloop.storage.kinds import HALVES, storable

Cell = str | float | int | None
Row = tuple[Cell, ...]

CHUNK: Final = 10_000
_SUSPECT: Final = re.compile(r"NaN|Infinity|(?<![\d.])-0\.0(?!\d)|\\u0000|\\ud[89a-f]|\d{19}(?![\d.e])")
"""In the JSON of rows: what a column may not hold."""


@dataclass(frozen=True)
class RowForm:
    """How values of one type are written as rows. `columns`: name and type of what is in them, in the rows' order."""

    table: str
    of: type
    columns: tuple[tuple[str, type], ...]
    row: Callable[[Any], Row]
    value: Callable[..., Any]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the columns of a row as it is stored: `position` counts an inspection's values of all types from 0."""
        return "position", *(name for name, _ in self.columns), "exact"

    def rows(self, values: Values) -> Iterator[list[Row]]:
        """Rows of the values of this type, in pieces."""
        row, kind = self.row, self.of
        numbered = [(k, one) for k, one in enumerate(values) if type(one) is kind]
        for start in range(0, len(numbered), CHUNK):
            piece = [(k, *row(one), None) for k, one in numbered[start : start + CHUNK]]
            if _SUSPECT.search(json.dumps(piece)):
                piece = [_safe(one, values[int(one[0] or 0)]) for one in piece]
            yield piece

    def read(self, stored: Row) -> Any:
        """The value of a row without its position."""
        return self.value(*stored[:-1]) if stored[-1] is None else CODEC.from_json(str(stored[-1]), self.of)


def _safe(row: Row, value: Any) -> Row:
    cells = tuple(one if _fits(one) else None for one in row)
    return row if cells == row else (*cells[:-1], storable(CODEC.to_json(value)))


def _fits(cell: Cell) -> bool:
    if isinstance(cell, str):
        return "\x00" not in cell and not HALVES.search(cell)
    if isinstance(cell, int) or cell is None:
        return cell is None or abs(cell) < 2**63
    return math.isfinite(cell) and not (cell == 0 and math.copysign(1, cell) < 0)


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)


def _numbers(values: Sequence[float] | None, count: int) -> Row:
    return (None,) * count if values is None else tuple(map(float, values))


def _touch_row(one: Touch) -> Row:
    (x, z), measured = one.nominal_mm, one.measured_mm
    seen = (None, None) if measured is None else (float(measured[0]), float(measured[1]))
    return one.point, one.feature, float(x), float(z), *seen, _number(one.error_mm), one.line


def _touch(
    point: str, feature: str | None, x: float, z: float, seen_x: float | None, seen_z: float | None, *rest: Any
) -> Touch:
    return Touch(point, (x, z), feature, None if seen_x is None or seen_z is None else (seen_x, seen_z), *rest)


def _reading_row(one: Reading) -> Row:
    if len(one.place_mm) > 3:
        raise ValueError(f"a place of {len(one.place_mm)} coordinates")
    place: Row = (*map(float, one.place_mm), None, None, None)[:3]
    at = None if one.measured_at is None else one.measured_at.isoformat()
    return (
        *(one.characteristic, str(one.quantity), float(one.actual)),
        *(_number(one.nominal), _number(one.lower_limit), _number(one.upper_limit)),
        *(one.feature, one.other, one.axis, len(one.place_mm), *place, one.repeat),
        *(_number(one.standard_u), at, _number(one.temperature_c), one.line, one.side),
    )


def _reading(*cells: Any) -> Reading:
    name, quantity, actual, nominal, lower, upper, feature, other, axis, places, *rest = cells
    place, (repeat, u, at, temperature, line, side) = tuple(rest[:places]), rest[3:]
    return Reading(
        *(name, Quantity(quantity), actual, nominal, lower, upper, feature, other, axis, place, repeat, u),
        *(None if at is None else datetime.fromisoformat(at), temperature, line, side),
    )


def _cmm_row(one: CmmPoint) -> Row:
    vectors = (_numbers(vector, 3) for vector in (one.measured_mm, one.nominal_mm, one.outward_normal))
    return one.name, *(cell for vector in vectors for cell in vector)


def _cmm_point(name: str, *cells: Any) -> CmmPoint:
    measured, nominal, normal = ((cells[k : k + 3] if cells[k] is not None else None) for k in (0, 3, 6))
    if measured is None:
        raise ValueError("a point without coordinates")
    return CmmPoint(measured, nominal, normal, name)


def _columns(kind: type, *names: str) -> tuple[tuple[str, type], ...]:
    return tuple((name, kind) for name in names)


FORMS: Final = (
    RowForm(
        "touch",
        Touch,
        _columns(str, "point", "feature")
        + _columns(float, "nominal_x_mm", "nominal_z_mm", "measured_x_mm", "measured_z_mm", "error_mm")
        + _columns(int, "line"),
        _touch_row,
        _touch,
    ),
    RowForm(
        "reading",
        Reading,
        _columns(str, "characteristic", "quantity")
        + _columns(float, "actual", "nominal", "lower_limit", "upper_limit")
        + _columns(str, "feature", "other", "axis")
        + _columns(int, "place_count")
        + _columns(float, "place_1_mm", "place_2_mm", "place_3_mm")
        + _columns(int, "repeat")
        + _columns(float, "standard_u")
        + _columns(str, "measured_at")
        + _columns(float, "temperature_c")
        + _columns(int, "line")
        + _columns(str, "side"),
        _reading_row,
        _reading,
    ),
    RowForm(
        "cmm_point",
        CmmPoint,
        _columns(str, "name")
        + _columns(float, "measured_x_mm", "measured_y_mm", "measured_z_mm")
        + _columns(float, "nominal_x_mm", "nominal_y_mm", "nominal_z_mm", "normal_x", "normal_y", "normal_z"),
        _cmm_row,
        _cmm_point,
    ),
)
