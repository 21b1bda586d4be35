"""Consequences of facts and touches of runs: `record_facts`, `record_touches`, `record_temperatures`."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from hashlib import sha256
from typing import Final

from trueloop.domain.factory import BlockKind, FactKind, PartState, Run, RunFact, StepState
from trueloop.errors import Code
from trueloop.factory.decisions.plan import left_unknown
from trueloop.factory.known import Changes, Event, NewTask, OrderNow, PartNow, StepNow, unknown
from trueloop.factory.requests import By, CellSilent, RecordFacts, RecordTemperatures, RecordTouches, require_machine
from trueloop.storage.factory_tables import stamp
from trueloop.wording import wording


def state_of(kind: BlockKind, run: Run, facts: Iterable[RunFact], touches: bool) -> StepState:
    """Returns the state, of all facts at once: in whatever order they arrive, and however often, it is the same.

    A cut is recorded once it ended; gauging once its touches are here too. An end outweighs that nobody knew of one. A
    run that failed after it had started is unknown, for the tool may have cut. `verified` counts only where what was
    read back equals what was sent.
    """
    told = {run_fact.what for run_fact in facts if run_fact.what is not FactKind.VERIFIED}
    if FactKind.ENDED in told:
        return StepState.RECORDED if kind.cuts or touches else StepState.ENDED
    if FactKind.UNKNOWN in told or (FactKind.FAILED in told and FactKind.STARTED in told):
        return StepState.UNKNOWN
    if FactKind.FAILED in told:
        return StepState.FAILED
    if FactKind.STARTED in told:
        return StepState.STARTED
    if verified(run, facts):
        return StepState.VERIFIED
    return StepState.SENT if FactKind.SENT in told else StepState.OFFERED


def verified(run: Run, facts: Iterable[RunFact]) -> bool:
    """Returns whether a witness read back what was sent, and no one read back anything else."""
    read = [run_fact.values.get("read_back_sha256", "") for run_fact in facts if run_fact.what is FactKind.VERIFIED]
    return bool(read) and all(one == run.sent_sha256 for one in read)


def read_back_otherwise(run: Run, facts: Iterable[RunFact]) -> str | None:
    """Returns the hash of what a control held instead of what was sent; None: no witness read back anything else."""
    read = [run_fact.values.get("read_back_sha256", "") for run_fact in facts if run_fact.what is FactKind.VERIFIED]
    return next((one for one in read if one != run.sent_sha256), None)


@dataclass(frozen=True)
class SilenceFacts:
    """The order, the run of the step that is asked about, and when its machine was heard last; None: never."""

    order: OrderNow
    run: Run | None
    heard_at: datetime | None


def cell_silent(facts: SilenceFacts, request: CellSilent, by: By, now: datetime) -> Changes:
    """Makes the run unknown and holds its part, unless it has ended or its cell was heard meanwhile.

    Repeated it changes nothing. An end that the program witnessed frees the part when the cell is heard again.
    """
    part, step = facts.order.part(request.part), facts.order.step(request.part, request.step)
    if step.state is not StepState.STARTED or facts.run is None or facts.heard_at is None:
        return Changes()
    silent_s = (now - facts.heard_at).total_seconds()
    if silent_s <= request.limit_s:
        return Changes()
    return left_unknown(facts.order, part, facts.run, f"and its cell has been silent for {silent_s:.0f} s", now)


MOST_ATTEMPTS: Final = 3
"""Of a step that fails before it starts; then a person looks at it."""
_MOVED: Final = (FactKind.STARTED, FactKind.ENDED, FactKind.UNKNOWN)


@dataclass(frozen=True)
class KnownRun:
    """A run with what is known of it already. `row`: its part's number in the store; `touches`: hashes of files."""

    run: Run
    row: int
    facts: tuple[RunFact, ...]
    touches: frozenset[str] = frozenset()


@dataclass(frozen=True)
class RunsFacts:
    """Runs by key, and their orders by id."""

    runs: Mapping[str, KnownRun]
    orders: Mapping[str, OrderNow]


def record_facts(facts: RunsFacts, request: RecordFacts, by: By, now: datetime) -> Changes:
    """Keeps every fact of a known run, whatever it is. Raises FAC-UNKNOWN for a run that nobody offered."""
    done = Changes(answer=tuple(dict.fromkeys(run_fact.run for run_fact in request.facts)))
    orders = dict(facts.orders)
    for key in done.answer:
        known = _known(facts, key, by)
        told = {run_fact.identity: run_fact for run_fact in known.facts}
        new = [run_fact for run_fact in request.facts if run_fact.run == key and run_fact.identity not in told]
        if not new:
            continue
        known = replace(known, facts=(*known.facts, *{run_fact.identity: run_fact for run_fact in new}.values()))
        then = _after(orders[known.run.order], known, new)
        orders |= {order.order.id: order for order in then.orders}
        done = _joined(done, replace(then, keep=(*{run_fact.identity: run_fact for run_fact in new}.values(),)))
    changed = tuple(order_now for key, order_now in orders.items() if order_now != facts.orders[key])
    return replace(done, orders=changed)


def record_touches(facts: RunsFacts, request: RecordTouches, by: By, now: datetime) -> Changes:
    """Keeps a gauging run's file of touches once. Raises FAC-UNKNOWN, FAC-TOUCHES (another file of the run)."""
    known = _known(facts, request.run, by)
    hashed = sha256(request.content).hexdigest()
    if hashed in known.touches:
        return Changes(answer=hashed)
    kind = facts.orders[known.run.order].block(known.run.step).kind
    if known.touches or kind not in (BlockKind.PROBE, BlockKind.INSPECT):
        said = (
            "has touches already, of another content"
            if known.touches
            else f"is of a step {kind.value!r}, which has none"
        )
        raise Code.FAC_TOUCHES.refusal(
            f"run {request.run!r} {said}: {request.name!r} is not kept",
            hint="send the file that the gauging run of this key wrote, as it wrote it",
            values={"run": request.run},
        )
    row = {"run": request.run, "at": stamp(now), "name": request.name, "sha256": hashed, "content": request.content}
    then = _after(facts.orders[known.run.order], replace(known, touches=frozenset({hashed})), [])
    event = Event("touches", f"part:{known.row}", {"run": request.run, "sha256": hashed, "name": request.name})
    return _joined(Changes(rows=(("run_touches", row),), events=(event,), answer=hashed), then)


def record_temperatures(facts: frozenset[str], request: RecordTemperatures, by: By, now: datetime) -> Changes:
    """Temperatures of a machine. `facts`: signals whose value of that moment is there, for a cell sends them again."""
    require_machine(by, request.machine)
    said = {"machine": request.machine, "run": request.run, "at": stamp(request.at)}
    rows = [
        ("temperature", {**said, "signal": name, "celsius": c})
        for name, c in request.signals.items()
        if name not in facts
    ]
    return Changes(rows=tuple(rows))


def _known(facts: RunsFacts, key: str, by: By) -> KnownRun:
    known = facts.runs.get(key)
    if known is None:
        raise unknown(wording("run"), key, wording("it was never offered"))
    require_machine(by, known.run.machine.name)
    return known


def _after(order: OrderNow, known_run: KnownRun, new: list[RunFact]) -> Changes:
    """Derives the state of step and part from all facts of a run."""
    part, run = order.part(known_run.row), known_run.run
    step = part.steps[run.step]
    if part.rejected or (step.run == run.key and step.state is StepState.RECORDED):
        return Changes((order,))
    if step.run != run.key:
        return _contradicted(order, part, known_run, new)
    state = state_of(step.kind, run, known_run.facts, bool(known_run.touches))
    if state is step.state and not read_back_otherwise(run, known_run.facts):
        return Changes((order,))
    after = part.with_step(replace(step, state=state))
    if part.state is not PartState.HELD or (state is StepState.RECORDED and part.held_why.startswith(Code.FAC_CUT)):
        after = after.freed()
    after = _held(after, replace(step, state=state), known_run)
    events = [Event(str(state), f"part:{part.row}", {"run": run.key, "step": str(step.no)})]
    if after.state is PartState.HELD and part.state is not PartState.HELD:
        events.append(Event("held", f"part:{part.row}", {"why": after.held_why, "run": run.key}))
    return Changes((_left(order.with_part(after), after, step),), events=tuple(events), tasks=tasks_of(order, after))


def _held(part: PartNow, step: StepNow, known_run: KnownRun) -> PartNow:
    run, serial = known_run.run, part.value.serial
    if (other := read_back_otherwise(run, known_run.facts)) is not None:
        return part.held(
            Code.FAC_READBACK, f"for part {serial!r} {run.sent_sha256[:16]!r} was sent, and {other[:16]!r} read back"
        )
    if step.state is StepState.UNKNOWN:
        return part.held(Code.FAC_CUT, f"step {step.no} ({step.kind}) of part {serial!r} started and did not end")
    if step.state is StepState.FAILED and step.attempts >= MOST_ATTEMPTS:
        return part.held(Code.FAC_HELD, f"step {step.no} ({step.kind}) of part {serial!r} failed {step.attempts} times")
    ended = step.state in (StepState.ENDED, StepState.RECORDED)
    if ended and step.kind is BlockKind.FINISH and not verified(run, known_run.facts):
        return part.held(Code.FAC_READBACK, f"part {serial!r} was finished by a program that nobody read back")
    return part


def _contradicted(order: OrderNow, part: PartNow, run: KnownRun, new: list[RunFact]) -> Changes:
    """An earlier attempt, which a person took for not made, turns out to have moved: nobody knows what was cut."""
    moved = [run_fact for run_fact in new if run_fact.what in _MOVED]
    if not moved:
        return Changes((order,))
    why = f"run {run.run.key}, decided as not made, reports {moved[0].what} at {moved[0].at.isoformat()}"
    after = part.held(Code.FAC_HELD, why)
    return Changes((order.with_part(after),), events=(Event("held", f"part:{part.row}", {"why": why}),))


def _left(order: OrderNow, part: PartNow, step: StepNow) -> OrderNow:
    """With one armed part less once the last program of a part has run."""
    moving = [step_now for step_now in part.steps if step_now.kind.moves]
    last = moving[-1].no == step.no and moving[-1].state is StepState.RECORDED
    return replace(order, armed_parts=max(order.armed_parts - 1, 0)) if last else order


def tasks_of(order: OrderNow, part: PartNow) -> tuple[NewTask, ...]:
    """Returns the correction task, once all gauging before it is recorded and nothing holds the part."""
    step = part.next
    if part.state is PartState.HELD or step is None or step.kind is not BlockKind.CORRECT:
        return ()
    values = {"order": order.order.id, "part": str(part.row), "step": str(step.no)}
    return (NewTask("correct", f"part:{part.row}", values),)


def _joined(first: Changes, then: Changes) -> Changes:
    return replace(
        first,
        orders=then.orders,
        keep=(*first.keep, *then.keep),
        events=(*first.events, *then.events),
        tasks=(*first.tasks, *then.tasks),
    )
