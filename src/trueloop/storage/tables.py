"""The store's tables as they are today; how they came to be so: `migrations/`.

Every kind of value has a table: `identity` is that of the value, `version` counts the rows of one identity, and
`supersedes` names the row that this one corrects. `sha256` is of the document with all that is stored apart from it.
"""

from typing import Any, Final

from sqlalchemy import (
    BigInteger,
    CheckConstraint,
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    Table,
    Text,
    UniqueConstraint,
)

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
        *(_index(kind.table, names) for names in _indexed(kind)),
    )


def _index(table: str, names: tuple[str, ...]) -> Index:
    return Index(f"{table}_by_{names[0]}", *names)


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
