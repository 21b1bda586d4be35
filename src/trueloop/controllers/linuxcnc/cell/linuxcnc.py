"""LinuxCNC as a cell's control, by the Python module that it brings: `LinuxCnc`.

`Task` is the process that runs programs: LinuxCNC's status stays in shared memory, unchanged, when it was killed.
"""

import math
import os
import subprocess
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from trueloop.controllers.linuxcnc.cell.decide import ControlNow, Doing
from trueloop.errors import Code, TrueloopError
from trueloop.nc.witness import LOG_FILE

LOOK_S: Final = 1.0
"""How often all processes are looked at, while it is not there."""


class Task:
    """The task of one configuration: LinuxCNC gives it `-ini FILE`."""

    def __init__(self, ini: Path, program: str, processes: Path = Path("/proc")) -> None:
        """`program`: [TASK] TASK of the configuration."""
        self._ini, self._program, self._processes = ini.resolve(), program, processes
        self._pid: int | None = None
        self._next_look = 0.0

    def pid(self) -> int | None:
        """Its number now; None: it does not run."""
        if self._pid is not None and not self._is(self._pid):
            self._pid = None
        if self._pid is None and time.monotonic() >= self._next_look:
            self._next_look = time.monotonic() + LOOK_S
            numbers = (int(one.name) for one in self._processes.iterdir() if one.name.isdecimal())
            self._pid = next((number for number in numbers if self._is(number)), None)
        return self._pid

    def _is(self, number: int) -> bool:
        try:
            name, *given = (self._processes / str(number) / "cmdline").read_bytes().split(b"\0")
        except OSError:
            return False
        if Path(name.decode(errors="replace")).name != self._program or b"-ini" not in given[:-1]:
            return False
        return Path(given[given.index(b"-ini") + 1].decode(errors="replace")) == self._ini


EMPTY: Final = "nothing.ngc"
"""Loaded in place of a program that shall not be started again: LinuxCNC cannot unload."""
TAKEN_S: Final = 5.0
"""How long LinuxCNC may take to follow a command."""
_POLL_S: Final = 0.01
_LOG_TAIL: Final = 1 << 18
"""Bytes of the log that are read: far more than one run writes."""


class LinuxCnc:
    """A running LinuxCNC, and one that is away and comes again. Errors that it reports are left to its own display."""

    def __init__(self, ini: Path, programs: Path, module: Any) -> None:
        """`ini`: its configuration; `programs`: the cell's folder; `module`: LinuxCNC's. Raises CTL-LINUXCNC."""
        self._nc, self._home, self._programs = module, ini.resolve().parent, programs.resolve()
        try:
            task = module.ini(str(ini)).find("TASK", "TASK") or "milltask"
            self._programs.mkdir(exist_ok=True)
            (self._programs / EMPTY).write_bytes(b"M2\n")
        except (OSError, module.error) as error:
            raise _failed(f"{ini} and {programs} cannot be used: {error}") from error
        self._task = Task(ini, Path(task).name)
        self._status: Any = None
        self._command: Any = None
        self._pid: int | None = None
        self._active_at_s = time.monotonic()

    def now(self) -> ControlNow:
        """Returns LinuxCNC's present state. Raises CTL-LINUXCNC where LinuxCNC is another user's."""
        if not self._polled():
            return ControlNow(Doing.AWAY, "", self._still_s())
        status, automatic = self._status, self._status.task_mode == self._nc.MODE_AUTO
        doing = self._doing()
        if doing in (Doing.RUNNING, Doing.PAUSED):
            self._active_at_s = time.monotonic()
            if not automatic:  # by hand or by typed blocks: none of its programs runs
                return ControlNow(doing)
        return ControlNow(doing, self._name(status.file), self._still_s(), status.motion_line or None)

    def witness(self) -> str:
        """Returns the end of what programs have logged; empty where there is no log."""
        with suppress(OSError), (self._home / LOG_FILE).open("rb") as log:
            log.seek(0, os.SEEK_END)
            start = max(0, log.tell() - _LOG_TAIL)
            log.seek(start)
            text = log.read().decode(errors="replace")
            return text.partition("\n")[2] if start else text
        return ""

    def write(self, name: str, text: bytes) -> None:
        """Writes a program whole, or not at all."""
        aside = self._programs / f".{name}"
        try:
            with aside.open("wb") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            aside.replace(self._programs / name)
        except OSError as error:
            raise _failed(f"{name!r} is not written to {self._programs}: {error.strerror}") from error

    def read_back(self, name: str) -> bytes | None:
        """Returns the file as it stands there; None: there is none."""
        return _content(self._programs / name)

    def open(self, name: str) -> None:
        """Loads a program, and waits until LinuxCNC reports it as loaded."""
        self._told("automatic mode", lambda: self._command.mode(self._nc.MODE_AUTO))
        self._told(f"loading {name!r}", lambda: self._command.program_open(str(self._programs / name)))
        until = time.monotonic() + TAKEN_S
        while not (self._polled() and self._name(self._status.file) == name):
            if time.monotonic() > until:
                raise _failed(f"it has not loaded {name!r} within {TAKEN_S:g} s")
            time.sleep(_POLL_S)

    def clear(self, name: str) -> None:
        """Loads the empty program in its place, and deletes it."""
        if self._polled() and self._name(self._status.file) == name:
            self.open(EMPTY)
        (self._programs / name).unlink(missing_ok=True)

    def cycle_start(self) -> None:
        """Starts what is loaded. That it runs is seen, not believed: see `decide`."""
        self._told("automatic mode", lambda: self._command.mode(self._nc.MODE_AUTO))
        self._command.auto(self._nc.AUTO_RUN, 0)

    def touches(self, name: str) -> bytes | None:
        """Returns a gauging program's file, which PROBEOPEN and LOGOPEN write into the configuration's folder."""
        return _content(self._home / name)

    def discard_touches(self, name: str) -> None:
        """Renames the file with the time appended: nothing is lost."""
        with suppress(FileNotFoundError):
            (self._home / name).rename(self._home / f"{name}.{time.time_ns()}")

    def _doing(self) -> Doing:
        status, nc = self._status, self._nc
        if status.task_state != nc.STATE_ON:
            return Doing.FAULT
        if status.paused or status.interp_state == nc.INTERP_PAUSED:
            return Doing.PAUSED
        still = status.exec_state in (nc.EXEC_DONE, nc.EXEC_ERROR) and status.inpos
        if status.interp_state != nc.INTERP_IDLE or not still:
            return Doing.RUNNING
        return Doing.IDLE if all(status.homed[: status.joints]) else Doing.FAULT

    def _still_s(self) -> float:
        return time.monotonic() - self._active_at_s

    def _polled(self) -> bool:
        """Returns whether the status is that of a task that runs."""
        pid = self._task.pid()
        try:
            if pid is None:
                self._pid = None
                return False
            if pid != self._pid:
                self._status, self._command, self._pid = self._nc.stat(), self._nc.command(), pid
            self._status.poll()
        except self._nc.error:  # it comes up, or goes
            self._pid = None
            return False
        except SystemError as error:  # what its module says where ~/.tool.mmap is missing
            raise Code.CTL_LINUXCNC.refusal(
                "LinuxCNC runs with another home: what it holds cannot be read from here",
                hint="run the cell as the user who runs LinuxCNC, with the same HOME",
            ) from error
        return bool(self._status.ini_filename)

    def _name(self, file: str) -> str:
        path = Path(file)
        return path.name if path.parent == self._programs else file

    def _told(self, what: str, command: Callable[[], object]) -> None:
        if not self._polled():
            raise _failed(f"{what}: it does not run")
        command()
        done = self._command.wait_complete(TAKEN_S)
        if done != self._nc.RCS_DONE:
            said = "it refused" if done == self._nc.RCS_ERROR else f"it did not answer within {TAKEN_S:g} s"
            raise _failed(f"{what}: {said}")


def _content(file: Path) -> bytes | None:
    try:
        return file.read_bytes()
    except FileNotFoundError:
        return None


def _failed(why: str) -> TrueloopError:
    hint = "see what LinuxCNC shows; the cell goes on by itself once it can"
    return Code.CTL_LINUXCNC.refusal(f"LinuxCNC: {why}", hint=hint)


WAIT_S: Final = 5.0
OLDEST_S: Final = 86_400.0
"""A value of an older age is none: who sets the pin has never had one, or lost it long ago."""


@dataclass(frozen=True)
class Temperature:
    """°C, and how long ago that was measured, s."""

    celsius: float
    age_s: float = 0.0


def read_pins(
    pins: Mapping[str, str], ages: Mapping[str, str], program: str = "halcmd"
) -> tuple[dict[str, Temperature], list[str]]:
    """Reads pins: temperatures by signal, and why others cannot be read. `ages`: pins of the values' ages, s."""
    found, wrong = {}, []
    for name, pin in pins.items():
        try:
            age_s = _value(program, ages[name]) if name in ages else 0.0
            if not 0.0 <= age_s <= OLDEST_S:
                raise ValueError(f"its value is {age_s:g} s old")
            found[name] = Temperature(_value(program, pin), age_s)
        except (OSError, subprocess.SubprocessError, ValueError) as error:
            said = (getattr(error, "stderr", None) or str(error)).strip()
            wrong.append(f"{name}, pin {pin!r}: {said}")
    return found, wrong


def _value(program: str, pin: str) -> float:
    """Raises ValueError for anything that is not a number."""
    said = subprocess.run(
        [program, "getp", pin], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=WAIT_S, check=True
    ).stdout
    value = float(said)
    if not math.isfinite(value):
        raise ValueError(f"{said.strip()} is no number")
    return value
