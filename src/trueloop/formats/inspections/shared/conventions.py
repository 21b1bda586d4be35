"""Signs that a file does not state, found by what its numbers have in common."""

from typing import Final, Literal, TypeAlias

import numpy as np

from trueloop.arrays import Array

Deviation: TypeAlias = Literal["actual - nominal", "nominal - actual"]
LowerTolerance: TypeAlias = Literal["with its sign", "without its sign"]
MOST_OF: Final = 0.9
"""Share of the rows that must agree: a row that was typed wrongly does not change the sign of all others."""


def deviation_sign(actual: Array, nominal: Array, deviation: Array, rounding: Array | float) -> Deviation | None:
    """How deviations are counted, from rows that state all three, (n,) each, nan where they do not; None: unknown.

    Rows that agree with both signs, such as deviations of 0, say nothing.
    """
    computed = actual - nominal
    same, opposite = np.abs(deviation - computed) <= rounding, np.abs(deviation + computed) <= rounding
    plus, minus = int(np.sum(same & ~opposite)), int(np.sum(opposite & ~same))
    if plus > MOST_OF * (plus + minus):
        return "actual - nominal"
    if minus > MOST_OF * (plus + minus):
        return "nominal - actual"
    return None


def lower_tolerance_sign(
    upper: Array, lower: Array, deviation: Array | None = None, good: Array | None = None
) -> LowerTolerance | None:
    """Whether lower tolerances are printed with their sign, (n,) each, nan where not stated; None: cannot be known.

    Where one is negative, signs are printed. A zone has a width: of `0.05 0.05` the second is without its sign. Of
    `0.05 0.02`, which may be either, deviations of parts whose verdict `good` (1 or 0, nan where not stated) is known
    tell.
    """
    stated = ~(np.isnan(upper) | np.isnan(lower)) & (lower != 0)
    if not np.any(stated):
        return "with its sign"
    up, low = upper[stated], lower[stated]
    if np.any(low < 0):
        return "with its sign"
    signed, unsigned = bool(np.all(low < up)), bool(np.all(-low < up))
    if signed and unsigned and deviation is not None and good is not None:
        dev, verdict = deviation[stated], good[stated]
        known = ~(np.isnan(dev) | np.isnan(verdict))
        inside, inside_unsigned = (low <= dev) & (dev <= up), (-low <= dev) & (dev <= up)
        signed = bool(np.all((inside == (verdict > 0))[known]))
        unsigned = bool(np.all((inside_unsigned == (verdict > 0))[known]))
    if signed == unsigned:
        return None
    return "with its sign" if signed else "without its sign"
