"""Many rows into a table at once: SQLite by `executemany`, PostgreSQL by COPY."""

from collections.abc import Iterable
from typing import Any

from sqlalchemy import Connection, Table

from trueloop.storage.value_rows import Row


def insert_rows(connection: Connection, table: Table, inspection: int, pieces: Iterable[list[Row]]) -> None:
    """Writes the rows of an inspection's values, past SQLAlchemy, which would take most of the time."""
    names = ", ".join(column.name for column in table.columns)
    raw: Any = connection.connection.dbapi_connection
    for piece in pieces:
        if connection.dialect.name == "sqlite":
            marks = ", ".join("?" * len(table.columns))
            raw.executemany(
                f"INSERT INTO {table.name} ({names}) VALUES ({marks})", [(inspection, *row) for row in piece]
            )
        else:
            with raw.cursor() as cursor, cursor.copy(f"COPY {table.name} ({names}) FROM STDIN") as copy:
                for row in piece:
                    copy.write_row((inspection, *row))
