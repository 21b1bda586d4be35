"""The factory: orders, runs and facts; how far orders and parts have come; events, alarms, tasks, accounts, keys."""

from typing import Any, Final

import sqlalchemy as sa
from alembic import op

from trueloop.storage.migrations.versions.v0001_first import guard, make_kind

revision: Final = "0003"
down_revision: Final = "0002"

KINDS: Final = {
    "work_order": ("part_type", "machine"),
    "run": ("work_order", "machine", "part_type", "serial"),
    "run_fact": ("run",),
}
LOGS: Final = {
    "event": "id at who what subject document",
    "transfer": "id at who control program_sha256 name direction sent_sha256 read_back_sha256 outcome document",
    "alarm": "id at source code said document machine part_type blocks:i",
    "alarm_acknowledged": "alarm:k>alarm.id at who why",
    "certificate": "id part:i>part.id at who sha256 verdict content:b",
    "program_release": "program_sha256:k at who why",
    "temperature": "id machine run signal at celsius:d",
    "run_touches": "id run at name sha256 content:b",
    "calibration": "id machine at who document",
}
STATES: Final = {
    "order_state": "order:k state machine changed_at number:i version:i armed_parts:i",
    "part_state": "part:k>part.id state order machine changed_at held_why version:i",
    "step": "order:k part:k>part.id no:k kind state run program_sha256 changed_at attempts:i version:i",
    "task": "id kind subject state document said lease_until? problem? result? worker made_by made_at changed_at "
    "tries:i progress:d",
    "account": "id name display argon2id oidc_subject? role language created_at disabled:i version:i",
    "session": "id_sha256:k account:i>account.id created_at seen_at expires_at ended_at? address",
    "api_key": "id machine name key_sha256 scope expires_at ended_at? made_by created_at",
    "idempotency": "account:k key:k request_sha256 status:i body:b created_at",
    "upload": "id by name sha256 created_at content:b",
    "attempt": "id subject address failed_at",
    "machine_heard": "machine:k at document",
}
INDEXES: Final = (
    *("event subject", "transfer control", "transfer program_sha256", "alarm machine", "alarm part_type"),
    *("certificate part", "temperature run", "temperature machine at", "calibration machine at"),
    *("order_state machine state", "order_state number", "part_state order", "part_state state part"),
    *(
        "part_state changed_at",
        "step part",
        "step run",
        "step state kind",
        "step program_sha256",
        "task state id",
        "task subject",
        "session account",
    ),
    *("idempotency created_at", "attempt subject", "attempt address"),
)
ONCE: Final[dict[str, dict[str, tuple[str, ...]]]] = {
    "run_touches": {"run_touches_once": ("run", "sha256")},
    "account": {"account_once": ("name",), "account_once_of_subject": ("oidc_subject",)},
    "api_key": {"api_key_once": ("key_sha256",)},
}
WHOLE: Final = ("id", "part", "no", "alarm")
"""Keys that are whole numbers; all others are text."""
TYPES: Final[dict[str, Any]] = {"": sa.Text, "d": sa.Double, "i": sa.Integer, "b": sa.LargeBinary}


def upgrade() -> None:
    """Makes the tables and what guards those that are append-only."""
    for table, columns in KINDS.items():
        make_kind(table, columns)
    for table, said in (LOGS | STATES).items():
        once = [sa.UniqueConstraint(*columns, name=name) for name, columns in ONCE.get(table, {}).items()]
        op.create_table(table, *(_column(one) for one in said.split()), *once)
    for index in INDEXES:
        table, *names = index.split()
        op.create_index(f"{table}_by_{'_'.join(names)}", table, names)
    guard((*KINDS, *LOGS))


def _column(said: str) -> sa.Column[Any]:
    """`name:type>reference`, with `?` where it may be NULL; type `k`: of the key."""
    stated, _, refers = said.partition(">")
    name, _, kind = stated.rstrip("?").partition(":")
    to = [sa.ForeignKey(refers)] if refers else []
    if name == "id":
        return sa.Column("id", sa.Integer, primary_key=True)
    if kind == "k":
        of = sa.Integer if name in WHOLE else sa.Text
        return sa.Column(name, of, *to, primary_key=True, autoincrement=False)
    return sa.Column(name, TYPES[kind], *to, nullable=said.endswith("?"))
