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

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature, Line
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


def of_curve(curve: ErrorCurve) -> Shift:
    """An error curve as a shift: its own polynomials on the feature, its end tangents beyond."""
    begins, coefficients = curve.pieces
    return Shift(begins, np.vstack([coefficients[:1], coefficients])).carried_straight(0.0, curve.length_mm)


def to_take_out(profile: Profile, index: int, curve: ErrorCurve) -> Shift:
    """The error of one feature's curve with what its slope asks for besides: `e + e′²/κ` on an arc, `e` on a line."""
    return weighted_sum(((1.0, of_curve(curve)), (1.0, of_slope(profile, index, curve))))


def unasked_u_mm(term: Shift, arc_length_mm: ArrayLike) -> Array:
    """Standard uncertainty of what is left where nobody says what the error follows, mm: the term's size over √3.

    `term` is that of `of_slope`, which was not taken out. An error that is partly the nose's leaves any part of it:
    zero to all of it alike [GUM 4.3.7], about zero.
    """
    return np.asarray(np.abs(term.value_mm(arc_length_mm)) / np.sqrt(3.0))


def of_slope(profile: Profile, index: int, curve: ErrorCurve) -> Shift:
    """What the slope of one feature's curve asks for besides its error: `e′²/κ` on an arc, nothing on a line."""
    feature = profile.features[index]
    if isinstance(feature, Line):
        return ZERO
    slope = of_curve(curve).derivative()
    term = weighted_sum(((1.0 / float(feature.curvature_per_mm(0.0)), product(slope, slope)),)).clipped(MOST_MM)
    return product(_fade(profile, index, curve, feature), term)


def _fade(profile: Profile, index: int, curve: ErrorCurve, feature: Feature) -> Shift:
    """A factor from 0 to 1: within `REACHES` times the way of the contact at the ends that join tangentially."""
    tangent = [False, *(junction.kind is JunctionKind.TANGENT for junction in profile.junctions), False]
    ends = np.array([0.0, feature.length_mm])
    reach = REACHES * np.abs(curve.slope(ends) / feature.curvature_per_mm(ends)) * tangent[index : index + 2]
    return product(_smooth(0.0, float(reach[0])), _smooth(feature.length_mm, -float(reach[1])))


def _smooth(end_mm: float, reach_mm: float) -> Shift:
    """3u² − 2u³ of u = (s − end)/reach within [0, 1], 0 before and 1 after; 1 where nothing is reached."""
    if reach_mm == 0.0:
        return constant(1.0)
    outside = [[0.0] * 4, [1.0, 0.0, 0.0, 0.0]]
    if reach_mm > 0.0:
        rise = [0.0, 0.0, 3.0 / reach_mm**2, -2.0 / reach_mm**3]
        return Shift(np.array([end_mm, end_mm + reach_mm]), np.array([outside[0], rise, outside[1]]))
    fall = [1.0, 0.0, -3.0 / reach_mm**2, -2.0 / reach_mm**3]
    return Shift(np.array([end_mm + reach_mm, end_mm]), np.array([outside[1], fall, outside[0]]))
