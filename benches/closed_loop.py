"""Clients that ask a service without a pause, as cheaply as Python can: one thread, a bare socket each, no library.

Eight threads with an HTTP library wait for each other's interpreter; what these wait is the service's.
"""

import selectors
import socket
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from urllib.parse import urlsplit

_LONGEST_S = 60.0


@dataclass
class _Asking:
    """One connection: when it asked, and what has come of the answer."""

    connection: socket.socket
    began: float = 0.0
    come: bytes = b""

    def ask(self, request: bytes) -> None:
        """Sends it."""
        self.began, self.come = time.perf_counter(), b""
        self.connection.sendall(request)

    def answered(self) -> bool:
        """Takes what has come: whether the answer is whole."""
        self.come += self.connection.recv(1 << 20)
        head, _, body = self.come.partition(b"\r\n\r\n")
        if not self.come or b"\r\n\r\n" not in self.come:
            assert self.come, "the service closed the connection"
            return False
        assert head.startswith(b"HTTP/1.1 200 "), head
        return len(body) >= int(head.lower().partition(b"content-length:")[2].split()[0])


def times_ms(
    address: str, headers: Mapping[str, str], path: Callable[[], str], clients: int, requests: int
) -> list[float]:
    """What each request waited for its whole answer, sorted; each client asks anew as soon as it has one."""
    host, times = urlsplit(address).netloc, list[float]()
    said = "".join(f"{name}: {value}\r\n" for name, value in {"Host": host, **headers}.items())
    selector = selectors.DefaultSelector()
    for _ in range(clients):
        one = _Asking(socket.create_connection((host.partition(":")[0], int(host.partition(":")[2]))))
        one.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        selector.register(one.connection, selectors.EVENT_READ, one)
        one.ask(_request(path(), said))
    while len(times) < requests:
        ready = selector.select(_LONGEST_S)
        assert ready, f"no answer within {_LONGEST_S} s"
        for key, _ in ready:
            asking: _Asking = key.data
            if asking.answered():
                times.append(1000 * (time.perf_counter() - asking.began))
                asking.ask(_request(path(), said))
    for key in list(selector.get_map().values()):
        key.data.connection.close()
    selector.close()
    return sorted(times)


def _request(path: str, headers: str) -> bytes:
    return f"GET /api/v1/{path} HTTP/1.1\r\n{headers}\r\n".encode()
