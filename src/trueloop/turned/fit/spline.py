"""A spline over arc length with prescribed ends and a covariance: what every error curve is made of.

The basis is the clamped B-spline basis: the value at an end is the outermost coefficient, the slope there follows from
the two outermost ones, so that end conditions hold to the last bit. The truncated powers of [6517 Eq. 2] span the same
curves, but lose up to a millimetre at 1,000 points.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trueloop._core import fit_spline, spline_basis
from trueloop.arrays import Array, by_content

THIRDS: Final = np.array([0.0, 1 / 3, 2 / 3, 1.0])


@dataclass(frozen=True)
class EndConditions:
    """The conditions prescribed at the ends: values in mm, slopes in mm per mm; None leaves it free [6517 Eq. 12]."""

    start_value_mm: float | None = None
    start_slope: float | None = None
    end_value_mm: float | None = None
    end_slope: float | None = None

    @property
    def numbers(self) -> tuple[float | None, float | None, float | None, float | None]:
        """Returns value and slope at the start, value and slope at the end."""
        return self.start_value_mm, self.start_slope, self.end_value_mm, self.end_slope

    @property
    def reversed(self) -> "EndConditions":
        """Returns the conditions of a curve that is run from its end to its start: slopes change their sign."""
        start_value, start_slope, end_value, end_slope = self.numbers
        slopes = [None if slope is None else -slope for slope in (end_slope, start_slope)]
        return EndConditions(end_value, slopes[0], start_value, slopes[1])

    @property
    def count(self) -> int:
        """Returns how many numbers are prescribed."""
        return sum(number is not None for number in self.numbers)

    @property
    def coefficients(self) -> int:
        """Returns how many coefficients they take part in: one for a value alone, two for a slope."""
        ends = ((self.start_value_mm, self.start_slope), (self.end_value_mm, self.end_slope))
        return sum(2 if slope is not None else int(value is not None) for value, slope in ends)


@dataclass(frozen=True)
class LinearForm:
    """Numbers that are linear in a spline's coefficients: row q sums `weights[q, k] · c[first[q] + k]`."""

    first: NDArray[np.int64]
    weights: Array

    def of(self, coefficients: Array) -> Array:
        """Returns the numbers, for coefficients of shape (n,) or (n, m)."""
        picked: Array = np.einsum("qk,qk...->q...", self.weights, coefficients[self._columns])
        return picked

    def dense(self, coefficients: int) -> Array:
        """Returns the full rows, (q, coefficients)."""
        rows = np.zeros((len(self.first), coefficients))
        np.put_along_axis(rows, self._columns, self.weights, axis=1)
        return rows

    @property
    def _columns(self) -> NDArray[np.int64]:
        return self.first[:, None] + np.arange(self.weights.shape[1])


@by_content
@dataclass(frozen=True)
class Spline:
    """A piecewise polynomial of degree 0 to 3 on [0, length], in the clamped B-spline basis, with its covariance.

    `interior_knots_mm` ascend; a knot that stands m times has degree − m continuous derivatives. Coefficients i and
    i + k have the covariance `covariance_band_mm2[i, k] + prescribed_mm[i] · prescribed_mm[i + k]`: the first from the
    touches, the second from the uncertainty of prescribed end values and of what is common to all touches, shape
    (n, m). Outside of `supported_mm` (None: the whole interval) the curve goes on along its tangent there.
    """

    interior_knots_mm: Array
    length_mm: float
    degree: int
    coefficients_mm: Array
    covariance_band_mm2: Array
    prescribed_mm: Array
    supported_mm: tuple[float, float] | None = None

    def value_form(self, arc_length_mm: ArrayLike, lower_mm: float = 0.0, upper_mm: float | None = None) -> LinearForm:
        """Values on the stretch [lower, upper]; beyond it along the tangent at its end."""
        s = np.atleast_1d(np.asarray(arc_length_mm, dtype=np.float64))
        lower_mm, upper_mm = self._carried(lower_mm, upper_mm)
        inside = np.clip(s, lower_mm, upper_mm)
        first, values, slopes = self._basis(inside, lower_mm, upper_mm)
        return LinearForm(first, values + (s - inside)[:, None] * slopes)

    def slope_form(self, arc_length_mm: ArrayLike, lower_mm: float = 0.0, upper_mm: float | None = None) -> LinearForm:
        """Slopes, mm per mm, on the stretch [lower, upper]; beyond it the slope at its end."""
        s = np.atleast_1d(np.asarray(arc_length_mm, dtype=np.float64))
        lower_mm, upper_mm = self._carried(lower_mm, upper_mm)
        first, _, slopes = self._basis(np.clip(s, lower_mm, upper_mm), lower_mm, upper_mm)
        return LinearForm(first, slopes)

    def of(self, form: LinearForm) -> Array:
        """Returns the numbers of a form on this spline."""
        return form.of(self.coefficients_mm)

    def covariance(self, a: LinearForm, b: LinearForm) -> Array:
        """Returns the covariance of two forms' numbers, row by row; a row's forms lie within four coefficients."""
        band = self.covariance_band_mm2
        total: Array = np.sum(a.of(self.prescribed_mm) * b.of(self.prescribed_mm), axis=1)
        for i in range(a.weights.shape[1]):
            for j in range(b.weights.shape[1]):
                low = np.minimum(a.first + i, b.first + j)
                apart = np.abs(a.first + i - b.first - j)
                total = total + a.weights[:, i] * b.weights[:, j] * band[low, apart]
        return total

    def variance(self, form: LinearForm) -> Array:
        """Returns the variance of the numbers of a form."""
        return self.covariance(form, form)

    @property
    def dense_covariance_mm2(self) -> Array:
        """Returns the covariance of all coefficients, (n, n); of two more than three apart, only their common part."""
        band, n = self.covariance_band_mm2, len(self.coefficients_mm)
        full: Array = self.prescribed_mm @ self.prescribed_mm.T
        for k in range(min(band.shape[1], n)):
            off = np.diag(band[: n - k, k], k)
            full += off if k == 0 else off + off.T
        return full

    def with_common(self, response_mm: Array) -> "Spline":
        """Returns the spline with one more independent error, which the coefficients follow by `response_mm`, (n,)."""
        return replace(self, prescribed_mm=np.column_stack([self.prescribed_mm, response_mm]))

    def drawn_out_u_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the possible error of going on along the tangent beyond the touches, (n,): ½·f″·d², at the distance d
        from them.

        f″ is the curve's at the last touch, with its standard uncertainty: it may well bend on as it bent. Zero within
        `supported_mm`.
        """
        s = np.atleast_1d(np.asarray(arc_length_mm, dtype=np.float64))
        if self.supported_mm is None:
            return np.zeros(len(s))
        low, high = self.supported_mm
        bend = np.where(s < low, self._bend_per_mm(low), self._bend_per_mm(high))
        distance = np.maximum(np.maximum(low - s, s - high), 0.0)
        missed: Array = 0.5 * bend * distance**2
        return missed

    def pieces(self) -> tuple[Array, Array]:
        """Returns where the polynomial pieces begin, and their coefficients c, shape (pieces, 4): Σ c[k]·(s − begin)ᵏ
        in mm.

        The per-interval form of [6517 Eq. 29–33], about each piece's own beginning instead of the origin: powers of
        the whole arc length lose digits.
        """
        bounds = [t for t in self.supported_mm or () if 0.0 < t < self.length_mm]
        begins = np.concatenate([[0.0], np.unique([*self.interior_knots_mm, *bounds])])
        ends = np.append(begins[1:], self.length_mm)
        sampled = [self.of(self.value_form(b + THIRDS * (e - b), b, e)) for b, e in zip(begins, ends, strict=True)]
        in_unit_steps = np.array(sampled) @ np.linalg.inv(THIRDS[:, None] ** np.arange(4)).T
        used = np.arange(4) <= self.degree
        return begins, np.where(used, in_unit_steps / (ends - begins)[:, None] ** np.arange(4), 0.0)

    def kink_form(self, knot_mm: float) -> LinearForm:
        """Returns the slope after a knot less the slope before it. The outer functions have no slope there."""
        n = len(self.coefficients_mm)
        row = np.zeros(n)
        for side, sign in (
            (self.slope_form(knot_mm, upper_mm=knot_mm), -1.0),
            (self.slope_form(knot_mm, knot_mm), 1.0),
        ):
            row[side.first[0] : side.first[0] + side.weights.shape[1]] += sign * side.weights[0]
        first = int(np.argmax(row != 0.0))
        return LinearForm(np.array([first]), row[None, first : first + 4])

    def _carried(self, lower_mm: float, upper_mm: float | None) -> tuple[float, float]:
        """Returns the part of a stretch on which the polynomial itself holds: a point where touches support none."""
        low, high = self.supported_mm or (0.0, self.length_mm)
        upper_mm = self.length_mm if upper_mm is None else upper_mm
        return min(max(lower_mm, low), high), max(min(upper_mm, high), low)

    def _bend_per_mm(self, at_mm: float) -> float:
        """Returns the second derivative within the supported range, standard uncertainty added (root of squares)."""
        low, high = self.supported_mm or (0.0, self.length_mm)
        knots = np.abs(self.interior_knots_mm - at_mm)
        step = min(1e-3 * self.length_mm, 0.5 * float(np.min(knots[knots > 0.0], initial=high - low)))
        inner = at_mm + step if at_mm < high else at_mm - step
        ends = min(at_mm, inner), max(at_mm, inner)
        a, b = (self.slope_form(s, *ends) for s in ends)
        form = LinearForm(a.first, (b.weights - a.weights) / step)
        return math.hypot(float(self.of(form)[0]), math.sqrt(max(float(self.variance(form)[0]), 0.0)))

    def _basis(self, s: Array, lower_mm: float, upper_mm: float) -> tuple[NDArray[np.int64], Array, Array]:
        return spline_basis(s, self.interior_knots_mm, self.length_mm, self.degree, lower_mm, upper_mm)


@dataclass(frozen=True)
class SplineFit:
    """A least-squares fit before the scatter is known: covariances are per unit variance of a touch.

    `residual_mm` = value − spline at the points; `leverage` the diagonal of the hat matrix; `sensitivity` how the
    coefficients follow the prescribed numbers, shape (n, number of conditions).
    """

    spline: Spline
    conditions: EndConditions
    residual_mm: Array
    leverage: Array
    sensitivity: Array

    @property
    def leave_one_out_mm(self) -> Array:
        """Returns the errors of predicting points from the others: residual / (1 − leverage); NaN: undetermined."""
        spare = 1.0 - self.leverage
        return np.where(spare > 1e-9, self.residual_mm / np.where(spare > 1e-9, spare, 1.0), np.nan)

    @property
    def degrees_of_freedom(self) -> int:
        """Points less unknowns."""
        return len(self.residual_mm) - (len(self.spline.coefficients_mm) - self.conditions.count)

    def scaled(self, variance_mm2: float, covariance_of_conditions: Array | None = None) -> Spline:
        """Returns the spline with its covariance: σ²C + SFSᵀ, F the covariance of prescribed numbers (None: exact)."""
        band = variance_mm2 * self.spline.covariance_band_mm2
        response = self.spline.prescribed_mm
        if covariance_of_conditions is not None:
            values, vectors = np.linalg.eigh(covariance_of_conditions)
            response = self.sensitivity @ (vectors * np.sqrt(np.maximum(values, 0.0)))
        return replace(self.spline, covariance_band_mm2=band, prescribed_mm=response)


def least_squares_spline(
    arc_length_mm: ArrayLike,
    error_mm: ArrayLike,
    interior_knots_mm: ArrayLike,
    length_mm: float,
    degree: int = 3,
    conditions: EndConditions | None = None,
    weights: ArrayLike | None = None,
) -> SplineFit:
    """Fits the spline of least weighted squares that meets the end conditions exactly [6517 Eq. 11, 12, 16].

    Raises `CurveFitError` (from the core) with the kind of what is wrong; `undetermined` names the stretch in which
    points are missing. Points ascend within [0, length].
    """
    conditions = conditions or EndConditions()
    s, y, knots = (np.ascontiguousarray(a, dtype=np.float64) for a in (arc_length_mm, error_mm, interior_knots_mm))
    free = conditions.start_value_mm is None, conditions.end_value_mm is None
    supported = None
    if degree > 1 and len(s) > 1:
        supported = float(s[0]) if free[0] else 0.0, float(s[-1]) if free[1] else length_mm
    w = None if weights is None else np.ascontiguousarray(weights, dtype=np.float64)
    fitted = fit_spline(s, y, w, knots, length_mm, degree, conditions.numbers)
    coefficients, band, sensitivity, residual, leverage = fitted
    spline = Spline(
        interior_knots_mm=knots,
        length_mm=length_mm,
        degree=degree,
        coefficients_mm=coefficients,
        covariance_band_mm2=band,
        prescribed_mm=np.zeros((len(coefficients), 1)),
        supported_mm=supported,
    )
    return SplineFit(spline, conditions, residual, leverage, sensitivity)
