"""The displacement of the commanded contour of one feature along its outward normal, as a function of arc length.

A shift is piecewise polynomials, and so are sums, products and the error curves that it is made of: all of it exact,
up to the last bits of floating point.

The term of an arc's correction from its own slope where errors follow the nose: a leaning contour is touched
elsewhere.

A worn nose errs by contact angle φ: the surface it leaves has the support function of what was commanded, plus E(φ).
A touch at the nominal normal sees `e = E − e′²/2κ`, because the surface leans by e′ and was cut e′/κ further along; a
contour shifted by c leans by c′ and has the support function `c + c′²/2κ`. What then is left, `E + c + c′²/2κ −
(E′ + c′)²/2κ`, is zero to second order for

    c = −w (e + e′²/κ),

κ the signed curvature at the place (for w < 1 it leaves (1 − w) e, as it should). On an arc of 32 mm that a nose errs
along by 0.15 mm a radian, the second term is 0.7 µm. On a straight feature the contact angle stands still: no term. An
error that goes by place, not by contact angle, has no such term: only who knows that the nose makes it asks for this.
Who does not know has an uncertainty of it.

Along a curve κ changes, and may go through zero: what a nose makes has `e′ = κ dE/dφ`, so that `e′²/κ = κ (dE/dφ)²`
goes to zero with it. A slope that remains there is steeper than a nose makes it: dE/dφ stops at
`STEEPEST_MM_PER_RAD`, and the term at `MOST_MM`.
"""

from dataclasses import dataclass
from math import comb
from typing import Final

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from trueloop.arrays import Array, by_content
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.error_curve.curve import ErrorCurve

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
    """Returns the piecewise linear shift through ascending samples (n,), straight beyond; one sample: a constant."""
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


def product(shift: Shift, other: Shift) -> Shift:
    """Returns the product of the two."""
    breaks = np.union1d(shift.breaks_mm, other.breaks_mm)
    a, b = shift.on_breaks(breaks), other.on_breaks(breaks)
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


REACHES: Final = 4.0
"""Towards a tangent junction the term fades within so many times e′/κ, how far the contact moves along: the neighbour
has none or another, and the contour must not step. The fading itself then leans by less than half of what e does."""


MOST_MM: Final = 0.001
"""More than this is not taken for the nose's. On the domes and knobs of [6811] Tables 8 and 10 the curve of the touches
drops by 15 to 30 µm within the last millimetres before the spindle axis, where cutting speed ends: the term would be
several µm there, and the finish cuts of Tables 9 and 11 do not show it."""

STEEPEST_MM_PER_RAD: Final = 0.25
"""No nose errs by more per radian of contact angle: its whole radius is some tenths of a millimetre to a few."""

PLACES: Final = 257
"""Along a curve the term is computed at so many places, and is a monotone cubic between them."""


def of_curve(curve: ErrorCurve) -> Shift:
    """Returns an error curve as a shift: its own polynomials on the feature, its end tangents beyond."""
    begins, coefficients = curve.pieces
    return Shift(begins, np.vstack([coefficients[:1], coefficients])).carried_straight(0.0, curve.length_mm)


def to_take_out(profile: Profile, index: int, curve: ErrorCurve) -> Shift:
    """Returns the error of one feature's curve with the term of its slope: `e + e′²/κ`, on a line `e`."""
    return weighted_sum(((1.0, of_curve(curve)), (1.0, of_slope(profile, index, curve))))


def unasked_u_mm(term: Shift, arc_length_mm: ArrayLike) -> Array:
    """Returns the standard uncertainty, mm, of the remainder where nothing states what the error follows: the term's
    size over √3.

    `term` is that of `of_slope`, which was not taken out. An error that is partly the nose's leaves any part of it:
    zero to all of it alike [GUM 4.3.7], about zero.
    """
    return np.asarray(np.abs(term.value_mm(arc_length_mm)) / np.sqrt(3.0))


def of_slope(profile: Profile, index: int, curve: ErrorCurve) -> Shift:
    """Returns the term of the slope of one feature's curve besides its error: `e′²/κ`, nothing on a line."""
    feature = profile.features[index]
    if isinstance(feature, Line):
        return ZERO
    term = _along_curve(feature, curve) if isinstance(feature, Curve) else _along_arc(feature, curve)
    # A factor from 0 to 1: within `REACHES` times the way of the contact at tangential ends
    tangent = [False, *(junction.kind is JunctionKind.TANGENT for junction in profile.junctions), False]
    ends = np.array([0.0, feature.length_mm])
    reach = REACHES * _per_rad_mm(feature, curve, ends) * tangent[index : index + 2]
    return product(product(_smooth(0.0, float(reach[0])), _smooth(feature.length_mm, -float(reach[1]))), term)


def _along_arc(arc: Arc, curve: ErrorCurve) -> Shift:
    """Returns the term where κ is one number: the exact square of a piecewise polynomial."""
    curvature = float(arc.curvature_per_mm(0.0))
    per_rad = weighted_sum(((1.0 / curvature, of_curve(curve).derivative()),)).clipped(STEEPEST_MM_PER_RAD)
    return weighted_sum(((curvature, product(per_rad, per_rad)),)).clipped(MOST_MM)


def _along_curve(feature: Curve, curve: ErrorCurve) -> Shift:
    """Returns the term with κ at each place, through `PLACES` of them."""
    from scipy.interpolate import PchipInterpolator  # slow to import

    s = np.linspace(0.0, feature.length_mm, PLACES)
    term = np.clip(feature.curvature_per_mm(s) * _per_rad_mm(feature, curve, s) ** 2, -MOST_MM, MOST_MM)
    rows = PchipInterpolator(s, term).c[::-1].T
    return Shift(s[:-1], np.vstack([rows[:1], rows])).carried_straight(0.0, feature.length_mm)


def _per_rad_mm(feature: Feature, curve: ErrorCurve, arc_length_mm: Array) -> Array:
    """Returns the size of dE/dφ = e′/κ, the way of the contact along the feature, mm; at most `STEEPEST_MM_PER_RAD`."""
    slope, curvature = np.abs(curve.slope(arc_length_mm)), np.abs(feature.curvature_per_mm(arc_length_mm))
    bounded = slope < STEEPEST_MM_PER_RAD * curvature
    return np.asarray(np.where(bounded, slope / np.where(bounded, curvature, 1.0), STEEPEST_MM_PER_RAD))


def _smooth(end_mm: float, reach_mm: float) -> Shift:
    """Returns 3u² − 2u³ of u = (s − end)/reach within [0, 1], 0 before and 1 after; 1 where nothing is reached."""
    if reach_mm == 0.0:
        return constant(1.0)
    outside = [[0.0] * 4, [1.0, 0.0, 0.0, 0.0]]
    if reach_mm > 0.0:
        rise = [0.0, 0.0, 3.0 / reach_mm**2, -2.0 / reach_mm**3]
        return Shift(np.array([end_mm, end_mm + reach_mm]), np.array([outside[0], rise, outside[1]]))
    fall = [1.0, 0.0, -3.0 / reach_mm**2, -2.0 / reach_mm**3]
    return Shift(np.array([end_mm + reach_mm, end_mm]), np.array([outside[1], fall, outside[0]]))
