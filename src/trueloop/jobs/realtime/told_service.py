"""What a corrector does, told to the service twice a second: in a thread of its own, so that it holds no record up."""

import threading
from collections import deque
from collections.abc import Callable, Mapping
from types import TracebackType
from typing import Any, Final

from trueloop.controllers.linuxcnc.cell.service import Service
from trueloop.errors import TrueloopError

EVERY_S: Final = 0.5
MOST: Final = 100
"""Stretches that wait: what is older the service does not miss."""


class ToldService:
    """Takes what the live page is told. What the service does not take is dropped, and said once until it takes again.

    `record` names the record, `axes` and `signals` what it is of; `tell` is told where the service is not reached.
    """

    def __init__(
        self, service: Service, record: str, axes: str, signals: tuple[str, ...], tell: Callable[[str], None]
    ) -> None:
        self._service, self._tell = service, tell
        self._head: dict[str, Any] = {"record": record, "axes": axes, "signals": list(signals)}
        self._waiting: deque[Mapping[str, Any]] = deque(maxlen=MOST)
        self._stop = threading.Event()
        self._said = ""
        self._thread = threading.Thread(target=self._work, daemon=True)

    def take(self, tick: Mapping[str, Any]) -> None:
        """One stretch as `report.realtime.live.told` gives it; silence is none."""
        if "from" in tick:
            values = {name: tick[name] for name in ("low", "high", "alarm", "said")}
            self._waiting.append({"from_s": tick["from"], "to_s": tick["to"], **values})

    def send(self) -> None:
        """What waits, at once."""
        stretches = [self._waiting.popleft() for _ in range(len(self._waiting))]
        if not stretches:
            return
        try:
            self._service.trace({**self._head, "stretches": stretches})
            self._said = ""
        except TrueloopError as error:
            if error.message != self._said:
                self._tell(f"the service does not show it: {error.message}")
            self._said = error.message

    def __enter__(self) -> "ToldService":
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._stop.set()
        self._thread.join()
        self._service.close()

    def _work(self) -> None:
        while not self._stop.wait(EVERY_S):
            self.send()
        self.send()
