"""The page Today: what waits for whom, what the machines do, what was made."""

from collections.abc import Iterator
from datetime import datetime
from typing import Final

from sqlalchemy import func, literal_column, or_, select

from trueloop.domain.factory.route import BlockKind
from trueloop.domain.factory.states import PartState, StepState
from trueloop.factory.load import Known
from trueloop.factory.roles import Role
from trueloop.factory.shown.capable import cpk_of_today
from trueloop.factory.shown.machines import all_machines
from trueloop.factory.shown.orders import FINISHED
from trueloop.factory.shown.paging import known_of, time
from trueloop.factory.shown.proposals import states_of
from trueloop.factory.shown.records import alarms
from trueloop.factory.views.today import Made, Today, Waiting
from trueloop.storage.factory_tables import ALARM, PART_STATE, STEP, stamp
from trueloop.storage.store import Store
from trueloop.storage.tables import ROWS, TABLES

MOST: Final = 100
"""Of one kind of what waits: a longer list is no list of today."""
_BY_HAND: Final = {
    BlockKind.REMOVE.value: ("remove", Role.OPERATOR),
    BlockKind.MEASURE.value: ("measure", Role.OPERATOR),
    BlockKind.RELEASE.value: ("release", Role.ENGINEER),
}
_STATE: Final = PART_STATE.c.state.concat(literal_column("''"))
"""The state, by which no index is chosen: what changed today is found by its time, among the parts of years."""


def today(store: Store, now: datetime) -> Today:
    """The whole page; the day begins at midnight in the zone of `now`."""
    began = stamp(now.replace(hour=0, minute=0, second=0, microsecond=0))
    with known_of(store) as known:
        waiting = (*_held(known), *_by_hand(known), *_to_start(known), *_proposed(known), *_alarms(known))
        return Today(now, waiting, all_machines(known, now), _made(known, began))


def _held(known: Known) -> Iterator[Waiting]:
    part = TABLES["part"]
    query = select(PART_STATE, part.c.serial).join(part, part.c.id == PART_STATE.c.part)
    held = query.where(PART_STATE.c.state == PartState.HELD.value).order_by(PART_STATE.c.part).limit(MOST)
    for row in known.rows(held):
        said = (row.machine, row.serial, row.held_why, time(row.changed_at))
        yield Waiting("decide", "part", str(row.part), *said, Role.OPERATOR.value)


def _by_hand(known: Known) -> Iterator[Waiting]:
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
    for row in known.rows(query.order_by(STEP.c.part).limit(MOST)):
        action, role = _BY_HAND[row.kind]
        yield Waiting(
            *(action, "part", str(row.part), row.machine, row.serial, f"step {row.no}", time(row.changed_at)),
            role.value,
        )


def _to_start(known: Known) -> Iterator[Waiting]:
    part = TABLES["part"]
    query = (
        select(STEP, PART_STATE.c.machine, part.c.serial)
        .join(PART_STATE, PART_STATE.c.part == STEP.c.part)
        .join(part, part.c.id == STEP.c.part)
        .where(STEP.c.state == StepState.VERIFIED.value, PART_STATE.c.state != PartState.HELD.value)
    )
    for row in known.rows(query.order_by(STEP.c.part).limit(MOST)):
        said = (row.machine, row.serial, f"{row.kind}: press Cycle Start", time(row.changed_at))
        yield Waiting("start", "order", row.order, *said, Role.OPERATOR.value)


def _proposed(known: Known) -> Iterator[Waiting]:
    for one, state, _ in states_of(known):
        if state == "open":
            said = f"{one.changes.value}: {', '.join(one.characteristics)}"
            yield Waiting("review", "proposal", one.id, "", one.part_type.name, said, one.made_at, Role.ENGINEER.value)


def _alarms(known: Known) -> Iterator[Waiting]:
    for row in known.rows(alarms(open_only=True).order_by(ALARM.c.id).limit(MOST)):
        said = (row.machine, row.part_type, row.said, time(row.at))
        yield Waiting("acknowledge", "alarm", str(row.id), *said, Role.OPERATOR.value)


def _made(known: Known, began: str) -> Made:
    query = select(_STATE, func.count()).where(PART_STATE.c.changed_at >= began).group_by(_STATE)
    counts: dict[str, int] = dict(known.rows(query))
    held = select(func.count()).where(PART_STATE.c.state == PartState.HELD.value)
    return Made(
        sum(counts.get(one, 0) for one in FINISHED),
        _in_tolerance(known, began),
        *(known.connection.scalar(held) or 0, counts.get(PartState.REJECTED.value, 0)),
        cpk_of_today(known, FINISHED, began),
    )


def _in_tolerance(known: Known, began: str) -> int:
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
    return known.connection.scalar(made.where(measured.exists(), ~outside.exists())) or 0
