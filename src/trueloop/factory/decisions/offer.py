"""What a machine does next: `candidate`, `next_block`."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime
from hashlib import sha256
from typing import Final

from trueloop.domain.factory.run import Run, RunFact
from trueloop.domain.factory.states import FactKind, PartState, StepState
from trueloop.errors import Code
from trueloop.factory.changes import Changes, Event, Offer
from trueloop.factory.decisions.finish import Candidate, MachineFacts, checks_of
from trueloop.factory.known import OrderNow, PartNow
from trueloop.factory.requests import NextBlock
from trueloop.factory.roles import By

_ASKED_FOR: Final = (StepState.OFFERED, StepState.SENT, StepState.VERIFIED)
_MAY_BEGIN: Final = (StepState.WAITING, StepState.FAILED)


@dataclass(frozen=True)
class NextFacts:
    """The candidate of a machine (None: there is nothing to do) and, where it has one, its run."""

    machine: MachineFacts
    candidate: Candidate | None
    run: Run | None = None


def candidate(orders: Iterable[OrderNow]) -> tuple[OrderNow, PartNow] | None:
    """Which part is next on a machine, by its orders in their order. A part that is in the machine comes first.

    None: nothing is to be done, or the part in the machine is held, or waits for a person or a task.
    """
    every = [(order, part) for order in orders for part in order.parts]
    inside = [one for one in every if one[1].on_machine]
    waiting = [
        (order, part) for order, part in every if not part.rejected and part.state is not PartState.HELD and part.next
    ]
    fresh = [one for one in waiting if one[1].next and one[1].next.kind.moves and one[1].state is PartState.PLANNED]
    for chosen in (inside or fresh)[:1]:
        step, held = chosen[1].next, chosen[1].state is PartState.HELD
        if step is not None and step.kind.moves and (not held or step.state is StepState.STARTED):
            return chosen
    return None


def next_block(facts: NextFacts, request: NextBlock, by: By, now: datetime) -> Changes:
    """The block that the machine may run now, under a key of its own; asked again, the same under the same key.

    A cell that asks does not run anything: a run that has started and not ended becomes unknown, and its part is held.
    Raises FAC errors for what is not in order.
    """
    what = facts.candidate
    if what is None:
        return Changes()
    step = what.step
    if step.state is StepState.STARTED and facts.run is not None:
        return left_unknown(what.order, what.part, facts.run, "and its cell asks for the next", now)
    if step.state not in (*_ASKED_FOR, *_MAY_BEGIN):
        return Changes()
    checks = checks_of(what, facts.machine, now)
    assert what.program is not None, "checked"
    again = step.state in _ASKED_FOR and facts.run is not None
    attempt = step.attempts if again else step.attempts + 1
    order = what.order.order
    key = f"{order.id}.{what.part.row}.{step.no}.{attempt}"
    sent = request.as_sent(what.program, key)
    mode = "armed" if what.order.armed_parts > 0 else "press-cycle-start"
    if again and facts.run is not None:
        if sha256(sent).hexdigest() != facts.run.sent_sha256:
            return _otherwise(what, facts.run)
        return Changes(answer=Offer(facts.run, what.order.block(step.no), sent, checks, mode))
    model = order.route.conditions.model_sha256 or ""
    run = Run(
        *(key, order.id, what.part.value, step.no, attempt, order.machine),
        *(step.program_sha256, sha256(sent).hexdigest(), model),
    )
    offered = replace(step, state=StepState.OFFERED, run=key, attempts=attempt)
    after = what.order.with_part(what.part.with_step(offered))
    event = Event("offered", f"part:{what.part.row}", {"run": key, "step": str(step.no), "mode": mode})
    return Changes((after,), (run,), events=(event,), answer=Offer(run, what.order.block(step.no), sent, checks, mode))


def _otherwise(what: Candidate, run: Run) -> Changes:
    """A run that was offered in one text is not offered in another: its cell may hold the first."""
    part = what.part.held(Code.FAC_READBACK, f"run {run.key} was offered as {run.sent_sha256[:16]!r}, and no longer is")
    event = Event("held", f"part:{part.row}", {"why": part.held_why, "run": run.key})
    return Changes((what.order.with_part(part),), events=(event,))


def left_unknown(order: OrderNow, part: PartNow, run: Run, but: str, now: datetime) -> Changes:
    """A run that has started, of whose end nobody knows, and why that is said now: its part is held."""
    step = part.steps[run.step]
    why = f"step {step.no} ({step.kind}) started and did not end, {but}"
    fact = RunFact(run.key, FactKind.UNKNOWN, now, "service", {"why": why})
    part = part.with_step(replace(step, state=StepState.UNKNOWN)).held(Code.FAC_CUT, why)
    event = Event("held", f"part:{part.row}", {"why": part.held_why, "run": run.key})
    return Changes((order.with_part(part),), (fact,), events=(event,))
