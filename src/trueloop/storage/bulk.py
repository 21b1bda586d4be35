"""Many rows at once, past SQLAlchemy, which would take most of the time."""

from collections.abc import Iterable, Iterator
from itertools import repeat
from typing import Any

from sqlalchemy import Connection, Table

from trueloop.storage.value_rows import Piece, Row

_FETCHED = 10_000


def insert_rows(connection: Connection, table: Table, inspection: int, pieces: Iterable[Piece]) -> None:
    """Writes the rows of an inspection's values."""
    names = ", ".join(column.name for column in table.columns)
    raw: Any = connection.connection.dbapi_connection
    for piece in pieces:
        rows = zip(repeat(inspection), *piece.columns, strict=False)
        if connection.dialect.name == "sqlite":
            marks = ", ".join("?" * len(table.columns))
            raw.executemany(f"INSERT INTO {table.name} ({names}) VALUES ({marks})", rows)
        else:
            with raw.cursor() as cursor, cursor.copy(f"COPY {table.name} ({names}) FROM STDIN") as copy:
                for row in rows:
                    copy.write_row(row)


def rows_of(connection: Connection, table: Table, inspections: Iterable[int]) -> Iterator[Row]:
    """The rows of inspections' values, each with its inspection first, in order."""
    names = ", ".join(column.name for column in table.columns)
    which = ", ".join(str(int(one)) for one in inspections)
    raw: Any = connection.connection.dbapi_connection
    cursor = raw.cursor()
    cursor.execute(f"SELECT {names} FROM {table.name} WHERE inspection IN ({which}) ORDER BY inspection, position")
    while rows := cursor.fetchmany(_FETCHED):
        yield from rows
    cursor.close()
