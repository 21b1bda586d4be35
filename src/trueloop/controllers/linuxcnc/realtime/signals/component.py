"""`rtec-signals`: sets the pins of LinuxCNC's corrector, several times a second, from what all threads have read.

The pins of `rtec-signals` in LinuxCNC's hardware layer, by the Python module that LinuxCNC brings.

The heartbeat counts only while every thread lives: a fault here stops it, and the corrector's watchdog does the rest. A
source that fails is not such a fault: its signals grow old.
"""

import hashlib
import importlib
import math
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from trueloop.controllers.linuxcnc.realtime.signals.readings import (
    NEVER_S,
    NOTHING,
    Board,
    Past,
    Reader,
    Reading,
    Say,
    ended,
    wait,
)
from trueloop.controllers.linuxcnc.realtime.signals.setup import Setup
from trueloop.errors import Code, TrueloopError
from trueloop.formats.realtime.samples_csv import SignalLog
from trueloop.machine.model.history import History
from trueloop.realtime.image import SIGNALS, Signal, from_history

NAME: Final = "rtec-signals"
DEBIANS: Final = "/usr/lib/python3/dist-packages"
"""Where Debian's package has LinuxCNC's modules, out of sight of other Pythons and of virtual environments."""

HINT: Final = (
    "LinuxCNC's modules are for the system's Python: make an environment of that, "
    "`/usr/bin/python3 -m venv --system-site-packages ENV`, install in it the wheel that `make wheel` writes, "
    "and call ENV/bin/trueloop"
)


def linuxcnc_module(name: str, folder: str = DEBIANS) -> ModuleType:
    """Imports a module of LinuxCNC: this Python's own, else Debian's. Raises RTC-CONNECTION where there is none.

    Debian's folder is not searched for anything else: what else is in there belongs to the system.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        spec = PathFinder.find_spec(name, [folder])
    try:
        if spec is None or spec.loader is None:
            raise ImportError(f"no module {name!r} for it, not in {folder} either")
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    except ImportError as error:
        version = ".".join(map(str, sys.version_info[:3]))
        raise Code.RTC_CONNECTION.refusal(
            f"Python {version} at {sys.executable!r} cannot load LinuxCNC's module {name!r}: {error}", hint=HINT
        ) from error


class Pins:
    """The component: signals and ages, the program, the heartbeat; in: the spindle's speed."""

    def __init__(self, hal: Any) -> None:
        """Raises RTC-CONNECTION where the hardware layer has no room for it, or has it already."""
        self._hal = hal
        try:
            self._component = hal.component(NAME)
            for number in range(SIGNALS):
                for pin in (f"signal-{number}", f"age-{number}"):
                    self._component.newpin(pin, hal.HAL_FLOAT, hal.HAL_OUT)
            self._component.newpin("program", hal.HAL_S32, hal.HAL_OUT)
            self._component.newpin("heartbeat", hal.HAL_U32, hal.HAL_OUT)
            self._component.newpin("spindle-speed", hal.HAL_FLOAT, hal.HAL_IN)
        except hal.error as error:
            raise Code.RTC_CONNECTION.refusal(
                f"the hardware layer does not take the component {NAME!r}: {str(error)!r}",
                hint="one of them at a time: end the other one, or start LinuxCNC anew",
            ) from error
        for number in range(SIGNALS):
            self._component[f"age-{number}"] = NEVER_S

    def ready(self) -> None:
        """Marks the component as ready, for which `loadusr -W` waits."""
        self._component.ready()

    def spindle_rpm(self) -> float | None:
        """Returns the spindle speed, rev/min, without its sign; None where nothing is linked to the pin."""
        if not self._hal.pin_has_writer(f"{NAME}.spindle-speed"):
            return None
        return abs(float(self._component["spindle-speed"])) * 60

    def give(self, readings: Sequence[Reading], program: int, now_s: float) -> None:
        """Sets the pins, signals in the order of the image."""
        for number, reading in enumerate(readings):
            self._component[f"signal-{number}"] = reading.value
            self._component[f"age-{number}"] = min(reading.age_s(now_s), NEVER_S)
        self._component["program"] = int(program)

    def beat(self, count: int) -> None:
        """Sets the heartbeat."""
        self._component["heartbeat"] = count % 2**32

    def end(self) -> None:
        """Takes the component away."""
        self._component.exit()


EVERY_S: Final = 0.05
AGAIN_S: Final = 1.0
"""How often a LinuxCNC that is not up yet is asked."""
HANGS_S: Final = 5.0
"""A status that does not answer for so long, or a program that takes as long to read."""
INTERPRETER: Final = "milltask"
"""LinuxCNC's process that reads programs."""


class Running(IntEnum):
    """As the pin `program` says it."""

    NONE = 0
    OURS = 1
    OTHER = 2


Identity = tuple[int, int, int, int]


class Interpreter:
    """LinuxCNC's process that reads programs, found by its name and looked into."""

    def __init__(self, processes: Path = Path("/proc")) -> None:
        self._processes = processes
        self._process: Path | None = None

    def loaded(self, file: str) -> Path:
        """Returns the file that the interpreter has open under this name: another than the name's if that was replaced.

        The name's file where the interpreter has none open, or where looking into its process is not allowed.
        """
        if self._process is None or not _is_interpreter(self._process):
            self._process = next(filter(_is_interpreter, self._processes.iterdir()), None)
        with suppress(OSError):
            for opened in (self._process / "fd").iterdir() if self._process else ():
                with suppress(OSError):
                    if str(opened.readlink()).removesuffix(" (deleted)") == file:
                        return opened
        return Path(file)


def _is_interpreter(process: Path) -> bool:
    try:
        return process.name.isdigit() and (process / "comm").read_text().strip() == INTERPRETER
    except OSError:
        return False


class ProgramWatch:
    """Told what LinuxCNC's status says, knows which program runs. `sha256` of the image's program, "": of no table."""

    def __init__(self, sha256: str, interpreter: Interpreter | None = None) -> None:
        self.sha256, self._interpreter = sha256, interpreter or Interpreter()
        self._known: tuple[str, Identity | None] = ("", None)
        self._hash = ""
        self._began: Identity | None = None
        self._called = False

    def running(self, file: str, *, automatic: bool, idle: bool, call_level: int, queued: int) -> Running:
        """Returns NONE in manual and MDI, between programs, and in a subprogram until its last motion ends: lines are
        those of another file there, and the interpreter is ahead of the motion.

        A file that changes while it runs is OTHER: what of it was read before nobody knows.
        """
        if not automatic or idle or not file:
            self._began, self._called = None, False
            return Running.NONE
        self._called = call_level > 0 or (self._called and queued > 0)
        loaded = self._interpreter.loaded(file)
        identity = _identity(loaded)
        self._began = self._began or identity
        if identity is None or identity != self._began:
            return Running.OTHER
        if self._known != (file, identity):
            self._known, self._hash = (file, identity), _sha256(loaded)
        if not self.sha256 or self._hash != self.sha256:
            return Running.OTHER
        return Running.NONE if self._called else Running.OURS


def _identity(file: Path) -> Identity | None:
    try:
        of = file.stat()
    except OSError:
        return None
    return of.st_dev, of.st_ino, of.st_size, of.st_mtime_ns


def _sha256(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""


class ProgramThread(threading.Thread):
    """Asks LinuxCNC's status; NONE while there is none to ask."""

    def __init__(self, linuxcnc: Any, watch: ProgramWatch, stop: threading.Event, say: Say) -> None:
        super().__init__(name="program", daemon=True)
        self._linuxcnc, self._watch, self._stopped, self._say = linuxcnc, watch, stop, say
        self.running, self.asked_s = Running.NONE, time.monotonic()

    def run(self) -> None:
        """Asks until the end."""
        ask: Callable[[], Running] | None = None
        while not self._stopped.is_set():
            began_s = time.monotonic()
            try:
                ask = ask or self._connected()
                self.running = ask()
            except (self._linuxcnc.error, SystemError):  # the second where it forgets to say the first
                self.running, ask = Running.NONE, None
            except Exception as error:  # is said, and ends the thread and with it the heartbeat
                self.running = Running.NONE
                self._say(f"{self.name}: stopped by a fault of trueloop: {type(error).__name__}: {error}")
                return
            self.asked_s = time.monotonic()
            wait(self._stopped, began_s, EVERY_S if ask else AGAIN_S)

    def healthy(self, now_s: float) -> bool:
        """Returns whether the thread goes on polling."""
        return self.is_alive() and now_s - self.asked_s < HANGS_S

    def _connected(self) -> Callable[[], Running]:
        status = self._linuxcnc.stat()

        def ask() -> Running:
            status.poll()
            return self._watch.running(
                status.file,
                automatic=status.task_mode == self._linuxcnc.MODE_AUTO,
                idle=status.interp_state == self._linuxcnc.INTERP_IDLE,
                call_level=status.call_level,
                queued=status.queue,
            )

        return ask


class Collector:
    """The threads that read, and what they have read so far."""

    def __init__(self, setup: Setup, stop: threading.Event, say: Say, *, logging: bool = True) -> None:
        """`logging`: begin the log and write it; without, lags start as it left them and it is left alone."""
        self.setup, self._stop = setup, stop
        self.board = Board(setup.scale)
        self.readers = {name: Reader(name, feed, self.board, stop, say) for name, feed in setup.feeds.items()}
        log, history = _begun(setup, say) if logging else (None, _recorded(setup))
        from_log = {lag.name: from_history(lag, setup.rules, history) for lag in setup.lags} if history else {}
        self.past = Past(
            setup.lags,
            setup.rules,
            from_log | dict(setup.states),
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
        """Starts the threads."""
        for thread in self.threads():
            thread.start()

    def threads(self) -> list[threading.Thread]:
        """Returns all threads."""
        return [*self.readers.values(), self.past]

    def readings(self, now_s: float, spindle_rpm: float | None) -> list[Reading]:
        """Returns the readings of the image's signals in its order."""
        for name in self.setup.spindle if spindle_rpm is not None else ():
            self.board.put(name, spindle_rpm or 0.0, now_s)
        for name, value in self.setup.constants.items():
            self.board.put(name, value, now_s)
        found: Mapping[str, Reading] = self.board.readings() | self.past.readings()
        return [found.get(signal.name, NOTHING) for signal in self.setup.wanted]

    def healthy(self, now_s: float) -> bool:
        """Returns whether every thread does its work."""
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


def run(setup: Setup, hal: Any, linuxcnc: Any, sha256: Callable[[], str], stop: threading.Event, say: Say) -> None:
    """Runs the component until `stop`. `sha256`: of the image's program; it is read again whenever no program runs.

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
        while not all(_read(reading) for reading in readings) and time.monotonic() < last_s:
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
