"""The live page over HTTP, for a browser on the same computer: the page, and its data as server-sent events."""

import json
import threading
from collections import deque
from collections.abc import Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any, Final

from trueloop.errors import Code

KEPT: Final = 600
"""History that a browser gets first: a minute."""
WAIT_S: Final = 1.0
LOCAL: Final = "127.0.0.1"


class LiveServer:
    """Serves from its own threads until it is closed. Raises RTC-CONNECTION where the address is not to be had."""

    def __init__(self, page: str, host: str = LOCAL, port: int = 0) -> None:
        self._kept: deque[str] = deque(maxlen=KEPT)
        self._count, self._end = 0, ""
        self._changed = threading.Condition()
        try:
            self._server = ThreadingHTTPServer((host, port), _handler(self, page.encode()))
        except (OSError, OverflowError) as error:
            raise Code.RTC_CONNECTION.refusal(
                f"the live page cannot be served at {host}:{port}: {error}",
                hint="another program may have that port: leave --port out, and a free one is taken",
            ) from error
        self._server.daemon_threads = True
        self._server.block_on_close = False
        self.host, self.port = host, int(self._server.server_address[1])
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """Returns the address of the page."""
        return f"http://{self.host}:{self.port}/"

    def tell(self, tick: Mapping[str, Any]) -> None:
        """Sends a tick to all browsers, those included that come later."""
        with self._changed:
            self._kept.append(json.dumps(tick, ensure_ascii=False, allow_nan=False))
            self._count += 1
            self._changed.notify_all()

    def close(self, why: str) -> None:
        """Tells every browser why, and ends."""
        with self._changed:
            self._end = why
            self._changed.notify_all()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def __enter__(self) -> "LiveServer":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close("the record has ended")

    def after(self, count: int) -> tuple[int, list[str], str]:
        """Returns the ticks after so many; waits for them a while. The third is why it has ended, or ""."""
        with self._changed:
            if count == self._count and not self._end:
                self._changed.wait(WAIT_S)
            new = min(self._count - count, len(self._kept))
            return self._count, list(self._kept)[len(self._kept) - new :], self._end


def _handler(live: LiveServer, page: bytes) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        """One request of a browser."""

        def do_GET(self) -> None:
            """Serves the page, its events, and nothing else."""
            if live.host == LOCAL and not _is_local(self.headers.get("Host", "")):
                self.send_error(403)  # a page from elsewhere whose name leads here
            elif self.path == "/":
                self._send("text/html; charset=utf-8")
                self.wfile.write(page)
            elif self.path == "/events":
                self._send("text/event-stream")
                self._events()
            else:
                self.send_error(404)

        def _send(self, kind: str) -> None:
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Cache-Control", "no-store")
            self.end_headers()

        def _events(self) -> None:
            seen, end = 0, ""
            try:
                while not end:
                    seen, new, end = live.after(seen)
                    said = f"data: [{','.join(new)}]\n\n" if new else ": waiting\n\n"
                    self.wfile.write((said + (f"event: end\ndata: {end}\n\n" if end else "")).encode())
                    self.wfile.flush()
            except OSError:  # the browser has gone
                return

        def log_message(self, format: str, *args: object) -> None:
            """Requests are not news."""

    return Handler


def _is_local(host: str) -> bool:
    return host.rpartition(":")[0] in (LOCAL, "localhost")
