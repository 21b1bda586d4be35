"""The schema of a store and its migration to today's: `check_schema`, `bring_up_to_date`.

The store's tables as they are today; how they came to be so: `migrations/`.

Every kind of value has a table: `identity` is that of the value, `version` counts the rows of one identity, and
`supersedes` names the row that this one corrects. `sha256` is of the document with all that is stored apart from it.
"""

from pathlib import Path
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

from trueloop.errors import Code, TrueloopError
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
"""The schema that this version of trueloop writes: the newest of `migrations/versions`."""
_VERSION_TABLE: Final = "trueloop_schema"
_SCRIPTS: Final = Path(__file__).with_name("migrations")
NEW_FILE: Final = _SCRIPTS / "today.sql"
"""The statements that make a new SQLite store, a line each: the result of all migrations, without Alembic, whose import
and run take 0.3 s.
"""


def schema_of(connection: Connection) -> str | None:
    """Returns the schema's number as text; None: the database has nothing of trueloop's."""
    if not inspect(connection).has_table(_VERSION_TABLE):
        return None
    found = connection.scalar(text(f"SELECT version_num FROM {_VERSION_TABLE}"))
    return None if found is None else str(found)


def check_schema(connection: Connection, where: str) -> bool:
    """Refuses a database that is not a store (STO-FILE) or has a newer schema (STO-SCHEMA); whether it has an older."""
    found = schema_of(connection)
    if found is None:
        raise Code.STO_FILE.refusal(
            f"{where!r} is a database, but holds no store of trueloop",
            hint="make a store by `trueloop db init` in a file or database of its own",
        )
    if found > TODAY:
        raise Code.STO_SCHEMA.refusal(
            f"the store {where!r} has schema {found}, this version of trueloop knows schemas up to {TODAY}",
            hint="use the newer version of trueloop that wrote it",
        )
    return found < TODAY


def older(connection: Connection, where: str) -> TrueloopError:
    """Returns the refusal STO-SCHEMA of an older schema that is not migrated on opening."""
    return Code.STO_SCHEMA.refusal(
        f"the store {where!r} has schema {schema_of(connection)}, this version of trueloop writes schema {TODAY}",
        hint="`trueloop db init` with its URL migrates a store in PostgreSQL, once all who share it have this version; "
        "a file is migrated when a command opens it that may write",
    )


def bring_up_to_date(connection: Connection, where: str) -> None:
    """Makes the tables of an empty database, or migrates those of an earlier schema, in the transaction under way.

    Raises STO-FILE for a database that holds other tables, STO-SCHEMA for a newer schema.
    """
    found = schema_of(connection)
    if found == TODAY:
        return
    if found is not None and found > TODAY:
        check_schema(connection, where)
    if found is None and (others := inspect(connection).get_table_names()):
        raise Code.STO_FILE.refusal(
            f"{where!r} holds tables that are not trueloop's: {', '.join(sorted(others)[:5])}",
            hint="give the store a file or a database of its own",
        )
    if found is None and connection.dialect.name == "sqlite":
        for statement in NEW_FILE.read_text("utf-8").splitlines():
            connection.exec_driver_sql(statement)
        return
    migrate_to("head", connection)


def statements_of(connection: Connection) -> str:
    """Returns the statements that make the store in a SQLite database as it is, as in `NEW_FILE`."""
    made = connection.scalars(text("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY rowid"))
    version = f"INSERT INTO {_VERSION_TABLE} VALUES ('{schema_of(connection)}')"
    return "".join(f"{' '.join(statement.split())}\n" for statement in (*made, version))


def migrate_to(revision: str, connection: Connection) -> None:
    """Runs the migrations up to one, or to the newest: "head"."""
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(_SCRIPTS).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    config.attributes["connection"] = connection
    config.attributes["version_table"] = _VERSION_TABLE
    command.upgrade(config, revision)
