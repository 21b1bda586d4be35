"""The one way by which anything changes in the factory: `carry_out` reads facts, decides, and writes what follows."""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import datetime
from typing import Any, Final, NamedTuple

from sqlalchemy import Connection, Table, func, insert, select, update

from trueloop.domain.factory import StepState
from trueloop.domain.part import PartType
from trueloop.domain.proposal import Proposal, ProposalDecision
from trueloop.domain.tool import Edge, Machine
from trueloop.factory import requests as ask
from trueloop.factory.book import read_book
from trueloop.factory.decisions import plan, records, runs
from trueloop.factory.decisions.plan import PlanFacts
from trueloop.factory.decisions.records import ProgramFacts, ProposalFacts
from trueloop.factory.known import Changes, OrderNow, PartNow, StepNow
from trueloop.factory.load import (
    StoreReader,
    last_word,
    machine_names,
    next_of,
    order_of,
    program_text,
    runs_of,
    silence_of,
)
from trueloop.factory.requests import By, Role, require_machine, require_role
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.storage.keeping import Keeping
from trueloop.storage.schema import (
    ALARM,
    ALARM_ACKNOWLEDGED,
    DONE,
    EVENT,
    IDEMPOTENCY,
    LOGS,
    ORDER_STATE,
    PART_STATE,
    PROGRAM_RELEASE,
    STEP,
    TABLES,
    TASK,
    TEMPERATURE,
    stamp,
)
from trueloop.storage.store import Store

_LOGS: Final[Mapping[str, Table]] = {table.name: table for table in LOGS}


def write(
    reader: StoreReader, changes: Changes, before: Mapping[str, OrderNow], by: str, now: datetime
) -> tuple[OrderNow, ...]:
    """Values, then orders with their parts and steps, then what happened. Returns the orders as they are now."""
    keeping = Keeping(reader.codec, reader.connection, by)
    for value in changes.keep:
        keeping.keep(value)
    at = stamp(now)
    done = tuple(_write_order(reader, keeping, before.get(order.order.id), order, at) for order in changes.orders)
    for table, row in changes.rows:
        reader.connection.execute(insert(_LOGS[table]).values(**row))
    for event in changes.events:
        said = json.dumps(dict(event.values))
        row = {"at": at, "who": by, "what": event.what, "subject": event.subject, "document": said}
        reader.connection.execute(insert(EVENT).values(**row))
    for task in changes.tasks:
        row = {"kind": task.kind, "subject": task.subject, "document": json.dumps(dict(task.values)), "made_by": by}
        reader.connection.execute(insert(TASK).values(**row, **_NEW_TASK, made_at=at, changed_at=at))
    return done


def note_done(connection: Connection, account: str, key: str) -> None:
    """Marks a request as done, for it has changed something: whatever becomes of its answer, it is not done again."""
    mine = (IDEMPOTENCY.c.account == account) & (IDEMPOTENCY.c.key == key)
    connection.execute(update(IDEMPOTENCY).where(mine).values(status=DONE))


_NEW_TASK: Final[Mapping[str, Any]] = {"state": "waiting", "said": "", "worker": "", "tries": 0, "progress": 0.0}


def _write_order(reader: StoreReader, keeping: Keeping, old: OrderNow | None, new: OrderNow, at: str) -> OrderNow:
    if old is None:
        return _new_order(reader, keeping, new, at)
    if old == new:
        return new
    new = replace(new, version=old.version + 1)
    state = {"state": new.state, "armed_parts": new.armed_parts, "version": new.version, "changed_at": at}
    reader.connection.execute(update(ORDER_STATE).where(ORDER_STATE.c.order == new.order.id).values(**state))
    for was, part in zip(old.parts, new.parts, strict=True):
        if was != part:
            _write_part(reader, new.order.id, was, part, at)
    return new


def _write_part(reader: StoreReader, order: str, was: PartNow, part: PartNow, at: str) -> None:
    said = {"state": part.state.value, "held_why": part.held_why, "version": was.version + 1, "changed_at": at}
    reader.connection.execute(update(PART_STATE).where(PART_STATE.c.part == part.row).values(**said))
    own = (STEP.c.order == order, STEP.c.part == part.row)
    for before, step in zip(was.steps, part.steps, strict=True):
        if before != step:
            changed = _of_step(replace(step, version=before.version + 1), at)
            reader.connection.execute(update(STEP).where(*own, STEP.c.no == step.no).values(**changed))


def _of_step(step: StepNow, at: str) -> dict[str, Any]:
    return {
        **{"state": step.state.value, "run": step.run, "program_sha256": step.program_sha256},
        **{"attempts": step.attempts, "version": step.version, "changed_at": at},
    }


def _new_order(reader: StoreReader, keeping: Keeping, new: OrderNow, at: str) -> OrderNow:
    name, machine = new.order.id, new.order.machine.name
    rows = [replace(part, row=keeping.keep(part.value).row) for part in new.parts]
    new = replace(new, parts=tuple(rows))
    state = {"state": new.state, "machine": machine, "changed_at": at, "armed_parts": new.armed_parts}
    reader.connection.execute(insert(ORDER_STATE).values(order=name, number=new.number, version=new.version, **state))
    parts = [
        {
            **{"part": part.row, "state": part.state.value, "order": name, "machine": machine, "changed_at": at},
            **{"held_why": part.held_why, "version": part.version},
        }
        for part in new.parts
    ]
    reader.connection.execute(insert(PART_STATE), parts)
    steps = [
        {"order": name, "part": part.row, "no": step.no, "kind": step.kind.value, **_of_step(step, at)}
        for part in new.parts
        for step in part.steps
    ]
    reader.connection.execute(insert(STEP), steps)
    return new


__all__ = ["Done", "carry_out"]


class Done(NamedTuple):
    """The result of a request: the decision's answer, and the orders that changed, as they are now."""

    answer: Any
    orders: tuple[OrderNow, ...]


def carry_out(store: Store, request: ask.Request, by: By, now: datetime, expected: str | None = None) -> Done:
    """Carries out a request, whole or not at all, in one transaction with its event and its task.

    `expected`: the version (`etag`) that was read of the order; another one is refused. Two requests at once are
    taken one after the other. Raises FAC-ROLE, FAC-STALE, what the decision refuses, and STO errors.
    """
    require_role(request, by)
    load, decide = _HOW[type(request)]
    book = _book(store, request)
    with store.writing() as connection:
        known = StoreReader(connection, store.codec)
        facts = load(known, request, book)
        before = _orders_in(facts)
        for order_now in before.values():
            if expected is not None and str(order_now.version) != expected:
                raise records.stale(expected, str(order_now.version))
        if isinstance(request, ask.NextBlock):
            require_machine(by, request.machine)
        changes = decide(facts, request, by, now)
        after = write(known, changes, before, by.name, now)
        if by.once is not None:
            note_done(connection, *by.once)
        return Done(changes.answer, after)


def _book(store: Store, request: ask.Request) -> ProposalFacts | None:
    """The series behind a proposal; read before the transaction, for it may be long. The store takes one decision."""
    if not isinstance(request, ask.DecideProposal):
        return None
    with store.reading() as connection:
        proposal: Proposal | None = StoreReader(connection, store.codec).first(Proposal, request.proposal)
    book = None if proposal is None else read_book(store, proposal.part_type.name, SeriesOptions())
    return ProposalFacts(proposal, book)


def _orders_in(facts: Any) -> Mapping[str, OrderNow]:
    if isinstance(facts, OrderNow):
        return {facts.order.id: facts}
    if isinstance(facts, runs.SilenceFacts):
        return {facts.order.order.id: facts.order}
    if isinstance(facts, runs.RunsFacts):
        return facts.orders
    if isinstance(facts, plan.NextFacts) and facts.candidate is not None:
        return {facts.candidate.order.order.id: facts.candidate.order}
    return {}


def _plan(reader: StoreReader, request: ask.PlanOrder, _: Any) -> PlanFacts:
    part_type = reader.first(PartType, request.part_type, request.revision)
    machines = reader.values(Machine, machine=request.machine)
    part = TABLES["part"]
    query = select(part.c.serial).join(PART_STATE, PART_STATE.c.part == part.c.id)
    ordered = reader.connection.scalars(
        query.where(part.c.part_type == request.part_type, part.c.serial.in_(request.serials))
    )
    wanted = {block.program_sha256 for block in request.blocks}
    released = reader.connection.scalars(
        select(PROGRAM_RELEASE.c.program_sha256).where(PROGRAM_RELEASE.c.program_sha256.in_(wanted))
    )
    number = (reader.connection.scalar(select(func.max(ORDER_STATE.c.number))) or 0) + 1
    machine = machines[-1] if machines else None
    names = machine_names(reader)
    return PlanFacts(
        part_type=part_type,
        machine=machine,
        ordered=frozenset(ordered),
        released=frozenset(released),
        number=number,
        machines=names,
    )


def _program(reader: StoreReader, request: ask.ReleaseProgram | ask.RecordTransfer, _: Any) -> ProgramFacts:
    sha = request.program_sha256
    query = select(PROGRAM_RELEASE.c.at).where(PROGRAM_RELEASE.c.program_sha256 == sha)
    return ProgramFacts(program_text(reader, sha) is not None, reader.connection.scalar(query) is not None)


def _proposal(reader: StoreReader, request: ask.DecideProposal, book: ProposalFacts) -> ProposalFacts:
    """With the decisions as they are now: another may have decided since the book was read."""
    if book.book is None:
        return book
    now = tuple(reader.values(ProposalDecision, identity=request.proposal))
    others = tuple(decision for decision in book.book.decisions if decision.proposal != request.proposal)
    return replace(book, book=replace(book.book, decisions=(*others, *now)))


def _alarm(reader: StoreReader, request: ask.Acknowledge, _: Any) -> bool | None:
    query = select(ALARM.c.id, ALARM_ACKNOWLEDGED.c.alarm).outerjoin(
        ALARM_ACKNOWLEDGED, ALARM_ACKNOWLEDGED.c.alarm == ALARM.c.id
    )
    row = reader.connection.execute(query.where(ALARM.c.id == request.alarm)).one_or_none()
    return None if row is None else row.alarm is not None


def _part(reader: StoreReader, request: ask.Certify, _: Any) -> frozenset[int]:
    part = TABLES["part"]
    return frozenset(reader.connection.scalars(select(part.c.id).where(part.c.id == request.part)))


def _temperatures(reader: StoreReader, request: ask.RecordTemperatures, _: Any) -> frozenset[str]:
    of_then = (TEMPERATURE.c.machine == request.machine) & (TEMPERATURE.c.at == stamp(request.at))
    of_them = of_then & TEMPERATURE.c.signal.in_(tuple(request.signals))
    return frozenset(reader.connection.scalars(select(TEMPERATURE.c.signal).where(of_them)))


def _order(reader: StoreReader, request: Any, _: Any) -> OrderNow:
    return order_of(reader, request.order)


_How = tuple[Callable[..., Any], Callable[..., Any]]
_HOW: Final[Mapping[type, _How]] = {
    ask.PlanOrder: (_plan, plan.plan_order),
    ask.NextBlock: (lambda known, request, _: next_of(known, request.machine), plan.next_block),
    ask.RecordFacts: (
        lambda known, request, _: runs_of(known, [fact.run for fact in request.facts]),
        runs.record_facts,
    ),
    ask.RecordTouches: (lambda known, request, _: runs_of(known, [request.run]), runs.record_touches),
    ask.RecordTemperatures: (_temperatures, runs.record_temperatures),
    ask.Calibrated: (lambda *_: None, records.calibrated),
    ask.Hold: (_order, runs.hold),
    ask.DecideStep: (_order, runs.decide_step),
    ask.Arm: (_order, runs.arm),
    ask.RecordStep: (_order, runs.record_step),
    ask.StepCorrected: (_order, runs.step_corrected),
    ask.CorrectionRefused: (_order, runs.correction_refused),
    ask.CellSilent: (
        lambda known, request, _: silence_of(known, request.order, request.part, request.step),
        runs.cell_silent,
    ),
    ask.ReleaseProgram: (_program, records.release_program),
    ask.RecordTransfer: (_program, records.record_transfer),
    ask.Certify: (_part, records.certify),
    ask.RaiseAlarm: (lambda *_: None, records.raise_alarm),
    ask.Acknowledge: (_alarm, records.acknowledge),
    ask.DecideProposal: (_proposal, records.decide_proposal),
    ask.SetTool: (lambda known, request, _: known.first(Edge, *request.edge), records.set_tool),
}


_SERVICE: Final = By("service", Role.SERVICE)


def hold_silent(store: Store, now: datetime, limit_s: float) -> int:
    """Holds every part that was being cut when its machine was heard last, longer ago than this. Returns how many."""
    with store.reading() as connection:
        found = [one for one in _started(connection) if _silent(connection, one, now, limit_s)]
    held = 0
    for order, part, no in found:
        held += len(carry_out(store, ask.CellSilent(order, part, no, limit_s), _SERVICE, now).orders)
    return held


def _started(connection: Connection) -> list[tuple[str, int, int]]:
    query = select(STEP.c.order, STEP.c.part, STEP.c.no).where(STEP.c.state == StepState.STARTED.value)
    return [(row.order, row.part, row.no) for row in connection.execute(query)]


def _silent(connection: Connection, step: tuple[str, int, int], now: datetime, limit_s: float) -> bool:
    at = last_word(connection, *step)
    return at is not None and (now - at).total_seconds() > limit_s
