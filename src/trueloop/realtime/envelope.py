"""A long record as few numbers that hide nothing: the least and the largest value of each stretch of time.

A stretch is as long as a pixel or so; every spike of a single period is seen. Stretches grow as the record does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers, by_content
from trueloop.realtime.samples import Samples

MOST: Final = 1200
"""Stretches at most; at that many, two become one."""


@by_content
@dataclass(frozen=True)
class Envelope:
    """`low` and `high` (columns, stretches) of `names`; a stretch begins at its number times `step_s`.

    Where nothing was recorded, or what is not a number, both are NaN.
    """

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
