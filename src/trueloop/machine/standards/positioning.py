"""Accuracy and repeatability of positioning of one axis after ISO 230-2:2014, clause 3 (definitions) and 7.

Deviations are actual − target, mm (or rad). ↑ is the approach towards larger coordinates. n approaches to each of m
targets each way.
"""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError


@dataclass(frozen=True)
class BothWays:
    """A value for the approach from below (↑), from above (↓), and for both together."""

    up: float
    down: float
    both: float


@dataclass(frozen=True)
class Positioning:
    """The standard's values. Arrays have one entry a target, in ascending order of `target`.

    `accuracy` A, A↑, A↓; `repeatability` R, R↑, R↓; `systematic` E, E↑, E↓; `mean_range` M; `reversal` B and its mean.
    `deviation_up` and `deviation_down` are the raw deviations (targets, approaches). All in mm, rad where `angular`.
    """

    target: Array
    deviation_up: Array
    deviation_down: Array
    mean_up: Array
    mean_down: Array
    spread_up: Array
    spread_down: Array
    accuracy: BothWays
    repeatability: BothWays
    systematic: BothWays
    mean_range: float
    reversal: float
    mean_reversal: float
    angular: bool = False


def positioning(target: Array, deviation_up: Array, deviation_down: Array, *, angular: bool = False) -> Positioning:
    """Analyses deviations (targets, approaches) of both ways. Raises MCH-DATA for too few or missing approaches."""
    _check(target, deviation_up, deviation_down)
    order = np.argsort(target)
    up, down = deviation_up[order], deviation_down[order]
    mean_up, mean_down = up.mean(axis=1), down.mean(axis=1)
    spread_up, spread_down = up.std(axis=1, ddof=1), down.std(axis=1, ddof=1)
    reversal = mean_up - mean_down
    mean = 0.5 * (mean_up + mean_down)
    highest = np.array([mean_up + 2 * spread_up, mean_down + 2 * spread_down])
    lowest = np.array([mean_up - 2 * spread_up, mean_down - 2 * spread_down])
    means = np.array([mean_up, mean_down])
    at_target = np.array([4 * spread_up, 4 * spread_down, 2 * spread_up + 2 * spread_down + np.abs(reversal)])
    return Positioning(
        target=target[order],
        deviation_up=up,
        deviation_down=down,
        mean_up=mean_up,
        mean_down=mean_down,
        spread_up=spread_up,
        spread_down=spread_down,
        accuracy=_spans(highest, lowest),
        repeatability=BothWays(float(at_target[0].max()), float(at_target[1].max()), float(at_target.max())),
        systematic=_spans(means, means),
        mean_range=float(np.ptp(mean)),
        reversal=float(np.abs(reversal).max()),
        mean_reversal=float(reversal.mean()),
        angular=angular,
    )


def _spans(highest: Array, lowest: Array) -> BothWays:
    """Largest of the one minus smallest of the other: each way, and over both."""
    up, down = highest.max(axis=1) - lowest.min(axis=1)
    return BothWays(float(up), float(down), float(highest.max() - lowest.min()))


def _check(target: Array, up: Array, down: Array) -> None:
    if up.shape != down.shape or up.ndim != 2 or len(target) != len(up):
        raise TrueloopError(
            Code.MCH_DATA,
            f"{len(target)} targets, deviations ↑ {up.shape} and ↓ {down.shape} do not make one table",
            hint="every target needs the same number of approaches from below and from above",
        )
    if up.shape[0] < 2 or up.shape[1] < 2 or not (np.isfinite(up).all() and np.isfinite(down).all()):
        raise TrueloopError(
            Code.MCH_DATA,
            f"{up.shape[0]} targets with {up.shape[1]} approaches each way, some missing: no spread can be computed",
            hint="the standard asks for five targets a metre at least and five approaches each way",
        )
