"""The service run by uvicorn until it is stopped: where it listens, TLS, and an end that comes.

Connections that are open at once: bounded over all and by address, and none is held open by sending nothing.

uvicorn answers 503 when too many are open and waits for the first request as long as a client likes. Here the idle
connection that was used longest ago gives way to a new one, and a request's headers have to come within a time.
"""

import asyncio
import socket
import ssl
import sys
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from ipaddress import IPv4Network, IPv6Network, ip_address, ip_network
from pathlib import Path
from types import FrameType
from typing import Any, Final

import uvicorn
from fastapi import FastAPI
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from trueloop.errors import Code, TrueloopError
from trueloop.server import heap
from trueloop.server.app import create_app
from trueloop.server.identity.oidc import Oidc
from trueloop.server.settings import Settings, is_loopback, log
from trueloop.storage.store import Store

MOST: Final = 256
"""Connections open at once."""
MOST_OF_ADDRESS: Final = 64
"""Those of one address; a proxy, which brings the requests of many, has all of them."""
HEADERS_S: Final = 10.0
"""Time for the headers of a request, from when the connection is made or was last used."""
KEPT_ALIVE_S: Final = 30
"""Time that a connection stays open between two requests."""
_LOOK_S: Final = 1.0


class BoundedConnection(AutoHTTPProtocol):  # type: ignore[misc,valid-type]
    """uvicorn's own protocol with these bounds; `proxies`: networks whose addresses are not bounded by themselves."""

    proxies: tuple[IPv4Network | IPv6Network, ...] = ()
    _used_s = 0.0
    _served = False
    _look: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:
        """Takes a connection; the one idle for longest is closed where there are too many."""
        super().connection_made(transport)
        self._used_s = self.loop.time()
        self._look = self.loop.call_later(_LOOK_S, self._close_if_late)
        for same, most in ((self._of_address, MOST_OF_ADDRESS), (lambda: list(_all(self.connections)), MOST)):
            of_them = same()
            if len(of_them) > most:
                idle = [connection for connection in of_them if connection.is_idle and connection is not self]
                min(idle, key=lambda connection: connection._used_s, default=self).transport.close()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forgets it."""
        if self._look is not None:
            self._look.cancel()
        super().connection_lost(exc)

    @property
    def is_idle(self) -> bool:
        """Returns whether no request is being answered."""
        return self.cycle is None or bool(self.cycle.response_complete)

    def _of_address(self) -> list["BoundedConnection"]:
        if self.client is None or any(ip_address(self.client[0]) in network for network in self.proxies):
            return []
        return [
            connection
            for connection in _all(self.connections)
            if connection.client and connection.client[0] == self.client[0]
        ]

    def _close_if_late(self) -> None:
        now_s = self.loop.time()
        if not self.is_idle:
            self._used_s, self._served = now_s, True
        elif now_s - self._used_s >= HEADERS_S + (KEPT_ALIVE_S if self._served else 0.0):
            self.transport.close()
            return
        self._look = self.loop.call_later(_LOOK_S, self._close_if_late)


def _all(connections: Collection[Any]) -> Iterator[BoundedConnection]:
    """Those that are not being closed already."""
    for connection in connections:
        if isinstance(connection, BoundedConnection) and not connection.transport.is_closing():
            yield connection


def bounded(proxies: Collection[str]) -> type[BoundedConnection]:
    """Makes the protocol for a service behind these proxies."""
    return type("BoundedConnection", (BoundedConnection,), {"proxies": tuple(map(ip_network, proxies))})


END_S: Final = 5
"""Requests that are being answered when it is to stop get this long, s."""


@dataclass(frozen=True)
class Listening:
    """Where; without a certificate this machine alone. `proxies`: addresses of TLS ends that are believed."""

    host: str = "127.0.0.1"
    port: int = 8080
    certificate: Path | None = None
    key: Path | None = None
    proxies: tuple[str, ...] = ()

    @property
    def tls(self) -> bool:
        """Returns whether browsers reach it over TLS: it answers so, or a proxy before it."""
        return self.certificate is not None or bool(self.proxies)


def require_safe(where: Listening) -> None:
    """Raises SRV-TLS where others could reach it without TLS, or where certificate and key are not a pair."""
    if (where.certificate is None) != (where.key is None):
        raise _no_tls(where.host, "a certificate needs its key, and a key its certificate")
    if where.certificate is None and not is_loopback(where.host):
        raise _no_tls(where.host, "others could read passwords and change programs on their way")
    if where.certificate is not None:
        try:
            ssl.create_default_context(ssl.Purpose.CLIENT_AUTH).load_cert_chain(where.certificate, where.key, "")
        except (OSError, ssl.SSLError) as wrong:
            raise _no_tls(where.host, f"{where.certificate} and {where.key} cannot be used: {wrong}") from wrong


def serve(
    store: Store,
    settings: Settings,
    where: Listening,
    ready: Callable[[str, str], None],
    *,
    listening: socket.socket,
    oidc: Oidc | None = None,
) -> None:
    """Serves by the socket that listens there, until SIGINT or SIGTERM.

    `ready` gets the address once connections are taken, and what is added to it to make the first account: empty where
    the store has an account.
    """
    require_safe(where)
    heap.share_one()
    app = create_app(store, settings, oidc=oidc)
    server = _Server(config_of(app, where), app.state.stopping.set)
    host = f"[{where.host}]" if ":" in where.host else where.host
    ready(f"{settings.scheme}://{host}:{listening.getsockname()[1]}/", app.state.first.fragment)
    log("started", host=where.host, port=listening.getsockname()[1], tls=where.tls)
    server.run([listening])
    log("stopped")


def config_of(app: FastAPI, where: Listening) -> uvicorn.Config:
    """Returns how uvicorn runs the service."""
    return uvicorn.Config(
        app,
        http=bounded(where.proxies),
        lifespan="on",
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=bool(where.proxies),
        forwarded_allow_ips=list(where.proxies),
        ssl_certfile=where.certificate,
        ssl_keyfile=where.key,
        timeout_keep_alive=KEPT_ALIVE_S,
        timeout_graceful_shutdown=END_S,
        ws="none",
    )


class _Server(uvicorn.Server):
    """Tells streams, which would never end by themselves, that it stops."""

    def __init__(self, config: uvicorn.Config, stop: Callable[[], None]) -> None:
        super().__init__(config)
        self._stop = stop

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """Stops at SIGINT or SIGTERM."""
        self._stop()
        super().handle_exit(sig, frame)

    def capture_signals(self) -> Any:
        """Captures as uvicorn does, but does not raise a heeded SIGINT once more: it ended as it should."""
        return _heeded(super().capture_signals(), self)


class _heeded:  # noqa: N801 -- a context manager, written where it is used
    def __init__(self, inner: Any, server: uvicorn.Server) -> None:
        self.inner, self.server = inner, server

    def __enter__(self) -> None:
        self.inner.__enter__()

    def __exit__(self, *wrong: Any) -> None:
        self.server._captured_signals.clear()
        self.inner.__exit__(*wrong)


def listen(where: Listening) -> socket.socket:
    """Opens a socket that listens. Raises SRV-ADDRESS."""
    family = socket.AF_INET6 if ":" in where.host else socket.AF_INET
    # asyncio sends at once only on sockets that say they are TCP; else each answer waits 40 ms for the client's ACK
    listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        if sys.platform != "win32":
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((where.host, where.port))
        listening.listen(128)
    except OSError as wrong:
        listening.close()
        raise Code.SRV_ADDRESS.refusal(
            f"the service cannot listen at {where.host!r}, port {where.port}: {wrong.strerror or wrong}",
            hint="end what listens there, or choose another by --port or --host",
            values={"host": where.host, "port": float(where.port)},
        ) from wrong
    return listening


def _no_tls(host: str, why: str) -> TrueloopError:
    return Code.SRV_TLS.refusal(
        f"nothing is served at {host!r}: {why}",
        hint="give --tls-cert and --tls-key, or serve this machine alone: --host 127.0.0.1",
        values={"host": host},
    )
