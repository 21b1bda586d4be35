"""The check that a store still has what was written into it: `damage` reads all of it and compares with the hashes."""

import sqlite3
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection, select
from sqlalchemy.exc import DatabaseError

from trueloop.errors import Code, TrueloopError
from trueloop.storage.keeping import AT_ONCE
from trueloop.storage.kinds import KINDS, Kind
from trueloop.storage.schema import ROWS, TABLES
from trueloop.storage.store import Store
from trueloop.storage.value_rows import FORMS, PIECE, RowForm, digest, rows_of

_MALFORMED: Final = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


@dataclass(frozen=True)
class Damage:
    """One thing that is not as it was written: of which table and row (None: of the whole), and why."""

    table: str
    row: int | None
    why: str


def damage(store: Store, after: int = 0) -> list[Damage]:
    """Returns the damage; `after`: rows up to this number are taken as good. Raises STO-FILE, STO-BUSY.

    SQLite checks its pages, indices and references itself; in PostgreSQL that is left to `pg_amcheck`. Then every
    row is hashed anew: document, payload, and the values of an inspection. A table whose pages SQLite cannot read is
    damaged as a whole.
    """
    found: list[Damage] = []
    try:
        with store.reading() as connection:
            found += (one for look in _whole(connection) for one in _readable("", look(connection)))
            for kind in KINDS:
                found += _readable(kind.table, _of_kind(connection, kind, after))
    except TrueloopError as wrong:  # SQLite may not even end the transaction on a damaged file
        if wrong.code is not Code.STO_FILE or not found:
            raise
    return list(dict.fromkeys(found))


def _whole(connection: Connection) -> tuple[Callable[[Connection], Iterator[Damage]], ...]:
    return (_pages, _references) if connection.dialect.name == "sqlite" else ()


def _readable(table: str, damages: Iterator[Damage]) -> Iterator[Damage]:
    try:
        yield from damages
    except (DatabaseError, sqlite3.DatabaseError) as wrong:  # what comes while rows are fetched is SQLite's own
        cause = getattr(wrong, "orig", wrong)
        if (getattr(cause, "sqlite_errorcode", 0) or 0) & 0xFF not in _MALFORMED:
            raise
        yield Damage(table, None, f"it cannot be read: {cause}")


def _pages(connection: Connection) -> Iterator[Damage]:
    for (said,) in connection.exec_driver_sql("PRAGMA integrity_check(20)"):
        if said != "ok":
            yield Damage("", None, str(said))


def _references(connection: Connection) -> Iterator[Damage]:
    for table, row, to, _ in connection.exec_driver_sql("PRAGMA foreign_key_check"):
        yield Damage(table, row, f"refers to a row of {to} that is not there")


def _of_kind(connection: Connection, kind: Kind, after: int) -> Iterator[Damage]:
    table = TABLES[kind.table]
    texts = ["document", "payload"] if kind.aside == "payload" else ["document"]
    columns = [table.c.id, table.c.sha256, *(table.c[name] for name in texts)]
    query = select(*columns).where(table.c.id > after).order_by(table.c.id)
    for piece in connection.execute(query.execution_options(yield_per=AT_ONCE)).partitions(AT_ONCE):
        for number, sha256, *held in piece:
            rows = _hashed_rows(connection, number) if kind.aside == "values" else ()
            if digest(held, rows) != sha256:
                yield Damage(kind.table, number, "its content is not what was kept")


def _hashed_rows(connection: Connection, inspection: int) -> Iterator[bytes]:
    for form in FORMS:
        rows: list[Any] = []
        for row in rows_of(connection, ROWS[form.table], [inspection]):
            rows.append(row)
            if len(rows) == PIECE:
                yield _hashed(form, rows)
                rows = []
        if rows:
            yield _hashed(form, rows)


def _hashed(form: RowForm, rows: list[Any]) -> bytes:
    _, *columns = map(list, zip(*rows, strict=True))
    return form.hashed(columns)
