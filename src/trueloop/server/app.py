"""The service as an ASGI app: `create_app`."""

import secrets
import time
from collections import OrderedDict
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from datetime import datetime
from functools import partial
from threading import Event, Lock, Thread
from typing import Any, Final, TypeVar

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import PlainTextResponse
from sqlalchemy import func, select

import trueloop
from trueloop.errors import TrueloopError
from trueloop.factory.carry_out import hold_silent
from trueloop.factory.tasks import Runner, run_task
from trueloop.jobs.factory.runners import RUNNERS, correct
from trueloop.jobs.factory.uploads import order_read
from trueloop.server import guarded, pages, problems
from trueloop.server.access import Access, require
from trueloop.server.apart.reading import PROCESSES, answered
from trueloop.server.gates import Figures, Gates
from trueloop.server.guarded import Service
from trueloop.server.heap import start_giving_back
from trueloop.server.identity.accounts import FirstAccount
from trueloop.server.identity.attempts import Attempts
from trueloop.server.identity.oidc import Oidc, SignIns
from trueloop.server.routes import (
    accounts,
    by_hand,
    cell,
    changes,
    events,
    machines,
    session,
    shown,
    sign_on,
    studied,
    uploads,
)
from trueloop.server.settings import Limits, Settings, log, now
from trueloop.server.traces import Traces
from trueloop.storage.schema import TABLES
from trueloop.storage.store import Store

MOST: Final = 64
"""Answers that are kept; the one that was not asked for longest goes first."""
_OF_RUNS: Final = {"run", "run_fact", "work_order"}
"""How far orders have come: it says nothing of how parts are."""
T = TypeVar("T")


def newest_facts(store: Store) -> tuple[int, ...]:
    """Returns the number of the newest fact of each kind: facts are added and never changed."""
    numbers = [select(func.max(table.c.id)).scalar_subquery() for name, table in TABLES.items() if name not in _OF_RUNS]
    with store.reading() as connection:
        return tuple(number or 0 for number in connection.execute(select(*numbers)).one())


@dataclass
class _Answer:
    facts: tuple[int, ...]
    lock: Lock = field(default_factory=Lock)
    done: list[Any] = field(default_factory=list)


class Studies:
    """Answers by what was asked. Who asks while it is being worked out waits for the same answer."""

    def __init__(self) -> None:
        self._answers: OrderedDict[object, _Answer] = OrderedDict()
        self._lock = Lock()

    def of(self, store: Store, key: object, work_out: Callable[[], T]) -> T:
        """Returns the answer as of the newest facts. A refusal is not kept: the next request tries anew."""
        answer = self._answer(key, newest_facts(store))
        with answer.lock:
            if not answer.done:
                answer.done.append(work_out())
            found: T = answer.done[0]
            return found

    def _answer(self, asked: object, facts: tuple[int, ...]) -> _Answer:
        with self._lock:
            answer = self._answers.get(asked)
            if answer is None or answer.facts != facts:
                answer = self._answers[asked] = _Answer(facts)
            self._answers.move_to_end(asked)
            while len(self._answers) > MOST:
                self._answers.popitem(last=False)
            return answer


_IDLE_S: Final = 0.5
_AFTER_A_FAULT_S: Final = 5.0
_WATCH_S: Final = 5.0


def start_workers(store: Store, clock: Callable[[], datetime], stopping: Event, count: int, limits: Limits) -> None:
    """Starts them. They end with the process: a task is leased, and its lease runs out. `limits`: of what is read."""
    runners = {**RUNNERS, "correct": partial(correct, first=partial(answered, limits, reading=order_read))}
    for _ in range(count):
        name = f"worker-{secrets.token_hex(4)}"
        Thread(target=_work, args=(store, runners, clock, stopping, name), name=name, daemon=True).start()


def start_watch(store: Store, clock: Callable[[], datetime], stopping: Event, silent_s: float) -> None:
    """Looks for machines that are silent while they cut, as long as the service runs."""
    Thread(target=_watch, args=(store, clock, stopping, silent_s), name="watch", daemon=True).start()


def _watch(store: Store, clock: Callable[[], datetime], stopping: Event, silent_s: float) -> None:
    while not stopping.wait(_WATCH_S):
        try:
            if held := hold_silent(store, clock(), silent_s):
                log("silent", held=held)
        except TrueloopError as refused:  # the store is busy or away
            log("watch waits", code=refused.code.value, why=refused.message)


def _work(
    store: Store, runners: Mapping[str, Runner], clock: Callable[[], datetime], stopping: Event, name: str
) -> None:
    while not stopping.is_set():
        try:
            task = run_task(store, runners, name, clock)
        except TrueloopError as refused:  # the store is busy or away
            log("worker waits", worker=name, code=refused.code.value, why=refused.message)
            stopping.wait(_AFTER_A_FAULT_S)
            continue
        except Exception as fault:  # the task is tried again when its lease has run out, three times at most
            log("worker failed", worker=name, error=f"{type(fault).__name__}: {fault}")
            stopping.wait(_AFTER_A_FAULT_S)
            continue
        if task is None:
            stopping.wait(_IDLE_S)
        else:
            log("task", worker=name, task=task.id, kind=task.kind, state=task.state)


PREFIX: Final = "/api/v1"
ROUTERS: Final[tuple[APIRouter, ...]] = (
    session.routes,
    sign_on.routes,
    accounts.routes,
    events.routes,
    shown.routes,
    machines.routes,
    studied.routes,
    changes.routes,
    cell.routes,
    uploads.routes,
    by_hand.routes,
)


def create_app(
    store: Store,
    settings: Settings,
    clock: Callable[[], datetime] = now,
    oidc: Oidc | None = None,
    seconds: Callable[[], float] = time.monotonic,
) -> FastAPI:
    """The whole service on an open store. `clock` gives the time with its zone; `oidc`: who else says who signs in.

    `seconds` is a clock that is never set, by which attempts to sign in are delayed.
    """
    stopping, figures = Event(), Figures()

    @asynccontextmanager
    async def running(_: FastAPI) -> AsyncIterator[None]:
        start_workers(store, clock, stopping, settings.workers, settings.limits)
        if settings.workers:
            start_watch(store, clock, stopping, settings.silent_s)
            start_giving_back(stopping)
            PROCESSES.start()
        yield
        stopping.set()
        PROCESSES.end()

    app = FastAPI(
        title="trueloop",
        version=trueloop.__version__,
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
        lifespan=running,
    )
    app.state.service = Service(store, settings, clock, secrets.token_bytes(32), Attempts(seconds))
    app.state.figures, app.state.stopping, app.state.traces = figures, stopping, Traces()
    app.state.studies = Studies()
    app.state.first = FirstAccount(store)
    app.state.sign_ins = None if oidc is None else SignIns(oidc)
    problems.install(app)
    for apirouter in ROUTERS:
        app.include_router(apirouter, prefix=PREFIX)
    app.include_router(_about_itself(), prefix=PREFIX)
    _add_monitoring(app, figures)
    pages.install(app, settings)
    app.add_middleware(Gates, settings=settings, figures=figures)
    return app


def _about_itself() -> APIRouter:
    routes = guarded.router()

    @routes.get("/openapi.json", include_in_schema=False)
    def openapi(request: Request) -> dict[str, Any]:
        found: dict[str, Any] = request.app.openapi()
        return found

    return routes


def _add_monitoring(app: FastAPI, figures: Figures) -> None:
    @app.get("/healthz", include_in_schema=False)
    def health(request: Request) -> PlainTextResponse:
        """Reports that it runs and its store answers, and nothing else, since anybody may ask."""
        with request.app.state.service.store.reading() as connection:
            connection.exec_driver_sql("SELECT 1")
        return PlainTextResponse("ok\n")

    @app.get("/metrics", include_in_schema=False)
    def metrics(request: Request) -> PlainTextResponse:
        """Figures for Prometheus: by a key for metrics, or a session."""
        require(Access("viewer", key="metrics"), guarded.known(guarded.service_of(request), request))
        return PlainTextResponse(figures.text(), media_type="text/plain; version=0.0.4")


__all__ = ["PREFIX", "ROUTERS", "create_app"]
