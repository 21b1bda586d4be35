"""Checks of every request before its address: the caller, his rights, his origin, and once only."""

from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field, replace
from datetime import datetime
from hashlib import sha256
from typing import Annotated, Any, Final

from fastapi import APIRouter, Depends, Path, Request, Response
from fastapi.routing import APIRoute
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from trueloop.errors import Code
from trueloop.factory.requests import By as FactoryBy
from trueloop.factory.requests import Role
from trueloop.server import once
from trueloop.server.access import access_of, require
from trueloop.server.gates import turn
from trueloop.server.identity import keys, sessions
from trueloop.server.identity.attempts import Attempts
from trueloop.server.identity.keys import Who
from trueloop.server.settings import Settings
from trueloop.storage.store import Store

_SAFE: Final = ("GET", "HEAD", "OPTIONS")
LOOKING_ON: Final = "looking-on"
"""A header of what a page asks by itself while nobody touches it: that is not using the session."""


@dataclass(frozen=True)
class Service:
    """The objects that an address works with, in the app's state."""

    store: Store
    settings: Settings
    clock: Callable[[], datetime]
    secret: bytes  # of this run of the service: signs places in lists
    attempts: Attempts = field(default_factory=Attempts)


def service_of(request: Request) -> Service:
    """The service that a request came to."""
    found: Service = request.app.state.service
    return found


def who_of(request: Request) -> Who:
    """Who was let in."""
    found: Who = request.state.who
    return found


def factory_by(who: Who) -> FactoryBy:
    """Returns who was let in, in the form that the factory's decisions use."""
    return FactoryBy(who.name, Role(who.role), who.machine, who.once)


async def _here(request: Request) -> Service:
    """Not awaiting anything: a plain function is given a thread for each request, which takes longer than this."""
    return service_of(request)


async def _by(request: Request) -> Who:
    return who_of(request)


Here = Annotated[Service, Depends(_here)]
By = Annotated[Who, Depends(_by)]
Row = Annotated[int, Field(ge=0, lt=1 << 31)]
"""The number of a row in a body: a larger one than databases count to is not a number of a row."""
RowPath = Annotated[int, Path(ge=0, lt=1 << 31)]
"""The number of a row in an address."""
Handler = Callable[[Request], Coroutine[Any, Any, Response]]


class Guarded(APIRoute):
    """A route with its entry in ACCESS; making one without fails."""

    def get_route_handler(self) -> Handler:
        """The framework's handler behind the gates."""
        inner = super().get_route_handler()
        method = next(iter(self.methods or ()))
        access = access_of(method, self.path)

        async def handle(request: Request) -> Response:
            here = service_of(request)
            if not access.open:
                request.state.who = who = await run_in_threadpool(known, here, request)
                require(access, who)
            if method not in _SAFE:
                require_origin(here.settings, request)
                await request.body()  # here: the framework would take a body that is too large for a malformed one
            if access.quick:  # who asks is known: noting that he was there may have waited for who writes
                async with turn():
                    return await inner(request)
            if method != "POST" or not access.once:
                return await inner(request)
            return await _done_once(here, request, inner)

        return handle


def router(prefix: str = "") -> APIRouter:
    """A router all of whose routes are guarded."""
    return APIRouter(prefix=prefix, route_class=Guarded)


def known(here: Service, request: Request) -> Who:
    """By the key where there is one, else by the cookie: neither is taken for the other."""
    header, now = request.headers.get("authorization"), here.clock()
    if header is not None:
        return keys.of_bearer(here.store, header, now)
    cookie = request.cookies.get(here.settings.cookie)
    if cookie is None:
        raise sessions.signed_out()
    return sessions.of_cookie(here.store, here.settings, cookie, now, seen=LOOKING_ON not in request.headers)


def require_origin(settings: Settings, request: Request) -> None:
    """A browser says from which page a change comes; a program with a key has no page. Raises SRV-ORIGIN."""
    who: Who | None = getattr(request.state, "who", None)
    if who is not None and not who.person:
        return
    origin, host = request.headers.get("origin", ""), request.headers.get("host", "")
    if origin != f"{settings.scheme}://{host}" or request.headers.get("sec-fetch-site", "same-origin") != "same-origin":
        raise Code.SRV_ORIGIN.refusal(
            f"the change comes from {origin!r}, which is not this service",
            hint=f"use the service's own pages; a program sends `Origin: {settings.scheme}://{host}`",
            values={"origin": origin},
        )


async def _done_once(here: Service, request: Request, inner: Handler) -> Response:
    asked = await asked_of(request)
    before = await run_in_threadpool(once.begin, here.store, asked, here.clock())
    if before is not None:
        return Response(before.body, before.status, {"Idempotent-Replay": "true"}, "application/json")
    request.state.who = replace(who_of(request), once=(asked.who, asked.key))
    try:
        answer = await inner(request)
    except Exception:
        await run_in_threadpool(once.give_up, here.store, asked)
        raise
    if answer.status_code >= 400:
        await run_in_threadpool(once.give_up, here.store, asked)
        return answer
    body = b"" if getattr(request.state, "secret_answer", False) else bytes(answer.body)
    await run_in_threadpool(once.finish, here.store, asked, once.Answer(answer.status_code, body))
    return answer


async def asked_of(request: Request) -> once.KeyedRequest:
    """Reads an action that is to be done once. Raises SRV-ONCE without a key."""
    key = request.headers.get("idempotency-key", "")
    if not 1 <= len(key) <= once.LONGEST_KEY or not key.isprintable():
        raise Code.SRV_ONCE.refusal(
            f"a POST needs an Idempotency-Key of 1 to {once.LONGEST_KEY} characters; {len(key)} were given",
            hint="send a new random one for each thing to be done, and the same one when it is tried again",
        )
    who = who_of(request)
    asked = sha256(f"{request.method} {request.url.path}?{request.url.query}\n".encode())
    asked.update(await request.body())
    return once.KeyedRequest(f"{'person' if who.person else 'key'}:{who.machine}:{who.name}", key, asked.hexdigest())
