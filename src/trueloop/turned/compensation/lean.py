"""What an arc's correction owes to its own slope where errors follow the nose: a leaning contour is touched elsewhere.

A worn nose errs by contact angle φ: the surface it leaves has the support function of what was commanded, plus E(φ).
A touch at the nominal normal sees `e = E − e′²/2κ`, because the surface leans by e′ and was cut e′/κ further along; a
contour shifted by c leans by c′ and has the support function `c + c′²/2κ`. What then is left, `E + c + c′²/2κ −
(E′ + c′)²/2κ`, is zero to second order for

    c = −w (e + e′²/κ),

κ the signed curvature of the arc (for w < 1 it leaves (1 − w) e, as it should). On an arc of 32 mm that a nose errs
along by 0.15 mm a radian, the second term is 0.7 µm. On a straight feature the contact angle stands still: no term. An
error that goes by place, not by contact angle, has no such term: only who knows that the nose makes it asks for this.
Who does not know has an uncertainty of it. What is steeper than a nose makes it is no nose's, and the term stops at
`MOST_MM`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.compensation.shift import ZERO, Shift, ShiftFunction, weighted_sum
from trueloop.turned.error_curve.curve import ErrorCurve

REACHES: Final = 4.0
"""Towards a tangent junction the term fades within so many times e′/κ, how far the contact moves along: the neighbour
has none or another, and the contour must not step. The fading itself then leans by less than half of what e does."""


MOST_MM: Final = 0.001
"""More than this is not taken for the nose's. On the domes and knobs of [6811] Tables 8 and 10 the curve of the touches
drops by 15 to 30 µm within the last millimetres before the spindle axis, where cutting speed ends: the term would be
several µm there, and the finish cuts of Tables 9 and 11 do not show it."""


@dataclass(frozen=True)
class Fade:
    """Where the term fades on one arc of `length_mm`: within these lengths of its start and its end; 0 does not."""

    length_mm: float
    start_mm: float
    end_mm: float

    def at(self, s: Array) -> tuple[Array, Array]:
        """Factor from 0 to 1 and its slope per mm, shapes as s."""
        rise, rising = _smooth(s, self.start_mm)
        fall, falling = _smooth(self.length_mm - s, self.end_mm)
        return rise * fall, rising * fall - rise * falling


def of_curve(curve: ErrorCurve) -> Shift:
    """An error curve as a shift: same shape out as in."""
    return Shift(lambda s: _shaped(curve.value_mm, s), lambda s: _shaped(curve.slope, s))


def to_take_out(profile: Profile, index: int, curve: ErrorCurve) -> Shift:
    """The error of one feature's curve with what its slope asks for besides: `e + e′²/κ` on an arc, `e` on a line."""
    return weighted_sum(((1.0, of_curve(curve)), (1.0, of_slope(profile, index, curve))))


def unasked_u_mm(profile: Profile, index: int, curve: ErrorCurve) -> ShiftFunction:
    """Standard uncertainty of what is left where nobody says what the error follows, mm: the term's size over √3.

    An error that is partly the nose's leaves any part of the term: zero to all of it alike [GUM 4.3.7], about zero.
    """
    term = of_slope(profile, index, curve)
    return lambda s: np.abs(term.value_mm(s)) / np.sqrt(3.0)


def of_slope(profile: Profile, index: int, curve: ErrorCurve) -> Shift:
    """What the slope of one feature's curve asks for besides its error: `e′²/κ` on an arc, nothing on a line."""
    feature = profile.features[index]
    if isinstance(feature, Line):
        return ZERO
    kappa, fade = float(feature.curvature_per_mm(0.0)), _fade(profile, index, curve, feature)

    def term_mm(s: Array) -> Array:
        return np.clip(_shaped(curve.slope, s) ** 2 / kappa, -MOST_MM, MOST_MM)

    def value_mm(s: ArrayLike) -> Array:
        at = np.asarray(s, dtype=np.float64)
        return fade.at(at)[0] * term_mm(at)

    def slope(s: ArrayLike) -> Array:
        at = np.asarray(s, dtype=np.float64)
        (factor, fading), term = fade.at(at), term_mm(at)
        growing = 2.0 * _shaped(curve.slope, at) * _shaped(curve.bend_per_mm, at) / kappa
        return factor * np.where(np.abs(term) < MOST_MM, growing, 0.0) + fading * term

    return Shift(value_mm, slope)


def _fade(profile: Profile, index: int, curve: ErrorCurve, feature: Feature) -> Fade:
    """Within `REACHES` times the way of the contact at the ends that join tangentially."""
    tangent = [False, *(junction.kind is JunctionKind.TANGENT for junction in profile.junctions), False]
    ends = np.array([0.0, feature.length_mm])
    reach = REACHES * np.abs(curve.slope(ends) / feature.curvature_per_mm(ends)) * tangent[index : index + 2]
    return Fade(feature.length_mm, float(reach[0]), float(reach[1]))


def _smooth(s: Array, reach_mm: float) -> tuple[Array, Array]:
    """3u² − 2u³ of u = s/reach within [0, 1], and its slope."""
    if reach_mm == 0.0:
        return np.ones_like(s), np.zeros_like(s)
    u = np.clip(s / reach_mm, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / reach_mm


def _shaped(of: Callable[[ArrayLike], Array], s: ArrayLike) -> Array:
    """A curve's answers in the shape that was asked."""
    return np.reshape(of(np.ravel(s)), np.shape(s))
