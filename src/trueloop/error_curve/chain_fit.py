"""The fit of one chain: a straight line along lines, a cubic spline along arcs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.error_curve.chain import Chain, End
from trueloop.error_curve.knots import Knots, candidates, every_rth, fit_determined, joint_repeats
from trueloop.error_curve.options import FitOptions
from trueloop.error_curve.spline import EndConditions, SplineFit
from trueloop.errors import Code, TrueloopError
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.geometry.feature import Array
from trueloop.geometry.profile import Profile
from trueloop.units import UM_PER_MM

SHORT_SPAN: Final = 0.1
"""Touches that span less than this share of a line say nothing of its slope: drawn out to the ends, their scatter would
be multiplied by ten and more. The line gets a constant."""

ROUNDING_MM: Final = 0.01
"""How far a touch may lie beyond its feature's end and still be taken for one at the end."""


@dataclass(frozen=True)
class ConditionSource:
    """Where the conditions at one end of a chain come from: a neighbour's end, or an estimate with its uncertainty."""

    neighbour: End | None = None
    standard_u_mm: float = 0.0


@dataclass(frozen=True)
class ChainFit:
    """A fitted chain. `knot_every` has one entry a feature; `touches` are positions in the error vectors."""

    chain: Chain
    touches: NDArray[np.intp]
    fit: SplineFit
    sources: tuple[ConditionSource, ConditionSource]
    knot_every: tuple[int | None, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class ChainTouches:
    """The touches of a chain in order of arc length along it."""

    positions: NDArray[np.intp]
    arc_length_mm: Array
    error_mm: Array
    by_feature_mm: tuple[Array, ...]


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


def fit_chain(
    profile: Profile, chain: Chain, touches: ChainTouches, options: FitOptions, conditions: EndConditions
) -> tuple[SplineFit, tuple[int | None, ...], tuple[str, ...]]:
    """Fit, r of each feature, and notes."""
    names = tuple(profile.features[i].name for i in chain.features)
    if chain.curved:
        return _fit_arcs(chain, names, touches, options, conditions)
    fit, note = _fit_lines(chain, touches, options, conditions)
    return fit, (None,) * len(names), (f"{' and '.join(names)}: {note}",)


def _fit_lines(
    chain: Chain, touches: ChainTouches, options: FitOptions, conditions: EndConditions
) -> tuple[SplineFit, str]:
    s = touches.arc_length_mm
    short = len(s) > 1 and float(np.ptp(s)) < SHORT_SPAN * chain.length_mm and not conditions.count
    degree = 0 if short else 1
    repeats = joint_repeats(options.tangent_policy, 1) if degree else 0
    knots = Knots((), chain.joints_mm if repeats else (), repeats)
    fit, _ = fit_determined(s, touches.error_mm, knots, chain.length_mm, degree, conditions)
    if short:
        return fit, f"{len(s)} touches span less than a tenth of the length: their mean, no slope"
    if fit.spline.degree == 0:
        return fit, "one touch: its error holds for the whole feature, a taper cannot be seen"
    return fit, f"straight line through {len(s)} touches by least squares"


def _fit_arcs(
    chain: Chain, names: Sequence[str], touches: ChainTouches, options: FitOptions, conditions: EndConditions
) -> tuple[SplineFit, tuple[int | None, ...], tuple[str, ...]]:
    asked = [options.knot_every_for(name) for name in names]
    counts = [len(points) for points in touches.by_feature_mm]
    for name, r in zip(names, asked, strict=True):
        if r is not None and r < 2:
            raise _bad_knot_every(name, r)
    tried = [1] if None not in asked else candidates(max(counts))
    best: tuple[float, SplineFit, Knots, int] | None = None
    for r in tried:
        knots = _knots(chain, touches, [given or r for given in asked], options)
        fit, kept = fit_determined(touches.arc_length_mm, touches.error_mm, knots, chain.length_mm, 3, conditions)
        error = _leave_one_out_rms(fit)
        if best is None or error < best[0] * (1.0 - 1e-9):
            best = (error, fit, kept, r)
    assert best is not None  # `candidates` is never empty
    error, fit, kept, r = best
    every = tuple(given or r for given in asked)
    if None not in asked:
        _refuse_dropped_knots(names, touches, _knots(chain, touches, every, options), fit)
    return fit, every, (_describe(names, fit, kept, every, None in asked, error),)


def _knots(chain: Chain, touches: ChainTouches, every: Sequence[int], options: FitOptions) -> Knots:
    at_points: list[float] = []
    for points, r in zip(touches.by_feature_mm, every, strict=True):
        at_points += every_rth([points], chain.starts_mm, chain.length_mm, r)
    return Knots(tuple(at_points), chain.joints_mm, joint_repeats(options.tangent_policy, 3))


def _leave_one_out_rms(fit: SplineFit) -> float:
    """Infinite where some touch cannot be predicted from the others."""
    error = fit.leave_one_out_mm
    return float("inf") if np.any(np.isnan(error)) else float(np.sqrt(np.mean(error**2)))


def _describe(
    names: Sequence[str], fit: SplineFit, kept: Knots, every: Sequence[int], chosen: bool, error: float
) -> str:
    who = " and ".join(names)
    if fit.spline.degree < 3:
        shape = ("constant", "straight line", "parabola")[fit.spline.degree]
        return f"{who}: {len(fit.residual_mm)} touches carry no more than a {shape} over arc length"
    r = ", ".join(str(r) for r in every)
    text = f"{who}: cubic spline with {len(kept.at_points_mm)} knots, every r-th touch, r = {r}"
    return f"{text}, chosen by leave-one-out ({error * UM_PER_MM:.2f} µm RMS)" if chosen else text


def _refuse_dropped_knots(names: Sequence[str], touches: ChainTouches, asked: Knots, fit: SplineFit) -> None:
    """The user asked for these knots: too few touches for them is refused, not mended in silence."""
    needed = len(asked.interior_mm) + 4 - fit.conditions.count
    if len(touches.positions) < needed:
        raise TrueloopError(
            Code.FIT_POINTS,
            f"{' and '.join(names)}: {len(touches.positions)} touches, but the knots asked for need {needed}",
            hint="leave `knot_every` out, make it larger, or touch the feature at more points",
        )


def _bad_knot_every(name: str, r: int) -> TrueloopError:
    return TrueloopError(
        Code.FIT_KNOTS,
        f"{name}: a knot at every {r}. touch cannot be fitted; r is at least 2",
        hint="3 is the published choice, 4 to 5 suit smooth errors; without `knot_every` leave-one-out chooses",
    )


def _beyond(name: str, point: str, beyond_mm: float) -> TrueloopError:
    return TrueloopError(
        Code.FIT_OUTSIDE,
        f"touch {point!r} lies {beyond_mm:.3f} mm beyond the end of {name!r}; at most {ROUNDING_MM} mm is rounding",
        hint="give the touch to the feature it lies on, or mend the nominal coordinates",
    )
