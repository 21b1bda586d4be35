"""All that a store knows of one part: `life`."""

from dataclasses import dataclass
from functools import cache
from typing import Any

from sqlalchemy import Connection, Select, bindparam, select

from trueloop.domain.codec import Codec
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Identity, InspectionLink
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, Record
from trueloop.storage.encoded import Kept
from trueloop.storage.kinds import joined, kind_of, searchable
from trueloop.storage.reading import Query, found, kept
from trueloop.storage.schema import TABLES
from trueloop.storage.store import Store

_SEVERAL = 500
"""Cuts asked for at once."""


@dataclass(frozen=True)
class Life:
    """One part: its cuts and inspections, which inspection shows which cut, and the records of its corrections.

    Each oldest first as it was kept, without what is superseded. `corrections` are those in the programs of its cuts
    and those made from its inspections, without their payload: `find` gives it.
    """

    part: Part
    cuts: tuple[Kept[Cut], ...]
    inspections: tuple[Kept[Inspection], ...]
    links: tuple[Kept[InspectionLink], ...]
    corrections: tuple[Kept[Record], ...]

    def cut_of(self, inspection: Inspection) -> Cut | None:
        """Returns the cut that an inspection shows; None where no link names it."""
        shown: dict[Identity, Identity] = {link.value.inspection: link.value.cut for link in self.links}
        wanted = shown.get(inspection.identity)
        return next((cut.value for cut in self.cuts if cut.value.identity == wanted), None)


def life(store: Store, part: Part) -> Life:
    """Returns everything about one part; empty where the store has nothing about it."""
    with store.reading() as connection:
        return life_in(connection, store.codec, part)


def life_in(connection: Connection, codec: Codec, part: Part) -> Life:
    """Reads a part's life within a transaction."""
    own = {"part_type": part.part_type.name, "serial": part.serial}
    every = {
        kind: [
            one
            for one in found(connection, codec, Query(kind_of(kind), own))
            if one.value.part.identity == part.identity
        ]
        for kind in (Cut, Inspection)
    }
    links = _links(connection, codec, [joined(one.value.identity) for one in every[Cut]])
    named = {str(one.value.correction) for one in every[Cut]} - {""}
    return Life(
        part, tuple(every[Cut]), tuple(every[Inspection]), links, tuple(_records(connection, codec, part, named))
    )


def _links(connection: Connection, codec: Codec, cuts: list[str]) -> tuple[Kept[InspectionLink], ...]:
    kind = kind_of(InspectionLink)
    each = (one for cut in cuts for one in found(connection, codec, Query(kind, {"cut": cut})))
    return tuple(sorted(each, key=lambda one: one.row))


def _records(connection: Connection, codec: Codec, part: Part, named: set[str]) -> list[Kept[Record]]:
    """By the ids that cuts name, and by the part whose inspections they were made from."""
    identities = [searchable(joined((one,))) for one in sorted(named)[:_SEVERAL]]
    own = {"the_serial": searchable(part.serial), "the_type": searchable(part.part_type.name)}
    rows = {row.id: row for row in connection.execute(_of_part(), own)}
    if identities:
        rows |= {row.id: row for row in connection.execute(_of_ids(), {"ids": identities})}
    records = [kept(rows[number], _record(codec, rows[number].document)) for number in sorted(rows)]
    return [one for one in records if one.value.id in named or _is_of(one.value, part)]


@cache
def _standing() -> Select[Any]:
    """Corrections that nothing supersedes, without their payloads."""
    table = TABLES["correction"]
    later = table.alias("later")
    columns = [column for column in table.columns if column.name != "payload"]
    joined_up = table.outerjoin(later, later.c.supersedes == table.c.id)
    return select(*columns, later.c.id.label("superseded_by")).select_from(joined_up).where(later.c.id.is_(None))


@cache
def _of_ids() -> Select[Any]:
    return _standing().where(TABLES["correction"].c.identity.in_(bindparam("ids", expanding=True)))


@cache
def _of_part() -> Select[Any]:
    table = TABLES["correction"]
    return _standing().where(table.c.serial == bindparam("the_serial"), table.c.part_type == bindparam("the_type"))


def _record(codec: Codec, document: str) -> Record:
    correction: Correction[None] = codec.from_json(document, Correction)
    return correction.record


def _is_of(record: Record, part: Part) -> bool:
    return any(one.part.identity == part.identity for one in record.inspections)
