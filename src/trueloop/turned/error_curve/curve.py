"""The error curve of one feature: the values that users of a fit request.

The uncertainty of the next cut's error, cause by cause.

The width of a band in standard uncertainties.

Written out because the libraries that have it take longer to import than a correction to compute.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trueloop.arrays import Array, by_content
from trueloop.turned.fit.between_cuts import BetweenCuts, NextCut
from trueloop.turned.fit.spline import EndConditions, Spline

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
    return _of_causes(np.hstack([_causes(budget) for budget in budgets]), budgets[0].degrees_of_freedom)


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


SAME_MM: Final = 1e-9
"""A polynomial that reaches no further than this into a feature is its neighbour's."""


@by_content
@dataclass(frozen=True)
class ErrorCurve:
    """Part error over a feature's arc length, in mm, positive = material left on, with its uncertainty.

    Arc length counts from the feature's start; the curve holds on [0, length] and goes on along its end tangents, which
    is meant for the extrapolation to a displaced junction, not for more. `spline` may run over several features
    joined tangentially; this one begins at `start_mm` of it. `scatter_mm` is the standard deviation of single errors
    about the curve, from `degrees_of_freedom` spare touches (None: no touch to spare, taken from the gauging alone).
    `repeatability_mm` is the next cut's own; where the part's z is taken from a touch, that of the next cut scatters as
    well, and the coefficients follow it by `reference`. `between_cuts` is what sets the next cut apart from the one
    that was touched;
    `probe_share` is the probe's part of the touches' variance. Without `touches` on the feature or on those it runs on
    from, the curve is an estimate; where the touches say nothing of it at all it is `unsupported`, and zero.
    `knot_every` is r of [6517 Eq. 5]; `notes` say in words how the curve came about. `next_cut` is what earlier parts
    and these touches say of the next cut, whose uncertainty is then known as a whole; None: nothing. `from_memory`: the
    curve itself is from there, and not through the touches.
    """

    feature: str
    length_mm: float
    spline: Spline
    start_mm: float
    conditions: EndConditions
    knot_every: int | None
    scatter_mm: float
    repeatability_mm: float
    reference: Array | None
    between_cuts: BetweenCuts
    probe_share: float
    touches: int
    unsupported: bool
    degrees_of_freedom: int | None
    notes: tuple[str, ...]
    next_cut: NextCut | None = None
    from_memory: bool = False

    def value_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the part error at arc lengths of shape (n,) or a number, → (n,)."""
        return self.spline.of(self.spline.value_form(*self._stretch(arc_length_mm)))

    def expected_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the error of the next cut had nothing been corrected, (n,): the curve, or what is remembered."""
        if self.next_cut is None:
            return self.value_mm(arc_length_mm)
        return self.next_cut.expected_mm(self._stretch(arc_length_mm)[0])

    @property
    def gain(self) -> float:
        """Returns the expected effect of a correction of 1."""
        return 1.0 if self.next_cut is None else self.next_cut.gain

    def slope(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the change of the error along the feature, mm per mm, (n,)."""
        return self.spline.of(self.spline.slope_form(*self._stretch(arc_length_mm)))

    def standard_deviation_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the standard uncertainty of the curve, (n,): from the touches' scatter (or gauging) and prescribed
        end values.

        Beyond the last touch it grows with the uncertainty of the slope there, and with what the bend may add.
        """
        stretch = self._stretch(arc_length_mm)
        return np.hypot(
            np.sqrt(self.spline.variance(self.spline.value_form(*stretch))), self.spline.drawn_out_u_mm(stretch[0])
        )

    def budget(self, arc_length_mm: ArrayLike) -> Budget:
        """Returns the standard uncertainty of the next cut's error about the curve cause by cause.

        The curve, the process along the cut, and what differs between the two cuts, as known or assumed. A change of
        tool, of feed or of the depth of cut is not in it.
        """
        return self.budget_of(self.standard_deviation_mm(arc_length_mm), arc_length_mm)

    def budget_of(self, curve_u_mm: Array, arc_length_mm: ArrayLike) -> Budget:
        """Returns the budget where the part taken out has these standard uncertainties, (n,), not the curve's."""
        if self.next_cut is not None:
            return remembered_only(self.next_cut.u_mm(self._stretch(arc_length_mm)[0]), self.degrees_of_freedom)
        # By how much the curve follows the touch that the part's z is taken from, (n,)
        form = self.spline.value_form(*self._stretch(arc_length_mm))
        share = np.zeros(len(form.first)) if self.reference is None else form.of(self.reference)
        with_reference = np.hypot(1.0, share)
        along_x = np.sqrt(np.maximum(1.0 - share**2, 0.0))  # what moves a whole cut along z moves its reference as well
        known = float(self.touches > 0)
        every = np.ones_like(curve_u_mm)
        return Budget(
            probe_mm=known * np.sqrt(self.probe_share) * curve_u_mm,
            curve_mm=known * np.sqrt(1.0 - self.probe_share) * curve_u_mm,
            process_mm=self.repeatability_mm * with_reference * every,
            common_mm=self.between_cuts.common_difference_mm * along_x * every,
            along_mm=self.between_cuts.scatter_difference_mm * with_reference * every,
            estimate_mm=(1.0 - known) * curve_u_mm,
            degrees_of_freedom=self.degrees_of_freedom,
        )

    def coefficient_rows(self, arc_length_mm: ArrayLike) -> Array:
        """Returns by how much the error at arc lengths follows the spline's coefficients, (n, coefficients)."""
        return self.spline.value_form(*self._stretch(arc_length_mm)).dense(len(self.spline.coefficients_mm))

    def drawn_out_u_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the standard uncertainty of the error that the curve's bend may add beyond the last touch, (n,)."""
        return self.spline.drawn_out_u_mm(self._stretch(arc_length_mm)[0])

    def half_band_mm(self, arc_length_mm: ArrayLike, coverage: float = COVERAGE) -> Array:
        """Returns the half width of the band that holds the curve with the given probability at each point, (n,).

        k times the standard uncertainty, k from Student's distribution: few touches, wider band.
        """
        return student_t_factor(coverage, self.degrees_of_freedom) * self.standard_deviation_mm(arc_length_mm)

    @property
    def knots_mm(self) -> Array:
        """Returns the spline's knots strictly inside the feature, from its start; repeated ones stand once."""
        knots = np.unique(self.spline.interior_knots_mm) - self.start_mm
        return knots[(knots > 0.0) & (knots < self.length_mm)]

    @cached_property
    def pieces(self) -> tuple[Array, Array]:
        """Begins of the polynomial pieces from the feature's start, (m,), and coefficients (m, 4) in mm.

        On piece j the error is Σₖ c[j, k]·(s − begin[j])ᵏ: [6517 Eq. 29–33] about each piece's own beginning.
        """
        begins, coefficients = self.spline.pieces()
        ends = np.append(begins[1:], self.spline.length_mm)
        inside = (ends > self.start_mm + SAME_MM) & (begins < self.start_mm + self.length_mm - SAME_MM)
        return begins[inside] - self.start_mm, coefficients[inside]

    def _stretch(self, arc_length_mm: ArrayLike) -> tuple[Array, float, float]:
        end_mm = min(self.start_mm + self.length_mm, self.spline.length_mm)
        return np.asarray(arc_length_mm, dtype=np.float64) + self.start_mm, self.start_mm, end_mm
