"""Pairs of boxes that overlap, found by cells as large as the boxes: memory and time go by the pairs, not by n × n."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array

MOST_PAIRS: Final = 4_000_000
"""Candidates at most at one size of cells; a drawing of a part has a few for each of its lines."""
AT_ONCE: Final = 100_000
"""Candidates compared at a time."""
_LEVELS: Final = 24
"""Sizes of cells, each twice the one before; what is smaller than the smallest counts as of that size."""

Pairs = NDArray[np.int64]


class TooDenseError(ValueError):
    """More than `MOST_PAIRS` boxes lie in the same places."""


def overlapping(low: Array, high: Array, other_low: Array, other_high: Array) -> Pairs:
    """Returns pairs (m, 2), ascending: numbers of a box of the first kind and of one of the second that overlap.

    Boxes are given by their low and their high corners, (n, 2) each. A box lies in at most four cells of its own size
    or a larger one. Raises TooDenseError.
    """
    if not len(low) or not len(other_low):
        return np.zeros((0, 2), dtype=np.int64)
    everything = np.concatenate([low, high, other_low, other_high])
    origin, span = everything.min(axis=0), float(np.max(np.ptp(everything, axis=0)))
    smallest = max(span, 1e-9) / 2**_LEVELS
    levels, other_levels = (_levels(*each, smallest) for each in ((low, high), (other_low, other_high)))
    found = [np.zeros(0, dtype=np.int64)]
    for level in np.union1d(levels, other_levels).tolist():
        size = smallest * 2.0**level
        for mine, theirs in ((levels == level, other_levels <= level), (levels < level, other_levels == level)):
            a, b = np.flatnonzero(mine), np.flatnonzero(theirs)
            cells = _cells(low[a], high[a], origin, size), _cells(other_low[b], other_high[b], origin, size)
            for i, j in _joined(a, cells[0], b, cells[1]):
                meet = np.all((low[i] <= other_high[j]) & (other_low[j] <= high[i]), axis=1)
                found.append(i[meet] * len(other_low) + j[meet])
    number = np.sort(np.concatenate(found))  # `np.unique` takes eight times as long
    return np.stack(np.divmod(number[np.diff(number, prepend=-1) > 0], len(other_low)), axis=1)


def _levels(low: Array, high: Array, smallest: float) -> NDArray[np.int64]:
    size = np.max(high - low, axis=1)
    levels: NDArray[np.int64] = np.ceil(np.log2(np.maximum(size / smallest, 1.0))).astype(np.int64)
    return levels


def _cells(low: Array, high: Array, origin: Array, size: float) -> NDArray[np.int64]:
    """Keys (n, 4) of the cells of the four corners; −1 for one that is there already."""
    (x0, z0), (x1, z1) = (np.floor((corner - origin) / size).astype(np.int64).T for corner in (low, high))
    keys = np.stack([x << 32 | z for x in (x0, x1) for z in (z0, z1)], axis=1)
    keys[x0 == x1, 2:] = -1
    keys[z0 == z1, 1] = -1
    keys[z0 == z1, 3] = -1
    return keys


def _joined(a: Pairs, a_keys: Pairs, b: Pairs, b_keys: Pairs) -> Iterator[tuple[Pairs, Pairs]]:
    """Yields pairs of which one cell is the same, about `AT_ONCE` at a time: memory does not go by their number."""
    (a, a_key), (b, b_key) = _flat(a, a_keys), _flat(b, b_keys)
    order = np.argsort(b_key, kind="stable")
    b, b_key = b[order], b_key[order]
    first, last = np.searchsorted(b_key, a_key, "left"), np.searchsorted(b_key, a_key, "right")
    counts = last - first
    ends = np.cumsum(counts)
    total = int(counts.sum())
    if total > MOST_PAIRS:
        raise TooDenseError(f"more than {MOST_PAIRS} pairs of lines lie in the same places")
    for rows in np.split(np.arange(len(a)), np.searchsorted(ends, np.arange(AT_ONCE, total, AT_ONCE))):
        of = np.repeat(rows, counts[rows])
        if len(of):
            yield a[of], b[last[of] - (ends[of] - ends[of[0]] + counts[of[0]] - np.arange(len(of)))]


def _flat(numbers: Pairs, keys: Pairs) -> tuple[Pairs, Pairs]:
    row, column = np.nonzero(keys >= 0)
    return numbers[row], keys[row, column]
