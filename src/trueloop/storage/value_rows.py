"""Values of inspections as rows: touches, readings and points of a measuring machine, each in a table of its own.

A value as the store writes it: its document, what is stored apart from it, and the hash of both.

A row comes back as the value it was made from, to the last bit. What a database cannot hold in its columns (SQLite
stores −0.0 as 0.0 and no NaN, PostgreSQL no U+0000) is written as JSON into the column `exact`, and read from there.
All is done by columns, ten thousand values at a time: a file of a million touches is kept in seconds.
"""

import hashlib
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import chain, repeat
from operator import attrgetter
from typing import Any, Final, Generic, NamedTuple, TypeVar

import numpy as np
from sqlalchemy import BigInteger, Column, Connection, Double, Integer, Table, Text

from trueloop.domain.characteristic import Quantity
from trueloop.domain.codec import Codec
from trueloop.domain.inspection import CmmPoint, Reading, Touch, Values
from trueloop.domain.values import CODEC
from trueloop.storage.kinds import HALVES, Kind, joined, searchable, storable

Cell = str | float | int | None
Row = tuple[Cell, ...]

PIECE: Final = 10_000
"""Rows that are written, and hashed, at a time."""
_LARGEST: Final = 2**63
_NO_TEXT: Final = re.compile(r"\\u0000|\\ud[89a-f]")
"""In JSON: what no text of a database holds."""


class Cells(NamedTuple):
    """A column: its name, the type of what is in it, and how to get that from values."""

    name: str
    of: type
    get: Callable[[Sequence[Any]], list[Cell]]


class Piece(NamedTuple):
    """Rows as columns, and the bytes by which they are hashed."""

    columns: tuple[Sequence[Cell], ...]
    hashed: bytes


@dataclass(frozen=True)
class RowForm:
    """The conversion of values of one type into rows, and of the cells of a row into a value."""

    table: str
    of: type
    cells: tuple[Cells, ...]
    value: Callable[..., Any]

    @property
    def names(self) -> tuple[str, ...]:
        """Returns the stored columns' names: `position` counts an inspection's values of all types from 0."""
        return "position", *(cell.name for cell in self.cells), "exact"

    def pieces(self, values: Values) -> Iterator[Piece]:
        """Yields the rows of the values of this type."""
        numbered = _numbered(values, self.of)
        for start in range(0, len(numbered), PIECE):
            yield self._piece(numbered[start : start + PIECE], values)

    def hashed(self, columns: Sequence[Sequence[Cell]]) -> bytes:
        """Returns the bytes by which rows are hashed, given by columns as they are stored: numbers by their bits."""
        types = (int, *(cell.of for cell in self.cells), str)
        return b"".join(_hashed(column, of) for column, of in zip(columns, types, strict=True))

    def read(self, stored: Row) -> Any:
        """Returns the value of a row without its position."""
        return self.value(*stored[:-1]) if stored[-1] is None else CODEC.from_json(str(stored[-1]), self.of)

    def _piece(self, positions: list[int], values: Values) -> Piece:
        chosen = [values[k] for k in positions]
        columns: list[Sequence[Cell]] = [_stored(cell.get(chosen), cell.of) for cell in self.cells]
        exact: list[Cell] = [None] * len(chosen)
        if not all(_plain(column, cell.of) for column, cell in zip(columns, self.cells, strict=True)):
            for k, row in enumerate(zip(*columns, strict=True)):
                exact[k] = None if all(map(_fits, row)) else storable(CODEC.to_json(chosen[k]))
            columns = [[one if _fits(one) else None for one in column] for column in columns]
        every = (positions, *columns, exact)
        return Piece(every, self.hashed(every))


def nothing_in(column: Sequence[Cell]) -> bool:
    """Returns whether no cell of a column is stated."""
    return column.count(None) == len(column)


def _numbered(values: Values, kind: type) -> list[int]:
    """The positions of the values of one type."""
    kinds = set(map(type, values))
    if kinds <= {kind}:
        return list(range(len(values)))
    return [k for k, one in enumerate(values) if type(one) is kind] if kind in kinds else []


def _stored(column: list[Cell], of: type) -> Sequence[Cell]:
    """Whole numbers among lengths become floats, as the database gives them back."""
    if of is not float or nothing_in(column):
        return column
    if None not in column:
        whole: list[Cell] = np.array(column, dtype=float).tolist()
        return whole
    return [None if one is None else float(one) for one in column]


def _plain(column: Sequence[Cell], of: type) -> bool:
    """Returns whether a database holds every cell of a column as it is."""
    if nothing_in(column):
        return True
    if of is str:
        return not _NO_TEXT.search(json.dumps(column))
    if of is int:
        return all(one is None or -_LARGEST <= one < _LARGEST for one in column if not isinstance(one, str))
    numbers = np.array(column, dtype=float)
    nothing = np.isnan(numbers).sum() - column.count(None)
    return not (nothing or np.isinf(numbers).any() or np.signbit(numbers[numbers == 0]).any())


def _hashed(column: Sequence[Cell], of: type) -> bytes:
    if of is float:
        numbers = np.full(len(column), np.nan, "<f8") if nothing_in(column) else np.array(column, dtype="<f8")
        return numbers.tobytes()
    return json.dumps(column, separators=(",", ":")).encode()


def _fits(cell: Cell) -> bool:
    if isinstance(cell, str):
        return "\x00" not in cell and not HALVES.search(cell)
    if isinstance(cell, int) or cell is None:
        return cell is None or -_LARGEST <= cell < _LARGEST
    return math.isfinite(cell) and not (cell == 0 and math.copysign(1, cell) < 0)


def _same(of: type, *names: str) -> tuple[Cells, ...]:
    """Columns that are fields of the value."""
    return tuple(_each(name, of, attrgetter(name)) for name in names)


def _each(name: str, of: type, get: Callable[[Any], Cell]) -> Cells:
    """A column whose cells come of one value each."""
    return Cells(name, of, lambda values: list(map(get, values)))


def _axis(name: str, field: str, k: int) -> Cells:
    """One coordinate of a place, which may not be stated or have fewer."""
    place_of = attrgetter(field)

    def get(values: Sequence[Any]) -> list[Cell]:
        places: list[Sequence[float] | None] = list(map(place_of, values))
        if not any(places):
            return [None] * len(places)
        return [None if place is None or len(place) <= k else place[k] for place in places]

    return Cells(name, float, get)


def _axes(field: str, *names: str) -> tuple[Cells, ...]:
    return tuple(_axis(name, field, k) for k, name in enumerate(names))


def _touch(
    point: str, feature: str | None, x: float, z: float, seen_x: float | None, seen_z: float | None, *rest: Any
) -> Touch:
    return Touch(point, (x, z), feature, None if seen_x is None or seen_z is None else (seen_x, seen_z), *rest)


def _place_count(reading: Reading) -> int:
    if len(reading.place_mm) > 3:
        raise ValueError(f"a place of {len(reading.place_mm)} coordinates")
    return len(reading.place_mm)


def _measured_at(reading: Reading) -> str | None:
    return None if reading.measured_at is None else reading.measured_at.isoformat()


def _reading(*cells: Any) -> Reading:
    name, quantity, actual, nominal, lower, upper, feature, other, axis, places, *rest = cells
    place, (repeat, u, at, temperature, line, side) = tuple(rest[:places]), rest[3:]
    return Reading(
        characteristic=name,
        quantity=Quantity(quantity),
        actual=actual,
        nominal=nominal,
        lower_limit=lower,
        upper_limit=upper,
        feature=feature,
        other=other,
        axis=axis,
        place_mm=place,
        repeat=repeat,
        standard_u=u,
        measured_at=None if at is None else datetime.fromisoformat(at),
        temperature_c=temperature,
        line=line,
        side=side,
    )


def _cmm_point(name: str, *cells: Any) -> CmmPoint:
    measured, nominal, normal = ((cells[k : k + 3] if cells[k] is not None else None) for k in (0, 3, 6))
    if measured is None:
        raise ValueError("a point without coordinates")
    return CmmPoint(measured, nominal, normal, name)


FORMS: Final = (
    RowForm(
        "touch",
        Touch,
        (
            *_same(str, "point", "feature"),
            *_axes("nominal_mm", "nominal_x_mm", "nominal_z_mm"),
            *_axes("measured_mm", "measured_x_mm", "measured_z_mm"),
            *_same(float, "error_mm"),
            *_same(int, "line"),
        ),
        _touch,
    ),
    RowForm(
        "reading",
        Reading,
        (
            *_same(str, "characteristic"),
            _each("quantity", str, lambda one: str(one.quantity)),
            *_same(float, "actual", "nominal", "lower_limit", "upper_limit"),
            *_same(str, "feature", "other", "axis"),
            _each("place_count", int, _place_count),
            *_axes("place_mm", "place_1_mm", "place_2_mm", "place_3_mm"),
            *_same(int, "repeat"),
            *_same(float, "standard_u"),
            _each("measured_at", str, _measured_at),
            *_same(float, "temperature_c"),
            *_same(int, "line"),
            *_same(str, "side"),
        ),
        _reading,
    ),
    RowForm(
        "cmm_point",
        CmmPoint,
        (
            *_same(str, "name"),
            *_axes("measured_mm", "measured_x_mm", "measured_y_mm", "measured_z_mm"),
            *_axes("nominal_mm", "nominal_x_mm", "nominal_y_mm", "nominal_z_mm"),
            *_axes("outward_normal", "normal_x", "normal_y", "normal_z"),
        ),
        _cmm_point,
    ),
)


T = TypeVar("T")


@dataclass(frozen=True)
class Kept(Generic[T]):
    """A value in the store: its row, when it was kept, and whether this call kept it. `superseded_by`: another row.

    `supersedes` is the row that it replaces, `by` who kept it and `why` it supersedes that row. Rows are
    numbered in the order in which they were kept, whatever the clock said; `clock_back`: when this one was kept, the
    clock stood before the time of the row before.
    """

    row: int
    value: T
    kept_at: datetime
    new: bool = False
    superseded_by: int | None = None
    supersedes: int | None = None
    by: str = ""
    why: str = ""
    clock_back: bool = False


@dataclass(frozen=True)
class Encoded:
    """`rows` by the name of their table, in pieces; `columns` with document, identity and hash."""

    columns: Mapping[str, Any]
    rows: Mapping[str, list[Piece]]


def encoded(codec: Codec, kind: Kind, value: Any) -> Encoded:
    """Encodes a value of this kind. Raises TypeError for what the codec does not know."""
    apart = {kind.aside: getattr(value, kind.aside)} if kind.aside else {}
    rows = {form.table: list(form.pieces(apart["values"])) for form in FORMS} if "values" in apart else {}
    document = storable(codec.to_json(_without(value, kind)))
    payload = {"payload": storable(codec.to_json(apart["payload"]))} if "payload" in apart else {}
    columns = {name: searchable(None if one is None else str(one)) for name, one in kind.columns(value).items()}
    return Encoded(
        {
            "identity": searchable(joined(value.identity)),
            "sha256": digest(
                (document, *payload.values()), (piece.hashed for pieces in rows.values() for piece in pieces)
            ),
            "document": document,
            **payload,
            **columns,
        },
        rows,
    )


def digest(texts: Iterable[str], pieces: Iterable[bytes]) -> str:
    """Returns the hash of a value's texts and then of its rows, table by table (`RowForm.hashed`)."""
    sha = hashlib.sha256()
    for text in texts:
        sha.update(text.encode())
    for piece in pieces:
        sha.update(piece)
    return sha.hexdigest()


def _without(value: Any, kind: Kind) -> Any:
    return value if not kind.aside else replace(value, **{kind.aside: () if kind.aside == "values" else None})


_FETCHED: Final = 10_000
_BOUND: Final = 999
"""Cells that one statement takes in every SQLite."""
_BINARY: Final[Mapping[type, str]] = {Integer: "int4", BigInteger: "int8", Double: "float8", Text: "text"}
"""PostgreSQL's names of the columns' types."""


def insert_rows(connection: Connection, table: Table, inspection: int, pieces: Iterable[Piece]) -> None:
    """Writes the rows of an inspection's values. Columns in which nothing is stated are left to be NULL."""
    raw: Any = connection.connection.dbapi_connection
    insert = _into_sqlite if connection.dialect.name == "sqlite" else _into_postgresql
    own, *others = table.columns
    for piece in pieces:
        stated = [(column, cells) for column, cells in zip(others, piece.columns, strict=True) if not nothing_in(cells)]
        rows = zip(repeat(inspection), *(cells for _, cells in stated), strict=False)
        insert(raw, table, [own, *(column for column, _ in stated)], rows)


def _into_sqlite(raw: Any, table: Table, columns: list[Column[Any]], rows: Iterable[Row]) -> None:
    """As many rows a statement as it takes: most of the time is that of statements."""
    cells = list(chain.from_iterable(rows))
    size = _BOUND // len(columns) * len(columns)
    whole = len(cells) // size * size
    row = f"({', '.join('?' * len(columns))})"
    for start, end, count in ((0, whole, size), (whole, len(cells), len(cells) - whole)):
        if start < end:
            statement = f"INSERT INTO {_named(table, columns)} VALUES {', '.join([row] * (count // len(columns)))}"
            raw.executemany(statement, (cells[k : k + count] for k in range(start, end, count)))


def _into_postgresql(raw: Any, table: Table, columns: list[Column[Any]], rows: Iterable[Row]) -> None:
    """In binary form: numbers by their bits, and never as text."""
    statement = f"COPY {_named(table, columns)} FROM STDIN (FORMAT BINARY)"
    with raw.cursor() as cursor, cursor.copy(statement) as copy:
        copy.set_types([_BINARY[type(column.type)] for column in columns])
        for row in rows:
            copy.write_row(row)


def _named(table: Table, columns: list[Column[Any]]) -> str:
    return f"{table.name} ({', '.join(column.name for column in columns)})"


def rows_of(connection: Connection, table: Table, inspections: Iterable[int]) -> Iterator[Row]:
    """Yields the rows of inspections' values, each with its inspection first, in order."""
    names = ", ".join(column.name for column in table.columns)
    which = ", ".join(str(int(inspection)) for inspection in inspections)
    raw: Any = connection.connection.dbapi_connection
    cursor = raw.cursor()
    cursor.execute(f"SELECT {names} FROM {table.name} WHERE inspection IN ({which}) ORDER BY inspection, position")
    while rows := cursor.fetchmany(_FETCHED):
        yield from rows
    cursor.close()
