"""The service as an ASGI app: `create_app`."""

import secrets
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from datetime import datetime
from threading import Event
from typing import Any, Final

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import PlainTextResponse

import trueloop
from trueloop.server import guarded, pages, problems
from trueloop.server.access import Access, require
from trueloop.server.apart.reading import PROCESSES
from trueloop.server.figures import Figures
from trueloop.server.gates import Gates
from trueloop.server.guarded import Service
from trueloop.server.heap import start_giving_back
from trueloop.server.identity.attempts import Attempts
from trueloop.server.identity.oidc import SignIns
from trueloop.server.identity.provider import Oidc
from trueloop.server.routes import (
    accounts,
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
from trueloop.server.settings import Settings, now
from trueloop.server.studies import Studies
from trueloop.server.traces import Traces
from trueloop.server.workers import start_watch, start_workers
from trueloop.storage.store import Store

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
        start_workers(store, clock, stopping, settings.workers)
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
    app.state.sign_ins = None if oidc is None else SignIns(oidc)
    problems.install(app)
    for one in ROUTERS:
        app.include_router(one, prefix=PREFIX)
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
        """Whether it runs and its store answers; for whoever asks, and so no more than that."""
        with request.app.state.service.store.reading() as connection:
            connection.exec_driver_sql("SELECT 1")
        return PlainTextResponse("ok\n")

    @app.get("/metrics", include_in_schema=False)
    def metrics(request: Request) -> PlainTextResponse:
        """Figures for Prometheus: by a key for metrics, or a session."""
        require(Access("viewer", key="metrics"), guarded.known(guarded.service_of(request), request))
        return PlainTextResponse(figures.text(), media_type="text/plain; version=0.0.4")


__all__ = ["PREFIX", "ROUTERS", "create_app"]
