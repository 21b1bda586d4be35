"""Changes by people: each address is one request to the factory, which decides it."""

from dataclasses import dataclass
from hashlib import sha256
from typing import Annotated, Any, Literal

from fastapi import Request, Response
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.shown.orders import order_view
from trueloop.factory.shown.programs import proposal_view
from trueloop.factory.views.orders import OrderView
from trueloop.factory.views.series import ProposalView
from trueloop.jobs.factory.uploads import ReadingOptions, Upload, toml_read
from trueloop.server import etags
from trueloop.server.apart.reading import read_apart
from trueloop.server.guarded import By, Here, Row, RowPath, Service, factory_by, router
from trueloop.server.identity.keys import Who

routes = router()
Text = Annotated[str, Field(max_length=2000)]


@dataclass(frozen=True)
class Why:
    """The reason, which is kept."""

    why: Text


@dataclass(frozen=True)
class HoldPart:
    """Which part, and why."""

    part: Row
    why: Text


@dataclass(frozen=True)
class Decision:
    """Decision on the effect of an unknown or held step on the part."""

    part: Row
    step: Row
    verdict: Literal["made", "not-made", "reject"]
    why: Text


@dataclass(frozen=True)
class ArmParts:
    """How many parts may start without a press of Cycle Start; 0: none."""

    parts: Row
    why: Text


@dataclass(frozen=True)
class DoneByHand:
    """Which step was done."""

    step: Row
    why: Text


@dataclass(frozen=True)
class Judged:
    """Why, and which rules are overridden."""

    why: Text
    overrides: tuple[str, ...] = ()


@dataclass(frozen=True)
class CalibratedBy:
    """Result of a calibration."""

    values: dict[str, str]


@dataclass(frozen=True)
class Said:
    """It was done."""

    done: bool = True


@routes.post("/orders", status_code=201)
async def plan(body: ask.PlanOrder, here: Here, who: By, response: Response) -> OrderView:
    """A new order; its route is frozen."""
    for name, text in (("job_toml", body.job_toml), ("probe_toml", body.probe_toml)):
        if text:
            content = text.encode()
            await read_apart(here, Upload(name, sha256(content).hexdigest(), content), ReadingOptions(), toml_read)
    return await run_in_threadpool(_planned, body, here, who, response)


def _planned(order: ask.PlanOrder, here: Service, who: Who, response: Response) -> OrderView:
    done = carry_out(here.store, order, factory_by(who), here.clock())
    return _shown(here, done.orders[0].order.id, response)


@routes.post("/orders/{id}/hold")
def hold(id: str, body: HoldPart, here: Here, who: By, request: Request, response: Response) -> OrderView:
    """Holds a part."""
    return _changed(here, who, id, ask.Hold(id, body.part, body.why), request, response)


@routes.post("/orders/{id}/decide")
def decide(id: str, body: Decision, here: Here, who: By, request: Request, response: Response) -> OrderView:
    """Decides what a step has done."""
    wanted = ask.DecideStep(id, body.part, body.step, body.verdict, body.why)
    return _changed(here, who, id, wanted, request, response)


@routes.post("/orders/{id}/arm")
def arm(id: str, body: ArmParts, here: Here, who: By, request: Request, response: Response) -> OrderView:
    """Arms an order. Only at the machine: with its key. A browser may be anywhere."""
    return _changed(here, who, id, ask.Arm(id, body.parts, body.why), request, response)


@routes.post("/orders/{id}/parts/{part}/record")
def record(
    id: str, part: RowPath, body: DoneByHand, here: Here, who: By, request: Request, response: Response
) -> OrderView:
    """Records a step that a person did."""
    return _changed(here, who, id, ask.RecordStep(id, part, body.step, body.why), request, response)


@routes.post("/proposals/{id}/accept")
def accept(id: str, body: Judged, here: Here, who: By, request: Request, response: Response) -> ProposalView:
    """Accepts a proposal."""
    return _judged(here, who, ask.DecideProposal(id, "accepted", body.why, body.overrides), request, response)


@routes.post("/proposals/{id}/reject")
def reject(id: str, body: Judged, here: Here, who: By, request: Request, response: Response) -> ProposalView:
    """Rejects a proposal."""
    return _judged(here, who, ask.DecideProposal(id, "rejected", body.why, body.overrides), request, response)


@routes.post("/alarms/{id}/acknowledge")
def acknowledge(id: RowPath, body: Why, here: Here, who: By) -> Said:
    """Somebody has seen an alarm."""
    carry_out(here.store, ask.Acknowledge(id, body.why), factory_by(who), here.clock())
    return Said()


@routes.post("/programs/{sha}/release")
def release(sha: str, body: Why, here: Here, who: By) -> Said:
    """A program may be sent to machines."""
    carry_out(here.store, ask.ReleaseProgram(sha, body.why), factory_by(who), here.clock())
    return Said()


@routes.post("/machines/{name:path}/calibrated")
def calibrated(name: str, body: CalibratedBy, here: Here, who: By) -> Said:
    """A machine's probe was calibrated now."""
    carry_out(here.store, ask.Calibrated(name, body.values), factory_by(who), here.clock())
    return Said()


def _changed(here: Service, who: Who, order: str, wanted: Any, request: Request, response: Response) -> OrderView:
    """A change of an order as it was read; a cell does not read orders, and its machine's state is its own."""
    expected = etags.wanted(request) if who.person or "if-match" in request.headers else None
    carry_out(here.store, wanted, factory_by(who), here.clock(), expected)
    return _shown(here, order, response)


def _shown(here: Service, order: str, response: Response) -> OrderView:
    found = order_view(here.store, order)
    etags.tag(response, found.etag)
    return found


def _judged(here: Service, who: Who, wanted: ask.DecideProposal, request: Request, response: Response) -> ProposalView:
    """One decision a proposal: the store takes no second one, so nothing can come between look and decision."""
    etags.require_same(request, proposal_view(here.store, wanted.proposal, here.clock()).etag)
    carry_out(here.store, wanted, factory_by(who), here.clock())
    found = proposal_view(here.store, wanted.proposal, here.clock())
    etags.tag(response, found.etag)
    return found
