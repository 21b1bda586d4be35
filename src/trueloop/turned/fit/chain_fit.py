"""The fit of one chain, and the touches it starts from.

Chains: features joined tangentially that one spline runs over, and which chain prescribes what to which.

Lines and arcs are distinguished because their errors behave differently: along a line the contact angle of the nose
stands still, along an arc it turns. A chain of arcs takes its end values from the lines it is tangent to.

The knots of an arc's spline, and their reduction when the touches do not carry them.

[6517 Eq. 5] sets a knot at every r-th point of the feature: t_j = x_{jr}, counted from the feature's own first point
(the neighbour's value at the junction is not counted). Read so, r = 3 leaves the residuals that the report's finish
cut shows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import accumulate
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trueloop._core import CurveFitError
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import is_curved
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.turned.fit.between_cuts import NextCut
from trueloop.turned.fit.spline import EndConditions, SplineFit, least_squares_spline
from trueloop.turned.touches.error_vectors import ErrorVectors


class TangentPolicy(StrEnum):
    """The demand of a tangent junction of line and arc, or of two arcs, on the error curves.

    PATH: equal value and slope, so that the compensated path is tangent, as published [6517 §4]. PART: equal value
    only. The nose errs as a function of contact angle, so the error has a kink where curvature jumps, and only a path
    with the opposite kink leaves a tangent part.
    """

    PART = "part"
    PATH = "path"


@dataclass(frozen=True)
class Chain:
    """Consecutive features with tangent junctions between them, all lines or all arcs."""

    features: tuple[int, ...]
    starts_mm: tuple[float, ...]
    length_mm: float
    curved: bool

    @property
    def joints_mm(self) -> tuple[float, ...]:
        """Returns the arc lengths along the chain of the tangent junctions inside it."""
        return self.starts_mm[1:]


@dataclass(frozen=True)
class End:
    """One end of a chain."""

    chain: int
    at_end: bool


def chains_of(profile: Profile) -> tuple[Chain, ...]:
    """Groups the profile's features into chains."""
    groups: list[list[int]] = []
    for i in range(len(profile.features)):
        joined = i > 0 and profile.junctions[i - 1].kind == JunctionKind.TANGENT
        if joined and _curved(profile, i - 1) == _curved(profile, i):
            groups[-1].append(i)
        else:
            groups.append([i])
    return tuple(_chain(profile, group) for group in groups)


def tangent_neighbours(profile: Profile, chains: tuple[Chain, ...], index: int) -> tuple[End | None, End | None]:
    """Returns the ends of the chains before and after that `chains[index]` is tangent to: None at corners and ends."""
    first, last = chains[index].features[0], chains[index].features[-1]
    tangent_before = first > 0 and profile.junctions[first - 1].kind == JunctionKind.TANGENT
    tangent_after = last < len(profile.junctions) and profile.junctions[last].kind == JunctionKind.TANGENT
    return (End(index - 1, True) if tangent_before else None, End(index + 1, False) if tangent_after else None)


def _chain(profile: Profile, group: list[int]) -> Chain:
    lengths = [profile.features[i].length_mm for i in group]
    *starts, total = accumulate(lengths, initial=0.0)
    return Chain(tuple(group), tuple(starts), total, _curved(profile, group[0]))


def _curved(profile: Profile, index: int) -> bool:
    return is_curved(profile.features[index])


ROUNDING_MM: Final = 0.01
"""The distance that a touch may lie beyond its feature's end and still be taken for one at the end."""


@dataclass(frozen=True)
class ConditionSource:
    """The source of the conditions at one end of a chain: a neighbour's end, or an estimate with its uncertainty.

    `gives_slope` says whether the neighbour gives the slope beside the value; the user's own counts as exact.
    """

    neighbour: End | None = None
    standard_u_mm: float = 0.0
    gives_slope: bool = False


Sources: TypeAlias = tuple[ConditionSource, ConditionSource]


@dataclass(frozen=True)
class ChainTouches:
    """The touches of a chain in order of arc length along it; `positions` are theirs in the error vectors."""

    positions: NDArray[np.intp]
    arc_length_mm: Array
    error_mm: Array
    by_feature_mm: tuple[Array, ...]


@dataclass(frozen=True)
class ChainFit:
    """A fitted chain.

    `fit` is in units of the touches' variance; `sources` say where its end conditions come from; `knot_every` has one
    entry a feature. `residual_mm` and `leave_one_out_mm` (NaN where the other touches say nothing) go by `touches`,
    positions in the error vectors; `spare` are the degrees of freedom. A curve from a model instead of the touches
    brings the square root of its coefficients' covariance, `from_model_mm`, (coefficients, m). `unsupported`: no touch
    says anything of the chain, and it is left as programmed. `scatter_mm` of a touch about a curve that was fitted to
    readings, which are too few to show it; None: found. `next_cut` is what is remembered of the next cut; where that
    makes the curve, `scattered` is the touches' own, about which they show how they scatter.
    """

    chain: Chain
    touches: NDArray[np.intp]
    fit: SplineFit
    sources: Sources
    knot_every: tuple[int | None, ...]
    notes: tuple[str, ...]
    residual_mm: Array
    leave_one_out_mm: Array
    spare: int
    from_model_mm: Array | None = None
    unsupported: bool = False
    scatter_mm: float | None = None
    next_cut: NextCut | None = None
    scattered: SplineFit | None = None

    @property
    def scattered_mm(self) -> Array:
        """Residuals about the touches' own curve, (n,)."""
        return self.residual_mm if self.scattered is None else self.scattered.residual_mm

    @property
    def through_touches(self) -> SplineFit | None:
        """Returns the fit to the chain's touches alone; None where there is none."""
        if not len(self.touches) or self.scatter_mm is not None:
            return None
        if self.scattered is not None:
            return self.scattered
        return self.fit if self.from_model_mm is None else None

    def places_mm(self, vectors: ErrorVectors) -> Array:
        """Returns the arc lengths of its touches along the chain, (n,)."""
        start = dict(zip(self.chain.features, self.chain.starts_mm, strict=True))
        starts = np.array([start[i] for i in vectors.feature_index[self.touches].tolist()])
        return np.clip(starts + vectors.arc_length_mm[self.touches], 0.0, self.chain.length_mm)


def own_fit(
    chain: Chain,
    touches: ChainTouches,
    fit: SplineFit,
    sources: Sources,
    note: str,
    knot_every: tuple[int | None, ...] | None = None,
) -> ChainFit:
    """Fits a chain to its own touches."""
    return ChainFit(
        chain=chain,
        touches=touches.positions,
        fit=fit,
        sources=sources,
        knot_every=knot_every or (None,) * len(chain.features),
        notes=(note,),
        residual_mm=fit.residual_mm,
        leave_one_out_mm=fit.leave_one_out_mm,
        spare=fit.degrees_of_freedom,
    )


def touches_of(profile: Profile, chain: Chain, vectors: ErrorVectors) -> ChainTouches:
    """Collects them; refuses touches beyond their feature."""
    positions, along = [], []
    for index, start in zip(chain.features, chain.starts_mm, strict=True):
        mine = vectors.of_feature(index)
        mine = mine[np.argsort(vectors.arc_length_mm[mine], kind="stable")]
        length = profile.features[index].length_mm
        beyond = np.maximum(-vectors.arc_length_mm[mine], vectors.arc_length_mm[mine] - length)
        if np.any(beyond > ROUNDING_MM):
            raise _beyond(profile.features[index].name, vectors.point[mine[np.argmax(beyond)]], float(np.max(beyond)))
        positions.append(mine)
        along.append(start + np.clip(vectors.arc_length_mm[mine], 0.0, length))
    order = np.concatenate(positions)
    return ChainTouches(order, np.concatenate(along), vectors.error_mm[order], tuple(along))


def _beyond(name: str, point: str, beyond_mm: float) -> TrueloopError:
    return Code.FIT_OUTSIDE.refusal(
        f"touch {point!r} lies {beyond_mm:.3f} mm beyond the end of {name!r}; at most {ROUNDING_MM} mm is rounding",
        hint="give the touch to the feature it lies on, or mend the nominal coordinates",
        values={"point": point, "feature": name, "beyond_mm": beyond_mm, "limit_mm": ROUNDING_MM},
    )


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
