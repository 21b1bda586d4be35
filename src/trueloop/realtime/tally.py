"""Counts of each value: exact quantiles of a run of any length, in the memory that its different values take."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, Integers, by_content


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
