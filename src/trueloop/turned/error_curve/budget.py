"""The uncertainty of the next cut's error, cause by cause.

The width of a band in standard uncertainties.

Written out because the libraries that have it take longer to import than a correction to compute.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, by_content

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


@by_content
@dataclass(frozen=True)
class Budget:
    """Standard uncertainties of the next cut's error about its prediction at n places, all (n,), mm.

    `probe_mm` and `curve_mm`: of the fitted curve, by the probe's repeatability and by how the touched cut scatters;
    `process_mm`: how the next cut scatters by itself. These are known from `degrees_of_freedom` spare touches (None:
    from gauging alone). `common_mm` and `along_mm`: what the next cut does otherwise, as a whole and along itself;
    `estimate_mm`: of a feature without a touch, whose error was estimated. These are stated, not found from touches.
    `memory_mm`: of a next cut that earlier parts tell, everything in it; None: of no place.
    """

    probe_mm: Array
    curve_mm: Array
    process_mm: Array
    common_mm: Array
    along_mm: Array
    estimate_mm: Array
    degrees_of_freedom: int | None
    memory_mm: Array | None = None

    @property
    def found_mm(self) -> Array:
        """Returns the root of squares of the causes determined from touches."""
        return np.hypot(np.hypot(self.probe_mm, self.curve_mm), self.process_mm)

    @property
    def between_cuts_mm(self) -> Array:
        """Returns the root of squares of the differences between the next cut and the one that was touched."""
        return np.hypot(self.common_mm, self.along_mm)

    @property
    def stated_mm(self) -> Array:
        """Returns the root of squares of the causes stated beforehand."""
        stated = np.hypot(self.between_cuts_mm, self.estimate_mm)
        return stated if self.memory_mm is None else np.hypot(stated, self.memory_mm)

    @property
    def standard_u_mm(self) -> Array:
        """Returns the root of squares of all."""
        return np.hypot(self.found_mm, self.stated_mm)

    @property
    def expanded_u_mm(self) -> Array:
        """Returns the half width of the band that holds 95 %: each part times its own k, root of squares.

        Student's k belongs to what few touches tell, the normal one to what is stated. The sum of a Student and a
        normal variable lies within with 95 to 99 %; one k for both would multiply the stated part by up to 12.7.
        """
        return np.hypot(coverage_factor(self.degrees_of_freedom) * self.found_mm, coverage_factor() * self.stated_mm)

    def at(self, places: NDArray[np.intp]) -> "Budget":
        """Returns the budget at some of the places."""
        return _of_causes(_causes(self)[:, places], self.degrees_of_freedom)

    @property
    def alike(self) -> "Budget":
        """Returns the budget were the two cuts alike except in their scatter."""
        zero = np.zeros_like(self.common_mm)
        return replace(self, common_mm=zero, along_mm=zero)

    def with_more(self, curve_mm: Array) -> "Budget":
        """Returns the budget with a further uncertainty of the curve, (n,)."""
        return replace(self, curve_mm=np.hypot(self.curve_mm, curve_mm))


def joined(budgets: Sequence[Budget]) -> Budget:
    """Places of several features as one budget, in their order; all with the same degrees of freedom."""
    return _of_causes(np.hstack([_causes(one) for one in budgets]), budgets[0].degrees_of_freedom)


def remembered_only(standard_u_mm: Array, degrees_of_freedom: int | None) -> Budget:
    """Returns the budget of a next cut predicted from earlier parts, (n,): its uncertainty is known as a whole."""
    zero = np.zeros_like(standard_u_mm)
    return Budget(
        probe_mm=zero,
        curve_mm=zero,
        process_mm=zero,
        common_mm=zero,
        along_mm=zero,
        estimate_mm=zero,
        degrees_of_freedom=degrees_of_freedom,
        memory_mm=standard_u_mm,
    )


def _causes(budget: Budget) -> Array:
    """Returns a row a cause, (7, n)."""
    found = (budget.probe_mm, budget.curve_mm, budget.process_mm)
    memory = np.zeros_like(budget.probe_mm) if budget.memory_mm is None else budget.memory_mm
    return np.stack([*found, budget.common_mm, budget.along_mm, budget.estimate_mm, memory])


def _of_causes(rows: Array, degrees_of_freedom: int | None) -> Budget:
    memory = rows[6] if np.any(rows[6]) else None
    return Budget(
        probe_mm=rows[0],
        curve_mm=rows[1],
        process_mm=rows[2],
        common_mm=rows[3],
        along_mm=rows[4],
        estimate_mm=rows[5],
        degrees_of_freedom=degrees_of_freedom,
        memory_mm=memory,
    )
