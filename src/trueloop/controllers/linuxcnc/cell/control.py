"""What a cell needs of a control: `Control`; what it sees of it: `ControlNow`."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol


class Doing(StrEnum):
    """What a control does."""

    IDLE = "idle"
    RUNNING = "running"
    PAUSED = "paused"
    FAULT = "fault"  # emergency stop, off, or not homed: nothing can run
    AWAY = "away"  # it does not answer


@dataclass(frozen=True)
class ControlNow:
    """`program`: the name of the program that is loaded, "" where none is. `still_s`: how long nothing has run."""

    doing: Doing
    program: str = ""
    still_s: float = 0.0
    line: int | None = None

    @property
    def active(self) -> bool:
        """Returns whether a program is in execution."""
        return self.doing in (Doing.RUNNING, Doing.PAUSED)


class Control(Protocol):
    """A control and the folder of its programs. Methods raise CTL-LINUXCNC where it does not do as asked."""

    def now(self) -> ControlNow:
        """Returns the control's present state. Raises CTL-LINUXCNC where that can never be seen from here."""

    def witness(self) -> str:
        """Returns what programs have logged of themselves: read after `now`, it is the later of the two."""

    def write(self, name: str, text: bytes) -> None:
        """Puts a program into the folder; nothing is loaded by it."""

    def read_back(self, name: str) -> bytes | None:
        """Returns the program that stands there, as the control would read it; None: there is none."""

    def open(self, name: str) -> None:
        """Loads a program of the folder."""

    def clear(self, name: str) -> None:
        """Unloads a program, if it is loaded, and takes it out of the folder: it cannot be started again."""

    def cycle_start(self) -> None:
        """Starts what is loaded."""

    def touches(self, name: str) -> bytes | None:
        """Returns the file that a gauging program wrote; None: there is none."""

    def discard_touches(self, name: str) -> None:
        """Puts a file of that name aside, so that the next is the run's own."""


@dataclass(frozen=True)
class Seen:
    """How often a run's program has begun and ended, by its own word."""

    started: int = 0
    ended: int = 0


def seen(log: str, key: str) -> Seen:
    """Counts the starts and ends of one run. A last line without its end is not read: it may be being written."""
    lines = [line.strip() for line in log.splitlines(keepends=True) if line.endswith("\n")]
    return Seen(lines.count(f"{key} started"), lines.count(f"{key} ended"))
