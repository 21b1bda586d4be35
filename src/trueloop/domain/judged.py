"""Characteristics judged: inside the limits or not, before the correction and as expected after it."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from trueloop.domain.characteristic import Characteristic

Verdict: TypeAlias = Literal["in", "out", "undecided"]
"""By ISO 14253-1: proven inside, proven outside, or neither with the stated uncertainty."""


@dataclass(frozen=True)
class Judgement:
    """One value of a characteristic held against its limits; mm, of angles degrees.

    `standard_u` is the standard uncertainty of `value` with `degrees_of_freedom` (None: as good as infinite).
    `probability_in` is that of being inside the limits; `margin` the distance to the nearer limit, negative outside.
    Without limits there is nothing to judge: all three are None.
    """

    value: float
    standard_u: float
    degrees_of_freedom: int | None
    probability_in: float | None
    margin: float | None
    verdict: Verdict | None


@dataclass(frozen=True)
class Judged:
    """One characteristic: `before` of the part as it was measured, `after` as expected of the next cut.

    `before` is None where the part was measured before its finish cut, so that it has the allowance left on.
    """

    characteristic: Characteristic
    before: Judgement | None
    after: Judgement
