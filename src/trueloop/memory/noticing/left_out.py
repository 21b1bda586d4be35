"""Touches that all others contradict: one grain of dirt must not raise an alarm about an edge."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy.special import ndtri

from trueloop.arrays import Array, Integers
from trueloop.estimate.weights import plain
from trueloop.memory.noticing.alarm import LeftOut

CONTRADICTED: Final = 3.0
"""Standard deviations, of up to twenty touches."""
BY_CHANCE_ABOVE: Final = 0.027
"""With more, so that parts with many touches have no more of them left out: expected number above the limit."""
MOST: Final = 2
SHARE: Final = 0.15
"""More contradicted touches than two, or than this share of many, are no accident. Where 2 % of touches are gross,
0.7 % of parts have three or more among twenty, and 0.06 % four.
"""
FOR_TWO, FOR_ONE = 6, 3
"""The least numbers of touches to leave out two and one: fewer do not decide which of them is wrong."""


def kept(error: Array, covariance: Array, points: Sequence[str]) -> tuple[Integers, tuple[LeftOut, ...]]:
    """Indices of the errors that stay, and those left out, the most contradicted first."""
    stay = np.arange(len(error))
    left: list[LeftOut] = []
    while len(left) < _most(len(error)):
        found = plain(covariance[np.ix_(stay, stay)], error[stay])
        z = found.left_out_mm / found.left_out_u_mm
        worst = int(np.argmax(np.abs(z)))
        if abs(z[worst]) <= _contradicted(len(stay)):
            break
        index = int(stay[worst])
        left.append(LeftOut(index, points[index], float(z[worst])))
        stay = np.delete(stay, worst)
    return stay, tuple(left)


def _contradicted(n: int) -> float:
    """Returns the number of standard deviations by which a touch among n has to differ: by chance one of them does so
    in 1 of 37 parts.
    """
    return max(CONTRADICTED, float(ndtri(1.0 - BY_CHANCE_ABOVE / n)))


def _most(n: int) -> int:
    return max(MOST, int(SHARE * n)) if n >= FOR_TWO else 1 if n >= FOR_ONE else 0
