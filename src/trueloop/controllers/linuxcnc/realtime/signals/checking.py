"""Every source read once: what each signal says, how old it is, and whether the image's range holds it."""

import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from trueloop.controllers.linuxcnc.realtime.signals.component import Collector
from trueloop.controllers.linuxcnc.realtime.signals.readings import Reading, ended
from trueloop.controllers.linuxcnc.realtime.signals.setup import Setup
from trueloop.realtime.image import Signal

POLL_S = 0.05


@dataclass(frozen=True)
class CheckedSignal:
    """One signal: `age_s` and `value` None where it was not read; `fault` is empty where all is well."""

    name: str
    source: str
    value: float | None
    age_s: float | None
    low: float
    high: float
    fault: str


def checked(setup: Setup, wait_s: float, spindle_rpm: Callable[[], float | None]) -> list[CheckedSignal]:
    """Reads until every signal is there, `wait_s` at most. Writes no log. Raises RTC-SOURCE as sources do."""
    stop, said = threading.Event(), list[str]()
    collector = Collector(setup, stop, said.append, logging=False)
    try:
        collector.start()
        last_s = time.monotonic() + wait_s
        readings = collector.readings(time.monotonic(), spindle_rpm())
        while not all(_read(one) for one in readings) and time.monotonic() < last_s:
            time.sleep(POLL_S)
            readings = collector.readings(time.monotonic(), spindle_rpm())
    finally:
        ended(collector.threads(), stop)
    return _judged(collector, readings, time.monotonic())


def _read(reading: Reading) -> bool:
    return math.isfinite(reading.value)


def _judged(collector: Collector, readings: Sequence[Reading], now_s: float) -> list[CheckedSignal]:
    found = []
    for signal, reading in zip(collector.setup.wanted, readings, strict=True):
        source = collector.setup.source_of.get(signal.name, "lag")
        value, age_s = (reading.value, reading.age_s(now_s)) if _read(reading) else (None, None)
        fault = _fault(collector, signal, value, age_s)
        found.append(
            CheckedSignal(
                name=signal.name, source=source, value=value, age_s=age_s, low=signal.low, high=signal.high, fault=fault
            )
        )
    return found


def _fault(collector: Collector, signal: Signal, value: float | None, age_s: float | None) -> str:
    if value is None or age_s is None:
        return _unread(collector, signal.name)
    if age_s > collector.setup.stale_s:
        return f"older than {collector.setup.stale_s:g} s"
    return "" if signal.low <= value <= signal.high else "outside the range of the image"


def _unread(collector: Collector, name: str) -> str:
    """Why there is no value."""
    setup = collector.setup
    for lag in setup.lags:
        if lag.name == name:
            state = collector.past.states.get(name)
            if state is None:
                return f"{lag.of} was not read"
            return f"known in {state.known_in_s(lag, setup.rules) / 3600:.2f} h, or when equilibrium is stated"
    if name in setup.spindle:
        return "nothing is linked to the pin spindle-speed here"
    reader = collector.readers.get(setup.source_of[name])
    return (reader and reader.why(name)) or "nothing was read"
