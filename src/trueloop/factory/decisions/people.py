"""Decisions of people on parts, `hold`, `decide_step`, `arm`, `record_step`, and a task's reports on a correction."""

from dataclasses import replace
from datetime import datetime
from typing import Final

from trueloop.domain.factory import BlockKind, FactKind, PartState, RunFact, StepState
from trueloop.errors import Code, TrueloopError
from trueloop.factory.decisions.runs import tasks_of
from trueloop.factory.known import Changes, Event, OrderNow, PartNow, StepNow
from trueloop.factory.requests import Arm, By, CorrectionRefused, DecideStep, Hold, RecordStep, Role, StepCorrected
from trueloop.wording import wording

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
