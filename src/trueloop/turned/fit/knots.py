"""The knots of an arc's spline, and their reduction when the touches do not carry them.

[6517 Eq. 5] sets a knot at every r-th point of the feature: t_j = x_{jr}, counted from the feature's own first point
(the neighbour's value at the junction is not counted). Read so, r = 3 leaves the residuals that the report's finish
cut shows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop._core import CurveFitError
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.spline import EndConditions, SplineFit, least_squares_spline


@dataclass(frozen=True)
class Knots:
    """Interior knots of a chain: those set by the touches, and its joints with how often each stands."""

    at_points_mm: tuple[float, ...]
    joints_mm: tuple[float, ...]
    repeats: int

    @property
    def interior_mm(self) -> Array:
        """Returns all of them, ascending."""
        return np.sort(np.array([*self.at_points_mm, *(t for t in self.joints_mm for _ in range(self.repeats))]))


def joint_repeats(policy: TangentPolicy, degree: int) -> int:
    """Returns the multiplicity of a knot at a tangent junction: continuous for PART (C⁰), tangent for PATH (C¹)."""
    return degree if policy == TangentPolicy.PART else degree - 1


def every_rth(points_mm: Array, starts_mm: Sequence[float], length_mm: float, r: int) -> tuple[float, ...]:
    """Returns every r-th point of a feature [6517 Eq. 5], arc lengths along the chain.

    Left out are one on a feature's end, and the last point: no touch lies beyond it, and a polynomial piece without a
    touch multiplies the scatter of its neighbours.
    """
    ends = np.array([*starts_mm, length_mm])
    knots = points_mm[r - 1 : -1 : r]
    return tuple(float(t) for t in knots if np.min(np.abs(t - ends)) > 1e-6 * length_mm)


def candidates(points: int) -> list[int]:
    """Returns the r among which leave-one-out chooses: 2 to 10, and those that give 0 to 9 knots; largest first."""
    spread = {points // k for k in range(1, 11)}
    return sorted((r for r in spread | set(range(2, 11)) if 2 <= r <= max(points, 2)), reverse=True)


def fit_determined(
    arc_length_mm: Array, error_mm: Array, knots: Knots, length_mm: float, degree: int, conditions: EndConditions
) -> tuple[SplineFit, Knots]:
    """Fits with as many of the knots, and as high a degree, as the touches determine.

    While a stretch has too few touches, the knot nearest its middle is dropped (joints last); when none is left the
    degree is lowered: cubic, parabola, straight line, constant. One touch gives a constant.
    """
    while True:
        try:
            return least_squares_spline(
                arc_length_mm, error_mm, knots.interior_mm, length_mm, degree, conditions
            ), knots
        except CurveFitError as error:
            if error.args[0] != "undetermined" or degree == 0:
                raise _refused(error, len(arc_length_mm), conditions) from error
            fewer = _without_one(knots, *error.args[2])
            if fewer is None:
                degree -= 1
                repeats = min(knots.repeats, degree)
                knots = replace(knots, repeats=repeats, joints_mm=knots.joints_mm if repeats else ())
            else:
                knots = fewer


def _refused(error: CurveFitError, touches: int, conditions: EndConditions) -> TrueloopError:
    if error.args[0] == "too-many-conditions":
        return Code.FIT_CONDITIONS.refusal(
            f"{touches} touches and {conditions.count} prescribed values and slopes fit no curve: {error.args[1]}",
            hint="prescribe fewer values and slopes at the ends, or touch more points",
        )
    return Code.FIT_POINTS.refusal(
        f"{touches} touches do not determine a curve: {error.args[1]}",
        hint="touch the feature at more points",
        values={"touches": touches},
    )


def _without_one(knots: Knots, start_mm: float, end_mm: float) -> Knots | None:
    """Returns the knots less the one nearest the middle of a stretch; None when there is none in it."""
    middle = (start_mm + end_mm) / 2
    there = [t for t in (knots.at_points_mm or knots.joints_mm) if start_mm <= t <= end_mm]
    there = there or [t for t in knots.joints_mm if start_mm <= t <= end_mm]
    if not there:
        return None
    dropped = min(there, key=lambda t: abs(t - middle))
    return replace(
        knots,
        at_points_mm=tuple(t for t in knots.at_points_mm if t != dropped),
        joints_mm=tuple(t for t in knots.joints_mm if t != dropped),
    )
