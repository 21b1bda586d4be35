"""Reads the inputs of decisions within one transaction."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime
from hashlib import sha256
from typing import Any

from sqlalchemy import Connection, select

from trueloop.described import filled_from
from trueloop.domain.codec import Codec
from trueloop.domain.factory import BlockKind, PartState, Run, RunFact, StepState, WorkOrder
from trueloop.domain.record import Correction, ProgramText
from trueloop.domain.tool import Machine
from trueloop.factory.decisions.plan import Candidate, CorrectionFacts, MachineFacts, NextFacts, candidate
from trueloop.factory.decisions.runs import KnownRun, RunsFacts, SilenceFacts
from trueloop.factory.known import OrderNow, PartNow, StepNow, unknown
from trueloop.storage.keeping import Query, found
from trueloop.storage.kinds import joined, kind_of, searchable
from trueloop.storage.schema import (
    ALARM,
    ALARM_ACKNOWLEDGED,
    API_KEY,
    CALIBRATION,
    MACHINE_HEARD,
    ORDER_STATE,
    PART_STATE,
    RUN_TOUCHES,
    STEP,
    TABLES,
    TEMPERATURE,
)
from trueloop.wording import wording


@dataclass(frozen=True)
class StoreReader:
    """A connection in a transaction, and the codec of the store."""

    connection: Connection
    codec: Codec

    def values(self, kind: type, **columns: str) -> list[Any]:
        """Values that stand, oldest first."""
        return [stored.value for stored in found(self.connection, self.codec, Query(kind_of(kind), columns))]

    def first(self, kind: type, *identity: str) -> Any:
        """Returns the value of an identity; None: there is none."""
        return next(iter(self.values(kind, identity=joined(identity))), None)

    def rows(self, query: Any, **wanted: Any) -> list[Any]:
        """Returns the rows of a query with these parameters."""
        return list(self.connection.execute(query, wanted))


def order_of(reader: StoreReader, order_id: str) -> OrderNow:
    """Returns the order. Raises FAC-UNKNOWN."""
    state = reader.connection.execute(select(ORDER_STATE).where(ORDER_STATE.c.order == order_id)).one_or_none()
    order: WorkOrder | None = reader.first(WorkOrder, order_id)
    if order is None or state is None:
        raise unknown(wording("order"), order_id, wording("the store has none of that id"))
    steps: dict[int, list[StepNow]] = {}
    for one in reader.rows(select(STEP).where(STEP.c.order == order_id).order_by(STEP.c.part, STEP.c.no)):
        steps.setdefault(one.part, []).append(step_now(one))
    by_identity = {searchable(joined(one.identity)): one for one in order.parts}
    part = TABLES["part"]
    query = select(PART_STATE, part.c.identity).join(part, part.c.id == PART_STATE.c.part)
    rows = reader.rows(query.where(PART_STATE.c.order == order_id))
    place = {identity: k for k, identity in enumerate(by_identity)}
    parts = tuple(
        PartNow(
            row=row.part,
            value=by_identity[row.identity],
            state=PartState(row.state),
            steps=tuple(steps[row.part]),
            held_why=row.held_why,
            version=row.version,
        )
        for row in sorted(rows, key=lambda row: place[row.identity])
    )
    return filled_from(OrderNow, state, order=order, parts=parts)


def step_now(row: Any) -> StepNow:
    """Makes a step from its row."""
    return filled_from(StepNow, row, kind=BlockKind(row.kind), state=StepState(row.state))


def runs_of(reader: StoreReader, keys: Iterable[str]) -> RunsFacts:
    """Returns the runs that there are, with their orders; of others nothing."""
    runs: dict[str, KnownRun] = {}
    orders: dict[str, OrderNow] = {}
    for key in dict.fromkeys(keys):
        run: Run | None = reader.first(Run, key)
        if run is None:
            continue
        order = orders.get(run.order) or order_of(reader, run.order)
        orders[run.order] = order
        row = next(part.row for part in order.parts if part.value.identity == run.part.identity)
        touches = reader.connection.scalars(select(RUN_TOUCHES.c.sha256).where(RUN_TOUCHES.c.run == key))
        runs[key] = KnownRun(run, row, tuple(reader.values(RunFact, run=key)), frozenset(touches))
    return RunsFacts(runs, orders)


def next_of(reader: StoreReader, machine: str) -> NextFacts:
    """Returns what the machine could do next: orders under way first, then those planned, in the order of making."""
    chosen = None
    begun = [order_of(reader, one) for one in _orders(reader, machine, ("running", "held"))]
    inside = any(part.on_machine for order in begun for part in order.parts)
    chosen = candidate(begun)
    for planned in () if chosen or inside else _orders(reader, machine, ("planned",)):
        if chosen := candidate([order_of(reader, planned)]):
            break
    if chosen is None:
        return NextFacts(MachineFacts(machine), None)
    order, part = chosen
    step = part.next
    assert step is not None, "a candidate has a step"
    text = program_text(reader, step.program_sha256)
    made = correction_of(reader, order, part, step, text) if order.block(step.no).corrected else None
    run: Run | None = reader.first(Run, step.run) if step.run else None
    facts = machine_facts(reader, machine, order.order.part_type.name)
    return NextFacts(facts, Candidate(order, part, step, text, made), run)


def _orders(reader: StoreReader, machine: str, states: tuple[str, ...]) -> list[str]:
    query = select(ORDER_STATE.c.order).where(ORDER_STATE.c.machine == machine, ORDER_STATE.c.state.in_(states))
    return list(reader.connection.scalars(query.order_by(ORDER_STATE.c.number)))


def program_text(reader: StoreReader, sha: str) -> bytes | None:
    """Returns the text of a program; None: the store has none."""
    text: ProgramText | None = reader.first(ProgramText, sha) if sha else None
    return None if text is None else text.content


def correction_of(
    reader: StoreReader, order: OrderNow, part: PartNow, step: StepNow, text: bytes | None
) -> CorrectionFacts | None:
    """Returns the correction that the part's step CORRECT led to, and whether the program to run carries its mark."""
    done = [step_now for step_now in part.steps[: step.no] if step_now.kind is BlockKind.CORRECT]
    made = record_of(reader, done[-1].run) if done and done[-1].run else None
    if made is None:
        return None
    record, source = made.record, made.source_sha256
    marked = text is not None and record.id.encode().lower() in text.lower()
    as_given = step.program_sha256 == source
    probes = [step_now.run for step_now in part.steps if step_now.kind is BlockKind.PROBE]
    read = {inspection.sha256 for inspection in record.inspections} | set(record.inputs_sha256.values())
    query = select(RUN_TOUCHES.c.run).where(RUN_TOUCHES.c.run.in_(probes), RUN_TOUCHES.c.sha256.in_(sorted(read)))
    return CorrectionFacts(
        record.id,
        tuple(inspection.part.identity for inspection in record.inspections),
        source,
        sha256(text).hexdigest() if text is not None and (marked or as_given) else "",
        reader.connection.scalar(query) or "",
    )


def record_of(reader: StoreReader, correction: str) -> Correction[None] | None:
    """Returns a correction without its payload, which may be large; None: the store has none of that id."""
    table = TABLES["correction"]
    query = select(table.c.document).where(table.c.identity == searchable(joined((correction,)))).order_by(table.c.id)
    documents = list(reader.connection.scalars(query))
    return reader.codec.from_json(documents[-1], Correction) if documents else None


def machine_facts(reader: StoreReader, machine: str, part_type: str) -> MachineFacts:
    """Returns what was heard of a machine last."""
    at = select(CALIBRATION.c.at).where(CALIBRATION.c.machine == machine).order_by(CALIBRATION.c.at.desc()).limit(1)
    warm = select(TEMPERATURE.c.at).where(TEMPERATURE.c.machine == machine).order_by(TEMPERATURE.c.at.desc()).limit(1)
    heard = reader.connection.scalar(select(MACHINE_HEARD.c.document).where(MACHINE_HEARD.c.machine == machine))
    said: Mapping[str, Any] = {} if heard is None else json.loads(heard)
    open_ones = select(ALARM.c.id).outerjoin(ALARM_ACKNOWLEDGED, ALARM_ACKNOWLEDGED.c.alarm == ALARM.c.id)
    blocking = open_ones.where(
        *(ALARM_ACKNOWLEDGED.c.alarm.is_(None), ALARM.c.blocks == 1),
        *(ALARM.c.machine.in_(("", machine)), ALARM.c.part_type.in_(("", part_type))),
    )
    return MachineFacts(
        machine,
        _time(reader.connection.scalar(at)),
        _time(reader.connection.scalar(warm)),
        str(said.get("corrector") or "off"),
        tuple(reader.connection.scalars(blocking.order_by(ALARM.c.id))),
    )


def machine_names(reader: StoreReader) -> frozenset[str]:
    """Returns the names of all machines that the store knows: kept, heard, or with a cell's key that has not ended."""
    keys = select(API_KEY.c.machine).where(API_KEY.c.scope == "cell", API_KEY.c.ended_at.is_(None))
    named = (name for query in (select(MACHINE_HEARD.c.machine), keys) for name in reader.connection.scalars(query))
    return frozenset((*(one.name for one in reader.values(Machine)), *named))


def last_word(connection: Connection, order: str, part: int, step: int) -> datetime | None:
    """Returns when the machine of a step was heard last: by a heartbeat, or by what changed the step."""
    own = (STEP.c.order == order, STEP.c.part == part, STEP.c.no == step)
    changed = connection.scalar(select(STEP.c.changed_at).where(*own))
    machine = select(ORDER_STATE.c.machine).where(ORDER_STATE.c.order == order).scalar_subquery()
    heard = connection.scalar(select(MACHINE_HEARD.c.at).where(MACHINE_HEARD.c.machine == machine))
    return max((datetime.fromisoformat(at) for at in (changed, heard) if at), default=None)


def silence_of(reader: StoreReader, order_id: str, part: int, step: int) -> SilenceFacts:
    """Returns what is known of a step whose machine may be silent. Raises FAC-UNKNOWN."""
    order = order_of(reader, order_id)
    run: Run | None = reader.first(Run, order.step(part, step).run)
    return SilenceFacts(order, run, last_word(reader.connection, order_id, part, step))


def _time(text: str | None) -> datetime | None:
    return None if text is None else datetime.fromisoformat(text)
