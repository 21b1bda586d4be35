"""Events of a run in words: faults and changes of phase, with their time and line of the program.

Ramping and in force take turns at every reversal: the two count as one here.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop import _core
from trueloop.realtime.samples import Samples

_NAMES: Final = _core.realtime_names()
PHASES: Final = tuple(name for _, name, _ in _NAMES["phases"])
"""Names of the phases, by the number that `rtec.phase` shows."""
FAULTS: Final = tuple(meaning for _, _, meaning in _NAMES["faults"])
"""Meanings of the faults, by the number that `rtec.fault-code` and `rtec.signal-fault` show."""
WAITS: Final = tuple(meaning for _, _, meaning in _NAMES["waits"])
"""Names of what a run waits for, by the number that `rtec.waits-for` shows."""
OFF, WAITING, RAMPING, IN_FORCE, FROZEN, LEAVING, FAULTED = range(7)
ALARMING: Final = (FROZEN, LEAVING, FAULTED)


@dataclass(frozen=True)
class Event:
    """The state from this time on: its phase, and the reason for it, 0 where there is none.

    The reason is what is waited for while waiting, what is wrong with a signal while that is frozen or leaving, else
    the fault. `signal`: the column that it is about, "" where there is none.
    """

    time_s: float
    line: int
    phase: int
    reason: int
    signal: str

    @property
    def alarming(self) -> bool:
        """Returns whether the phase is one of a fault (`ALARMING`)."""
        return self.phase in ALARMING

    def in_words(self) -> str:
        """Returns the event as "faulted: a signal jumped (T1_degC)"."""
        phase = word(PHASES, self.phase)
        if not self.reason:
            return phase
        reason = word(WAITS if self.phase == WAITING else FAULTS, self.reason)
        return f"{phase}: {reason}" + (f" ({self.signal})" if self.signal and self.phase in ALARMING else "")


def word(words: Sequence[str], number: int) -> str:
    """Returns a name by its number; the number itself where it has no name."""
    return words[number] if 0 <= number < len(words) else str(number)


def events(samples: Samples, before: Event | None = None) -> list[Event]:
    """Returns every change, first the state at the beginning where there is no event `before`."""
    if not len(samples):
        return []
    phase, about = samples.count("phase"), samples.count("fault_signal")
    settled = np.where(phase == RAMPING, IN_FORCE, phase)
    reason = np.select(
        [phase == WAITING, np.isin(phase, (FROZEN, LEAVING))],
        [samples.count("waits_for"), samples.count("signal_fault")],
        samples.count("fault"),
    )
    same = np.column_stack([settled, reason, np.where(np.isin(phase, ALARMING), about, -1)])
    changes = np.flatnonzero(np.any(same[1:] != same[:-1], axis=1)) + 1
    found = [
        Event(
            float(samples.time_s[k]),
            int(samples.columns["line"][k]),
            int(phase[k]),
            int(reason[k]),
            _signal(samples.signals, int(same[k, 2])),
        )
        for k in (0, *changes)
    ]
    return found[1:] if before is not None and _same(before, found[0]) else found


def _signal(signals: Sequence[str], place: int) -> str:
    """The column of a signal; "" for −1."""
    if place < 0:
        return ""
    return signals[place] if place < len(signals) else f"signal {place}"


def _same(one: Event, other: Event) -> bool:
    first, second = (IN_FORCE if event.phase == RAMPING else event.phase for event in (one, other))
    return (first, one.reason, one.signal) == (second, other.reason, other.signal)
