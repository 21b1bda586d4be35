"""Many rows at once, past SQLAlchemy, which would take most of the time."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, repeat
from typing import Any, Final

from sqlalchemy import BigInteger, Column, Connection, Double, Integer, Table, Text

from trueloop.storage.value_rows import Piece, Row, nothing_in

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
    which = ", ".join(str(int(one)) for one in inspections)
    raw: Any = connection.connection.dbapi_connection
    cursor = raw.cursor()
    cursor.execute(f"SELECT {names} FROM {table.name} WHERE inspection IN ({which}) ORDER BY inspection, position")
    while rows := cursor.fetchmany(_FETCHED):
        yield from rows
    cursor.close()
