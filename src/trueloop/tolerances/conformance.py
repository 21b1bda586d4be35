"""Judges whether a value is inside its limits, with its uncertainty: ISO 14253-1.

The default rule of ISO 14253-1:2017 asks for a probability of 95 %: a size is proven in where it is inside both limits
by the guard band g = k·u, proven out where it is outside one of them by g, and else undecided. k is one-sided: 1.645,
or Student's quantile of 95 % where u is known from few degrees of freedom. Valid for values whose error is about
normal; a zone narrower than 2g proves nothing to be in.
"""

from typing import Final

from scipy.special import stdtr, stdtrit

from trueloop.domain.characteristic import Judgement, Verdict

PROVEN: Final = 0.95
"""One-sided probability with which a value has to be inside, or outside, a limit."""
AS_NORMAL: Final = 1e9
"""Degrees of freedom at which Student's distribution is the normal one, to 1e-9."""


def judge(
    value: float,
    standard_u: float,
    degrees_of_freedom: int | None = None,
    lower: float | None = None,
    upper: float | None = None,
) -> Judgement:
    """A value against absolute limits, in one unit; None: free on that side. Without any there is no verdict."""
    guard = guard_band(standard_u, degrees_of_freedom)
    margins = [*([] if lower is None else [value - lower]), *([] if upper is None else [upper - value])]
    margin = min(margins, default=None)
    if margin is None:
        return Judgement(
            value=value,
            standard_u=standard_u,
            degrees_of_freedom=degrees_of_freedom,
            probability_in=None,
            margin=None,
            verdict=None,
        )
    return Judgement(
        value=value,
        standard_u=standard_u,
        degrees_of_freedom=degrees_of_freedom,
        probability_in=probability_between(value, standard_u, degrees_of_freedom, lower, upper),
        margin=margin,
        verdict=_verdict(margin, guard),
    )


def guard_band(standard_u: float, degrees_of_freedom: int | None = None) -> float:
    """The g = k·u by which a value has to be inside a limit, in the unit of u."""
    return float(stdtrit(degrees_of_freedom or AS_NORMAL, PROVEN)) * standard_u


def probability_between(
    value: float, standard_u: float, degrees_of_freedom: int | None, lower: float | None, upper: float | None
) -> float:
    """P(lower ≤ true value ≤ upper): Student's distribution about the value. Without uncertainty it is 0 or 1."""
    if standard_u == 0.0:
        return float((lower is None or lower <= value) and (upper is None or value <= upper))
    freedom = degrees_of_freedom or AS_NORMAL
    below_upper = 1.0 if upper is None else float(stdtr(freedom, (upper - value) / standard_u))
    below_lower = 0.0 if lower is None else float(stdtr(freedom, (lower - value) / standard_u))
    return max(below_upper - below_lower, 0.0)


def _verdict(margin: float, guard: float) -> Verdict:
    if margin >= guard:
        return "in"
    return "out" if margin < -guard else "undecided"
