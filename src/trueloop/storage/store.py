"""Keeping domain values and finding them again: `open_store`, `keep`, `find`.

>>> from trueloop.domain.part import Part, PartType
>>> store = open_store("sqlite://", create=True)
>>> part = Part(PartType("MODBAS2"), "2511")
>>> keep(store, [part])[0].new, keep(store, [part])[0].new  # the same value twice is one row
(True, False)
>>> [one.value.serial for one in find(store, Part, part_type="MODBAS2")]
['2511']
"""

import sqlite3
import time
import weakref
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar

from sqlalchemy import Connection, Engine, Table, func, insert, select

from trueloop.domain import values
from trueloop.domain.codec import Codec
from trueloop.domain.record import Correction
from trueloop.storage.encoded import Kept
from trueloop.storage.engines import WRITING, engine_of, understood, url_of
from trueloop.storage.keeping import Keeping
from trueloop.storage.kinds import kind_of
from trueloop.storage.reading import Query, found, shown
from trueloop.storage.schema import METADATA, bring_up_to_date, check_schema, older

__all__ = ["Kept", "Store", "find", "keep", "open_store"]

T = TypeVar("T")

WAIT_S = 10.0
"""The time to wait, s, for another program that writes."""

RETRY_S: Final = 0.01


@dataclass(frozen=True)
class Store:
    """An open store. `codec` knows the types of the products whose corrections are kept in it.

    `where`: its file or URL, without passwords. `unmade`: it is empty and in memory, until `made` makes its file.
    """

    engine: Engine
    codec: Codec
    where: str = ""
    unmade: bool = False

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Opens a transaction that reads. Raises STO-FILE, STO-BUSY."""
        with understood(self.where), self.engine.connect() as connection, connection.begin():
            yield connection

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Opens a transaction that writes: all that is done in it is kept, or nothing. Raises STO-BUSY, STO-WRITE."""
        with understood(self.where), self.engine.connect() as plain:
            connection = plain.execution_options(**{WRITING: True})
            with connection.begin():
                yield connection

    def made(self) -> "Store":
        """Returns the store itself; of one that is not made yet the store in its file. Raises STO errors."""
        return open_store(self.where, create=True, codec=self.codec) if self.unmade else self

    def close(self) -> None:
        """Ends the connections that are held open."""
        self.engine.dispose()


def open_store(
    where: str | Path,
    *,
    create: bool = False,
    codec: Codec | None = None,
    read_only: bool = False,
    wait_s: float = WAIT_S,
    unmade: bool = False,
) -> Store:
    """Opens the store in a SQLite file, or at the URL of a PostgreSQL database.

    `create` makes one in a new file or an empty database. A file of an older schema is migrated, in one transaction;
    a database that others share only with `create`. `wait_s`: how long a call waits for another program that writes;
    `unmade`: in memory, until `Store.made` makes the file.
    Raises STO-FILE, STO-SCHEMA, STO-BUSY, STO-WRITE, STO-DRIVER.
    """
    url = url_of(where)
    name = url.database if url.get_backend_name() == "sqlite" else ""
    opened = url_of("sqlite://") if unmade else url
    engine = engine_of(opened, wait_s, create=create, read_only=read_only)
    store = Store(engine, codec or values.CODEC.with_more(Correction), name or shown(str(where)), unmade)
    weakref.finalize(store, engine.dispose)  # commands end without closing it; PostgreSQL's connections are held open
    try:
        _made_ready(store, create or unmade, read_only, wait_s)
    except BaseException:
        store.close()
        raise
    return store


def keep(
    store: Store, kept: Iterable[Any], supersedes: int | None = None, *, by: str = "", why: str = ""
) -> list[Kept[Any]]:
    """Keeps values in one transaction: all or none. One that is there already is returned, not kept again.

    What they name (part types, parts, machines, tools, edges, settings) is kept with them where it is not there yet.
    `supersedes`: the row that the value replaces from now on, `by` whom and `why`. Raises STO-DIFFERS where
    a stored value of the same identity has another content and is not superseded, STO-UNKNOWN where there is no row to
    supersede, STO-BUSY and STO-WRITE.
    """
    given = list(kept)
    with store.writing() as connection:
        keeping = Keeping(store.codec, connection, by, why)
        return [keeping.keep(one, supersedes) for one in given]


def find(
    store: Store, kind: type[T], *, superseded: bool = False, whole: bool = True, **columns: str | None
) -> list[Kept[T]]:
    """Finds values of a type, oldest first, by the columns of `kinds`; superseded ones only with `superseded`.

    `whole`: False leaves out what is stored apart, which takes most of the time: values of inspections, and payloads of
    corrections, of which those that have one are found.

    `identity`, too, is a column: `find(store, Part, identity=joined(part.identity))`. Raises VAL-FORM for a correction
    whose product's codec the store was not opened with.
    """
    with store.reading() as connection:
        return list(found(connection, store.codec, Query(kind_of(kind), columns, superseded, whole=whole)))


def _made_ready(store: Store, create: bool, read_only: bool, wait_s: float) -> None:
    if not create:
        with store.reading() as connection:
            if not check_schema(connection, store.where):
                return
            if read_only or connection.dialect.name != "sqlite":
                raise older(connection, store.where)
    with store.writing() as connection:
        bring_up_to_date(connection, store.where)
    _keep_a_log(store, wait_s)


def _keep_a_log(store: Store, wait_s: float) -> None:
    """Writers then do not disturb readers: SQLite remembers it in the file."""
    if store.engine.dialect.name == "sqlite":
        with understood(store.where), store.engine.connect() as connection:
            raw: Any = connection.connection.dbapi_connection
            if raw.execute("PRAGMA journal_mode").fetchone()[0] == "wal":
                return
            until = time.monotonic() + wait_s
            while True:  # SQLite does not wait for this by itself, and anyone who reads the new file is in its way
                try:
                    raw.execute("PRAGMA journal_mode = WAL")
                    return
                except sqlite3.OperationalError:
                    if time.monotonic() > until:
                        raise
                    time.sleep(RETRY_S)


AT_ONCE: Final = 1000


def copy_rows(source: Store, target: Store, progress: Callable[[int], None]) -> int:
    """Copies every row of every table, as `source` is at one moment, and returns their number; all or none.

    `target` has tables of this version and no rows. `progress` is called with the rows copied so far. Raises STO-FILE,
    STO-BUSY, STO-WRITE.
    """
    count = 0
    with source.reading() as reading, target.writing() as writing:
        for table in METADATA.sorted_tables:
            for rows in _rows(reading, table):
                writing.execute(insert(table), rows)
                count += len(rows)
                progress(count)
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
