"""Writing values into a store, within one transaction: `Keeping`.

Reading values from a store, within one transaction: `found`.
"""

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import cache, lru_cache
from operator import itemgetter
from typing import Any, Final

from sqlalchemy import Connection, Row, Select, bindparam, func, insert, select
from sqlalchemy import Row as Result

from trueloop.domain.codec import Codec
from trueloop.errors import Code, TrueloopError
from trueloop.storage.kinds import Kind, joined, kind_of, searchable
from trueloop.storage.schema import ROWS, TABLES
from trueloop.storage.value_rows import FORMS, Encoded, Kept, encoded, insert_rows, rows_of

_BEFORE_HOST: Final = re.compile(r"(?<=://)([^/:?]*):.*@", re.DOTALL)
"""User and password: to the last `@`, for passwords are pasted with one in them."""
_IN_QUERY: Final = re.compile(r"([?&][^=&]*(?:pass|secret|%)[^=&]*=)[^&]*", re.IGNORECASE)
"""`password`, `sslpassword`, and names written with `%`, in which these could hide."""


def shown(place: str) -> str:
    """Returns a store's file or URL with passwords masked, whether before the host or in the query.

    >>> shown("postgresql://ana:secret@plant/parts")
    'postgresql://ana:***@plant/parts'
    >>> shown("postgresql://ana@plant/parts?password=secret&sslmode=require")
    'postgresql://ana@plant/parts?password=***&sslmode=require'
    """
    if "://" not in place:
        return place
    return _IN_QUERY.sub(r"\1***", _BEFORE_HOST.sub(r"\1:***@", place))


AT_ONCE = 500
"""Rows read before their inspections' values are."""
RECENT: Final = 64
SHORT: Final = 500_000
"""The latest documents of at most so many characters are kept decoded: one command reads the same again and again."""


@dataclass(frozen=True)
class Query:
    """A search: a kind, by columns or by row, with or without superseded values.

    `whole`: with what is stored apart from the document; else it is empty, and only values that have a payload are
    found of a kind that keeps it apart.
    """

    kind: Kind
    columns: Mapping[str, str | None] = field(default_factory=dict)
    superseded: bool = False
    row: int | None = None
    whole: bool = True

    def select(self) -> Select[Any]:
        """Returns the statement for all columns and the superseding row; it takes `parameters`."""
        columns = tuple((name, value is None) for name, value in self.columns.items())
        query = _asked(self.kind.table, self.superseded, columns, self.row is not None)
        return query if self.whole else _without_payload(self.kind, query)

    @property
    def parameters(self) -> dict[str, str | int | None]:
        """Returns the values searched for."""
        wanted: dict[str, str | int | None] = {
            f"the_{name}": searchable(value) for name, value in self.columns.items() if value is not None
        }
        return wanted if self.row is None else {**wanted, "the_row": self.row}


@cache
def _asked(name: str, superseded: bool, columns: tuple[tuple[str, bool], ...], by_row: bool) -> Select[Any]:
    """Made once, for it takes longer than the database; a column with True is to be NULL."""
    table, query = TABLES[name], _all_of(name, superseded)
    for column, absent in columns:
        query = query.where(table.c[column].is_(None) if absent else table.c[column] == bindparam(f"the_{column}"))
    return query.where(table.c.id == bindparam("the_row")) if by_row else query


@cache
def _without_payload(kind: Kind, query: Select[Any]) -> Select[Any]:
    """The statement for all columns but the payload, of rows that have one: JSON's null is none."""
    if kind.aside != "payload":
        return query
    payload = TABLES[kind.table].c.payload
    columns = [column for column in query.selected_columns if column.name != payload.name]
    return query.with_only_columns(*columns).where(func.substr(payload, 1, 4) != "null")


@cache
def _all_of(name: str, superseded: bool) -> Select[Any]:
    """Every row of a table."""
    table = TABLES[name]
    later = table.alias("later")
    joined_up = table.outerjoin(later, later.c.supersedes == table.c.id)
    query = select(table, later.c.id.label("superseded_by")).select_from(joined_up).order_by(table.c.id)
    return query if superseded else query.where(later.c.id.is_(None))


def found(connection: Connection, codec: Codec, query: Query) -> Iterator[Kept[Any]]:
    """Yields the values, oldest first."""
    for piece in connection.execute(query.select(), query.parameters).partitions(AT_ONCE):
        apart = values_of(connection, [row.id for row in piece]) if query.kind.aside == "values" and query.whole else {}
        for row in piece:
            yield kept(row, decoded(codec, query.kind, row, apart.get(row.id, ()), query.whole))


def kept(row: Result[Any], value: Any) -> Kept[Any]:
    """Returns a row with its value."""
    at = datetime.fromisoformat(row.kept_at)
    return Kept(
        row=row.id,
        value=value,
        kept_at=at,
        new=False,
        superseded_by=row.superseded_by,
        supersedes=row.supersedes,
        by=row.kept_by,
        why=row.reason,
    )


def decoded(codec: Codec, kind: Kind, row: Result[Any], values: tuple[Any, ...] = (), whole: bool = True) -> Any:
    """Decodes the value of a row. Raises VAL-FORM for what the codec does not know."""
    texts = (row.document, row.payload) if kind.aside == "payload" and whole else (row.document,)
    read = _recent if sum(map(len, texts)) <= SHORT else _read
    value = read(codec, kind.type, *texts)
    return replace(value, values=values) if values else value


def _read(codec: Codec, kind: type, document: str, payload: str | None = None) -> Any:
    if payload is None:
        return codec.from_json(document, kind)
    return codec.value(json.loads(document) | {"payload": json.loads(payload)}, kind)


_recent = lru_cache(RECENT)(_read)


def values_of(connection: Connection, inspections: list[int]) -> dict[int, tuple[Any, ...]]:
    """Returns the values of inspections by row number, each in its order."""
    numbered: dict[Any, list[tuple[Any, Any]]] = {}
    for form in FORMS:
        for row in rows_of(connection, ROWS[form.table], inspections):
            numbered.setdefault(row[0], []).append((row[1], form.read(row[2:])))
    by_position = itemgetter(0)
    return {number: tuple(one for _, one in sorted(values, key=by_position)) for number, values in numbered.items()}


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
