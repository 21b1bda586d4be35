"""A value as the store writes it: its document, what is stored apart from it, and the hash of both."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import chain, repeat
from typing import Any, Final, Generic, TypeVar

from sqlalchemy import BigInteger, Column, Connection, Double, Integer, Table, Text

from trueloop.domain.codec import Codec
from trueloop.storage.kinds import Kind, joined, searchable, storable
from trueloop.storage.value_rows import FORMS, Piece, Row, nothing_in

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
