"""Writing values into a store, within one transaction: `Keeping`."""

from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Row, insert, select

from trueloop.domain.codec import Codec
from trueloop.errors import Code, TrueloopError
from trueloop.storage.encoded import Encoded, Kept, encoded, insert_rows
from trueloop.storage.kinds import Kind, joined, kind_of, searchable
from trueloop.storage.reading import Query, found, kept
from trueloop.storage.schema import ROWS, TABLES


@dataclass
class Keeping:
    """One transaction's work: `by` whom values are kept, and `why` one supersedes another.

    `there` are the identities that were seen in this transaction, by table: what a thousand inspections name is looked
    up once.
    """

    codec: Codec
    connection: Connection
    by: str = ""
    why: str = ""
    there: set[tuple[str, str]] = field(default_factory=set)

    def keep(self, value: Any, supersedes: int | None = None, kept_at: datetime | None = None) -> Kept[Any]:
        """Returns the value's row, existing or inserted; `kept_at`: the time of a row copied from another store."""
        kind = kind_of(type(value))
        self._keep_named(kind, value)
        content = encoded(self.codec, kind, value)
        rows = self._rows_of(kind, content.columns["identity"])
        equal = {row.id for row in rows if row.sha256 == content.columns["sha256"] or self._equal(kind, row.id, value)}
        same = _same([row for row in rows if row.id in equal], supersedes, copied=kept_at is not None)
        if same is not None:
            return kept(same, value)
        self._check(kind, rows, supersedes)
        return self._inserted(kind, value, content, len(rows) + 1, supersedes, kept_at or datetime.now(UTC))

    def _keep_named(self, kind: Kind, value: Any) -> None:
        """Keeps the values that a value names as first stored; the value's own document has its names for them."""
        for named in kind.refers(value):
            table, identity = kind_of(type(named)).table, searchable(joined(named.identity))
            key = (table, str(identity))
            if key in self.there:
                continue
            if not self._rows_of(kind_of(type(named)), key[1]):
                self.keep(named)
            self.there.add(key)

    def _rows_of(self, kind: Kind, identity: str) -> list[Row[Any]]:
        table = TABLES[kind.table]
        later = table.alias("later")
        columns = (table.c.id, table.c.sha256, table.c.kept_at, table.c.kept_by, table.c.supersedes, table.c.reason)
        query = select(*columns, later.c.id.label("superseded_by")).select_from(
            table.outerjoin(later, later.c.supersedes == table.c.id)
        )
        return list(self.connection.execute(query.where(table.c.identity == identity).order_by(table.c.version)))

    def _equal(self, kind: Kind, row: int, value: Any) -> bool:
        """Returns whether a row is the same value written otherwise, as an earlier version of trueloop did."""
        with suppress(TrueloopError):
            (stored,) = found(self.connection, self.codec, Query(kind, superseded=True, row=row))
            return bool(stored.value == value)
        return False

    def _check(self, kind: Kind, rows: list[Row[Any]], supersedes: int | None) -> None:
        standing = [row.id for row in rows if row.superseded_by is None]
        if standing and supersedes not in standing:
            raise Code.STO_DIFFERS.refusal(
                f"this {kind.words} is stored already as row {standing[-1]}, with another content",
                hint="what is stored never changes: name the row that the new one supersedes",
            )
        if supersedes is not None and supersedes not in standing:
            self._check_may_be_superseded(kind, supersedes)

    def _check_may_be_superseded(self, kind: Kind, row: int) -> None:
        table = TABLES[kind.table]
        if self.connection.scalar(select(table.c.id).where(table.c.id == row)) is None:
            raise Code.STO_UNKNOWN.refusal(
                f"there is no {kind.words} in row {row} to supersede", hint="look it up by find"
            )
        later = self.connection.scalar(select(table.c.id).where(table.c.supersedes == row))
        if later is not None:
            raise Code.STO_DIFFERS.refusal(
                f"the {kind.words} in row {row} is superseded already, by row {later}",
                hint=f"supersede row {later} instead",
            )

    def _inserted(
        self, kind: Kind, value: Any, content: Encoded, version: int, supersedes: int | None, at: datetime
    ) -> Kept[Any]:
        table = TABLES[kind.table]
        before = self.connection.scalar(select(table.c.kept_at).order_by(table.c.id.desc()).limit(1))
        why = "" if supersedes is None else self.why
        row = {
            **{"version": version, "kept_at": at.isoformat(), "kept_by": self.by, "supersedes": supersedes},
            **{"reason": why, **content.columns},
        }
        done = self.connection.execute(insert(table).values(**row))
        number = int((done.inserted_primary_key or (0,))[0])
        for name, pieces in content.rows.items():
            insert_rows(self.connection, ROWS[name], number, pieces)
        back = before is not None and datetime.fromisoformat(before) > at
        return Kept(
            row=number,
            value=value,
            kept_at=at,
            new=True,
            superseded_by=None,
            supersedes=supersedes,
            by=self.by,
            why=why,
            clock_back=back,
        )


def _same(same: list[Row[Any]], supersedes: int | None, *, copied: bool) -> Row[Any] | None:
    """Of rows with this content: the one that supersedes what is to be superseded, or still stands."""
    exactly = [row for row in same if row.supersedes == supersedes]
    if copied and exactly:
        return exactly[0]
    if supersedes is None:
        return same[-1] if same else None
    wanted = [row for row in same if row.supersedes == supersedes or (row.id == supersedes and not row.superseded_by)]
    return wanted[-1] if wanted else None
