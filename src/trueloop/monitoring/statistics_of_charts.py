"""The statistics that charts plot, from values in units of their standard deviation about their centre.

All functions work along the last axis, so that many series are charted at once, as in simulations of run lengths.
"""

from typing import Final

import numpy as np

from trueloop.arrays import Array

FAST_START: Final = 0.0
"""The start of both sums of a CUSUM: at zero, without head start."""


def moving_range(z: Array) -> Array:
    """Differences of neighbours without sign, one fewer than values."""
    return np.abs(np.diff(z, axis=-1))


def ewma(z: Array, weight: float) -> Array:
    """Returns the exponentially weighted average from the centre: y = (1 − weight)·y + weight·z [Roberts 1959]."""
    from scipy.signal import lfilter

    filtered: Array = lfilter([weight], [1.0, weight - 1.0], z, axis=-1)
    return filtered


def ewma_sigma(weight: float, count: int) -> Array:
    """Returns the standard deviation of that average at the first `count` values, for deviation 1, (count,)."""
    k = np.arange(1, count + 1)
    sigma: Array = np.sqrt(weight / (2.0 - weight) * (1.0 - (1.0 - weight) ** (2 * k)))
    return sigma


def cusum(z: Array, allowance: float) -> tuple[Array, Array]:
    """Returns the sums of a tabular CUSUM, upwards and downwards, ≥ 0 [Page 1954]: S = max(0, S ± z − allowance)."""
    up, down = np.zeros_like(z), np.zeros_like(z)
    above = below = np.full(z.shape[:-1], FAST_START)
    for k in range(z.shape[-1]):
        above = np.maximum(0.0, above + z[..., k] - allowance)
        below = np.maximum(0.0, below - z[..., k] - allowance)
        up[..., k], down[..., k] = above, below
    return up, down
