"""The first schema: a table for each kind of value, values of inspections in rows; append-only."""

from collections.abc import Sequence
from typing import Any, Final

import sqlalchemy as sa
from alembic import op

revision: Final = "0001"
down_revision: Final = None

KINDS: Final = {
    "part_type": ("part_type",),
    "part": ("part_type", "serial"),
    "machine": ("machine",),
    "tool": ("tool",),
    "edge": ("tool",),
    "setting": ("edge",),
    "program": ("program_sha256",),
    "program_text": ("program_sha256",),
    "cut": ("part_type", "serial", "stage", "edge", "correction"),
    "inspection": ("part_type", "serial", "file_sha256"),
    "inspection_link": ("cut",),
    "quarantine": ("cut",),
    "edge_event": ("edge", "event"),
    "correction": ("part_type", "serial", "edge", "program_sha256", "product"),
    "proposal": ("part_type", "changes"),
    "proposal_decision": ("verdict",),
    "part_cut_with": (),
}
ROWS: Final = {
    "touch": (
        *("point:t", "feature:t", "nominal_x_mm:d", "nominal_z_mm:d", "measured_x_mm:d", "measured_z_mm:d"),
        *("error_mm:d", "line:i"),
    ),
    "reading": (
        *("characteristic:t", "quantity:t", "actual:d", "nominal:d", "lower_limit:d", "upper_limit:d", "feature:t"),
        *("other:t", "axis:t", "place_count:i", "place_1_mm:d", "place_2_mm:d", "place_3_mm:d", "repeat:i"),
        *("standard_u:d", "measured_at:t", "temperature_c:d", "line:i", "side:t"),
    ),
    "cmm_point": (
        *("name:t", "measured_x_mm:d", "measured_y_mm:d", "measured_z_mm:d", "nominal_x_mm:d", "nominal_y_mm:d"),
        *("nominal_z_mm:d", "normal_x:d", "normal_y:d", "normal_z:d"),
    ),
}
TYPES: Final[dict[str, Any]] = {"t": sa.Text, "d": sa.Double, "i": sa.BigInteger}


def upgrade() -> None:
    """Makes the tables and what guards them."""
    for table, columns in KINDS.items():
        make_kind(table, columns)
    for table, cells in ROWS.items():
        _make_rows(table, [cell.split(":") for cell in cells])
    guard((*KINDS, *ROWS))


def make_kind(table: str, columns: Sequence[str]) -> None:
    """Creates the table of a kind of value, with an index for each column that it is searched by."""
    op.create_table(
        table,
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("identity", sa.Text, nullable=False),
        sa.Column("version", sa.Integer, nullable=False),
        sa.Column("kept_at", sa.Text, nullable=False),
        sa.Column("kept_by", sa.Text, nullable=False),
        sa.Column("supersedes", sa.Integer, sa.ForeignKey(f"{table}.id")),
        sa.Column("reason", sa.Text, nullable=False),
        sa.Column("sha256", sa.Text, nullable=False),
        *(sa.Column(name, sa.Text) for name in columns),
        sa.Column("document", sa.Text, nullable=False),
        *([sa.Column("payload", sa.Text, nullable=False)] if table == "correction" else []),
        sa.UniqueConstraint("identity", "version", name=f"{table}_once"),
        sa.UniqueConstraint("supersedes", name=f"{table}_superseded_once"),
        sa.CheckConstraint("supersedes < id", name=f"{table}_supersedes_earlier"),
    )
    for name in columns:
        op.create_index(f"{table}_by_{name}", table, ["serial", "part_type"] if name == "serial" else [name])


def _make_rows(table: str, cells: Sequence[Sequence[str]]) -> None:
    op.create_table(
        table,
        sa.Column("inspection", sa.Integer, sa.ForeignKey("inspection.id"), primary_key=True, autoincrement=False),
        sa.Column("position", sa.Integer, primary_key=True, autoincrement=False),
        *(sa.Column(name, TYPES[kind]) for name, kind in cells),
        sa.Column("exact", sa.Text),
        sqlite_with_rowid=False,
    )


def guard(tables: Sequence[str]) -> None:
    """Refuses every change of a row: in SQLite row by row, in PostgreSQL statements too, TRUNCATE among them."""
    if op.get_bind().dialect.name == "sqlite":
        for table in tables:
            for change in ("UPDATE", "DELETE"):
                op.execute(
                    f"CREATE TRIGGER {table}_no_{change.lower()} BEFORE {change} ON {table} "
                    f"BEGIN SELECT RAISE(ABORT, 'append-only'); END"
                )
        return
    op.execute(
        "CREATE OR REPLACE FUNCTION trueloop_append_only() RETURNS trigger LANGUAGE plpgsql AS "
        "$$ BEGIN RAISE EXCEPTION 'append-only: %', TG_TABLE_NAME; END $$"
    )
    for table in tables:
        op.execute(
            f"CREATE TRIGGER {table}_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON {table} "
            f"FOR EACH STATEMENT EXECUTE FUNCTION trueloop_append_only()"
        )
