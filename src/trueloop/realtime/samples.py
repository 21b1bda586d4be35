"""The record of every servo period of a run: commands, what was added to them by cause, signals, state, times.

A row is one period: drive = command + correction in each; all else is the corrector's input, state and output in it.
docs/realtime-samples.md describes each column.

Events of a run in words: faults and changes of phase, with their time and line of the program.

Ramping and in force take turns at every reversal: the two count as one here.

A long record as few numbers that hide nothing: the least and the largest value of each stretch of time.

A stretch is as long as a pixel or so; every spike of a single period is seen. Stretches grow as the record does.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop import _core
from trueloop.arrays import Array, Integers, by_content
from trueloop.units import SIGNALS, UM_PER_MM

AXES: Final = "xyz"
PLACES_MM: Final = ("command", "drive", "tool")
PLACES_UM: Final = ("model", "table", "correction", "following_error")
COUNTS: Final = (
    "line",
    "program",
    "phase",
    "waits_for",
    "fault",
    "signal_fault",
    "fault_signal",
    "on_path",
    "generation",
)
TIMES_NS: Final = ("write_ns", "thread_ns")
UNITS: Final = {unit: suffix for suffix, unit in SIGNALS.items()} | {"degC": "_degC", "rpm": "_rpm"}
"""Endings of a signal's column name, by its unit."""


@by_content
@dataclass(frozen=True)
class Samples:
    """Periods in order, by column: lengths in the unit of the column's name, x a radius, counts as whole numbers.

    `period_s`: length of a servo period. `axes`: those the columns are of, "xz". `signals`: the names of their columns.
    """

    period_s: float
    axes: str
    signals: tuple[str, ...]
    columns: Mapping[str, Array]

    def __len__(self) -> int:
        return len(self.columns["time_s"])

    @property
    def time_s(self) -> Array:
        """Returns the times of the periods since the beginning of the record."""
        return self.columns["time_s"]

    def mm(self, what: str) -> Array:
        """Returns one of PLACES_MM or PLACES_UM, (n, 3) in mm for X, Y, Z; zero for axes that were not recorded."""
        found = np.zeros((len(self), 3))
        for axis in self.axes:
            micrometres = what in PLACES_UM
            column = self.columns[f"{what}_{axis}_{'um' if micrometres else 'mm'}"]
            found[:, AXES.index(axis)] = column / UM_PER_MM if micrometres else column
        return found

    def count(self, what: str) -> Integers:
        """Returns one of COUNTS, (n,)."""
        return self.columns[what].astype(np.int64)

    @property
    def lost(self) -> int:
        """Periods between the first and the last one that were not recorded."""
        whole = round(float(self.time_s[-1] - self.time_s[0]) / self.period_s) + 1 if len(self) else 0
        return whole - len(self)

    def rows(self, chosen: slice | Integers) -> "Samples":
        """Returns the chosen periods."""
        return Samples(
            self.period_s, self.axes, self.signals, {name: column[chosen] for name, column in self.columns.items()}
        )


def column_names(axes: str, signals: Sequence[str]) -> tuple[str, ...]:
    """Returns the names of all columns in their order."""
    of_axes = {
        unit: [f"{what}_{axis}_{unit}" for what in places for axis in axes]
        for unit, places in (("mm", PLACES_MM), ("um", PLACES_UM))
    }
    return ("time_s", *of_axes["mm"], *signals, *of_axes["um"], *COUNTS, "oldest_age_s", *TIMES_NS)


def signal_columns(named: Iterable[tuple[str, str]]) -> tuple[str, ...]:
    """Columns for signals by name and unit: `T1_degC`. What no plain column's name may hold becomes an underscore."""
    taken = set(column_names(AXES, ()))
    found = []
    for name, unit in named:
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "signal"
        suffix = UNITS.get(unit, "")
        column = plain if plain.endswith(suffix) else plain + suffix
        while column in taken:
            column += "_"
        taken.add(column)
        found.append(column)
    return tuple(found)


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


def _same(left: Event, other: Event) -> bool:
    first, second = (IN_FORCE if event.phase == RAMPING else event.phase for event in (left, other))
    return (first, left.reason, left.signal) == (second, other.reason, other.signal)


MOST: Final = 1200
"""Stretches at most; at that many, two become one."""


@by_content
@dataclass(frozen=True)
class Envelope:
    """`low` and `high` (columns, stretches) of `names`; a stretch begins at its number times `step_s`; NaN: none."""

    names: tuple[str, ...]
    step_s: float
    low: Array
    high: Array

    @property
    def time_s(self) -> Array:
        """Returns the middle of each stretch."""
        return np.asarray((np.arange(self.low.shape[1]) + 0.5) * self.step_s, np.float64)

    def of(self, name: str) -> tuple[Array, Array]:
        """Returns the least and the largest values of a column, one of each for every stretch."""
        row = self.names.index(name)
        return self.low[row], self.high[row]


def empty(names: Sequence[str], step_s: float) -> Envelope:
    """Returns an envelope of no periods; `step_s`: the length of a stretch to begin with."""
    none = np.empty((len(names), 0))
    return Envelope(tuple(names), step_s, none, none)


def envelope(samples: Samples, names: Sequence[str], most: int = MOST) -> Envelope:
    """Returns the envelope of a whole record."""
    span = float(samples.time_s[-1]) + samples.period_s if len(samples) else samples.period_s
    return gathered(empty(names, max(samples.period_s, span / most)), samples, most + 1)


def gathered(so_far: Envelope, samples: Samples, most: int = MOST) -> Envelope:
    """Returns the envelope with further periods, none of them earlier than those gathered so far."""
    if not len(samples):
        return so_far
    while samples.time_s[-1] >= most * so_far.step_s:
        so_far = _halved(so_far)
    place = np.floor(samples.time_s / so_far.step_s + 1e-9).astype(np.intp)
    low, high = _widened(so_far, int(place[-1]) + 1)
    starts = np.flatnonzero(np.diff(place, prepend=-1))
    for row, name in enumerate(so_far.names):
        for kept, extreme in ((low, np.fmin), (high, np.fmax)):
            found = extreme.reduceat(samples.columns[name], starts)
            kept[row, place[starts]] = extreme(kept[row, place[starts]], found)
    return Envelope(so_far.names, so_far.step_s, low, high)


def merged(drawn: Envelope, most: int) -> Envelope:
    """Returns the envelope with `most` stretches at most."""
    while drawn.low.shape[1] > most:
        drawn = _halved(drawn)
    return drawn


def _widened(so_far: Envelope, count: int) -> tuple[Array, Array]:
    """Copies with room for `count` stretches."""
    more = ((0, 0), (0, max(0, count - so_far.low.shape[1])))
    low, high = (np.pad(values, more, constant_values=np.nan) for values in (so_far.low, so_far.high))
    return low, high


def _halved(so_far: Envelope) -> Envelope:
    """Two stretches as one."""
    low, high = _widened(so_far, so_far.low.shape[1] + so_far.low.shape[1] % 2)
    low, high = np.fmin(low[:, ::2], low[:, 1::2]), np.fmax(high[:, ::2], high[:, 1::2])
    return Envelope(so_far.names, 2 * so_far.step_s, low, high)


@by_content
@dataclass(frozen=True)
class Tally:
    """Different values in ascending order, and how often each came."""

    values: Array
    counts: Integers

    @property
    def total(self) -> int:
        """Returns the number of values counted."""
        return int(self.counts.sum())

    def quantile(self, share: float) -> float:
        """Returns the least value that this share of all does not exceed; NaN where there are no values."""
        if not len(self.values):
            return float("nan")
        place = np.searchsorted(np.cumsum(self.counts), share * self.total)
        return float(self.values[min(int(place), len(self.values) - 1)])


NONE = Tally(np.empty(0), np.empty(0, np.int64))


def counted(so_far: Tally, values: Array) -> Tally:
    """Returns the tally with further values counted."""
    new, times = np.unique(values, return_counts=True)
    both, place = np.unique(np.concatenate([so_far.values, new]), return_inverse=True)
    counts = np.zeros(len(both), np.int64)
    np.add.at(counts, place, np.concatenate([so_far.counts, times]))
    return Tally(both, counts)
