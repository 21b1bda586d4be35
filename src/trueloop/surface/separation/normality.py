"""Tests whether residuals follow a normal law: Kolmogorov–Smirnov as published, and Lilliefors, which is the right form
here.

The Kolmogorov–Smirnov test asks for a law known beforehand. With mean and scatter taken from the residuals themselves
its p-values are far too large, and it hardly ever rejects; Lilliefors (1967) is the same distance judged rightly.
"""

from dataclasses import dataclass
from math import exp, sqrt

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code


@dataclass(frozen=True)
class Normality:
    """The largest distance between the two distribution functions, and what it means under either test."""

    distance: float
    ks_p: float
    lilliefors_p: float


def normality(values: Array) -> Normality:
    """Both tests on values (n,), n ≥ 5, mean and scatter estimated. Raises SRF-MODEL for values all alike."""
    from scipy.special import kolmogorov, ndtr  # slow to import

    n, scatter = len(values), float(np.std(values, ddof=1))
    if n < 5 or not scatter > 0:
        raise Code.SRF_MODEL.refusal(
            f"{n} residuals that scatter by {scatter:g} mm follow no law",
            hint="the model goes through every point: ask for fewer control points, or measure more",
        )
    law = ndtr(np.sort((values - np.mean(values)) / scatter))
    steps = np.arange(n + 1) / n
    distance = float(max(np.max(steps[1:] - law), np.max(law - steps[:-1])))
    return Normality(distance, float(kolmogorov(sqrt(n) * distance)), lilliefors_p(distance, n))


def lilliefors_p(distance: float, n: int) -> float:
    """p-value: the formula of Dallal & Wilkinson (1986) up to 0.1, beyond it polynomials to Stephens' modified
    statistic (1974), as statistics packages use them; good to a tenth of itself in the range where decisions fall.
    """
    d, m = (distance, float(n)) if n <= 100 else (distance * (n / 100) ** 0.49, 100.0)
    p = exp(
        -7.01256 * d * d * (m + 2.78019) + 2.99587 * d * sqrt(m + 2.78019) - 0.122119 + 0.974598 / sqrt(m) + 1.67997 / m
    )
    if p <= 0.1:
        return p
    k = (sqrt(n) - 0.01 + 0.85 / sqrt(n)) * distance
    for upper, coefficients in (
        (0.302, (1.0,)),
        (0.5, (2.76773, -19.828315, 80.709644, -138.55152, 81.218052)),
        (0.9, (-4.901232, 40.662806, -97.490286, 94.029866, -32.355711)),
        (1.31, (6.198765, -19.558097, 23.186922, -12.234627, 2.423045)),
    ):
        if k <= upper:
            return min(1.0, max(0.0, sum(c * k**power for power, c in enumerate(coefficients))))
    return 0.0
