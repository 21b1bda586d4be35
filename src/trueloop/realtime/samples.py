"""The record of every servo period of a run: commands, what was added to them by cause, signals, state, times.

A row is one period: drive = command + correction in each; all else is the corrector's input, state and output in it.
docs/realtime-samples.md describes each column.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

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


def joined(parts: Sequence[Samples]) -> Samples:
    """Parts of one record, one after the other."""
    first = parts[0]
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in first.columns}
    return Samples(first.period_s, first.axes, first.signals, columns)
