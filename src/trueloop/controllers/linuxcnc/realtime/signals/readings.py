"""The latest reading of each signal, from threads that read sensors each at its own pace.

Times are those of `time.monotonic()`: a clock that is set leaves ages alone.
"""

import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import NamedTuple, Protocol

NEVER_S = 1e6
"""The age of what was never read: older than any limit, and still a number."""


class Reading(NamedTuple):
    """What a sensor said, in the unit of the model, and when it was read, s of the monotonic clock."""

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
        """A value as the sensor gives it, and when it was read."""

    def refuse(self, name: str, why: str) -> None:
        """Something that is no reading of this signal: it grows old."""


class Feed(Protocol):
    """What reads one source: a port, a broker, a folder."""

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Reads until `stop` is set; looks at it at least once a second.

        Raises `OSError` or `ValueError` where the source fails.
        """


class Board:
    """The latest readings, of all threads."""

    def __init__(self, scale: Mapping[str, Callable[[float], float]] | None = None) -> None:
        """`scale` takes a sensor's values to the unit of the model; signals without one are in it."""
        self._scale = dict(scale or {})
        self._latest: dict[str, Reading] = {}
        self._lock = threading.Lock()

    def put(self, name: str, value: float, time_s: float) -> None:
        """Keeps a reading, unless it is no number or older than what is known."""
        value = self._scale.get(name, float)(value)
        with self._lock:
            if math.isfinite(value) and time_s >= self._latest.get(name, NOTHING).time_s:
                self._latest[name] = Reading(value, time_s)

    def readings(self) -> dict[str, Reading]:
        """All that was read, by name. Never waits for a sensor."""
        with self._lock:
            return dict(self._latest)


def wait(stop: threading.Event, since_s: float, every_s: float) -> None:
    """Until `every_s` after `since_s`, or until the end."""
    stop.wait(max(since_s + every_s - time.monotonic(), 0.0))
