"""The fit of arcs and bent lines: a cubic spline with ends by the neighbours [6517 §4], as stiff as touches require."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import fdtrc

from trueloop.errors import Code
from trueloop.statistics import rms
from trueloop.turned.fit.chain_fit import (
    Chain,
    ChainFit,
    ChainTouches,
    Knots,
    Sources,
    candidates,
    every_rth,
    fit_determined,
    joint_repeats,
    own_fit,
)
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.spline import EndConditions, SplineFit
from trueloop.wording import Um, all_of, wording

SHAPES = (
    wording("constant"),
    wording("straight line over arc length"),
    wording("parabola over arc length"),
    wording("cubic"),
)


BENT_BY_CHANCE: Final = 0.02
"""The share of straight lines that pass for bent ones by the scatter of their touches."""

BENT_SPAN: Final = 0.7
"""Touches that span less than this share of a line do not show how it bends at its ends."""

MOST_KNOTS: Final = 5
"""A bow is smooth over a third of its line; more knots would follow the waves of the surface."""

STRAIGHT_MM: Final = 0.0005
"""Every bend makes the program longer: a line this near to straight is straight."""


@dataclass(frozen=True)
class Shape:
    """A candidate: degree, and r of each feature (None: no knots)."""

    degree: int
    every: tuple[int | None, ...]

    def knots(self, points: int) -> int:
        """Returns about how many knots a feature with so many touches has."""
        return max((points // r for r in self.every if r), default=0)


@dataclass(frozen=True)
class Tried:
    """A candidate's fit and the knots that it kept."""

    shape: Shape
    fit: SplineFit
    knots: Knots

    @property
    def unknowns(self) -> int:
        """Returns the number of free coefficients."""
        return len(self.fit.spline.coefficients_mm) - self.fit.conditions.count

    @property
    def left_out_rms_mm(self) -> float:
        """Returns the leave-one-out RMS; infinite where some touch cannot be predicted from the others."""
        error = self.fit.leave_one_out_mm
        return float("inf") if np.any(np.isnan(error)) else rms(error)


def fit_arcs(
    names: Sequence[str],
    chain: Chain,
    touches: ChainTouches,
    options: FitOptions,
    conditions: EndConditions,
    sources: Sources,
) -> ChainFit:
    """Fits one spline over arcs joined tangentially.

    Where the user gives r, a cubic spline with those knots, or FIT-POINTS when the touches are fewer than its unknowns.
    Otherwise the least leave-one-out error chooses among a constant, a straight line, a parabola, a cubic, and cubic
    splines with knots at every r-th touch; of equals the simplest (the largest r). One touch makes one unknown.
    """
    asked = [options.knot_every_for(name) for name in names]
    for name, r in zip(names, asked, strict=True):
        if r is not None and r < 2:
            raise Code.FIT_KNOTS.refusal(
                f"{name}: `knot_every` is {r}; a knot at every r-th touch needs r of at least 2",
                hint="3 is the published choice, 4 to 5 suit smooth errors; without `compensation.knot_every` "
                "leave-one-out chooses",
            )
    shapes = _shapes(asked, max(len(points) for points in touches.by_feature_mm))
    fitting = [shape for shape in shapes if shape.degree + 1 >= conditions.coefficients]
    tried = [_try(shape, chain, touches, options, conditions) for shape in fitting]
    if None not in asked:
        _refuse_dropped_knots(names, touches, tried[0], chain, options)
    best = _best([one for one in tried if one.unknowns > 0] or tried)
    return _described(names, chain, touches, sources, best, None in asked)


def fit_bent(
    names: Sequence[str], chain: Chain, touches: ChainTouches, options: FitOptions, sources: Sources, straight: ChainFit
) -> ChainFit | None:
    """Fits a curve over lines that the touches show to be bent: a bow of deflection or of a hot bed. None where a
    straight line is near enough.

    Of a parabola, a cubic and cubic splines the least leave-one-out error chooses, as on arcs. The curve has to explain
    more than `BENT_BY_CHANCE` allows (F-test of the two residual sums of squares, Bonferroni over the curves), to
    deviate from the straight line by `STRAIGHT_MM` at some touch, and to predict left out touches better. Valid within
    the touches: they have to span `BENT_SPAN` of the line, for a bow that is drawn out grows with the square of the
    distance.
    """
    s, spare = touches.arc_length_mm, straight.spare
    if spare < 3 or float(np.ptp(s)) < BENT_SPAN * chain.length_mm or straight.fit.conditions.count:
        return None
    count = max(len(points) for points in touches.by_feature_mm)
    shapes = [one for one in _shapes((None,) * len(names), count) if one.degree > 1 and one.knots(count) <= MOST_KNOTS]
    tried = [_try(shape, chain, touches, options, EndConditions()) for shape in shapes]
    stiff = [one for one in tried if 2 < one.unknowns <= len(s) // 2 + 1 and 0 < one.fit.degrees_of_freedom < spare]
    if not stiff:
        return None
    best = _best(stiff)
    free, left_mm2 = best.fit.degrees_of_freedom, float(np.sum(best.fit.residual_mm**2))
    explained_mm2 = float(np.sum(straight.residual_mm**2)) - left_mm2
    chance = fdtrc(spare - free, free, explained_mm2 * free / (max(left_mm2, 1e-30) * (spare - free)))
    bent = float(np.max(np.abs(straight.residual_mm - best.fit.residual_mm))) >= STRAIGHT_MM
    predicts = best.left_out_rms_mm < rms(straight.leave_one_out_mm)
    if not (bent and predicts and chance <= BENT_BY_CHANCE / len(stiff)):
        return None
    return _described(names, chain, touches, sources, best, True)


def _described(
    names: Sequence[str], chain: Chain, touches: ChainTouches, sources: Sources, best: Tried, chosen: bool
) -> ChainFit:
    note = wording("{feature}: {note}", feature=all_of(names), note=_describe(best, len(touches.positions), chosen))
    return own_fit(chain, touches, best.fit, sources, note, best.shape.every)


def _shapes(degrees: Sequence[int | None], touches: int) -> list[Shape]:
    """Simplest first."""
    if None not in degrees:
        return [Shape(3, tuple(degrees))]
    cubics = [Shape(3, tuple(given or r for given in degrees)) for r in candidates(touches)]
    simple = [Shape(degree, (None,) * len(degrees)) for degree in (0, 1, 2)]
    return cubics if any(degrees) else simple + cubics


def _try(shape: Shape, chain: Chain, touches: ChainTouches, options: FitOptions, conditions: EndConditions) -> Tried:
    knots = _knots(shape, chain, touches, options)
    s, error = touches.arc_length_mm, touches.error_mm
    fit, kept = fit_determined(s, error, knots, chain.length_mm, shape.degree, conditions)
    return Tried(shape, fit, kept)


def _knots(shape: Shape, chain: Chain, touches: ChainTouches, options: FitOptions) -> Knots:
    at_points: list[float] = []
    for points, r in zip(touches.by_feature_mm, shape.every, strict=True):
        at_points += every_rth(points, chain.starts_mm, chain.length_mm, r) if r else ()
    repeats = joint_repeats(options.junctions, shape.degree)
    return Knots(tuple(at_points), chain.joints_mm if repeats > 0 else (), repeats)


def _best(tried: Sequence[Tried]) -> Tried:
    """Returns the fit of the least leave-one-out error; the first of those that differ by rounding only."""
    least = min(one.left_out_rms_mm for one in tried)
    return next(one for one in tried if one.left_out_rms_mm <= least * (1.0 + 1e-9))


def _describe(best: Tried, touches: int, chosen: bool) -> str:
    text = SHAPES[best.fit.spline.degree]
    if best.knots.at_points_mm:
        text = wording(
            "cubic spline, {n} knots, one at every r-th touch, r = {r}",
            n=len(best.knots.at_points_mm),
            r=", ".join(str(r) for r in best.shape.every),
        )
    if not chosen:
        return text
    if np.isinf(best.left_out_rms_mm):
        return wording(
            "{curve}: {n} touches carry no more, and none can be left out to check it", curve=text, n=touches
        )
    left_out = Um(best.left_out_rms_mm, ".2f")
    return wording(
        "{curve}, chosen by leave-one-out ({left_out} RMS over {n} touches)", curve=text, left_out=left_out, n=touches
    )


def _refuse_dropped_knots(
    names: Sequence[str], touches: ChainTouches, tried: Tried, chain: Chain, options: FitOptions
) -> None:
    """Refuses requested knots for which there are too few touches, instead of dropping them in silence."""
    asked = _knots(tried.shape, chain, touches, options)
    needed = len(asked.interior_mm) + 4 - tried.fit.conditions.count
    if len(touches.positions) < needed:
        raise Code.FIT_POINTS.refusal(
            f"{' and '.join(names)}: {len(touches.positions)} touches, but the knots asked for need {needed}",
            hint="leave `compensation.knot_every` out, make it larger, or touch the feature at more points",
            values={"touches": len(touches.positions)},
        )
