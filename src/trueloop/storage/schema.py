"""The tables of a store: made by `make_tables`, known again by `check_schema`.

Every kind of value has a table: `identity` is that of the value, `version` counts the rows of one identity, and
`supersedes` names the row that this one corrects. `sha256` is of the document with all that is stored apart from it.
"""

from collections.abc import Iterator
from typing import Any, Final

from sqlalchemy import (
    BigInteger,
    CheckConstraint,
    Column,
    Connection,
    Double,
    ForeignKey,
    Index,
    Integer,
    Table,
    Text,
    UniqueConstraint,
    inspect,
    text,
)

from trueloop.errors import Code
from trueloop.storage.factory_tables import LOGS, METADATA, STATES
from trueloop.storage.kinds import KINDS, Kind
from trueloop.storage.value_rows import FORMS, RowForm

__all__ = ["LOGS", "METADATA", "ROWS", "STATES", "TABLES"]

_TYPES: Final[dict[type, Any]] = {str: Text, float: Double, int: BigInteger}


def _table_of_kind(kind: Kind) -> Table:
    return Table(
        kind.table,
        METADATA,
        Column("id", Integer, primary_key=True),
        Column("identity", Text, nullable=False),
        Column("version", Integer, nullable=False),
        Column("kept_at", Text, nullable=False),
        Column("kept_by", Text, nullable=False),
        Column("supersedes", Integer, ForeignKey(f"{kind.table}.id")),
        Column("reason", Text, nullable=False),
        Column("sha256", Text, nullable=False),
        *(Column(name, Text) for name in kind.names),
        Column("document", Text, nullable=False),
        *([Column(kind.aside, Text, nullable=False)] if kind.aside == "payload" else []),
        UniqueConstraint("identity", "version", name=f"{kind.table}_once"),
        UniqueConstraint("supersedes", name=f"{kind.table}_superseded_once"),
        CheckConstraint("supersedes < id", name=f"{kind.table}_supersedes_earlier"),
        *(Index(f"{kind.table}_by_{names[0]}", *names) for names in _indexed(kind)),
    )


def _indexed(kind: Kind) -> list[tuple[str, ...]]:
    """One for each column; a serial number is asked for with its part type, or alone."""
    return [("serial", "part_type") if name == "serial" else (name,) for name in kind.names]


def _table_of_rows(form: RowForm) -> Table:
    return Table(
        form.table,
        METADATA,
        Column("inspection", Integer, ForeignKey("inspection.id"), primary_key=True, autoincrement=False),
        Column("position", Integer, primary_key=True, autoincrement=False),
        *(Column(cell.name, _TYPES[cell.of]) for cell in form.cells),
        Column("exact", Text),
        sqlite_with_rowid=False,
    )


TABLES: Final = {kind.table: _table_of_kind(kind) for kind in KINDS}
ROWS: Final = {form.table: _table_of_rows(form) for form in FORMS}


TODAY: Final = "0006"
"""The number of the schema: that of the first version that was published."""
_VERSION_TABLE: Final = "trueloop_schema"


def check_schema(connection: Connection, where: str) -> None:
    """Refuses a database that is not a store (STO-FILE) or has another schema (STO-SCHEMA)."""
    found = _schema_of(connection)
    if found is None:
        raise Code.STO_FILE.refusal(
            f"{where!r} is a database, but holds no store of trueloop",
            hint="make a store by `trueloop db init` in a file or database of its own",
        )
    if found != TODAY:
        older = "export it with the version that wrote it: `trueloop db export all.jsonl`; then, with this one, "
        raise Code.STO_SCHEMA.refusal(
            f"the store {where!r} has schema {found}, this version of trueloop reads and writes schema {TODAY}",
            hint="use the newer version of trueloop that wrote it"
            if found > TODAY
            else f"{older}`trueloop db restore all.jsonl --db new.db`",
        )


def make_tables(connection: Connection, where: str) -> None:
    """Makes the tables of an empty database; leaves a store as it is. Raises STO-FILE and STO-SCHEMA for others."""
    if _schema_of(connection) is not None:
        return check_schema(connection, where)
    if others := inspect(connection).get_table_names():
        raise Code.STO_FILE.refusal(
            f"{where!r} holds tables that are not trueloop's: {', '.join(sorted(others)[:5])}",
            hint="give the store a file or a database of its own",
        )
    METADATA.create_all(connection, checkfirst=False)
    for statement in _guards(connection.dialect.name == "sqlite"):
        connection.execute(text(statement))
    connection.exec_driver_sql(f"CREATE TABLE {_VERSION_TABLE} (version_num VARCHAR(32) NOT NULL PRIMARY KEY)")
    connection.exec_driver_sql(f"INSERT INTO {_VERSION_TABLE} VALUES ('{TODAY}')")


def _schema_of(connection: Connection) -> str | None:
    """Returns the schema's number as text; None: the database has nothing of trueloop's."""
    if not inspect(connection).has_table(_VERSION_TABLE):
        return None
    found = connection.scalar(text(f"SELECT version_num FROM {_VERSION_TABLE}"))
    return None if found is None else str(found)


def _guards(sqlite: bool) -> Iterator[str]:
    """Refuses every change of a row: in SQLite row by row, in PostgreSQL statements too, TRUNCATE among them."""
    if not sqlite:
        yield (
            "CREATE OR REPLACE FUNCTION trueloop_append_only() RETURNS trigger LANGUAGE plpgsql AS "
            "$$ BEGIN RAISE EXCEPTION 'append-only: %', TG_TABLE_NAME; END $$"
        )
    for table in (*TABLES, *ROWS, *(log.name for log in LOGS)):
        if sqlite:
            for change in ("UPDATE", "DELETE"):
                yield (
                    f"CREATE TRIGGER {table}_no_{change.lower()} BEFORE {change} ON {table} "
                    f"BEGIN SELECT RAISE(ABORT, 'append-only'); END"
                )
        else:
            yield (
                f"CREATE TRIGGER {table}_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON {table} "
                f"FOR EACH STATEMENT EXECUTE FUNCTION trueloop_append_only()"
            )
