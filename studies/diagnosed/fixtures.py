"""Repeats at one point right after fixturing: part, tool probe or part probe, sound, loose, drifting or slipping."""

from enum import StrEnum

import numpy as np

from trueloop.arrays import Array


class Unsteady(StrEnum):
    """What is wrong with a fixturing [4773 §4.1]; sizes are those of `repeats`."""

    NOTHING = "nothing"
    SPREAD = "spread"  # standard deviation beside the probe's own
    DRIFT = "drift"  # from the first repeat to the last
    STEP = "step"  # once, somewhere between


def repeats(what: Unsteady, size_mm: float, count: int, probe_mm: float, seed: int = 0) -> Array:
    """`count` readings of one point, mm, about an unknown place."""
    rng = np.random.default_rng(seed)
    found = rng.normal(0.0, 0.02) + rng.normal(0.0, probe_mm, count)
    if what is Unsteady.SPREAD:
        found = found + rng.normal(0.0, size_mm, count)
    elif what is Unsteady.DRIFT:
        found = found + size_mm * np.arange(count) / max(count - 1, 1)
    elif what is Unsteady.STEP:
        found = found + size_mm * (np.arange(count) >= rng.integers(2, max(count - 1, 3)))
    read: Array = np.asarray(found, dtype=np.float64)
    return read
