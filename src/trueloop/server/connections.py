"""Connections that are open at once: bounded over all and by address, and none is held open by sending nothing.

uvicorn answers 503 when too many are open and waits for the first request as long as a client likes. Here the idle
connection that was used longest ago gives way to a new one, and a request's headers have to come within a time.
"""

import asyncio
from collections.abc import Collection, Iterator
from ipaddress import IPv4Network, IPv6Network, ip_address, ip_network
from typing import Any, Final

from uvicorn.protocols.http.auto import AutoHTTPProtocol

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
                idle = [one for one in of_them if one.is_idle and one is not self]
                min(idle, key=lambda one: one._used_s, default=self).transport.close()

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
        return [one for one in _all(self.connections) if one.client and one.client[0] == self.client[0]]

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
    for one in connections:
        if isinstance(one, BoundedConnection) and not one.transport.is_closing():
            yield one


def bounded(proxies: Collection[str]) -> type[BoundedConnection]:
    """Makes the protocol for a service behind these proxies."""
    return type("BoundedConnection", (BoundedConnection,), {"proxies": tuple(map(ip_network, proxies))})
