"""Keeping domain values and finding them again: `open_store`, `keep`, `find`, `supersede`.

>>> from trueloop.domain.part import Part, PartType
>>> store = open_store("sqlite://", create=True)
>>> part = Part(PartType("MODBAS2"), "2511")
>>> keep(store, [part])[0].new, keep(store, [part])[0].new  # the same value twice is one row
(True, False)
>>> [one.value.serial for one in find(store, Part, part_type="MODBAS2")]
['2511']
"""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Generic, TypeVar

from sqlalchemy import Column, Connection, Engine, Integer, MetaData, Table, Text, create_engine, insert, select

from trueloop.domain import values
from trueloop.domain.codec import Codec
from trueloop.domain.correction import Correction
from trueloop.errors import Code, TrueloopError
from trueloop.storage.kinds import KINDS, Kind, joined

T = TypeVar("T")


@dataclass(frozen=True)
class Store:
    """An open store. `codec` knows the types of the products whose corrections are kept in it."""

    engine: Engine
    codec: Codec


@dataclass(frozen=True)
class Kept(Generic[T]):
    """A value in the store: its row, when it was kept, and whether this call kept it. `superseded_by`: another row."""

    row: int
    value: T
    kept_at: datetime
    new: bool = False
    superseded_by: int | None = None


def open_store(where: str | Path, *, create: bool = False, codec: Codec | None = None) -> Store:
    """The store in a SQLite file, or at an SQLAlchemy URL. Raises STO-FILE, STO-SCHEMA, STO-WRITE."""
    url = str(where) if "://" in str(where) else f"sqlite:///{where}"
    if not create and url.startswith("sqlite:///") and not Path(url.removeprefix("sqlite:///")).is_file():
        raise TrueloopError(
            Code.STO_FILE, f"there is no store {where}", hint="make one by `trueloop db init`, or name another by --db"
        )
    engine = create_engine(url)
    METADATA.create_all(engine)
    return Store(engine, codec or values.CODEC.with_more(Correction))


def keep(store: Store, kept: Iterable[Any], supersedes: int | None = None) -> list[Kept[Any]]:
    """Keeps values in one transaction: all or none. One that is there already is found, not kept again.

    Raises STO-DIFFERS where a stored value of the same identity has another content and is not superseded.
    """
    with store.engine.begin() as connection:
        return [_kept(store, connection, one, supersedes) for one in kept]


def find(store: Store, kind: type[T], *, superseded: bool = False, **columns: str | None) -> list[Kept[T]]:
    """Values of a type, oldest first, by the columns of `kinds`; without those superseded, unless asked for."""
    table = TABLES[_kind(kind).table]
    query = select(table).order_by(table.c.id)
    for name, value in columns.items():
        query = query.where(table.c[name] == value)
    with store.engine.connect() as connection:
        rows = list(connection.execute(query))
        names = select(table.c.supersedes, table.c.id).where(table.c.supersedes.is_not(None))
        replaced = {row[0]: row[1] for row in connection.execute(names)}
    every = [
        Kept(
            row.id,
            store.codec.from_json(row.document, kind),
            datetime.fromisoformat(row.kept_at),
            False,
            replaced.get(row.id),
        )
        for row in rows
    ]
    return every if superseded else [one for one in every if one.superseded_by is None]


def _kept(store: Store, connection: Connection, value: Any, supersedes: int | None) -> Kept[Any]:
    kind = _kind(type(value))
    table, identity = TABLES[kind.table], joined(tuple(map(str, value.identity)))
    document = store.codec.to_json(value)
    known = connection.execute(select(table).where(table.c.identity == identity).order_by(table.c.id.desc())).first()
    if known is not None and known.document == document:
        return Kept(known.id, value, datetime.fromisoformat(known.kept_at))
    if known is not None and supersedes != known.id:
        raise TrueloopError(
            Code.STO_DIFFERS,
            f"this {kind.table} is stored already as row {known.id}, with another content",
            hint="what is stored never changes: name the row that the new one supersedes",
        )
    now = datetime.now(UTC)
    row = {"identity": identity, "document": document, "kept_at": now.isoformat(), "supersedes": supersedes}
    done = connection.execute(insert(table).values(**row, **kind.columns(value)))
    return Kept(int((done.inserted_primary_key or (0,))[0]), value, now, new=True)


def _kind(of: type) -> Kind:
    return next(kind for kind in KINDS if kind.type is of)


METADATA = MetaData()
TABLES = {
    kind.table: Table(
        kind.table,
        METADATA,
        Column("id", Integer, primary_key=True),
        Column("identity", Text, nullable=False, index=True),
        Column("kept_at", Text, nullable=False),
        Column("supersedes", Integer),
        Column("document", Text, nullable=False),
        *(Column(name, Text, index=True) for name in kind.names),
    )
    for kind in KINDS
}
