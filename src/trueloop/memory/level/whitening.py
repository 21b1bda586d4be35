"""A monitor of corrections by the signs of the remaining errors.

[4773 §2.5] warns of adjustments that "change their sign and steadily increase", and asks for a smaller weight; §3.5 has
the weight of a correction that changes its sign over several iterations reduced "by a standard percentage", and
increased where its value changes very little. Where the weight is right, what is left is white: a sign is as likely to
change as not.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.wording import wording

REDUCED: Final = 0.8
"""The factor by which a weight is multiplied, or divided to increase it: the standard percentage is 20 %."""
LEAST: Final = 0.1
LATEST: Final = 12
"""Pairs of parts that the monitor looks at, and as many as it needs."""
SUSPECT: Final = 0.01
"""The probability of signs as uneven by chance below which the monitor reports them."""


@dataclass(frozen=True)
class Whiteness:
    """The evidence that the signs of the latest innovations give of the weight. `agreeing` of `pairs` neighbours have
    the same sign; `probability` is that of an outcome as uneven by chance. `says` is empty where nothing is suspect.
    """

    pairs: int
    agreeing: int
    probability: float
    says: str = ""


def monitor(innovations: Array) -> Whiteness:
    """Tests the latest innovations of a series, (parts,): those of a right model are white.

    With fewer than twelve pairs nothing is reported: the probability is 1. Counts beyond chance are by the binomial
    distribution, two-sided. It notices a weight that is far off, not what a single part shows: see `memory.noticing`.
    """
    signs = np.sign(innovations[np.isfinite(innovations) & (innovations != 0)])[-LATEST - 1 :]
    same = signs[1:] == signs[:-1]
    seen = Whiteness(len(same), int(same.sum()), 1.0)
    if len(same) < LATEST:
        return seen
    from scipy.stats import binomtest

    seen = replace(seen, probability=float(binomtest(seen.agreeing, seen.pairs).pvalue))
    if seen.probability >= SUSPECT:
        return seen
    said = (
        wording("what is left keeps its sign: more of it could be corrected")
        if seen.agreeing > seen.pairs / 2
        else wording("what is left changes its sign from part to part: too much of it is corrected")
    )
    return replace(seen, says=said)
