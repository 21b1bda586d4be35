"""The displacement of the commanded contour of one feature along its outward normal, as a function of arc length.

A shift is piecewise polynomials, and so are sums, products and the error curves that it is made of: all of it exact,
up to the last bits of floating point.
"""

from dataclasses import dataclass
from math import comb
from typing import Final

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from trueloop.arrays import Array, by_content

FARTHEST_MM: Final = 1e4
"""Arc length beyond which no part reaches."""

NOTHING_MM: Final = 1e-10
"""A coefficient of the highest power does not count where it makes no more than this of that length: its root far
beyond would take the digits of the others.
"""


@by_content
@dataclass(frozen=True)
class Shift:
    """Displacement along the outward normal in mm (positive = away from the material), of arc length s in mm.

    Polynomials give way to the next at `breaks_mm` (m,), which ascend; at a break the one after it holds. Row j of
    `coefficients_mm` (m + 1, n) is Σₖ c[j, k]·(s − o[j])ᵏ, o[j] the break where it begins, for the first one, which
    has no beginning, the break where it ends; 0 where there is no break. The outermost ones go on without end.
    """

    breaks_mm: Array
    coefficients_mm: Array

    @property
    def origins_mm(self) -> Array:
        """Returns the origin of each polynomial, (m + 1,)."""
        return np.concatenate([self.breaks_mm[:1], self.breaks_mm]) if len(self.breaks_mm) else np.zeros(1)

    def value_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the shift; its shape out is that in."""
        return self._polynomial(self.coefficients_mm, arc_length_mm)

    def slope(self, arc_length_mm: ArrayLike) -> Array:
        """Returns its change along the feature, mm per mm; its shape out is that in."""
        return self._polynomial(_derived(self.coefficients_mm), arc_length_mm)

    def derivative(self) -> "Shift":
        """Returns the slope as piecewise polynomials of their own."""
        return Shift(self.breaks_mm, _derived(self.coefficients_mm))

    def on_breaks(self, breaks_mm: Array) -> Array:
        """Coefficients of the same polynomials on breaks among which are its own."""
        begins = np.concatenate([[-np.inf], breaks_mm])
        piece = np.searchsorted(self.breaks_mm, begins, side="right")
        origins = Shift(breaks_mm, self.coefficients_mm).origins_mm
        return _recentred(self.coefficients_mm[piece], origins - self.origins_mm[piece])

    def carried_straight(self, start_mm: float, end_mm: float) -> "Shift":
        """Returns this shift from one arc length to another, and beyond both along the tangents there."""
        inner = self.breaks_mm[(self.breaks_mm > start_mm) & (self.breaks_mm < end_mm)]
        begins = np.concatenate([[start_mm], inner])
        piece = np.searchsorted(self.breaks_mm, begins, side="right")
        rows = _recentred(self.coefficients_mm[piece], begins - self.origins_mm[piece])
        at_end = _recentred(rows[-1:], np.array([end_mm - begins[-1]]))
        straight = np.arange(rows.shape[1]) < 2
        return Shift(np.append(begins, end_mm), np.vstack([rows[:1] * straight, rows, at_end * straight]))

    def clipped(self, most_mm: float) -> "Shift":
        """Returns this shift limited to this size."""
        breaks = np.union1d(self.breaks_mm, [s for sign in (1.0, -1.0) for s in self._reaches(sign * most_mm)])
        rows, ends = self.on_breaks(breaks), np.concatenate([breaks[:1] - 2.0, breaks, breaks[-1:] + 2.0])
        inside = self.value_mm((ends[1:] + ends[:-1]) / 2 if len(breaks) else [0.0])
        flat = np.sign(inside)[:, None] * most_mm * (np.arange(rows.shape[1]) == 0)
        return Shift(breaks, np.where(np.abs(inside)[:, None] > most_mm, flat, rows))

    def _reaches(self, value_mm: float) -> list[float]:
        """Returns the arc lengths inside its pieces at which it has a value."""
        ends = np.concatenate([[-np.inf], self.breaks_mm, [np.inf]])
        counts = np.abs(self.coefficients_mm) * FARTHEST_MM ** np.arange(self.coefficients_mm.shape[1]) > NOTHING_MM
        found: list[float] = []
        for row, origin, low, high, counting in zip(
            self.coefficients_mm, self.origins_mm, ends, ends[1:], counts, strict=False
        ):
            powers = 1 + int(np.max(np.flatnonzero(counting), initial=0))
            roots = polynomial.polyroots(np.append(row[0] - value_mm, row[1:powers])) + origin
            found += [float(root.real) for root in roots if root.imag == 0.0 and low < root.real < high]
        return found

    def _polynomial(self, coefficients: Array, arc_length_mm: ArrayLike) -> Array:
        s = np.asarray(arc_length_mm, dtype=np.float64)
        piece = np.searchsorted(self.breaks_mm, s, side="right")
        along, rows = s - self.origins_mm[piece], coefficients[piece]
        value = rows[..., -1]
        for k in reversed(range(coefficients.shape[1] - 1)):
            value = value * along + rows[..., k]
        return np.asarray(value)


def constant(shift_mm: float) -> Shift:
    """Returns a shift that is constant everywhere."""
    return Shift(np.zeros(0), np.array([[shift_mm]]))


ZERO = constant(0.0)
"""A feature that stays where it is."""


def sampled(arc_length_mm: Array, values_mm: Array) -> Shift:
    """Returns the piecewise linear shift through samples (n,), carried on straight beyond the first and last.

    A constant through one sample. Sample positions ascend.
    """
    if len(arc_length_mm) == 1:
        return constant(float(values_mm[0]))
    rows = np.column_stack([values_mm[:-1], np.diff(values_mm) / np.diff(arc_length_mm)])
    return Shift(np.asarray(arc_length_mm[:-1]), np.vstack([rows[:1], rows]))


def weighted_sum(parts: tuple[tuple[float, Shift], ...]) -> Shift:
    """Returns Σ weight · shift."""
    breaks = np.unique(np.concatenate([part.breaks_mm for _, part in parts]))
    rows = np.zeros((len(breaks) + 1, max(part.coefficients_mm.shape[1] for _, part in parts)))
    for weight, part in parts:
        rows[:, : part.coefficients_mm.shape[1]] += weight * part.on_breaks(breaks)
    return Shift(breaks, rows)


def product(one: Shift, other: Shift) -> Shift:
    """Returns the product of the two."""
    breaks = np.union1d(one.breaks_mm, other.breaks_mm)
    a, b = one.on_breaks(breaks), other.on_breaks(breaks)
    rows = np.zeros((len(breaks) + 1, a.shape[1] + b.shape[1] - 1))
    for k in range(a.shape[1]):
        rows[:, k : k + b.shape[1]] += a[:, k : k + 1] * b
    return Shift(breaks, rows)


def _derived(coefficients: Array) -> Array:
    return coefficients[:, 1:] * np.arange(1, coefficients.shape[1]) if coefficients.shape[1] > 1 else coefficients * 0


def _recentred(coefficients: Array, by_mm: Array) -> Array:
    """Polynomials (m, n) counted from `by_mm` (m,) further along."""
    moved = np.zeros_like(coefficients)
    for k in range(coefficients.shape[1]):
        for j in range(k, coefficients.shape[1]):
            moved[:, k] += comb(j, k) * coefficients[:, j] * by_mm ** (j - k)
    return moved
