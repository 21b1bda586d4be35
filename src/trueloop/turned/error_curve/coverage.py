"""The width of a band in standard uncertainties.

Written out because the libraries that have it take longer to import than a correction to compute.
"""

import math
from collections.abc import Callable
from typing import Final

COVERAGE: Final = 0.95
"""Share that every band and every ± is to hold."""


def coverage_factor(degrees_of_freedom: int | None = None) -> float:
    """Returns k of an expanded uncertainty: so many standard uncertainties, by the spare touches, hold 95 %."""
    return student_t_factor(COVERAGE, degrees_of_freedom)


def student_t_factor(coverage: float, degrees_of_freedom: int | None) -> float:
    """Returns k with P(|t| ≤ k) = coverage for Student's distribution; None, or more than 1000 degrees: the normal one.

    From the closed forms of the distributions (Abramowitz & Stegun 26.7.3–4), to 1e-9. Raises ValueError for a coverage
    outside (0, 1).
    """
    if not 0.0 < coverage < 1.0:
        raise ValueError(f"a coverage of {coverage} is no probability between 0 and 1")
    if degrees_of_freedom is None or degrees_of_freedom > 1000:
        return _root(lambda k: math.erf(k / math.sqrt(2.0)), _normal_density, coverage)
    if degrees_of_freedom == 1:
        return math.tan(math.pi * coverage / 2.0)
    nu = degrees_of_freedom
    theta = _root(lambda angle: _within(angle, nu), lambda angle: _density(angle, nu), coverage)
    return math.sqrt(nu) * math.tan(theta)


def _root(probability: Callable[[float], float], density: Callable[[float], float], coverage: float) -> float:
    """Solves by Newton's iteration from zero: the probability of |x| ≤ k is concave in k: it never overshoots."""
    k = 0.0
    for _ in range(200):
        step = (coverage - probability(k)) / density(k)
        k += step
        if abs(step) < 1e-13:
            break
    return k


def _normal_density(k: float) -> float:
    return math.sqrt(2.0 / math.pi) * math.exp(-k * k / 2.0)


def _within(theta: float, nu: int) -> float:
    """Returns P(|t| ≤ √ν tan θ), in the angle θ = atan(t/√ν)."""
    cosine, total = math.cos(theta), 0.0
    odd = nu % 2
    term = cosine if odd else 1.0
    for k in range(odd, nu - 1, 2):
        total += term
        term *= cosine * cosine * (k + 1) / (k + 2)
    series = math.sin(theta) * total
    return 2.0 * (theta + series) / math.pi if odd else series


def _density(theta: float, nu: int) -> float:
    """Returns the derivative of `_within` with respect to θ."""
    log_peak = math.lgamma((nu + 1) / 2.0) - math.lgamma(nu / 2.0) - 0.5 * math.log(math.pi)
    return float(2.0 * math.exp(log_peak) * math.cos(theta) ** (nu - 1))
