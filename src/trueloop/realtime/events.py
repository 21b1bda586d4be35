"""What happened in a run, in words: faults and changes of phase, with when and at which line of the program.

Ramping and in force take turns at every reversal: the two count as one here.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.realtime.samples import Samples

PHASES: Final = ("off", "waiting", "ramping", "in force", "frozen", "leaving", "faulted")
"""By the number that `rtec.phase` shows."""
FAULTS: Final = (
    "none",
    "a correction beyond the limit",
    "a position, tool offset or correction that is no number",
    "the drive would leave its travel",
    "a signal older than it may be",
    "a signal outside the range in which the model holds",
    "a signal that jumped",
    "the signals' component is silent",
    "another program runs than the table's",
    "a block of the table is cut off its path",
    "settings that make no sense",
)
"""By the number that `rtec.fault-code` shows."""
RAMPING, IN_FORCE, FROZEN, LEAVING, FAULTED = 2, 3, 4, 5, 6
ALARMING: Final = (FROZEN, LEAVING, FAULTED)


@dataclass(frozen=True)
class Event:
    """The state from this time on. `fault` 0: none; `signal`: the column that it is about, "" where there is none."""

    time_s: float
    line: int
    phase: int
    fault: int
    signal: str

    @property
    def alarming(self) -> bool:
        """Whether something is wrong."""
        return self.fault != 0 or self.phase in ALARMING

    def in_words(self) -> str:
        """The phase, and why."""
        return state_in_words(self.phase, self.fault, self.signal)


def word(words: Sequence[str], number: int) -> str:
    """A name by its number; the number itself where there is no name for it."""
    return words[number] if 0 <= number < len(words) else str(number)


def state_in_words(phase: int, fault: int, signal: str) -> str:
    """As "faulted: a signal that jumped (T1_degC)"."""
    about = f" ({signal})" if signal else ""
    if fault:
        return f"{word(PHASES, phase)}: {word(FAULTS, fault)}{about}"
    return word(PHASES, phase) + (about if phase in ALARMING else "")


def signal_name(signals: Sequence[str], place: int) -> str:
    """The column of a signal; "" for −1."""
    if place < 0:
        return ""
    return signals[place] if place < len(signals) else f"signal {place}"


def events(samples: Samples, before: Event | None = None) -> list[Event]:
    """Every change, the state at the beginning first where nothing was `before`."""
    if not len(samples):
        return []
    phase, fault = samples.count("phase"), samples.count("fault")
    about = samples.count("fault_signal")
    same = np.column_stack([np.where(phase == RAMPING, IN_FORCE, phase), fault, about])
    changes = np.flatnonzero(np.any(same[1:] != same[:-1], axis=1)) + 1
    line = samples.count("line")
    found = [
        Event(
            float(samples.time_s[k]),
            int(line[k]),
            int(phase[k]),
            int(fault[k]),
            signal_name(samples.signals, int(about[k])),
        )
        for k in (0, *changes)
    ]
    return found[1:] if before is not None and _same(before, found[0]) else found


def _same(one: Event, other: Event) -> bool:
    settled = {RAMPING: IN_FORCE}
    first, second = (settled.get(event.phase, event.phase) for event in (one, other))
    return (first, one.fault, one.signal) == (second, other.fault, other.signal)
