"""The latest reading of each signal, from threads that read sensors each at its own pace.

The slow thread: what the past of the sensors makes of the lags, and the log of all that was read.

Each source has a thread, which starts the source again when it fails, at growing intervals. Times are those of
`time.monotonic()`: a clock that is set leaves ages alone.
"""

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Final, NamedTuple, Protocol

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.realtime.samples_csv import SignalLog
from trueloop.formats.realtime.signals_toml import SignalsFile
from trueloop.formats.toml_tables import Located
from trueloop.machine.model.history import History, Lag
from trueloop.realtime.image import LagRules, LagState, advanced, from_history

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


@dataclass(frozen=True)
class Clock:
    """Time of the log: `log_s`, s since 1970, at `monotonic_s`, then at `speed`; setting the clock moves no lag."""

    log_s: float
    monotonic_s: float
    speed: float = 1.0

    def at(self, now_s: float) -> float:
        """Returns the log's time at a time of the monotonic clock."""
        return self.log_s + self.speed * (now_s - self.monotonic_s)


class Past(threading.Thread):
    """Lags and log. `states` are the lags as the log left them."""

    def __init__(
        self,
        lags: tuple[Lag, ...],
        rules: LagRules,
        states: Mapping[str, LagState | None],
        board: Board,
        clock: Clock,
        stop: threading.Event,
        say: Say,
        *,
        log: SignalLog | None = None,
        sensors: tuple[str, ...] = (),
        every_s: float = 1.0,
        stale_s: float = 10.0,
    ) -> None:
        super().__init__(name="lags and log", daemon=True)
        self._lags, self._rules, self.states = lags, rules, dict(states)
        self._board, self._clock, self._stopped, self._say = board, clock, stop, say
        self._log, self._sensors, self._every_s, self._stale_s = log, sensors, every_s, stale_s
        self._readings: dict[str, Reading] = {}
        self._fault = ""
        self.turned_s = time.monotonic()

    def run(self) -> None:
        """Takes a turn every `every_s`."""
        while not self._stopped.is_set():
            began_s = time.monotonic()
            try:
                self.turn(began_s)
            except Exception as error:  # is said, and ends the thread and with it the heartbeat
                self._say(f"{self.name}: stopped by a fault of trueloop: {type(error).__name__}: {error}")
                return
            self.turned_s = time.monotonic()
            wait(self._stopped, began_s, self._every_s)

    def turn(self, now_s: float) -> None:
        """Advances all lags by one step, and writes a row of the log where all sensors are read."""
        read = {n: r for n, r in self._board.readings().items() if r.age_s(now_s) <= self._stale_s}
        known = dict(self._readings)
        for lag in self._lags:
            if (reading := read.get(lag.of)) is not None:
                state = advanced(self.states.get(lag.name), lag, self._rules, self._clock.at(now_s), reading.value)
                self.states[lag.name] = state
                known.pop(lag.name, None)
                if state.known(lag, self._rules):
                    known[lag.name] = Reading(state.value, reading.time_s)
        self._readings = known
        self._write(now_s, read)

    def readings(self) -> dict[str, Reading]:
        """Returns the lags that are known, each as old as what it was computed from."""
        return self._readings

    def healthy(self, now_s: float) -> bool:
        """Returns whether the turns go on."""
        return self.is_alive() and now_s - self.turned_s < 5 * self._every_s + 1

    def _write(self, now_s: float, read: Mapping[str, Reading]) -> None:
        """Reports once that the log cannot be written: the lags go on without it."""
        if self._log is None or not read.keys() >= set(self._sensors):
            return
        fault = ""
        try:
            self._log.append(self._clock.at(now_s), [read[name].value for name in self._sensors])
        except (OSError, TrueloopError) as error:
            fault = f"{self._log.path} is not written: {error}"
        if fault and fault != self._fault:
            self._say(fault)
        self._fault = fault


@dataclass(frozen=True)
class Replay:
    """A log from `start_s` on, of its own time, at `speed` times its pace; straight between its rows.

    `began_s`: when that row was due, on the monotonic clock. `columns` are signals of the log by name here.
    """

    log: History
    columns: dict[str, str]
    began_s: float
    start_s: float
    speed: float = 1.0
    every_s: float = 0.1

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Reads until the log ends; from then on its signals grow old."""
        while not stop.is_set():
            now_s = time.monotonic()
            row_s = self.start_s + self.speed * (now_s - self.began_s)
            for name, column in self.columns.items():
                if row_s <= self.log.time_s[-1]:
                    intake.put(name, float(np.interp(row_s, self.log.time_s, self.log.signals[column])), now_s)
                else:
                    intake.refuse(name, f"the log ended at {self.log.time_s[-1]:g} s")
            wait(stop, now_s, self.every_s)


@dataclass(frozen=True)
class ReplayedLogs:
    """All sources that are logs, by name; `units` and `states` by signal and lag."""

    feeds: Mapping[str, Feed]
    units: Mapping[str, str]
    states: Mapping[str, LagState | None]
    speed: float = 1.0


def replayed(file: Located[SignalsFile], names: Sequence[str], lags: Sequence[Lag], clock: Clock) -> ReplayedLogs:
    """Prepares the replays of these signals. Raises RTC-SOURCE: not in a log, other speeds; as `read_history`."""
    feeds: dict[str, Feed] = {}
    units: dict[str, str] = {}
    states: dict[str, LagState | None] = {}
    for source in dict.fromkeys(file.model.signals[name].source for name in names):
        columns = {n: file.model.signals[n].recorded or n for n in names if file.model.signals[n].source == source}
        feed = _replay(file, source, columns, clock)
        feeds[source] = feed
        units.update({name: feed.log.units[column] for name, column in columns.items()})
        states.update({lag.name: _state(feed, lag, clock) for lag in lags if lag.of in columns})
    used = list(feeds)
    speeds = {file.model.replay[source].speed for source in used}
    if len(speeds) > 1:
        with file.at("replay", used[1], "speed"):
            raise Code.RTC_SOURCE.refusal(
                f"logs are played again at {len(speeds)} speeds: {', '.join(f'{s:g}' for s in sorted(speeds))}",
                hint="one speed for all: lags run on one clock",
            )
    return ReplayedLogs(feeds, units, states, next(iter(speeds), 1.0))


def _replay(file: Located[SignalsFile], source: str, columns: dict[str, str], clock: Clock) -> Replay:
    table = file.model.replay[source]
    log = read_history(file.path.parent / table.file)
    for name, column in columns.items():
        if column not in log.signals:
            with file.at("signals", name):
                raise Code.RTC_SOURCE.refusal(
                    f"signal {name!r}: {table.file!r} holds no {column!r}, but {len(log.signals)} others: "
                    f"{', '.join(log.signals)}",
                    hint="say under which name it was logged: recorded = …",
                )
    start_s = float(log.time_s[0]) if table.start_s is None else table.start_s
    with file.at("replay", source, "start_s"):
        first, last = float(log.time_s[0]), float(log.time_s[-1])
        if not first <= start_s < last:
            raise Code.RTC_SOURCE.refusal(
                f"the log is from {first:g} to {last:g} s: it cannot begin at {start_s:g} s",
                hint="start_s counts as the log's own column time_s does",
            )
    return Replay(log, columns, clock.monotonic_s, start_s, table.speed)


def _state(feed: Replay, lag: Lag, clock: Clock) -> LagState | None:
    """A lag where the replay begins: in equilibrium at the log's first row, straight between rows however far apart."""
    start_s, column = feed.start_s, feed.columns[lag.of]
    until = feed.log.until(start_s)
    times = np.append(until.time_s[until.time_s < start_s], start_s)
    values = np.interp(times, feed.log.time_s, feed.log.signals[column])
    rules = LagRules(gap=math.inf, equilibrium_s=float(times[0]))
    state = from_history(lag, rules, History(times, {lag.of: values}))
    return state and replace(state, time_s=clock.log_s, since_s=clock.log_s)
