"""How many standard uncertainties a band must be wide."""

import math
from statistics import NormalDist


def student_t_factor(coverage: float, degrees_of_freedom: int | None) -> float:
    """The k with P(|t| ≤ k) = coverage for Student's distribution; None or many degrees of freedom: the normal one.

    Newton's iteration on the closed form of the distribution (Abramowitz & Stegun 26.7.3–4), to 1e-9.

    Raises ValueError for a coverage outside (0, 1).
    """
    if not 0.0 < coverage < 1.0:
        raise ValueError(f"a coverage of {coverage} is no probability between 0 and 1")
    normal = NormalDist().inv_cdf((1.0 + coverage) / 2.0)
    if degrees_of_freedom is None or degrees_of_freedom > 1000:
        return normal
    if degrees_of_freedom == 1:
        return math.tan(math.pi * coverage / 2.0)
    # In the angle θ = atan(t/√ν) the distribution is concave, so that Newton from below cannot overshoot.
    theta = math.atan(normal / math.sqrt(degrees_of_freedom))
    for _ in range(100):
        step = (coverage - _within(theta, degrees_of_freedom)) / _density(theta, degrees_of_freedom)
        theta += step
        if abs(step) < 1e-12:
            break
    return math.sqrt(degrees_of_freedom) * math.tan(theta)


def _within(theta: float, nu: int) -> float:
    """P(|t| ≤ √ν tan θ)."""
    cosine, term, total = math.cos(theta), 1.0, 0.0
    odd = nu % 2
    if odd:
        term = cosine
    for k in range(odd, nu - 1, 2):
        total += term
        term *= cosine * cosine * (k + 1) / (k + 2)
    series = math.sin(theta) * total
    return 2.0 * (theta + series) / math.pi if odd else series


def _density(theta: float, nu: int) -> float:
    """Derivative of `_within` with respect to θ."""
    log_peak = math.lgamma((nu + 1) / 2.0) - math.lgamma(nu / 2.0) - 0.5 * math.log(math.pi)
    return float(2.0 * math.exp(log_peak) * math.cos(theta) ** (nu - 1))
