"""Orders as they are shown."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any, Final, NamedTuple

from sqlalchemy import JSON, cast, func, literal_column, or_, select, type_coerce

from trueloop.described import filled_from
from trueloop.domain.factory import BlockKind, PartState, StepState
from trueloop.factory.load import StoreReader, order_of
from trueloop.factory.requests import Role
from trueloop.factory.shown.machines import all_machines
from trueloop.factory.shown.parts import cpk_of_today
from trueloop.factory.shown.programs import names_of, states_of
from trueloop.factory.shown.records import LIMIT, alarms, before, known_of, page_of, time
from trueloop.factory.views.orders import Made, OrderBlock, OrderPart, OrderRow, OrderView, Page, Today, Waiting
from trueloop.storage.kinds import joined, searchable
from trueloop.storage.schema import ALARM, ORDER_STATE, PART_STATE, ROWS, STEP, TABLES, stamp
from trueloop.storage.store import Store

FINISHED: Final = tuple(
    part_state.value
    for part_state in (
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
    """Returns a whole order. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        now = order_of(known, order_id)
        names = names_of(known, [block.program_sha256 for block in now.order.route.blocks])
        row = _row(_orders(known, [order_id])[order_id], now.state, _counts(known, [order_id]))
    blocks = tuple(
        OrderBlock(k, block.kind, names.get(block.program_sha256, ""), block.program_sha256, block.feature)
        for k, block in enumerate(now.order.route.blocks)
    )
    parts = tuple(
        OrderPart(part.row, part.value.serial, part.state, tuple(step.state for step in part.steps), part.held_why)
        for part in now.parts
    )
    return OrderView(
        row=row,
        etag=str(now.version),
        route_sha256=now.order.route.sha256,
        blocks=blocks,
        parts=parts,
        armed_parts=now.armed_parts,
    )


def _orders(reader: StoreReader, ids: Sequence[str]) -> Mapping[str, _Head]:
    """Returns the heads of listed orders, which the database reads from their documents of hundreds of parts."""
    table = TABLES["work_order"]
    within = (
        cast if reader.connection.dialect.name == "postgresql" else type_coerce
    )  # a cast makes it a number in SQLite
    said = within(table.c.document, JSON)
    paths = (("id",), ("part_type", "name"), ("machine", "name"), ("made_at", "value"), ("made_by",))
    wanted = table.c.identity.in_([searchable(joined((one,))) for one in ids])
    rows = reader.rows(select(*(said[path].as_string() for path in paths)).where(wanted))
    return {order: _Head(order, part_type, machine, time(at), by) for order, part_type, machine, at, by in rows}


def _counts(reader: StoreReader, ids: Sequence[str]) -> Mapping[tuple[str, str], int]:
    """Parts by order and state."""
    query = select(PART_STATE.c.order, PART_STATE.c.state, func.count()).where(PART_STATE.c.order.in_(ids))
    rows: list[Any] = reader.rows(query.group_by(PART_STATE.c.order, PART_STATE.c.state))
    return {(order, state): count for order, state, count in rows}


def _row(order: _Head, state: str, counts: Mapping[tuple[str, str], int]) -> OrderRow:
    parts = {of: count for (one, of), count in counts.items() if one == order.id}
    finished = sum(parts.get(one, 0) for one in FINISHED)
    held = parts.get(PartState.HELD.value, 0)
    return filled_from(OrderRow, order, quantity=sum(parts.values()), finished=finished, held=held, state=state)


MOST: Final = 100
"""The largest number of rows of each kind on the page of today."""
_BY_HAND: Final = {
    BlockKind.REMOVE.value: ("remove", Role.OPERATOR),
    BlockKind.MEASURE.value: ("measure", Role.OPERATOR),
    BlockKind.RELEASE.value: ("release", Role.ENGINEER),
}
_STATE: Final = PART_STATE.c.state.concat(literal_column("''"))
"""The state, by which no index is chosen: what changed today is found by its time, among the parts of years."""


def today(store: Store, now: datetime) -> Today:
    """Returns the whole page; the day begins at midnight in the zone of `now`."""
    began = stamp(now.replace(hour=0, minute=0, second=0, microsecond=0))
    with known_of(store) as known:
        waiting = (*_held(known), *_by_hand(known), *_to_start(known), *_proposed(known), *_alarms(known))
        return Today(now, waiting, all_machines(known, now), _made(known, began))


def _held(reader: StoreReader) -> Iterator[Waiting]:
    part = TABLES["part"]
    query = select(PART_STATE, part.c.serial).join(part, part.c.id == PART_STATE.c.part)
    held = query.where(PART_STATE.c.state == PartState.HELD.value).order_by(PART_STATE.c.part).limit(MOST)
    for row in reader.rows(held):
        said = (row.machine, row.serial, row.held_why, time(row.changed_at))
        yield Waiting("decide", "part", str(row.part), *said, Role.OPERATOR.value)


def _by_hand(reader: StoreReader) -> Iterator[Waiting]:
    """Steps without a program that are a part's next."""
    before, part = STEP.alias("before"), TABLES["part"]
    open_before = select(before.c.no).where(
        *(before.c.order == STEP.c.order, before.c.part == STEP.c.part, before.c.no < STEP.c.no),
        before.c.state != StepState.RECORDED.value,
    )
    query = (
        select(STEP, PART_STATE.c.machine, part.c.serial)
        .join(PART_STATE, PART_STATE.c.part == STEP.c.part)
        .join(part, part.c.id == STEP.c.part)
        .where(STEP.c.state == StepState.WAITING.value, STEP.c.kind.in_(_BY_HAND))
        .where(PART_STATE.c.state.in_([*FINISHED, PartState.CORRECTED.value, PartState.PROBED.value]))
        .where(PART_STATE.c.state != PartState.RELEASED.value, ~open_before.exists())
    )
    for row in reader.rows(query.order_by(STEP.c.part).limit(MOST)):
        action, role = _BY_HAND[row.kind]
        yield Waiting(
            action=action,
            subject="part",
            id=str(row.part),
            machine=row.machine,
            part=row.serial,
            said=f"step {row.no}",
            since=time(row.changed_at),
            role=role.value,
        )


def _to_start(reader: StoreReader) -> Iterator[Waiting]:
    part = TABLES["part"]
    query = (
        select(STEP, PART_STATE.c.machine, part.c.serial)
        .join(PART_STATE, PART_STATE.c.part == STEP.c.part)
        .join(part, part.c.id == STEP.c.part)
        .where(STEP.c.state == StepState.VERIFIED.value, PART_STATE.c.state != PartState.HELD.value)
    )
    for row in reader.rows(query.order_by(STEP.c.part).limit(MOST)):
        said = (row.machine, row.serial, f"{row.kind}: press Cycle Start", time(row.changed_at))
        yield Waiting("start", "order", row.order, *said, Role.OPERATOR.value)


def _proposed(reader: StoreReader) -> Iterator[Waiting]:
    for proposal, state, _ in states_of(reader):
        if state == "open":
            said = f"{proposal.changes.value}: {', '.join(proposal.characteristics)}"
            yield Waiting(
                action="review",
                subject="proposal",
                id=proposal.id,
                machine="",
                part=proposal.part_type.name,
                said=said,
                since=proposal.made_at,
                role=Role.ENGINEER.value,
            )


def _alarms(reader: StoreReader) -> Iterator[Waiting]:
    for row in reader.rows(alarms(open_only=True).order_by(ALARM.c.id).limit(MOST)):
        said = (row.machine, row.part_type, row.said, time(row.at))
        yield Waiting("acknowledge", "alarm", str(row.id), *said, Role.OPERATOR.value)


def _made(reader: StoreReader, began: str) -> Made:
    query = select(_STATE, func.count()).where(PART_STATE.c.changed_at >= began).group_by(_STATE)
    counts: dict[str, int] = dict(reader.rows(query))
    held = select(func.count()).where(PART_STATE.c.state == PartState.HELD.value)
    return Made(
        sum(counts.get(one, 0) for one in FINISHED),
        _in_tolerance(reader, began),
        reader.connection.scalar(held) or 0,
        counts.get(PartState.REJECTED.value, 0),
        cpk_of_today(reader, FINISHED, began),
    )


def _in_tolerance(reader: StoreReader, began: str) -> int:
    """Parts made today that were measured, and of whose readings none is outside its limits."""
    part, inspection, reading = TABLES["part"], TABLES["inspection"], ROWS["reading"]
    inspected = (inspection.c.serial == part.c.serial) & (inspection.c.part_type == part.c.part_type)
    measured = (
        select(reading.c.inspection)
        .select_from(part.join(inspection, inspected).join(reading, reading.c.inspection == inspection.c.id))
        .where(part.c.id == PART_STATE.c.part)
        .correlate(PART_STATE)
    )
    outside = measured.where(or_(reading.c.actual < reading.c.lower_limit, reading.c.actual > reading.c.upper_limit))
    made = select(func.count()).where(PART_STATE.c.changed_at >= began, _STATE.in_(FINISHED))
    return reader.connection.scalar(made.where(measured.exists(), ~outside.exists())) or 0
