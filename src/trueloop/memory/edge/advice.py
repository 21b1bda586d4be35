"""The number of today's touches that would have been enough."""

from typing import Final

import numpy as np

from trueloop.arrays import Array

NEARLY: Final = 1.1
"""Standard uncertainties that are at most so many times those of all touches count as good as these."""


def enough_touches(covariance_mm2: Array, touches: int) -> int:
    """Returns the least number of touches, placed one by one where they help most, that would have been enough.

    `covariance_mm2` is that of the touches, first, and of the finish errors, before a touch is known. The touch is
    taken next that leaves the least sum of variances; enough are those whose root of it is within 10 % of that of all.
    """
    rest, left = covariance_mm2, list(range(touches))
    variance = [float(np.trace(rest[touches:, touches:]))]
    while left:
        best = max(left, key=lambda k: _helps(rest, k, touches))
        left.remove(best)
        rest = _after(rest, best)
        variance.append(float(np.trace(rest[touches:, touches:])))
    return next(count for count, value in enumerate(variance) if value <= NEARLY**2 * variance[-1])


def _helps(covariance: Array, k: int, touches: int) -> float:
    """Returns by how much touch k, once known, lowers the sum of variances of the finish errors."""
    return float(np.sum(covariance[touches:, k] ** 2) / covariance[k, k])


def _after(covariance: Array, k: int) -> Array:
    """Returns the covariance once value k is known."""
    return np.asarray(covariance - np.outer(covariance[:, k], covariance[k]) / covariance[k, k])
