"""Whether an order can be made: `plan_order`."""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise
from typing import Final

from trueloop.domain.factory.order import WorkOrder
from trueloop.domain.factory.route import Block, BlockKind, Route
from trueloop.domain.factory.states import PartState
from trueloop.domain.machine import Machine
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, TrueloopError
from trueloop.factory.changes import Changes, Event
from trueloop.factory.known import OrderNow, PartNow, StepNow
from trueloop.factory.requests import PlanOrder
from trueloop.factory.roles import By

MOST_PARTS: Final = 500
_RANK: Final = {kind: k for k, kind in enumerate(BlockKind)}


@dataclass(frozen=True)
class PlanFacts:
    """What the store knows of what is ordered: `ordered` are serial numbers with an order, `released` programs' hashes.

    `part_type` and `machine` are as they are kept already; None: not kept. `number` is that of the order to come.
    """

    part_type: PartType | None
    machine: Machine | None
    ordered: frozenset[str]
    released: frozenset[str]
    number: int


def plan_order(facts: PlanFacts, request: PlanOrder, by: By, now: datetime) -> Changes:
    """The order, planned; its parts get their rows as it is kept. Raises FAC-PLAN, FAC-ORDERED, FAC-RELEASE."""
    for wrong in (*_wrong_parts(request), *_wrong_route(request)):
        raise TrueloopError(
            Code.FAC_PLAN, f"the order cannot be made: {wrong}", hint="change the order's route or parts"
        )
    for serial in request.serials:
        if serial in facts.ordered:
            raise TrueloopError(
                Code.FAC_ORDERED,
                f"part {serial!r} of {request.part_type!r} has an order already",
                hint="a part is made once: give the new part a serial number of its own",
                values={"serial": serial},
            )
    for block in request.blocks:
        if block.kind.moves and block.program_sha256 not in facts.released:
            raise not_released(block.program_sha256)
    part_type = facts.part_type or PartType(request.part_type, request.revision)
    route = Route(request.blocks, request.job_toml, request.conditions, request.probe_toml, request.probe_control)
    order = WorkOrder(
        f"O{facts.number}", part_type, facts.machine or Machine(request.machine), request.serials, route, now, by.name
    )
    said = {"parts": str(len(request.serials)), "route_sha256": route.sha256}
    return Changes((order_now(order, facts.number),), (order,), events=(Event("planned", f"order:{order.id}", said),))


def order_now(order: WorkOrder, number: int, rows: tuple[int, ...] = ()) -> OrderNow:
    """An order of which nothing is made; without rows its parts are numbered from −1 downwards until they are kept."""
    numbered = rows or tuple(-1 - k for k in range(len(order.serials)))
    steps = tuple(
        StepNow(k, one.kind, program_sha256="" if one.corrected else one.program_sha256)
        for k, one in enumerate(order.route.blocks)
    )
    parts = tuple(
        PartNow(row, Part(order.part_type, s), PartState.PLANNED, steps)
        for row, s in zip(numbered, order.serials, strict=True)
    )
    return OrderNow(order, number, parts)


def not_released(program: str) -> TrueloopError:
    """FAC-RELEASE."""
    return TrueloopError(
        Code.FAC_RELEASE,
        f"the program {program[:16]!r} is not released",
        hint="an engineer releases a program of the store before it is ordered or sent",
        values={"program": program},
    )


def _wrong_parts(request: PlanOrder) -> Iterator[str]:
    if not request.part_type or not request.machine:
        yield f"part type {request.part_type!r} and machine {request.machine!r} have to be stated"
    count = len(request.serials)
    if not 0 < count <= MOST_PARTS:
        yield f"{count} parts; it takes 1 to {MOST_PARTS}"
    if len(set(request.serials)) < count or not all(one.strip() for one in request.serials):
        yield f"of its {count} serial numbers one is empty or there twice"


def _wrong_route(request: PlanOrder) -> Iterator[str]:
    blocks = request.blocks
    kinds = [one.kind for one in blocks]
    if not blocks:
        yield "its route has 0 steps"
    for k, (before, after) in enumerate(pairwise(kinds), 1):
        if _RANK[after] < _RANK[before]:
            yield f"step {k} ({after}) comes after step {k - 1} ({before})"
    for k, block in enumerate(blocks):
        yield from (f"step {k} ({block.kind}) {why}" for why in _wrong_block(block, kinds[:k]))
    if BlockKind.CORRECT in kinds and not request.job_toml.strip():
        yield "it has the step 'correct', and no job to compute it by"
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
        yield "names no program"
    if not block.kind.moves and block.program_sha256:
        yield "takes no program"
    if block.corrected and (block.kind is not BlockKind.FINISH or BlockKind.CORRECT not in before):
        yield "is to be corrected: only a finish cut after a step 'correct' is"
    if block.kind is BlockKind.CORRECT and BlockKind.PROBE not in before:
        yield "needs a step 'probe' before it"
    if block.kind in (BlockKind.CORRECT, BlockKind.RELEASE) and block.kind in before:
        yield "is in the route twice"
