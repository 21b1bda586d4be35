"""The traces of correctors from `trueloop realtime watch`: the last minutes of each machine, in memory alone.

Nothing is decided by it, and the record is beside the machine. Of several services on one database each shows what it
was told itself.
"""

import json
from collections import deque
from dataclasses import dataclass, field
from datetime import datetime
from threading import Lock
from typing import Annotated, Any, Final

from fastapi.sse import format_sse_event
from pydantic import AfterValidator, Field

KEPT: Final = 600
"""Stretches of a machine: a page that opens later is shown these first."""
Name = Annotated[str, Field(min_length=1, max_length=64)]
Value = Annotated[float, Field(allow_inf_nan=False)]
Values = Annotated[dict[Name, Value | None], Field(max_length=100)]


def _forward(stretch: "Stretch") -> "Stretch":
    if stretch.to_s < stretch.from_s:
        raise ValueError("'to_s' lies before 'from_s'")
    return stretch


@dataclass(frozen=True)
class Stretch:
    """Some servo periods: from when to when, s since the record began; of each value the least and the largest.

    `alarm`: a signal was bad in it, or there was a fault. `said`: the last period, in words by name.
    """

    from_s: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    to_s: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    low: Values
    high: Values
    alarm: bool
    said: Annotated[dict[Name, Annotated[str, Field(max_length=200)]], Field(max_length=200)]


@dataclass(frozen=True)
class Trace:
    """The data of one record, oldest first; `record` names it, so that a new one begins a new picture."""

    record: Name
    axes: Annotated[str, Field(pattern="^[a-z]{1,9}$")]
    signals: Annotated[tuple[Name, ...], Field(max_length=50)]
    stretches: Annotated[tuple[Annotated[Stretch, AfterValidator(_forward)], ...], Field(min_length=1, max_length=100)]


@dataclass
class Traces:
    """The last stretches of every machine; each with its number."""

    _lock: Lock = field(default_factory=Lock)
    _told: dict[str, deque[tuple[int, bytes]]] = field(default_factory=dict)
    _count: int = 0

    def add(self, machine: str, trace: Trace, now: datetime) -> None:
        """Adds further stretches, as they came."""
        with self._lock:
            kept = self._told.setdefault(machine, deque(maxlen=KEPT))
            for stretch in trace.stretches:
                self._count += 1
                kept.append((self._count, _event(self._count, trace, stretch, now)))

    def after(self, machine: str, count: int) -> tuple[int, list[bytes]]:
        """Returns the number of a machine's last stretch, and those after the number `count`."""
        with self._lock:
            new = [one for one in self._told.get(machine, ()) if one[0] > count]
        return (new[-1][0] if new else count), [content for _, content in new]


def _event(number: int, trace: Trace, stretch: Stretch, now: datetime) -> bytes:
    shown: dict[str, Any] = {
        "at": now.isoformat(),
        "record": trace.record,
        "axes": trace.axes,
        "signals": trace.signals,
        "from": stretch.from_s,
        "to": stretch.to_s,
        "low": stretch.low,
        "high": stretch.high,
        "alarm": stretch.alarm,
        "said": stretch.said,
    }
    return format_sse_event(data_str=json.dumps(shown), id=str(number))
