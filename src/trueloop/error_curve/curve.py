"""The error curve of one feature: what a user asks of a fit."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from trueloop.error_curve.coverage import COVERAGE, student_t_factor
from trueloop.error_curve.spline import EndConditions, Spline
from trueloop.geometry.feature import Array


@dataclass(frozen=True)
class ErrorCurve:
    """Part error over a feature's arc length, in mm, positive = material left on, with its uncertainty.

    Arc length counts from the feature's start; the curve holds on [0, length] and goes on along its end tangents, which
    is meant for the extrapolation to a displaced junction, not for more. `spline` may run over several features
    joined tangentially; this one begins at `start_mm` of it. `scatter_mm` is the standard deviation of single errors
    about the curve, from `degrees_of_freedom` spare touches (None: no touch to spare, taken from the gauging alone).
    `knot_every` is r of [6517 Eq. 5]; `notes` say in words how the curve came about.
    """

    feature: str
    length_mm: float
    spline: Spline
    start_mm: float
    conditions: EndConditions
    knot_every: int | None
    scatter_mm: float
    repeatability_mm: float
    degrees_of_freedom: int | None
    notes: tuple[str, ...]

    def value_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Part error at arc lengths of shape (n,) or a number, → (n,)."""
        return self.spline.of(self.spline.value_form(*self._stretch(arc_length_mm)))

    def slope(self, arc_length_mm: ArrayLike) -> Array:
        """Change of the error along the feature, mm per mm, (n,)."""
        return self.spline.of(self.spline.slope_form(*self._stretch(arc_length_mm)))

    def bend_per_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Second derivative of the error along the feature, mm per mm², (n,)."""
        s = np.clip(np.atleast_1d(np.asarray(arc_length_mm, dtype=np.float64)), 0.0, self.length_mm)
        begins, c = self.pieces
        j = np.maximum(np.searchsorted(begins, s, side="right") - 1, 0)
        bend: Array = 2.0 * c[j, 2] + 6.0 * c[j, 3] * (s - begins[j])
        return bend

    def standard_deviation_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Standard uncertainty of the curve, (n,): from the touches' scatter (or gauging) and prescribed end values."""
        return np.sqrt(self.spline.variance(self.spline.value_form(*self._stretch(arc_length_mm))))

    def slope_standard_deviation(self, arc_length_mm: ArrayLike) -> Array:
        """Standard uncertainty of the slope, mm per mm, (n,)."""
        return np.sqrt(self.spline.variance(self.spline.slope_form(*self._stretch(arc_length_mm))))

    def prediction_standard_deviation_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Standard uncertainty of the next cut's error about the curve, (n,).

        Variance of the curve plus that of the process from cut to cut. It knows nothing of drift: a worn edge, a warmer
        machine or another depth of cut are not in it.
        """
        return np.hypot(self.standard_deviation_mm(arc_length_mm), self.repeatability_mm)

    def half_band_mm(self, arc_length_mm: ArrayLike, coverage: float = COVERAGE) -> Array:
        """Half width of the band that holds the curve with the given probability at each point, (n,).

        k times the standard uncertainty, k from Student's distribution: few touches, wider band.
        """
        return student_t_factor(coverage, self.degrees_of_freedom) * self.standard_deviation_mm(arc_length_mm)

    @property
    def knots_mm(self) -> Array:
        """The spline's knots strictly inside the feature, from the feature's start; repeated ones stand once."""
        knots = np.unique(self.spline.interior_knots_mm) - self.start_mm
        return knots[(knots > 0.0) & (knots < self.length_mm)]

    @cached_property
    def pieces(self) -> tuple[Array, Array]:
        """Begins of the polynomial pieces from the feature's start, (m,), and coefficients (m, 4) in mm.

        On piece j the error is Σₖ c[j, k]·(s − begin[j])ᵏ: [6517 Eq. 29–33] about each piece's own beginning.
        """
        begins, coefficients = self.spline.pieces()
        ends = np.append(begins[1:], self.spline.length_mm)
        inside = (ends > self.start_mm) & (begins < self.start_mm + self.length_mm)
        return begins[inside] - self.start_mm, coefficients[inside]

    def _stretch(self, arc_length_mm: ArrayLike) -> tuple[Array, float, float]:
        end_mm = min(self.start_mm + self.length_mm, self.spline.length_mm)
        return np.asarray(arc_length_mm, dtype=np.float64) + self.start_mm, self.start_mm, end_mm
