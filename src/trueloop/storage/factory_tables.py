"""Tables of the factory beside those of values: progress of orders and parts, logs of events, accounts and rights.

Those of `LOGS` are append-only, as values are; those of `STATES` change, each row with a `version` where two could
change it at once. Times are text, ISO 8601 in UTC to the microsecond (`stamp`), so that they sort as they follow each
other; `document` is JSON. An export holds values alone: none of these tables, and so no account and no key.
"""

from datetime import UTC, datetime
from typing import Any, Final

from sqlalchemy import Column, Double, ForeignKey, Index, Integer, LargeBinary, MetaData, Table, Text, UniqueConstraint

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
