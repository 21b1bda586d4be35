"""What a cell does next: `decide`, of what its journal says, what its control does, and what its program has logged."""

from dataclasses import dataclass
from enum import StrEnum

from trueloop.controllers.linuxcnc.cell.control import ControlNow, Doing, Seen
from trueloop.controllers.linuxcnc.cell.journal import RunNow
from trueloop.domain.factory import FactKind


class Do(StrEnum):
    """What to do; after each the world is looked at anew."""

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
class Asked:
    """The service's last word, where it is fresh: whether it still offers the run, and armed; `text`: the program."""

    key: str = ""
    armed: bool = False
    text: bytes | None = None


@dataclass(frozen=True)
class Patience:
    """`settled_s`: a control that stands still for so long has ended; `start_s`: one told to start, and has not."""

    settled_s: float = 1.0
    start_s: float = 10.0
    away_s: float = 30.0


def decide(run: RunNow | None, control: ControlNow, witness: Seen, asked: Asked, patience: Patience) -> Action:
    """Returns the next action: witnesses count first; motion last, and only where nothing began under this key."""
    if run is None:
        return Action(Do.WAIT, "a program runs that is not ours") if control.active else Action(Do.ASK)
    return _noticed(run, control, witness) or (
        _after_start(run, control, patience) if _moved(run) else _before_start(run, control, asked)
    )


def _moved(run: RunNow) -> bool:
    return run.begun or bool(run.facts & {FactKind.STARTED, FactKind.ENDED, FactKind.UNKNOWN})


def _noticed(run: RunNow, control: ControlNow, witness: Seen) -> Action | None:
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


def _before_start(run: RunNow, control: ControlNow, asked: Asked) -> Action:
    ours, offered = control.program == run.program, asked.key == run.key
    if run.withdrawn or run.differs:
        return Action(Do.CLEAR) if ours else Action(Do.CLOSE)
    if FactKind.VERIFIED not in run.facts:
        return Action(Do.SEND) if offered and asked.text is not None else Action(Do.ASK)
    if control.doing is not Doing.IDLE:
        return Action(Do.WAIT, f"the control is {control.doing.value}, with {control.program!r}")
    if not ours and (not run.opened or not control.program):
        return Action(Do.OPEN)
    if ours and control.doing is Doing.IDLE and offered and asked.armed:
        return Action(Do.BEGIN)
    return Action(Do.ASK, "press Cycle Start" if ours else f"open {run.program!r} at the control")
