"""The term of an arc's correction from its own slope where errors follow the nose: a leaning contour is touched
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

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.compensation.shift import ZERO, Shift, constant, product, weighted_sum
from trueloop.turned.error_curve.curve import ErrorCurve

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
    return product(_fade(profile, index, curve, feature), term)


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


def _fade(profile: Profile, index: int, curve: ErrorCurve, feature: Feature) -> Shift:
    """Returns a factor from 0 to 1: within `REACHES` times the way of the contact at tangential ends."""
    tangent = [False, *(junction.kind is JunctionKind.TANGENT for junction in profile.junctions), False]
    ends = np.array([0.0, feature.length_mm])
    reach = REACHES * _per_rad_mm(feature, curve, ends) * tangent[index : index + 2]
    return product(_smooth(0.0, float(reach[0])), _smooth(feature.length_mm, -float(reach[1])))


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
