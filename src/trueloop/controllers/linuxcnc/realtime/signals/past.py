"""The slow thread: what the past of the sensors makes of the lags, and the log of all that was read."""

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass

from trueloop.controllers.linuxcnc.realtime.signals.readings import Board, Reading, Say, wait
from trueloop.errors import TrueloopError
from trueloop.formats.realtime.signal_log import SignalLog
from trueloop.machine.model.history import Lag
from trueloop.realtime.lags import LagRules, LagState, advanced


@dataclass(frozen=True)
class Clock:
    """Time of the log: `log_s`, s since 1970, when the monotonic clock said `monotonic_s`; from there at `speed`.

    A clock on the wall that is set while the component runs moves no lag.
    """

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
        """A log that cannot be written is said once: the lags go on without it."""
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
