"""Decides whether an order can be made: `plan_order`.

Checks before a program runs, above all before a finish cut: `checks_of`.
"""

import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from difflib import get_close_matches
from hashlib import sha256
from itertools import pairwise
from typing import Final

from trueloop.domain.factory import Block, BlockKind, FactKind, PartState, Route, Run, RunFact, StepState, WorkOrder
from trueloop.domain.life import Identity
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Machine
from trueloop.errors import Code, TrueloopError
from trueloop.factory.known import Changes, Event, Offer, OrderNow, PartNow, StepNow
from trueloop.factory.requests import By, NextBlock, PlanOrder
from trueloop.wording import wording

AHEAD: Final = timedelta(seconds=60)
"""How far a cell's clock may be ahead of ours; beyond that nobody knows how old a value is."""


@dataclass(frozen=True)
class MachineFacts:
    """The last report of a machine; None: none came. `alarms` are the numbers of open ones that block it."""

    name: str
    calibrated_at: datetime | None = None
    temperature_at: datetime | None = None
    corrector: str = ""
    alarms: tuple[int, ...] = ()


@dataclass(frozen=True)
class CorrectionFacts:
    """The correction of a finish cut: its parts and programs; `probe_run`: the gauging run whose touches it is by."""

    id: str
    parts: tuple[Identity, ...]
    source_sha256: str
    corrected_sha256: str
    probe_run: str


@dataclass(frozen=True)
class Candidate:
    """The next step of a part, with what its checks need; `program`: its text, None where the store has none."""

    order: OrderNow
    part: PartNow
    step: StepNow
    program: bytes | None = None
    correction: CorrectionFacts | None = None


def checks_of(what: Candidate, machine: MachineFacts, now: datetime) -> tuple[str, ...]:
    """Returns what was checked, in words. Raises FAC errors for anything that is not in order."""
    found = (*_program(what),)
    return (*found, *_correction(what), *_machine(what, machine, now)) if what.step.kind is BlockKind.FINISH else found


def _program(what: Candidate) -> Iterator[str]:
    wanted = what.step.program_sha256
    found = "" if what.program is None else sha256(what.program).hexdigest()
    block = what.order.block(what.step.no)
    if not wanted or found != wanted or (not block.corrected and wanted != block.program_sha256):
        raise Code.FAC_PROGRAM.refusal(
            f"step {what.step.no} ({what.step.kind}) of part {what.part.value.serial!r}: the program accepted is "
            f"{wanted[:16] or 'none'!r}, the one in the store {found[:16] or 'none'!r}",
            hint="hold the part and look at its correction; nothing was sent",
            values={"accepted": wanted, "found": found},
        )
    yield f"program {wanted[:16]} as accepted"


def _correction(what: Candidate) -> Iterator[str]:
    block = what.order.block(what.step.no)
    if not block.corrected:
        return
    made, part, wanted = what.correction, what.part, what.step.program_sha256
    probes = [step for step in part.steps if step.kind is BlockKind.PROBE]
    if made is None or made.corrected_sha256 != wanted or made.source_sha256 != block.program_sha256:
        found = "none" if made is None else made.corrected_sha256
        raise Code.FAC_PROGRAM.refusal(
            f"part {part.value.serial!r}: no correction in the store leads from program {block.program_sha256[:16]!r} "
            f"to {wanted[:16]!r}, but to {found[:16]!r}",
            hint="hold the part; run its step 'correct' anew",
            values={"accepted": wanted, "found": found},
        )
    own = all(one == part.value.identity for one in made.parts) and made.parts
    if not own or made.probe_run not in [probe.run for probe in probes if probe.state is StepState.RECORDED]:
        raise Code.FAC_TOUCHES.refusal(
            f"correction {made.id!r} was made from touches of {'; '.join(map(_part_words, made.parts)) or 'no part'} "
            f"in run {made.probe_run!r}, not of part {part.value.serial!r}",
            hint="probe this part, and correct from its own touches",
            values={"run": made.probe_run},
        )
    yield f"correction {made.id} from this part's touches"


def _part_words(identity: Identity) -> str:
    """Returns a part in words: `shaft rev B serial b`."""
    name, revision, serial = identity
    return name + (f" rev {revision}" if revision else "") + (f" serial {serial}" if serial else "")


def _machine(what: Candidate, machine: MachineFacts, now: datetime) -> Iterator[str]:
    asked = what.order.order.route.conditions
    for code, name, at, limit in (
        (Code.FAC_CALIBRATION, "the calibration of the probe", machine.calibrated_at, asked.calibration_age_s),
        (Code.FAC_TEMPERATURE, "the latest temperature", machine.temperature_at, asked.temperature_age_s),
    ):
        if limit is not None:
            yield _fresh(code, machine.name, name, at, limit, now)
    planned = asked.model_sha256
    if planned is not None and machine.corrector != (planned or "off"):
        raise Code.FAC_CORRECTOR.refusal(
            f"machine {machine.name!r}: the corrector is to be {planned or 'off'!r} and is {machine.corrector!r}",
            hint="load the planned model, or plan the order for the one that is in force",
            values={"planned": planned or "off", "found": machine.corrector},
        )
    if machine.alarms:
        raise Code.FAC_ALARM.refusal(
            wording("alarm {alarm} ({n} in all) is not acknowledged", alarm=machine.alarms[0], n=len(machine.alarms)),
            hint=wording("look at it and acknowledge it; then the finish cut is offered"),
            values={"alarm": float(machine.alarms[0])},
        )
    yield "no alarm is open"


def _fresh(code: Code, machine: str, name: str, at: datetime | None, limit_s: float, now: datetime) -> str:
    age_s = None if at is None else (now - at).total_seconds()
    if age_s is not None and -AHEAD.total_seconds() <= age_s <= limit_s:
        return f"{name} is {max(age_s, 0.0):.0f} s old"
    said = "is not known" if age_s is None else f"is {age_s:.0f} s old"
    raise code.refusal(
        f"machine {machine!r}: {name} {said}; the limit is {limit_s:g} s",
        hint="calibrate the probe or have the cell send temperatures; an order may be planned without this",
        values={"machine": machine, "limit_s": limit_s},
    )


_ASKED_FOR: Final = (StepState.OFFERED, StepState.SENT, StepState.VERIFIED)
_MAY_BEGIN: Final = (StepState.WAITING, StepState.FAILED)


@dataclass(frozen=True)
class NextFacts:
    """The candidate of a machine (None: there is nothing to do) and, where it has one, its run."""

    machine: MachineFacts
    candidate: Candidate | None
    run: Run | None = None


def candidate(orders: Iterable[OrderNow]) -> tuple[OrderNow, PartNow] | None:
    """Returns the part that is next on a machine, by its orders in their order. A part in the machine comes first.

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
    """Offers the block that the machine may run now, under a key of its own; requested again, under the same key.

    A cell that asks does not run anything: a run that has started and not ended becomes unknown, and its part is held.
    Raises FAC errors for anything that is not in order.
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
        key=key,
        order=order.id,
        part=what.part.value,
        step=step.no,
        attempt=attempt,
        machine=order.machine,
        program_sha256=step.program_sha256,
        sent_sha256=sha256(sent).hexdigest(),
        model_sha256=model,
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
    """Marks a started run as unknown, with the reason why its end is not known: its part is held."""
    step = part.steps[run.step]
    why = f"step {step.no} ({step.kind}) started and did not end, {but}"
    fact = RunFact(run.key, FactKind.UNKNOWN, now, "service", {"why": why})
    part = part.with_step(replace(step, state=StepState.UNKNOWN)).held(Code.FAC_CUT, why)
    event = Event("held", f"part:{part.row}", {"why": part.held_why, "run": run.key})
    return Changes((order.with_part(part),), (fact,), events=(event,))


MOST_PARTS: Final = 500
_RANK: Final = {kind: k for k, kind in enumerate(BlockKind)}


@dataclass(frozen=True)
class PlanFacts:
    """The store's knowledge of an order's parts and programs: `ordered` are serial numbers with an order, `released`
    programs' hashes.

    `part_type` and `machine` are as they are kept already; None: not kept. `machines`: names of all machines that the
    store knows, also by a key or because they were heard. `number` is that of the order to come.
    """

    part_type: PartType | None
    machine: Machine | None
    ordered: frozenset[str]
    released: frozenset[str]
    number: int
    machines: frozenset[str] = frozenset()


def plan_order(facts: PlanFacts, request: PlanOrder, by: By, now: datetime) -> Changes:
    """Plans the order; its parts get their rows as it is kept. Raises FAC-PLAN, FAC-ORDERED, FAC-RELEASE."""
    for wrong in (*_wrong_parts(request), *_wrong_route(request)):
        raise Code.FAC_PLAN.refusal(
            wording("the order cannot be made: {why}", why=wrong), hint=wording("change the order's route or parts")
        )
    if request.machine not in facts.machines and not request.new_machine:
        raise _unknown_machine(request.machine, facts.machines)
    for serial in request.serials:
        if serial in facts.ordered:
            raise Code.FAC_ORDERED.refusal(
                wording(
                    "part {serial!r} of {part_type!r} has an order already", serial=serial, part_type=request.part_type
                ),
                hint=wording("a part is made once: give the new part a serial number of its own"),
                values={"serial": serial},
            )
    for block in request.blocks:
        if block.kind.moves and block.program_sha256 not in facts.released:
            raise not_released(block.program_sha256)
    part_type = facts.part_type or PartType(request.part_type, request.revision)
    route = Route(request.blocks, request.job_toml, request.conditions, request.probe_toml, request.probe_control)
    order = WorkOrder(
        id=f"O{facts.number}",
        part_type=part_type,
        machine=facts.machine or Machine(request.machine),
        serials=request.serials,
        route=route,
        made_at=now,
        made_by=by.name,
    )
    said = {"parts": str(len(request.serials)), "route_sha256": route.sha256}
    return Changes((order_now(order, facts.number),), (order,), events=(Event("planned", f"order:{order.id}", said),))


def order_now(order: WorkOrder, number: int, rows: tuple[int, ...] = ()) -> OrderNow:
    """Returns an order of which nothing is made; without rows its parts count from −1 downwards until they are kept."""
    numbered = rows or tuple(-1 - k for k in range(len(order.serials)))
    steps = tuple(
        StepNow(k, block.kind, program_sha256="" if block.corrected else block.program_sha256)
        for k, block in enumerate(order.route.blocks)
    )
    parts = tuple(
        PartNow(row, Part(order.part_type, s), PartState.PLANNED, steps)
        for row, s in zip(numbered, order.serials, strict=True)
    )
    return OrderNow(order, number, parts)


def _unknown_machine(name: str, machines: frozenset[str]) -> TrueloopError:
    near = get_close_matches(name, sorted(machines), 1, 0.6)
    return Code.FAC_PLAN.refusal(
        wording(
            "the order cannot be made: the store knows {n} machines, and {name!r} is not one of them",
            n=len(machines),
            name=name,
        ),
        hint=wording("choose {name!r}, if that was meant", name=near[0])
        if near
        else wording("choose one of them, or state that it is a new one"),
    )


def not_released(program: str) -> TrueloopError:
    """Returns the error FAC-RELEASE."""
    return Code.FAC_RELEASE.refusal(
        wording("the program {program!r} is not released", program=program[:16]),
        hint=wording("an engineer releases a program of the store before it is ordered or sent"),
        values={"program": program},
    )


def _wrong_parts(request: PlanOrder) -> Iterator[str]:
    if not request.part_type or not request.machine:
        yield wording(
            "part type {part_type!r} and machine {machine!r} have to be stated",
            part_type=request.part_type,
            machine=request.machine,
        )
    count = len(request.serials)
    if not 0 < count <= MOST_PARTS:
        yield wording("{n} parts; it takes 1 to {most}", n=count, most=MOST_PARTS)
    if len(set(request.serials)) < count or not all(serial.strip() for serial in request.serials):
        yield wording("of its {n} serial numbers one is empty or there twice", n=count)


def _wrong_route(request: PlanOrder) -> Iterator[str]:
    blocks = request.blocks
    kinds = [one.kind for one in blocks]
    if not blocks:
        yield wording("its route has 0 steps")
    for k, (before, after) in enumerate(pairwise(kinds), 1):
        if _RANK[after] < _RANK[before]:
            yield wording(
                "step {k} ({after}) comes after step {j} ({before})", k=k, after=after, j=k - 1, before=before
            )
    for k, block in enumerate(blocks):
        yield from (
            wording("step {k} ({kind}) {why}", k=k, kind=block.kind, why=why) for why in _wrong_block(block, kinds[:k])
        )
    if BlockKind.CORRECT in kinds and not request.job_toml.strip():
        yield wording("it has the step 'correct', and no job to compute it by")
    yield from _wrong_probe(request)


def _wrong_probe(request: PlanOrder) -> Iterator[str]:
    """A job that names a probe needs it, and places to touch: they cannot be those of touches that are to come."""
    try:
        gauging = tomllib.loads(request.job_toml).get("gauging", {})
    except tomllib.TOMLDecodeError as error:
        yield f"its job is no TOML: {error}"
        return
    if not isinstance(gauging, dict):
        yield f"'gauging' of its job is {gauging!r}, and no table"
    elif ("probe" in gauging) is not bool(request.probe_toml.strip()):
        given = "a probe file" if request.probe_toml.strip() else "no probe file"
        yield f"its job names the probe {gauging.get('probe', '')!r}, and {given} is given"
    elif "probe" in gauging and not {"points", "spacing_mm"} & set(gauging):
        yield "its job names a probe, and 0 places to touch: gauging.points or gauging.spacing_mm"


def _wrong_block(block: Block, before: list[BlockKind]) -> Iterator[str]:
    if block.kind.moves and not block.program_sha256:
        yield wording("names no program")
    if not block.kind.moves and block.program_sha256:
        yield wording("takes no program")
    if block.corrected and (block.kind is not BlockKind.FINISH or BlockKind.CORRECT not in before):
        yield wording("is to be corrected: only a finish cut after a step 'correct' is")
    if block.kind is BlockKind.CORRECT and BlockKind.PROBE not in before:
        yield wording("needs a step 'probe' before it")
    if block.kind in (BlockKind.CORRECT, BlockKind.RELEASE) and block.kind in before:
        yield wording("is in the route twice")
