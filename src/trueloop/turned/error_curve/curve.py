"""The error curve of one feature: the values that users of a fit request."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array, by_content
from trueloop.turned.error_curve.budget import COVERAGE, Budget, remembered_only, student_t_factor
from trueloop.turned.fit.between_cuts import BetweenCuts, NextCut
from trueloop.turned.fit.spline import EndConditions, Spline

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
        """Returns the error that the next cut would have had nothing been corrected, (n,): the curve, or the remembered
        error.
        """
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
        """Returns the budget where the part taken out has these standard uncertainties, (n,), instead of the
        curve's.
        """
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
        """Returns the spline's knots strictly inside the feature, from the feature's start; repeated ones stand
        once.
        """
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
