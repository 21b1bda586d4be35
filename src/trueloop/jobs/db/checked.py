"""What is odd in a store: damage, links to nothing, labels against links, order, clock."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from sqlalchemy import select

from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.jobs.db.agreed import Facts, odd_labels, odd_links, odd_order, odd_times
from trueloop.jobs.db.found import row_name, row_of
from trueloop.storage.integrity import Damage, damage
from trueloop.storage.kept import Kept
from trueloop.storage.kinds import KINDS, Kind
from trueloop.storage.reading import Query, found
from trueloop.storage.store import Store
from trueloop.storage.tables import TABLES


@dataclass(frozen=True)
class Checked:
    """What a check found, and how many rows it read."""

    rows: int
    findings: tuple[Finding, ...]


@dataclass
class _Pass:
    """One pass over all rows: what is odd so far, and the facts that are compared at the end."""

    rows: int = 0
    findings: list[Finding] = field(default_factory=list)
    facts: Facts = field(default_factory=Facts)


def check_store(store: Store, progress: Callable[[str], None] = lambda _: None) -> Checked:
    """Compares all that is stored with its hashes, then what the rows say of each other.

    `progress` is given what is being done. Where pages of a file are damaged, its rows may hold anything: they are not
    read. Raises STO-FILE, STO-BUSY.
    """
    progress(f"checking {store.where}: hashes")
    damaged = damage(store)
    if any(one.row is None for one in damaged):
        return Checked(0, tuple(map(_damaged, damaged)))
    over = _Pass()
    for kind in KINDS:
        progress(f"checking {store.where}: {kind.table}")
        before: Kept[Any] | None = None
        for kept in _readable(store, kind, over.findings):
            over.rows += 1
            over.findings += _clock(before, kept)
            before = replace(kept, value=None)
            if kept.superseded_by is None:
                over.facts.take(kept)
    facts, unreadable = over.facts, {one.values.get("row") for one in over.findings}
    more = [one for one in map(_damaged, damaged) if one.values["row"] not in unreadable]
    odd = (*odd_links(facts), *odd_labels(facts), *odd_order(facts), *odd_times(facts))
    return Checked(over.rows, (*over.findings, *more, *odd))


def _damaged(one: Damage) -> Finding:
    name = one.table.replace("_", "-")
    row = f"{name}:{one.row}" if one.row is not None else f"the table {one.table!r}" if one.table else "the file"
    return _finding(row, f"{row} is damaged: {one.why}")


def _readable(store: Store, kind: Kind, findings: list[Finding]) -> Iterator[Kept[Any]]:
    """The rows of a kind that can be read; the others are findings."""
    last = 0
    try:
        with store.reading() as connection:
            for kept in found(connection, store.codec, Query(kind, superseded=True)):
                yield kept
                last = kept.row
    except (TrueloopError, ValueError) as wrong:
        if isinstance(wrong, TrueloopError) and wrong.code is not Code.VAL_FORM:
            raise
        yield from _one_by_one(store, kind, last, findings)


def _one_by_one(store: Store, kind: Kind, after: int, findings: list[Finding]) -> Iterator[Kept[Any]]:
    table = TABLES[kind.table]
    with store.reading() as connection:
        rows = list(connection.scalars(select(table.c.id).where(table.c.id > after).order_by(table.c.id)))
    for row in rows:
        try:
            kept = row_of(store, kind.type, row)
        except (TrueloopError, ValueError) as wrong:
            findings.append(_unreadable(row_name(kind.type, row), wrong))
        else:
            if kept is not None:
                yield kept


def _unreadable(row: str, wrong: Exception) -> Finding:
    why = wrong.message if isinstance(wrong, TrueloopError) else str(wrong)
    return _finding(row, f"{row} cannot be read: {why}")


def _finding(row: str, said: str) -> Finding:
    hint = "restore the store from a backup: trueloop db restore"
    return Finding(Severity.ERROR, Code.STO_DAMAGED, said, hint, values={"row": row})


def _clock(before: Kept[Any] | None, kept: Kept[Any]) -> Iterator[Finding]:
    if before is None or kept.kept_at >= before.kept_at:
        return
    row = row_name(type(kept.value), kept.row)
    earlier, later = kept.kept_at.isoformat(), before.kept_at.isoformat()
    yield Finding(
        Severity.WARNING,
        Code.STO_CLOCK,
        f"{row} was kept at {earlier}, the row before it at {later}: the clock went back",
        "set the computer's clock; rows are in the order of their numbers, whatever the clock said",
        values={"earlier": earlier, "later": later},
    )
