"""Parts in lists."""

from typing import Any

from sqlalchemy import bindparam, select

from trueloop.domain.factory.states import PartState
from trueloop.domain.part import Part
from trueloop.factory.known import unknown
from trueloop.factory.load import Known
from trueloop.factory.shown.paging import LIMIT, before, known_of, page_of, time
from trueloop.factory.views.page import Page
from trueloop.factory.views.parts import PartRow
from trueloop.storage.factory_tables import PART_STATE
from trueloop.storage.kinds import searchable
from trueloop.storage.store import Store
from trueloop.storage.tables import TABLES

_PART = TABLES["part"]
_COLUMNS = (
    *(_PART.c.id, _PART.c.document, _PART.c.kept_at),
    *(PART_STATE.c.state, PART_STATE.c.order, PART_STATE.c.machine, PART_STATE.c.changed_at, PART_STATE.c.held_why),
)
_ONE = (
    select(*_COLUMNS)
    .select_from(_PART.join(PART_STATE, PART_STATE.c.part == _PART.c.id, isouter=True))
    .where(_PART.c.id == bindparam("number"))
)


def part_rows(
    store: Store,
    *,
    part_type: str | None = None,
    serial: str | None = None,
    state: PartState | None = None,
    limit: int = LIMIT,
    cursor: str | None = None,
) -> Page[PartRow]:
    """Parts, the latest that was named first; of a type, a serial number, a state."""
    key = _PART.c.id if state is None else PART_STATE.c.part
    query = select(*_COLUMNS).select_from(
        _PART.join(PART_STATE, PART_STATE.c.part == _PART.c.id, isouter=state is None)
    )
    if part_type is not None:
        query = query.where(_PART.c.part_type == searchable(part_type))
    if serial is not None:
        query = query.where(_PART.c.serial == searchable(serial))
    if state is not None:
        query = query.where(PART_STATE.c.state == state.value)
    with known_of(store) as known:
        rows = known.rows(before(query, key, limit, cursor))
        return page_of(rows, limit, lambda row: int(row.id), lambda row: row_of(known, row))


def part_of(known: Known, number: int) -> tuple[PartRow, Part]:
    """One part, and its value. Raises FAC-UNKNOWN."""
    row = known.connection.execute(_ONE, {"number": number}).one_or_none()
    if row is None:
        raise unknown("part", str(number), "the store has no such row")
    part = known.codec.from_json(row.document, Part)
    return _row(part, row), part


def row_of(known: Known, row: Any) -> PartRow:
    """A part of its row, with what its order has made of it."""
    return _row(known.codec.from_json(row.document, Part), row)


def _row(part: Part, row: Any) -> PartRow:
    return PartRow(
        *(row.id, part.part_type.name, part.part_type.revision, part.serial),
        None if row.state is None else PartState(row.state),
        *(row.order or "", row.machine or "", time(row.changed_at or row.kept_at)),
    )
