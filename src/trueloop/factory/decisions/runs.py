"""Consequences of facts and touches of runs: `record_facts`, `record_touches`, `record_temperatures`.

Decisions of people on parts, `hold`, `decide_step`, `arm`, `record_step`, and a task's reports on a correction.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from hashlib import sha256
from typing import Final

from trueloop.domain.factory import BlockKind, FactKind, PartState, Run, RunFact, StepState
from trueloop.errors import Code, TrueloopError
from trueloop.factory.decisions.plan import left_unknown
from trueloop.factory.known import Changes, Event, NewTask, OrderNow, PartNow, StepNow, unknown
from trueloop.factory.requests import (
    Arm,
    By,
    CellSilent,
    CorrectionRefused,
    DecideStep,
    Hold,
    RecordFacts,
    RecordStep,
    RecordTemperatures,
    RecordTouches,
    Role,
    StepCorrected,
    require_machine,
)
from trueloop.storage.schema import stamp
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


_BY_HAND: Final = (BlockKind.REMOVE, BlockKind.MEASURE, BlockKind.RELEASE)


def hold(order: OrderNow, request: Hold, by: By, now: datetime) -> Changes:
    """Holds a part: nothing more is offered for it; what runs goes on. Raises FAC-STATE where nothing is left to do."""
    part = order.part(request.part)
    if part.rejected or part.next is None:
        raise _state(part, wording("is done: there is nothing to hold"), wording("look at its life"))
    after = part.held(Code.FAC_HELD, f"{by.name}: {request.why}")
    return _changed(order, after, "held", {"why": after.held_why})


def decide_step(order: OrderNow, request: DecideStep, by: By, now: datetime) -> Changes:
    """Decides a step. Made: it is recorded. Not made: it may be offered anew, under another key. Reject: it is the end.

    Only of a part that is held: what runs, or may run, is not decided over. Gauging whose touches are not here cannot
    have been made; gauging that nothing was cut by yet may be decided as not made, and is done again. Raises FAC-STATE.
    """
    part, step = order.part(request.part), order.step(request.part, request.step)
    if part.state is not PartState.HELD:
        raise _state(part, wording("is not held"), wording("hold it first"))
    said = {"step": str(step.no), "verdict": request.verdict, "why": request.why, "run": step.run}
    if request.verdict == "reject":
        return _changed(order, replace(part, state=PartState.REJECTED, held_why=""), "rejected", said)
    if _gauging_before(part, step) and request.verdict == "not-made":
        return _changed(order, part.with_step(_anew(step)).freed(), "decided", said)
    if part.next is None or part.next.no != step.no:
        raise _state(
            part,
            wording("is held before another step: {step}", step=part.next.no if part.next else "–"),
            wording("decide on that step"),
        )
    if step.state is StepState.STARTED:
        raise _state(
            part,
            wording("is being made: step {no} ({kind}) has started", no=step.no, kind=step.kind),
            wording("wait until its cell says more"),
        )
    facts: tuple[RunFact, ...] = ()
    if request.verdict == "made":
        if not step.kind.cuts or step.state is StepState.WAITING:
            raise _state(
                part,
                wording("has no cut that was begun at step {no} ({kind})", no=step.no, kind=step.kind),
                wording("decide that it was not made"),
            )
        facts = (RunFact(step.run, FactKind.ENDED, now, f"person:{by.name}", {"why": request.why}),) if step.run else ()
        after = part.with_step(replace(step, state=StepState.RECORDED)).freed()
    else:
        after = part.with_step(_again(part, step)).freed()
    changes = _changed(order, after, "decided", said)
    return replace(changes, keep=facts, tasks=tasks_of(order, after))


def _gauging_before(part: PartNow, step: StepNow) -> bool:
    """Returns whether it is the gauging by whose touches the part is to be corrected next."""
    following = part.next is not None and part.next.kind is BlockKind.CORRECT and part.next.no == step.no + 1
    return following and step.kind is BlockKind.PROBE


def _anew(step: StepNow) -> StepNow:
    return replace(step, state=StepState.WAITING, run="")


def _again(part: PartNow, step: StepNow) -> StepNow:
    """A cell that has been offered a run may still begin it: it keeps its key, under which it is done at most once."""
    open_yet = step.state in (StepState.OFFERED, StepState.SENT, StepState.VERIFIED)
    keeps = open_yet and not part.held_why.startswith(Code.FAC_READBACK)
    return step if keeps else _anew(step)


def arm(order: OrderNow, request: Arm, by: By, now: datetime) -> Changes:
    """Arms an order: so many parts start without Cycle Start. Raises FAC-ARM away from the machine, or for too many."""
    left = sum(part.next is not None and not part.rejected for part in order.parts)
    own = by.machine == order.order.machine.name
    at_machine = own if by.role is Role.CELL else request.at_machine
    held = any(part.state is PartState.HELD for part in order.parts)
    if request.parts and (not at_machine or held or not 0 < request.parts <= left):
        why = (
            wording("a part of it is held")
            if held
            else wording("{n} parts are left", n=left)
            if at_machine
            else wording("nobody is at the machine")
        )
        raise Code.FAC_ARM.refusal(
            wording(
                "order {order!r} is not armed for {parts} parts: {why}",
                order=order.order.id,
                parts=request.parts,
                why=why,
            ),
            hint=wording(
                "arm it at machine {machine!r}, for no more parts than are left", machine=order.order.machine.name
            ),
            values={"parts": float(request.parts)},
        )
    said = {"parts": str(request.parts), "why": request.why}
    events = (Event("armed" if request.parts else "disarmed", f"order:{order.order.id}", said),)
    return Changes((replace(order, armed_parts=request.parts),), events=events)


def record_step(order: OrderNow, request: RecordStep, by: By, now: datetime) -> Changes:
    """Records a step without a program as done. Releasing takes an engineer. Raises FAC-STATE, FAC-HELD, FAC-ROLE."""
    part, step = order.part(request.part), order.step(request.part, request.step)
    _require_next(part, step, _BY_HAND)
    if step.kind is BlockKind.RELEASE and by.role is Role.OPERATOR:
        raise Code.FAC_ROLE.refusal(
            wording(
                "{by!r} has the role 'operator'; releasing part {serial!r} needs 'engineer'",
                by=by.name,
                serial=part.value.serial,
            ),
            hint=wording("ask an account with that role"),
            values={"role": by.role.value, "needed": Role.ENGINEER.value},
        )
    after = part.with_step(replace(step, state=StepState.RECORDED)).freed()
    return _changed(order, after, step.kind.leaves.value, {"step": str(step.no), "why": request.why})


def step_corrected(order: OrderNow, request: StepCorrected, by: By, now: datetime) -> Changes:
    """Gives the corrected program to the finish cuts that are to be corrected. Done twice it is done once.

    Nothing comes of touches in whose stead the part was gauged anew meanwhile: those have a task of their own.
    """
    part, step = order.part(request.part), order.step(request.part, request.step)
    done = step.state is StepState.RECORDED and step.run == request.correction
    if done or part.gauged_by(step.no) != request.gauged_by:
        return Changes()
    _require_next(part, step, (BlockKind.CORRECT,))
    after = part.with_step(replace(step, state=StepState.RECORDED, run=request.correction))
    for later in after.steps[step.no + 1 :]:
        if order.block(later.no).corrected:
            after = after.with_step(replace(later, program_sha256=request.program_sha256))
    said = {"correction": request.correction, "program_sha256": request.program_sha256}
    return _changed(order, after.freed(), "corrected", {**said, "touches_sha256": request.touches_sha256})


def correction_refused(order: OrderNow, request: CorrectionRefused, by: By, now: datetime) -> Changes:
    """Holds the part, with what the loop refused it for; not for touches of an earlier gauging."""
    part, step = order.part(request.part), order.step(request.part, request.step)
    if part.rejected or step.state is StepState.RECORDED or part.gauged_by(step.no) != request.gauged_by:
        return Changes()
    after = replace(part, state=PartState.HELD, held_why=f"{request.code}: {request.said}")
    return _changed(order, after, "held", {"why": after.held_why})


def _require_next(part: PartNow, step: StepNow, kinds: tuple[BlockKind, ...]) -> None:
    if part.state is PartState.HELD:
        raise Code.FAC_HELD.refusal(
            wording("part {serial!r} is held: {why}", serial=part.value.serial, why=part.held_why),
            hint=wording("decide on it first"),
            values={"serial": part.value.serial},
        )
    if part.rejected or part.next is None:
        raise _state(
            part,
            wording("has no step left: step {no} ({kind}) cannot be recorded", no=step.no, kind=step.kind),
            wording("name another part"),
        )
    if part.next.no != step.no:
        raise _state(
            part,
            wording(
                "is {state}: its next step is {next} ({next_kind}), not {no} ({kind})",
                state=part.state.value,
                next=part.next.no,
                next_kind=part.next.kind,
                no=step.no,
                kind=step.kind,
            ),
            wording("take its steps in their order"),
        )
    if step.kind not in kinds:
        by_hand = " and ".join(kind.value for kind in kinds)
        raise _state(
            part,
            wording(
                "is at step {no} ({kind}), which is not recorded by hand: {by_hand} are",
                no=step.no,
                kind=step.kind,
                by_hand=by_hand,
            ),
            wording("its machine reports that step when it has run it"),
        )


def _changed(order: OrderNow, part: PartNow, what: str, values: dict[str, str]) -> Changes:
    return Changes((order.with_part(part),), events=(Event(what, f"part:{part.row}", values),))


def _state(part: PartNow, why: str, hint: str) -> TrueloopError:
    values = {"state": part.state.value}
    return Code.FAC_STATE.refusal(
        wording("part {serial!r} {why}", serial=part.value.serial, why=why), hint=hint, values=values
    )
