"""All rows of a store into an empty one as they are: values, states, logs, accounts, keys; numbers are kept."""

from collections.abc import Callable
from typing import Any, Final

from sqlalchemy import Connection, Table, func, insert, select

from trueloop.storage.store import Store
from trueloop.storage.tables import METADATA

AT_ONCE: Final = 1000


def copy_rows(source: Store, target: Store, said: Callable[[int], None]) -> int:
    """Copies every row of every table, as `source` is at one moment, and returns their number; all or none.

    `target` has tables of this version and no rows. `said` is called with the rows copied so far. Raises STO-FILE,
    STO-BUSY, STO-WRITE.
    """
    count = 0
    with source.reading() as reading, target.writing() as writing:
        for table in METADATA.sorted_tables:
            for rows in _rows(reading, table):
                writing.execute(insert(table), rows)
                count += len(rows)
                said(count)
            _number_on(writing, table)
    return count


def _rows(connection: Connection, table: Table) -> Any:
    ordered = select(table).order_by(*table.primary_key.columns)
    result = connection.execute(ordered.execution_options(yield_per=AT_ONCE))
    return ([dict(row) for row in part] for part in result.mappings().partitions())


def _number_on(connection: Connection, table: Table) -> None:
    """PostgreSQL numbers rows by a sequence, which knows nothing of rows that came with their number."""
    column = table.autoincrement_column
    if connection.dialect.name != "postgresql" or column is None:
        return
    last = connection.execute(select(func.max(column))).scalar()
    if last is not None:
        connection.execute(select(func.setval(func.pg_get_serial_sequence(f'"{table.name}"', column.name), last)))
