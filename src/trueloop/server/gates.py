"""Checks before all addresses (plain ASGI): the host's name, sizes and times of bodies, headers, log, counts.

Requests that take a few milliseconds of one processor take turns, two at a time.

Python runs one thread at a time: eight that are let in at once spend as much again in handing its lock to each other,
and each of them waits for all. What takes long, and what waits for somebody else, does not queue here.
"""

import asyncio
import time
from collections import Counter
from collections.abc import Awaitable, Callable, Iterator, MutableMapping
from threading import Lock
from typing import Any, Final
from weakref import WeakKeyDictionary

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request

from trueloop.errors import Code, TrueloopError
from trueloop.server.etags import reader_of
from trueloop.server.problems import answer_of, unexpected
from trueloop.server.settings import Settings, log
from trueloop.wording import wording


class Figures:
    """Counts of this run of the service; threads count at once."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._requests: Counter[tuple[str, str, int]] = Counter()
        self._seconds: Counter[tuple[str, str]] = Counter()
        self.streams = 0

    def count(self, scope: MutableMapping[str, Any], status: int, took_s: float) -> None:
        """Counts one request, by the address's pattern: names of parts are not labels."""
        route = scope.get("route")
        path = str(getattr(route, "path", "")) or "other"
        with self._lock:
            self._requests[scope["method"], path, status] += 1
            self._seconds[scope["method"], path] += took_s  # type: ignore[assignment]  # a Counter adds floats too

    def text(self) -> str:
        """Returns the figures in the text format of Prometheus."""
        return "".join(f"{line}\n" for line in self._lines())

    def _lines(self) -> Iterator[str]:
        with self._lock:
            requests, seconds = sorted(self._requests.items()), sorted(self._seconds.items())
        yield "# HELP trueloop_requests_total Requests answered."
        yield "# TYPE trueloop_requests_total counter"
        for (method, path, status), count in requests:
            yield f'trueloop_requests_total{{method="{method}",path="{path}",status="{status}"}} {count}'
        yield "# HELP trueloop_request_seconds_total Time that requests took."
        yield "# TYPE trueloop_request_seconds_total counter"
        for (method, path), took in seconds:
            yield f'trueloop_request_seconds_total{{method="{method}",path="{path}"}} {took:.6f}'
        yield "# HELP trueloop_streams Streams open."
        yield "# TYPE trueloop_streams gauge"
        yield f"trueloop_streams {self.streams}"


Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[MutableMapping[str, Any], Receive, Send], Awaitable[None]]

_LARGE: Final = {"/api/v1/uploads": "upload_bytes", "/api/v1/cell/touches": "touches_bytes"}
_HEADERS: Final = {
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), payment=(), usb=()",
    "Cache-Control": "no-store",
}
"""Those of every answer that does not say otherwise."""


class Gates:
    """Around the whole app."""

    def __init__(self, app: App, settings: Settings, figures: Figures) -> None:
        self.app, self.settings, self.figures = app, settings, figures

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        begun = time.monotonic()
        status = 0

        async def sent(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = int(message["status"])
                self._add_headers(MutableHeaders(scope=message))
            await send(message)

        try:
            await self._checked(scope, receive, sent)
        except Exception as error:
            if status:
                raise
            await answer_of(unexpected(error), reader_of(Request(scope)))(scope, receive, sent)
        finally:
            took_s = time.monotonic() - begun
            self.figures.count(scope, status, took_s)
            log(
                "request",
                method=scope["method"],
                path=scope["path"],
                status=status,
                took_s=round(took_s, 4),
                address=_address(scope),
            )

    async def _checked(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        headers = Headers(scope=scope)
        limit = self._limit(str(scope["path"]))
        try:
            require_host(self.settings, headers.get("host", ""))
            declared = headers.get("content-length", "0")
            if not declared.isdecimal() or int(declared) > limit:
                raise too_large(limit, f"{declared} bytes are declared")
            bounded = _Bounded(receive, limit, self.settings.limits.body_s)
            await self.app(scope, bounded.receive, send)
        except TrueloopError as error:
            answer = answer_of(error, reader_of(Request(scope)))
            if error.code is Code.SRV_LARGE:
                answer.headers["Connection"] = "close"  # the rest of the body is not read
            await answer(scope, receive, send)

    def _limit(self, path: str) -> int:
        return int(getattr(self.settings.limits, _LARGE.get(path, "body_bytes")))

    def _add_headers(self, headers: MutableHeaders) -> None:
        for name, value in _HEADERS.items():
            headers.setdefault(name, value)
        if self.settings.tls:
            headers.setdefault("Strict-Transport-Security", "max-age=31536000")


class _Bounded:
    """A body that ends: by size, and by time."""

    def __init__(self, receive: Receive, limit: int, longest_s: float) -> None:
        self.inner, self.limit, self.seen = receive, limit, 0
        self.until = time.monotonic() + longest_s
        self.whole = False

    async def receive(self) -> Message:
        """Receives the next piece. Raises SRV-LARGE."""
        if self.whole:
            return await self.inner()
        try:
            message = await asyncio.wait_for(self.inner(), max(self.until - time.monotonic(), 0.01))
        except TimeoutError:
            raise too_large(self.limit, f"after {self.seen} bytes it took too long") from None
        self.seen += len(message.get("body", b""))
        if self.seen > self.limit:
            raise too_large(self.limit, f"more than {self.limit} bytes came")
        self.whole = not message.get("more_body", False)
        return message


def require_host(settings: Settings, host: str) -> None:
    """Refuses another host's name, which a page of another site whose name leads here still sends. Raises SRV-HOST."""
    name = host if host.endswith("]") else host.rpartition(":")[0] or host
    if name.casefold() not in settings.names:
        raise Code.SRV_HOST.refusal(
            f"this service is not {host!r}",
            hint="use a name that it was started with: trueloop serve --name",
            values={"host": host},
        )


def too_large(limit: int, why: str) -> TrueloopError:
    """Makes the error SRV-LARGE."""
    return Code.SRV_LARGE.refusal(
        wording("the request is too large: {why}; {limit} bytes are taken at this address", why=why, limit=limit),
        hint=wording("send less at once"),
        values={"limit_bytes": float(limit)},
    )


def _address(scope: MutableMapping[str, Any]) -> str:
    client = scope.get("client")
    return str(client[0]) if client else ""


AT_ONCE: Final = 2
"""One that Python runs, and one that the database or the system works for."""
_OF_LOOP: Final[WeakKeyDictionary[asyncio.AbstractEventLoop, asyncio.Semaphore]] = WeakKeyDictionary()


def turn() -> asyncio.Semaphore:
    """Returns the semaphore of the loop that runs: to be held by `async with`."""
    return _OF_LOOP.setdefault(asyncio.get_running_loop(), asyncio.Semaphore(AT_ONCE))
