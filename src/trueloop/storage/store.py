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
from functools import cache
from pathlib import Path
from typing import Any, Final, TypeVar

from sqlalchemy import Connection, Engine, Select, Table, bindparam, func, insert, select

from trueloop.domain import values
from trueloop.domain.codec import Codec
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Identity, InspectionLink
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, Record
from trueloop.storage.engines import WRITING, engine_of, understood, url_of
from trueloop.storage.keeping import Keeping, Query, found, kept, shown
from trueloop.storage.kinds import joined, kind_of, searchable
from trueloop.storage.schema import METADATA, TABLES, check_schema, make_tables
from trueloop.storage.value_rows import Kept

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

    `create` makes one in a new file or an empty database. `wait_s`: how long a call waits for another program that
    writes; `unmade`: in memory, until `Store.made` makes the file.
    Raises STO-FILE, STO-SCHEMA, STO-BUSY, STO-WRITE, STO-DRIVER.
    """
    url = url_of(where)
    name = url.database if url.get_backend_name() == "sqlite" else ""
    opened = url_of("sqlite://") if unmade else url
    engine = engine_of(opened, wait_s, create=create, read_only=read_only)
    store = Store(engine, codec or values.CODEC.with_more(Correction), name or shown(str(where)), unmade)
    weakref.finalize(store, engine.dispose)  # commands end without closing it; PostgreSQL's connections are held open
    try:
        _made_ready(store, create or unmade, wait_s)
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


def _made_ready(store: Store, create: bool, wait_s: float) -> None:
    if not create:
        with store.reading() as connection:
            return check_schema(connection, store.where)
    with store.writing() as connection:
        make_tables(connection, store.where)
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


_SEVERAL = 500
"""Cuts asked for at once."""


@dataclass(frozen=True)
class Life:
    """One part: its cuts and inspections, which inspection shows which cut, and the records of its corrections.

    Each oldest first as it was kept, without what is superseded. `corrections` are those in the programs of its cuts
    and those made from its inspections, without their payload: `find` gives it.
    """

    part: Part
    cuts: tuple[Kept[Cut], ...]
    inspections: tuple[Kept[Inspection], ...]
    links: tuple[Kept[InspectionLink], ...]
    corrections: tuple[Kept[Record], ...]

    def cut_of(self, inspection: Inspection) -> Cut | None:
        """Returns the cut that an inspection shows; None where no link names it."""
        shown: dict[Identity, Identity] = {link.value.inspection: link.value.cut for link in self.links}
        wanted = shown.get(inspection.identity)
        return next((cut.value for cut in self.cuts if cut.value.identity == wanted), None)


def life(store: Store, part: Part) -> Life:
    """Returns everything about one part; empty where the store has nothing about it."""
    with store.reading() as connection:
        return life_in(connection, store.codec, part)


def life_in(connection: Connection, codec: Codec, part: Part) -> Life:
    """Reads a part's life within a transaction."""
    own = {"part_type": part.part_type.name, "serial": part.serial}
    every = {
        kind: [
            stored
            for stored in found(connection, codec, Query(kind_of(kind), own))
            if stored.value.part.identity == part.identity
        ]
        for kind in (Cut, Inspection)
    }
    links = _links(connection, codec, [joined(stored.value.identity) for stored in every[Cut]])
    named = {str(stored.value.correction) for stored in every[Cut]} - {""}
    return Life(
        part, tuple(every[Cut]), tuple(every[Inspection]), links, tuple(_records(connection, codec, part, named))
    )


def _links(connection: Connection, codec: Codec, cuts: list[str]) -> tuple[Kept[InspectionLink], ...]:
    kind = kind_of(InspectionLink)
    each = (stored for cut in cuts for stored in found(connection, codec, Query(kind, {"cut": cut})))
    return tuple(sorted(each, key=lambda stored: stored.row))


def _records(connection: Connection, codec: Codec, part: Part, named: set[str]) -> list[Kept[Record]]:
    """By the ids that cuts name, and by the part whose inspections they were made from."""
    identities = [searchable(joined((one,))) for one in sorted(named)[:_SEVERAL]]
    own = {"the_serial": searchable(part.serial), "the_type": searchable(part.part_type.name)}
    rows = {row.id: row for row in connection.execute(_of_part(), own)}
    if identities:
        rows |= {row.id: row for row in connection.execute(_of_ids(), {"ids": identities})}
    records = [kept(rows[number], _record(codec, rows[number].document)) for number in sorted(rows)]
    return [record for record in records if record.value.id in named or _is_of(record.value, part)]


@cache
def _standing() -> Select[Any]:
    """Corrections that nothing supersedes, without their payloads."""
    table = TABLES["correction"]
    later = table.alias("later")
    columns = [column for column in table.columns if column.name != "payload"]
    joined_up = table.outerjoin(later, later.c.supersedes == table.c.id)
    return select(*columns, later.c.id.label("superseded_by")).select_from(joined_up).where(later.c.id.is_(None))


@cache
def _of_ids() -> Select[Any]:
    return _standing().where(TABLES["correction"].c.identity.in_(bindparam("ids", expanding=True)))


@cache
def _of_part() -> Select[Any]:
    table = TABLES["correction"]
    return _standing().where(table.c.serial == bindparam("the_serial"), table.c.part_type == bindparam("the_type"))


def _record(codec: Codec, document: str) -> Record:
    correction: Correction[None] = codec.from_json(document, Correction)
    return correction.record


def _is_of(record: Record, part: Part) -> bool:
    return any(inspection.part.identity == part.identity for inspection in record.inspections)
