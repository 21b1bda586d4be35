"""Figures of the service for monitoring: requests by address and status, time taken, streams open."""

from collections import Counter
from collections.abc import Iterator, MutableMapping
from threading import Lock
from typing import Any


class Figures:
    """Counts of this run of the service; threads count at once."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._requests: Counter[tuple[str, str, int]] = Counter()
        self._seconds: Counter[tuple[str, str]] = Counter()
        self.streams = 0

    def count(self, scope: MutableMapping[str, Any], status: int, took_s: float) -> None:
        """Counts one request, by the address's pattern: names of parts are no labels."""
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
