"""A thread for each source: reads it, and begins again when it fails, ever more slowly."""

import threading
import time
from collections.abc import Callable
from typing import Final

from trueloop.controllers.linuxcnc.realtime.signals.readings import Board, Feed

FIRST_WAIT_S: Final = 0.5
LONGEST_WAIT_S: Final = 15.0
END_S: Final = 3.0
"""How long the end waits for a source that hangs; a daemon thread then ends with the process."""

Say = Callable[[str], None]
"""Takes a line for the log."""


class Reader(threading.Thread):
    """Reads one source until `stop`. A source that fails is said once and tried again; its signals grow old.

    What is not foreseen (no `OSError`, no `ValueError`) ends the thread, and with it the heartbeat.
    """

    def __init__(self, name: str, feed: Feed, board: Board, stop: threading.Event, say: Say) -> None:
        super().__init__(name=name, daemon=True)
        self._feed, self._board, self._stopped, self._say = feed, board, stop, say
        self._wait_s, self._fault = FIRST_WAIT_S, ""
        self.refused: dict[str, str] = {}

    def run(self) -> None:
        """As the class says."""
        while not self._stopped.is_set():
            try:
                self._feed(self, self._stopped)
            except (OSError, ValueError) as error:
                self._tell(str(error) or type(error).__name__)
            except Exception as error:  # is said, and ends the thread
                self._say(f"{self.name}: stopped by a fault of trueloop: {type(error).__name__}: {error}")
                return
            self._stopped.wait(self._wait_s)
            self._wait_s = min(2 * self._wait_s, LONGEST_WAIT_S)

    def put(self, name: str, value: float, time_s: float) -> None:
        """Hands a reading on."""
        if self._fault or name in self.refused:
            self._say(f"{self.name}: {name} is read again")
            self.refused = {other: why for other, why in self.refused.items() if other != name}
        self._wait_s, self._fault = FIRST_WAIT_S, ""
        self._board.put(name, value, time_s)

    def refuse(self, name: str, why: str) -> None:
        """Says what is no reading, once."""
        if self.refused.get(name) != why:
            self._say(f"{self.name}: {name}: {why}")
        self.refused = self.refused | {name: why}

    def why(self, name: str) -> str:
        """Why a signal is not read, as far as it is known."""
        return self.refused.get(name) or self._fault

    def _tell(self, fault: str) -> None:
        if fault != self._fault:
            self._say(f"{self.name}: {fault}; tried again until it reads")
        self._fault = fault


def ended(threads: list[threading.Thread], stop: threading.Event) -> None:
    """Ends all threads and waits for them, not for ever."""
    stop.set()
    last_s = time.monotonic() + END_S
    for thread in threads:
        if thread.ident is not None:
            thread.join(max(last_s - time.monotonic(), 0.0))
