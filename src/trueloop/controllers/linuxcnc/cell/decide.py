"""The next action of a cell: `decide`, by its journal, its control's state, and its program's log."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from trueloop.controllers.linuxcnc.cell.journal import RunNow
from trueloop.domain.factory import FactKind


class Doing(StrEnum):
    """The state of a control."""

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
class ProgramCounts:
    """How often a run's program has begun and ended, by its own word."""

    started: int = 0
    ended: int = 0


def seen(log: str, key: str) -> ProgramCounts:
    """Counts the starts and ends of one run. A last line without its end is not read: it may be being written."""
    lines = [line.strip() for line in log.splitlines(keepends=True) if line.endswith("\n")]
    return ProgramCounts(lines.count(f"{key} started"), lines.count(f"{key} ended"))


class Do(StrEnum):
    """Actions; after each, journal and control are read again."""

    ASK = "ask"  # the service, for the next block or for how this one stands
    SEND = "send"  # write the program and read it back
    OPEN = "open"  # load it
    BEGIN = "begin"  # read it back once more, and start it
    TELL = "tell"  # note a fact
    GATHER = "gather"  # the touches that it wrote
    CLEAR = "clear"  # unload it and take it away
    CLOSE = "close"  # the run is over
    WAIT = "wait"


@dataclass(frozen=True)
class Action:
    """What, and for people why; of a fact which, and by whose word."""

    do: Do
    why: str = ""
    fact: FactKind | None = None
    witness: str = "cell"


@dataclass(frozen=True)
class ServiceState:
    """The service's last word, where it is fresh: whether it still offers the run, and armed; `text`: the program."""

    key: str = ""
    armed: bool = False
    text: bytes | None = None


@dataclass(frozen=True)
class Patience:
    """`settled_s`: a control that stands still for so long has ended; `start_s`: a start that was sent has failed."""

    settled_s: float = 1.0
    start_s: float = 10.0
    away_s: float = 30.0


def decide(
    run: RunNow | None, control: ControlNow, witness: ProgramCounts, service: ServiceState, patience: Patience
) -> Action:
    """Returns the next action: witnesses count first; motion last, and only where nothing began under this key."""
    if run is None:
        return Action(Do.WAIT, "a program runs that is not ours") if control.active else Action(Do.ASK)
    return _noticed(run, control, witness) or (
        _after_start(run, control, patience) if _moved(run) else _before_start(run, control, service)
    )


def _moved(run: RunNow) -> bool:
    return run.begun or bool(run.facts & {FactKind.STARTED, FactKind.ENDED, FactKind.UNKNOWN})


def _noticed(run: RunNow, control: ControlNow, witness: ProgramCounts) -> Action | None:
    """A fact that is not noted yet."""
    ours = control.program == run.program
    if FactKind.STARTED not in run.facts and (witness.started or witness.ended):
        return Action(Do.TELL, "", FactKind.STARTED, "program")
    if FactKind.STARTED not in run.facts and ours and control.active:
        return Action(Do.TELL, "", FactKind.STARTED, "control")
    if witness.started > 1 and FactKind.UNKNOWN not in run.facts:
        return Action(Do.TELL, f"it started {witness.started} times", FactKind.UNKNOWN, "program")
    if witness.ended and witness.started <= 1 and FactKind.ENDED not in run.facts:
        return Action(Do.TELL, "", FactKind.ENDED, "program")
    return None


def _after_start(run: RunNow, control: ControlNow, patience: Patience) -> Action:
    if FactKind.ENDED in run.facts and run.touches and not run.gathered:
        return Action(Do.GATHER)
    if run.facts & {FactKind.ENDED, FactKind.UNKNOWN}:
        return _over(run, control)
    started = FactKind.STARTED in run.facts
    if control.active and control.program == run.program:
        return Action(Do.WAIT, "it runs")
    limit_s = patience.settled_s if started else patience.start_s
    if control.doing is Doing.AWAY:
        limit_s = max(limit_s, patience.away_s)
    if control.still_s < limit_s and not control.active:
        return Action(Do.WAIT, "it may have ended" if started else "it may have begun")
    said = "started and did not end" if started else "was told to start, and no witness saw it"
    return Action(Do.TELL, f"it {said}", FactKind.UNKNOWN)


def _over(run: RunNow, control: ControlNow) -> Action:
    if control.program == run.program:
        return Action(Do.WAIT, "it still runs") if control.active else Action(Do.CLEAR)
    if FactKind.ENDED in run.facts:
        return Action(Do.CLOSE)
    return Action(Do.ASK, "a person decides whether the cut was made")


def _before_start(run: RunNow, control: ControlNow, service: ServiceState) -> Action:
    ours, offered = control.program == run.program, service.key == run.key
    if run.withdrawn or run.differs:
        return Action(Do.CLEAR) if ours else Action(Do.CLOSE)
    if FactKind.VERIFIED not in run.facts:
        return Action(Do.SEND) if offered and service.text is not None else Action(Do.ASK)
    if control.doing is not Doing.IDLE:
        return Action(Do.WAIT, f"the control is {control.doing.value}, with {control.program!r}")
    if not ours and (not run.opened or not control.program):
        return Action(Do.OPEN)
    if ours and control.doing is Doing.IDLE and offered and service.armed:
        return Action(Do.BEGIN)
    return Action(Do.ASK, "press Cycle Start" if ours else f"open {run.program!r} at the control")
