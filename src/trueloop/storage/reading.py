"""Reading values from a store, within one transaction: `found`."""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import cache, lru_cache
from operator import itemgetter
from typing import Any, Final

from sqlalchemy import Connection, Select, bindparam, func, select
from sqlalchemy import Row as Result

from trueloop.domain.codec import Codec
from trueloop.storage.encoded import Kept, rows_of
from trueloop.storage.kinds import Kind, searchable
from trueloop.storage.schema import ROWS, TABLES
from trueloop.storage.value_rows import FORMS

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
