"""Whether a store holds what was written into it: `damage` reads all of it and compares with the hashes."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, select

from trueloop.storage.bulk import rows_of
from trueloop.storage.encoded import digest
from trueloop.storage.kinds import KINDS, Kind
from trueloop.storage.reading import AT_ONCE
from trueloop.storage.store import Store
from trueloop.storage.tables import ROWS, TABLES
from trueloop.storage.value_rows import FORMS, PIECE, RowForm


@dataclass(frozen=True)
class Damage:
    """One thing that is not as it was written: of which table and row (None: of the whole), and why."""

    table: str
    row: int | None
    why: str


def damage(store: Store, after: int = 0) -> list[Damage]:
    """What is damaged; `after`: rows up to this number are taken as good. Raises STO-FILE, STO-BUSY.

    SQLite is asked for the order of its pages, indices and references; PostgreSQL's own are `pg_amcheck`'s. Then every
    row is hashed anew: document, payload, and the values of an inspection.
    """
    with store.reading() as connection:
        whole = list(_of_file(connection)) if connection.dialect.name == "sqlite" else []
        return [*whole, *(one for kind in KINDS for one in _of_kind(connection, kind, after))]


def _of_file(connection: Connection) -> Iterator[Damage]:
    for (said,) in connection.exec_driver_sql("PRAGMA integrity_check(20)"):
        if said != "ok":
            yield Damage("", None, str(said))
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
