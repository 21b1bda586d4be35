"""The nose model: one error function of contact angle, shared by all features that one tool nose cuts.

A worn or off-size nose errs where it is worn, so that the part error depends on the contact angle φ alone:

    e(part, feature, φ) = w(φ) + dX·sin φ + dZ·cos φ + left(feature)

with w the nose, dX and dZ the tool offsets of the part in hand, and a constant by which a straight feature deviates.
w is a cubic spline in φ fitted to the arcs of several parts; two touches then set the offsets of the next part, and its
whole arc is known. sin φ and cos φ could be moved between w and the offsets: w is fixed by having no part in common
with them, ∫w sin φ dφ = ∫w cos φ dφ = 0 over the fitted range.

It stops being valid when the nose goes on wearing, is turned to another edge, or cuts at angles outside the range; and
on straight features it knows only what was left on them: the cones of [6811] stand 11 to 17 µm off (30 µm on one
part whose taper looks falsified; the report says that some were).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.turned.fit.spline import Spline

APART_RAD: Final = math.radians(5.0)
"""Touches that shall set both offsets must span more than this."""

BEYOND_RAD: Final = math.radians(1.0)
"""The distance beyond its fitted range to which w is used, along its end tangents: less than the spacing of touches on
a dome."""


@dataclass(frozen=True)
class NoseTouches:
    """Errors of one part by contact angle, arrays of shape (n,).

    `feature` names what each touch lies on; `on_arc` says whether the contact angle turns there.
    """

    part: str
    feature: tuple[str, ...]
    on_arc: NDArray[np.bool_]
    contact_angle_rad: Array
    error_mm: Array

    def subset(self, chosen: ArrayLike) -> "NoseTouches":
        """Returns some of the touches, by position or mask."""
        which = np.arange(len(self.feature))[np.asarray(chosen)]
        names = tuple(self.feature[k] for k in which)
        return NoseTouches(self.part, names, self.on_arc[which], self.contact_angle_rad[which], self.error_mm[which])


@dataclass(frozen=True)
class NoseModel:
    """A fitted nose. Angles in rad from `lowest_rad` to `highest_rad`, errors in mm.

    `w` runs over φ − lowest and carries its covariance. `offsets_mm` holds (dX, dZ) of every part of the fit, `left_mm`
    what is left on its straight features, by part and feature. `scatter_mm` is the standard deviation of a touch on an
    arc about the model, with `degrees_of_freedom`.
    """

    lowest_rad: float
    highest_rad: float
    w: Spline
    offsets_mm: Mapping[str, tuple[float, float]]
    left_mm: Mapping[tuple[str, str], float]
    scatter_mm: float
    degrees_of_freedom: int

    def covers(self, angle_rad: ArrayLike) -> NDArray[np.bool_]:
        """Returns whether contact angles lie within the fitted range, or at most a degree beyond."""
        angle = np.asarray(angle_rad, dtype=np.float64)
        return (angle >= self.lowest_rad - BEYOND_RAD) & (angle <= self.highest_rad + BEYOND_RAD)

    def w_mm(self, angle_rad: ArrayLike) -> Array:
        """Returns the nose's own error at contact angles, (n,). Raises FIT-ANGLE outside the fitted range."""
        return self.basis(angle_rad) @ self.w.coefficients_mm

    def basis(self, angle_rad: ArrayLike) -> Array:
        """Returns the row of w's basis functions for each contact angle, (n, coefficients)."""
        angle = np.atleast_1d(np.asarray(angle_rad, dtype=np.float64))
        if not np.all(self.covers(angle)):
            bad = angle[~self.covers(angle)][0]
            raise Code.FIT_ANGLE.refusal(
                f"the nose model was fitted from {math.degrees(self.lowest_rad):.1f}° to "
                f"{math.degrees(self.highest_rad):.1f}° of contact angle and is asked for {math.degrees(bad):.1f}°",
                hint="fit it to parts whose arcs reach that angle, or use the feature's own curve there",
                values={
                    "angle_deg": math.degrees(bad),
                    "lowest_deg": math.degrees(self.lowest_rad),
                    "highest_deg": math.degrees(self.highest_rad),
                },
            )
        form = self.w.value_form(angle - self.lowest_rad)
        return form.dense(len(self.w.coefficients_mm))

    def predict(self, touches: NoseTouches) -> "NosePrediction":
        """Predicts the next part from at least two touches on its arcs: tool offsets by least squares.

        Raises FIT-POINTS when they do not set both offsets, FIT-ANGLE outside the fitted range.
        """
        angle, error = touches.contact_angle_rad, touches.error_mm
        if len(angle) < 2 or float(np.ptp(angle)) < APART_RAD:
            raise refuse_too_few(touches)
        solve = np.asarray(np.linalg.pinv(offset_terms(angle)), dtype=np.float64)
        basis = self.basis(angle)
        return NosePrediction(self, solve @ (error - basis @ self.w.coefficients_mm), solve, solve @ basis)


@dataclass(frozen=True)
class NosePrediction:
    """The prediction of one part by a nose model: `offsets_mm` = (dX, dZ) from its touches."""

    model: NoseModel
    offsets_mm: Array
    _from_touches: Array
    _from_w: Array

    def value_mm(self, angle_rad: ArrayLike) -> Array:
        """Returns the expected part error at contact angles, (n,)."""
        angle = np.atleast_1d(np.asarray(angle_rad, dtype=np.float64))
        return self.model.w_mm(angle) + offset_terms(angle) @ self.offsets_mm

    def root_of_covariance_mm(self, angle_rad: ArrayLike) -> Array:
        """Returns F with F·Fᵀ the covariance of the expected errors, (n, m): from w and the touches' scatter."""
        angle = np.atleast_1d(np.asarray(angle_rad, dtype=np.float64))
        terms = offset_terms(angle)
        rows = self.model.basis(angle) - terms @ self._from_w
        return np.hstack([rows @ self.model.w.prescribed_mm, self.model.scatter_mm * (terms @ self._from_touches)])

    def standard_deviation_mm(self, angle_rad: ArrayLike) -> Array:
        """Returns the standard uncertainty of the expected error, (n,)."""
        variance: Array = np.sum(self.root_of_covariance_mm(angle_rad) ** 2, axis=1)
        return np.sqrt(variance)


def offset_terms(angle_rad: Array) -> Array:
    """Returns (sin φ, cos φ): the effect of tool offsets dX and dZ on the error along the normal, (n, 2)."""
    return np.column_stack([np.sin(angle_rad), np.cos(angle_rad)])


def refuse_too_few(touches: NoseTouches) -> TrueloopError:
    """Returns the error for touches that do not set dX and dZ."""
    span = math.degrees(float(np.ptp(touches.contact_angle_rad))) if len(touches.feature) else 0.0
    return Code.FIT_POINTS.refusal(
        f"part {touches.part!r}: {len(touches.feature)} touches over {span:.1f}° of contact angle do not set the two "
        f"tool offsets; at least 2 over {math.degrees(APART_RAD):.0f}° are needed",
        hint="touch the arc at two places far apart",
        values={"touches": len(touches.feature)},
    )
