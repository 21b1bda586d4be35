"""`rtec-signals`: sets the pins of LinuxCNC's corrector, several times a second, from what all threads have read.

The heartbeat counts only while every thread lives: a fault here stops it, and the corrector's watchdog does the rest. A
source that fails is no such fault: its signals grow old.
"""

import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from trueloop.controllers.linuxcnc.realtime.signals.hal_pins import Pins
from trueloop.controllers.linuxcnc.realtime.signals.past import Past
from trueloop.controllers.linuxcnc.realtime.signals.program import ProgramThread, ProgramWatch, Running
from trueloop.controllers.linuxcnc.realtime.signals.reader import Reader, Say, ended
from trueloop.controllers.linuxcnc.realtime.signals.readings import NOTHING, Board, Reading, wait
from trueloop.controllers.linuxcnc.realtime.signals.setup import Setup
from trueloop.errors import TrueloopError
from trueloop.formats.realtime.signal_log import SignalLog
from trueloop.machine.model.history import History
from trueloop.realtime.lags import LagState, from_history


class Collector:
    """The threads that read, and what they have read so far."""

    def __init__(self, setup: Setup, stop: threading.Event, say: Say, *, logging: bool = True) -> None:
        """`logging`: begin the log and write it; without, lags start as it left them and it is left alone."""
        self.setup, self._stop = setup, stop
        self.board = Board(setup.scale)
        self.readers = {name: Reader(name, feed, self.board, stop, say) for name, feed in setup.feeds.items()}
        log, history = _begun(setup, say) if logging else (None, _recorded(setup))
        self.past = Past(
            setup.lags,
            setup.rules,
            _states(setup, history),
            self.board,
            setup.clock,
            stop,
            say,
            log=log,
            sensors=setup.sensors,
            every_s=setup.every_s,
            stale_s=setup.stale_s,
        )

    def start(self) -> None:
        """Begins to read."""
        for thread in self.threads():
            thread.start()

    def threads(self) -> list[threading.Thread]:
        """All of them."""
        return [*self.readers.values(), self.past]

    def readings(self, now_s: float, spindle_rpm: float | None) -> list[Reading]:
        """The image's signals in its order."""
        for name in self.setup.spindle if spindle_rpm is not None else ():
            self.board.put(name, spindle_rpm or 0.0, now_s)
        for name, value in self.setup.constants.items():
            self.board.put(name, value, now_s)
        found: Mapping[str, Reading] = self.board.readings() | self.past.readings()
        return [found.get(signal.name, NOTHING) for signal in self.setup.wanted]

    def healthy(self, now_s: float) -> bool:
        """Whether every thread does its work."""
        return self.past.healthy(now_s) and all(reader.is_alive() for reader in self.readers.values())


def _begun(setup: Setup, say: Say) -> tuple[SignalLog | None, History | None]:
    """The log and what is in it. One that cannot be written is said: signals go on without it."""
    if setup.log is None:
        return None, None
    try:
        return setup.log, setup.log.begin(setup.clock.log_s)
    except (OSError, TrueloopError) as error:
        say(f"no log is written to {setup.log.path}: {error}")
        return None, None


def _recorded(setup: Setup) -> History | None:
    return None if setup.log is None else setup.log.recorded(setup.clock.log_s)


def _states(setup: Setup, history: History | None) -> dict[str, LagState | None]:
    """Every lag as the log left it, or as a replay begins it."""
    from_log = {lag.name: from_history(lag, setup.rules, history) for lag in setup.lags} if history else {}
    return from_log | dict(setup.states)


def run(setup: Setup, hal: Any, linuxcnc: Any, sha256: Callable[[], str], stop: threading.Event, say: Say) -> None:
    """Runs the component until `stop`. `sha256`: of the image's program; it is asked for whenever no program runs.

    Raises RTC-CONNECTION where the hardware layer does not take it, RTC-SOURCE where the image's signals have changed.
    """
    pins = Pins(hal)
    collector = Collector(setup, stop, say)
    watch = ProgramWatch(sha256())
    program = ProgramThread(linuxcnc, watch, stop, say)
    try:
        collector.start()
        program.start()
        pins.ready()
        _cycle(collector, program, pins, stop, lambda: setattr(watch, "sha256", sha256()))
    except KeyboardInterrupt:
        pass  # LinuxCNC's module makes this of SIGTERM
    finally:
        ended([*collector.threads(), program], stop)
        pins.end()


def _cycle(
    collector: Collector, program: ProgramThread, pins: Pins, stop: threading.Event, ask_image: Callable[[], None]
) -> None:
    beats = 0
    while not stop.is_set():
        now_s = time.monotonic()
        if program.running is Running.NONE:
            ask_image()
        pins.give(collector.readings(now_s, pins.spindle_rpm()), program.running, now_s)
        if collector.healthy(now_s) and program.healthy(now_s):
            beats += 1
            pins.beat(beats)
        wait(stop, now_s, collector.setup.cycle_s)
