"""The latest reading of each signal, from threads that read sensors each at its own pace.

Each source has a thread, which starts the source again when it fails, at growing intervals. Times are those of
`time.monotonic()`: a clock that is set leaves ages alone.
"""

import math
import threading
import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import Final, NamedTuple, Protocol

NEVER_S = 1e6
"""The age of what was never read: older than any limit, and still a number."""


class Reading(NamedTuple):
    """A sensor's value, in the unit of the model, and the time of reading, s of the monotonic clock."""

    value: float
    time_s: float

    def age_s(self, now_s: float) -> float:
        """Returns the age, s."""
        return max(now_s - self.time_s, 0.0)


NOTHING = Reading(math.nan, -NEVER_S)
"""Of a signal that was never read: not even a component whose age pins are left alone takes it for a value."""


class Intake(Protocol):
    """Takes what a source says of its signals."""

    def put(self, name: str, value: float, time_s: float) -> None:
        """Stores a value as the sensor gives it, and when it was read."""

    def refuse(self, name: str, why: str) -> None:
        """Notes that something is not a reading of this signal: it grows old."""


class Feed(Protocol):
    """The reader of one source: a port, a broker, a folder."""

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Reads until `stop` is set, looking at least each second. Raises `OSError` or `ValueError` where it fails."""


class Board:
    """The latest readings, of all threads."""

    def __init__(self, scale: Mapping[str, Callable[[float], float]] | None = None) -> None:
        """`scale` takes a sensor's values to the unit of the model; signals without one are in it."""
        self._scale = dict(scale or {})
        self._latest: dict[str, Reading] = {}
        self._lock = threading.Lock()

    def put(self, name: str, value: float, time_s: float) -> None:
        """Keeps a reading, unless it is not a number or older than what is known."""
        value = self._scale.get(name, float)(value)
        with self._lock:
            if math.isfinite(value) and time_s >= self._latest.get(name, NOTHING).time_s:
                self._latest[name] = Reading(value, time_s)

    def readings(self) -> dict[str, Reading]:
        """Returns all that was read, by name. Never waits for a sensor."""
        with self._lock:
            return dict(self._latest)


def wait(stop: threading.Event, since_s: float, every_s: float) -> None:
    """Waits until `every_s` after `since_s`, or until `stop` is set."""
    stop.wait(max(since_s + every_s - time.monotonic(), 0.0))


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
        """Runs the feed, after a failure again, with growing waits up to `LONGEST_WAIT_S`."""
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
        """Says what is not a reading, once."""
        if self.refused.get(name) != why:
            self._say(f"{self.name}: {name}: {why}")
        self.refused = self.refused | {name: why}

    def why(self, name: str) -> str:
        """Returns why a signal is not read, as far as it is known."""
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


def unix_s(stamp: object) -> float:
    """Converts ISO 8601 (without a zone: UTC), or s or ms since 1970, to s since 1970. Raises `ValueError`."""
    if isinstance(stamp, str):
        moment = datetime.fromisoformat(stamp.strip())
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    if isinstance(stamp, bool) or not isinstance(stamp, (int, float)) or not math.isfinite(stamp):
        raise ValueError(f"{str(stamp)[:40]!r} is no time")
    return stamp / 1000 if stamp > 1e11 else float(stamp)  # 1e11 s is in the year 5138


def reported_s(stamp_s: float, source_now_s: float, asked_s: float, skew_s: float) -> float:
    """Returns when a value was read, on the clock that read `asked_s` when the source's read `source_now_s`.

    Raises `ValueError` for a stamp that lies in the future by more than `skew_s`: the clocks disagree, so that nobody
    knows how old the value is.
    """
    age_s = source_now_s - stamp_s
    if age_s < -skew_s:
        raise ValueError(f"its time stamp lies {-age_s:.1f} s in the future: set the clocks by one time server")
    return asked_s - max(age_s, 0.0)
