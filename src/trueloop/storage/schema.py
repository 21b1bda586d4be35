"""The tables of a store: made by `make_tables`, known again by `check_schema`.

Every kind of value has a table: `identity` is that of the value, `version` counts the rows of one identity, and
`supersedes` names the row that this one corrects. `sha256` is of the document with all that is stored apart from it.

Tables of the factory beside those of values: progress of orders and parts, logs of events, accounts and rights.

Those of `LOGS` are append-only, as values are; those of `STATES` change, each row with a `version` where two could
change it at once. Times are text, ISO 8601 in UTC to the microsecond (`stamp`), so that they sort as they follow each
other; `document` is JSON. An export holds values alone: none of these tables, and so no account and no key.
"""

from collections.abc import Iterator
from datetime import UTC, datetime
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
    LargeBinary,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
    inspect,
    text,
)

from trueloop.errors import Code
from trueloop.storage.kinds import KINDS, Kind
from trueloop.storage.value_rows import FORMS, RowForm

METADATA: Final = MetaData()


def stamp(at: datetime) -> str:
    """Returns a time in the form of the tables. Raises ValueError for one without a zone, which is ambiguous."""
    if at.tzinfo is None:
        raise ValueError(f"{at} has no zone")
    return at.astimezone(UTC).isoformat(timespec="microseconds")


def _table(name: str, *columns: Any, indexed: tuple[tuple[str, ...], ...] = ()) -> Table:
    return Table(name, METADATA, *columns, *(Index(f"{name}_by_{'_'.join(one)}", *one) for one in indexed))


def _id() -> Column[int]:
    return Column("id", Integer, primary_key=True)


def _text(*names: str) -> list[Column[str]]:
    return [Column(name, Text, nullable=False) for name in names]


def _maybe(*names: str) -> list[Column[str]]:
    return [Column(name, Text) for name in names]


def _count(*names: str) -> list[Column[int]]:
    return [Column(name, Integer, nullable=False) for name in names]


def _part() -> Column[int]:
    return Column("part", Integer, ForeignKey("part.id"), nullable=False)


def _part_key() -> Column[int]:
    return Column("part", Integer, ForeignKey("part.id"), primary_key=True, autoincrement=False)


EVENT: Final = _table("event", _id(), *_text("at", "who", "what", "subject", "document"), indexed=(("subject",),))
TRANSFER: Final = _table(
    "transfer",
    *(_id(), *_text("at", "who", "control", "program_sha256", "name", "direction", "sent_sha256")),
    *_text("read_back_sha256", "outcome", "document"),
    indexed=(("control",), ("program_sha256",)),
)
ALARM: Final = _table(
    "alarm",
    *(_id(), *_text("at", "source", "code", "said", "document", "machine", "part_type")),
    *_count("blocks"),
    indexed=(("machine",), ("part_type",)),
)
"""`blocks`: 1 where no finish cut starts before it is acknowledged, on its machine or of its part type (empty: any)."""
ALARM_ACKNOWLEDGED: Final = _table(
    "alarm_acknowledged",
    Column("alarm", Integer, ForeignKey("alarm.id"), primary_key=True, autoincrement=False),
    *_text("at", "who", "why"),
)
CERTIFICATE: Final = _table(
    "certificate",
    *(_id(), _part(), *_text("at", "who", "sha256", "verdict"), Column("content", LargeBinary, nullable=False)),
    indexed=(("part",),),
)
PROGRAM_RELEASE: Final = _table(
    "program_release", Column("program_sha256", Text, primary_key=True), *_text("at", "who", "why")
)
TEMPERATURE: Final = _table(
    "temperature",
    *(_id(), *_text("machine", "run", "signal", "at"), Column("celsius", Double, nullable=False)),
    indexed=(("run",), ("machine", "signal", "at")),
)
RUN_TOUCHES: Final = _table(
    "run_touches",
    *(_id(), *_text("run", "at", "name", "sha256"), Column("content", LargeBinary, nullable=False)),
    UniqueConstraint("run", "sha256", name="run_touches_once"),
)
CALIBRATION: Final = _table(
    "calibration", _id(), *_text("machine", "at", "who", "document"), indexed=(("machine", "at"),)
)
"""The table of calibrations of a machine's probe."""

ORDER_STATE: Final = _table(
    "order_state",
    Column("order", Text, primary_key=True),
    *_text("state", "machine", "changed_at"),
    *_count("number", "version", "armed_parts"),
    indexed=(("machine", "state"), ("number",)),
)
PART_STATE: Final = _table(
    "part_state",
    *(_part_key(), *_text("state", "order", "machine", "changed_at", "held_why"), *_count("version")),
    indexed=(("order",), ("state", "part"), ("changed_at",)),
)
STEP: Final = _table(
    "step",
    Column("order", Text, primary_key=True),
    _part_key(),
    Column("no", Integer, primary_key=True, autoincrement=False),
    *_text("kind", "state", "run", "program_sha256", "changed_at"),
    *_count("attempts", "version"),
    indexed=(("part",), ("run",), ("state", "kind"), ("program_sha256",)),
)
TASK: Final = _table(
    "task",
    *(_id(), *_text("kind", "subject", "state", "document", "said"), *_maybe("lease_until", "problem", "result")),
    *(*_text("worker", "made_by", "made_at", "changed_at"), *_count("tries")),
    Column("progress", Double, nullable=False),
    indexed=(("state", "id"), ("subject",)),
)
ACCOUNT: Final = _table(
    "account",
    *(_id(), *_text("name", "display", "argon2id"), *_maybe("oidc_subject"), *_text("role", "language", "created_at")),
    *_count("disabled", "version"),
    Column("unit", Text, nullable=False, server_default="mm"),
    UniqueConstraint("name", name="account_once"),
    UniqueConstraint("oidc_subject", name="account_once_of_subject"),
)
"""`unit`: of the lengths that the pages show to its holder, mm or inch."""
SESSION: Final = _table(
    "session",
    Column("id_sha256", Text, primary_key=True),
    Column("account", Integer, ForeignKey("account.id"), nullable=False),
    *(*_text("created_at", "seen_at", "expires_at"), *_maybe("ended_at"), *_text("address")),
    indexed=(("account",),),
)
API_KEY: Final = _table(
    "api_key",
    *(_id(), *_text("machine", "name", "key_sha256", "scope", "expires_at"), *_maybe("ended_at")),
    *_text("made_by", "created_at"),
    UniqueConstraint("key_sha256", name="api_key_once"),
)
BEGUN: Final = 0
DONE: Final = 1
"""States of a request in place of its answer's status: begun; has changed something and is not answered yet."""
IDEMPOTENCY: Final = _table(
    "idempotency",
    *(Column("account", Text, primary_key=True), Column("key", Text, primary_key=True)),
    *(*_text("request_sha256"), Column("status", Integer, nullable=False)),
    *(Column("body", LargeBinary, nullable=False), *_text("created_at")),
    indexed=(("created_at",),),
)
UPLOAD: Final = _table(
    "upload", _id(), *_text("by", "name", "sha256", "created_at"), Column("content", LargeBinary, nullable=False)
)
MACHINE_HEARD: Final = _table("machine_heard", Column("machine", Text, primary_key=True), *_text("at", "document"))

LOGS: Final = (
    *(EVENT, TRANSFER, ALARM, ALARM_ACKNOWLEDGED, CERTIFICATE, PROGRAM_RELEASE, TEMPERATURE, RUN_TOUCHES),
    CALIBRATION,
)
STATES: Final = (*(ORDER_STATE, PART_STATE, STEP, TASK, ACCOUNT, SESSION, API_KEY, IDEMPOTENCY, UPLOAD, MACHINE_HEARD),)


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
