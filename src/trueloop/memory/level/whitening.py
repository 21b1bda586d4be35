"""The weight by the signs of the remaining errors: for series without a model, and as a monitor beside one.

[4773 §2.5] warns of adjustments that "change their sign and steadily increase", and asks for a smaller weight; §3.5 has
the weight of a correction that changes its sign over several iterations reduced "by a standard percentage", and
increased where its value changes very little. Where the weight is right, what is left is white: a sign is as likely to
change as not. Two changes in a row and two times the same sign are then equally likely, a quarter of parts each, and
the weight stays about where it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.memory.level.step import PartReading, Step, Weight
from trueloop.wording import wording

FIRST: Final = 0.75
"""The first weight: of those "between 0.50 and 0.75" [4773 §2.5], that of its Fig. 9."""
REDUCED: Final = 0.8
"""The factor by which a weight is multiplied, or divided to increase it: the standard percentage is 20 %."""
LEAST: Final = 0.1
LATEST: Final = 12
"""Pairs of parts that the monitor looks at, and as many as it needs."""
SUSPECT: Final = 0.01
"""The probability of signs as uneven by chance below which the monitor reports them."""


def next_weight(weight: Array | float, signs: Array) -> Array:
    """Returns the weight after parts whose errors have had these signs, (…, parts), the latest last; weights (…)."""
    if signs.shape[-1] < 3:
        return np.asarray(weight, float) * np.ones(signs.shape[:-1])
    same = signs[..., -3:-1] * signs[..., -2:]
    changed, stayed = (same < 0).all(axis=-1), (same > 0).all(axis=-1)
    factor = np.where(changed, REDUCED, np.where(stayed, 1 / REDUCED, 1.0))
    return np.asarray(np.clip(weight * factor, LEAST, 1.0))


def whitened_steps(readings: Sequence[PartReading], first: float = FIRST) -> tuple[Step, ...]:
    """Returns one step a part, in the order in which they were cut: C moves by weight times the error that is left.

    Signs of before a setting of the tool count no more. A part in quarantine moves nothing.
    """
    weight, signs = first, np.empty(0)
    done: list[Step] = []
    for reading in readings:
        before, reason = weight, str(wording("in quarantine: nothing is learned from this part"))
        if reading.counts:
            signs = np.append(np.empty(0) if reading.set_before else signs, np.sign(reading.error_mm))
            weight = float(next_weight(weight, signs))
            reason = _reason(weight, before, signs)
        change = weight * reading.error_mm if reading.counts else 0.0
        moved = Weight(weight if reading.counts else 0.0, before if done else None, reason)
        done.append(Step(reading.correction_mm + change, change, moved, reading.error_mm - change))
    return tuple(done)


def _reason(weight: float, before: float, signs: Array) -> str:
    if weight < before:
        return wording("the sign of the error changed twice in a row: the correction overshoots")
    if weight > before:
        return wording("the error kept its sign three times: the correction falls short")
    return wording("first parts: too few signs to judge by") if len(signs) < 3 else wording("as before")


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
