"""The cell of a machine, by its key: what it is to do next, what happened, what it measured."""

from base64 import b64decode
from binascii import Error
from dataclasses import dataclass, field
from typing import Annotated

from fastapi import Request, Response
from pydantic import AwareDatetime, Field

from trueloop.domain.factory import FactKind, RunFact
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import Offer
from trueloop.factory.shown.machines import heard
from trueloop.nc.witness import witnessed
from trueloop.server.guarded import By, Here, router
from trueloop.server.guarded import factory_by as of
from trueloop.server.problems import refused_request
from trueloop.server.traces import Trace

routes = router("/cell")


@dataclass(frozen=True)
class Fact:
    """A fact of a run by a witness, and its time."""

    run: str
    what: FactKind
    at: AwareDatetime
    witness: Annotated[str, Field(max_length=100)]
    values: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Facts:
    """Some of them."""

    facts: Annotated[tuple[Fact, ...], Field(max_length=1000)]


@dataclass(frozen=True)
class KnownRuns:
    """The keys of the runs whose facts are kept now."""

    known: tuple[str, ...]


@dataclass(frozen=True)
class Touches:
    """The file that a gauging run wrote, in base64."""

    run: str
    file: str
    name: Annotated[str, Field(max_length=200)]


@dataclass(frozen=True)
class Kept:
    """The hash of what was kept."""

    sha256: str


@dataclass(frozen=True)
class Temperatures:
    """By signal, °C."""

    signals: dict[str, Annotated[float, Field(ge=-273.15, le=2000, allow_inf_nan=False)]]
    at: AwareDatetime
    run: str = ""


@dataclass(frozen=True)
class Heartbeat:
    """The machine's present state; no decision uses it."""

    state: Annotated[str, Field(max_length=100)]
    program: Annotated[str, Field(max_length=200)] = ""
    line: int | None = None
    progress: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)] | None = None
    corrector: Annotated[str, Field(max_length=200)] = ""
    temperatures_c: dict[str, float] | None = None


@routes.post("/next")
def next_block(here: Here, who: By) -> Offer | None:
    """The task that the machine may run now, again under the same key on a repeated request. Null: none."""
    offer: Offer | None = carry_out(here.store, ask.NextBlock(who.machine, witnessed), of(who), here.clock()).answer
    return offer


@routes.post("/facts")
def facts(body: Facts, here: Here, who: By) -> KnownRuns:
    """Records facts of runs; a repeated fact changes nothing."""
    told = tuple(RunFact(fact.run, fact.what, fact.at, fact.witness, fact.values) for fact in body.facts)
    done = carry_out(here.store, ask.RecordFacts(told), of(who), here.clock())
    return KnownRuns(tuple(done.answer))


@routes.post("/touches")
def touches(body: Touches, here: Here, who: By) -> Kept:
    """Records the touches of a gauging run."""
    try:
        content = b64decode(body.file, validate=True)
    except (Error, ValueError):
        raise refused_request(f"'file' of {body.name!r} is no base64 of {len(body.file)} characters") from None
    done = carry_out(here.store, ask.RecordTouches(body.run, body.name, content), of(who), here.clock())
    return Kept(str(done.answer))


@routes.post("/temperatures", status_code=204, response_class=Response)
def temperatures(body: Temperatures, here: Here, who: By) -> None:
    """Records values of its sensors."""
    wanted = ask.RecordTemperatures(who.machine, body.signals, body.at, body.run)
    carry_out(here.store, wanted, of(who), here.clock())


@routes.post("/heartbeat", status_code=204, response_class=Response)
def heartbeat(body: Heartbeat, here: Here, who: By) -> None:
    """Records the machine's state, every two seconds."""
    heard(here.store, who.machine, vars(body), of(who), here.clock())


@routes.post("/trace", status_code=204, response_class=Response)
def trace(body: Trace, here: Here, who: By, request: Request) -> None:
    """Takes the corrector's trace, as recorded beside the machine; shown, and not kept."""
    request.app.state.traces.add(who.machine, body, here.clock())
