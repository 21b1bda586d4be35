"""Orders as they are shown."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any, Final, NamedTuple

from sqlalchemy import JSON, cast, func, select, type_coerce

from trueloop.domain.factory.states import PartState
from trueloop.factory.load import Known, order_of
from trueloop.factory.shown.paging import LIMIT, before, known_of, page_of, time
from trueloop.factory.shown.programs import names_of
from trueloop.factory.views.orders import OrderBlock, OrderPart, OrderRow, OrderView
from trueloop.factory.views.page import Page
from trueloop.storage.factory_tables import ORDER_STATE, PART_STATE
from trueloop.storage.kinds import joined, searchable
from trueloop.storage.store import Store
from trueloop.storage.tables import TABLES

FINISHED: Final = tuple(
    one.value
    for one in (
        *(PartState.FINISHED, PartState.INSPECTED, PartState.REMOVED, PartState.MEASURED),
        PartState.RELEASED,
    )
)


class _Head(NamedTuple):
    """Of an order, without its parts and its route."""

    id: str
    part_type: str
    machine: str
    made_at: datetime
    made_by: str


def order_rows(
    store: Store, *, state: str | None = None, limit: int = LIMIT, cursor: str | None = None
) -> Page[OrderRow]:
    """Orders, the latest first."""
    query = select(ORDER_STATE) if state is None else select(ORDER_STATE).where(ORDER_STATE.c.state == state)
    with known_of(store) as known:
        rows = known.rows(before(query, ORDER_STATE.c.number, limit, cursor))
        orders, counts = _orders(known, [one.order for one in rows]), _counts(known, [one.order for one in rows])
        return page_of(rows, limit, lambda row: int(row.number), lambda row: _row(orders[row.order], row.state, counts))


def order_view(store: Store, order_id: str) -> OrderView:
    """A whole order. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        now = order_of(known, order_id)
        names = names_of(known, [one.program_sha256 for one in now.order.route.blocks])
        row = _row(_orders(known, [order_id])[order_id], now.state, _counts(known, [order_id]))
    blocks = tuple(
        OrderBlock(k, one.kind, names.get(one.program_sha256, ""), one.program_sha256, one.feature)
        for k, one in enumerate(now.order.route.blocks)
    )
    parts = tuple(
        OrderPart(one.row, one.value.serial, one.state, tuple(step.state for step in one.steps), one.held_why)
        for one in now.parts
    )
    return OrderView(row, str(now.version), now.order.route.sha256, blocks, parts, now.armed_parts)


def _orders(known: Known, ids: Sequence[str]) -> Mapping[str, _Head]:
    """What a list says of orders: the database reads it out of their documents, which name hundreds of parts each."""
    table = TABLES["work_order"]
    within = (
        cast if known.connection.dialect.name == "postgresql" else type_coerce
    )  # a cast makes it a number in SQLite
    said = within(table.c.document, JSON)
    paths = (("id",), ("part_type", "name"), ("machine", "name"), ("made_at", "value"), ("made_by",))
    wanted = table.c.identity.in_([searchable(joined((one,))) for one in ids])
    rows = known.rows(select(*(said[path].as_string() for path in paths)).where(wanted))
    return {order: _Head(order, part_type, machine, time(at), by) for order, part_type, machine, at, by in rows}


def _counts(known: Known, ids: Sequence[str]) -> Mapping[tuple[str, str], int]:
    """Parts by order and state."""
    query = select(PART_STATE.c.order, PART_STATE.c.state, func.count()).where(PART_STATE.c.order.in_(ids))
    rows: list[Any] = known.rows(query.group_by(PART_STATE.c.order, PART_STATE.c.state))
    return {(order, state): count for order, state, count in rows}


def _row(order: _Head, state: str, counts: Mapping[tuple[str, str], int]) -> OrderRow:
    parts = {of: count for (one, of), count in counts.items() if one == order.id}
    finished = sum(parts.get(one, 0) for one in FINISHED)
    held = parts.get(PartState.HELD.value, 0)
    return OrderRow(
        *(order.id, order.part_type, order.machine),
        *(sum(parts.values()), finished, held),
        *(state, order.made_at, order.made_by),
    )
