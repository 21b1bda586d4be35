"""How much the next cut scatters by itself: what the touches scatter by, less what the probe brought.

Touches scatter about their curve by process and probe together, the next cut by the process alone. With the probe's
variance u² known, the residuals of a curve with ν spare touches have the sum of squares S, and S/(v + u²) is χ² with
ν degrees of freedom: the restricted likelihood of v, the process's variance. S/ν − u² alone would be no estimate to
build a band on: it is uncertain by more than either, may be negative, and says nothing of that. So v is given the
distribution that the touches leave it (Jeffreys' prior, v ≥ 0), and the next cut is a normal scatter of unknown
variance v. Without a probe's share that is Student's distribution, to which the result is referred. With few touches,
or a process finer than its probe, the bands hold more than they promise.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import erf

from trueloop.arrays import Array
from trueloop.turned.error_curve.coverage import COVERAGE, coverage_factor

STEPS: Final = 400
"""Of the integral over the process's variance: what is held is known to 1e-4."""


@dataclass(frozen=True)
class Spread:
    """What one curve says of the scatter: residual sum of squares over `spare` touches, the probe's variance in it."""

    spare: int
    squares_mm2: float
    probe_mm2: float


def process_scatter_mm(spreads: Sequence[Spread]) -> float:
    """The standard deviation which times Student's k (of all spare touches) holds 95 % of what the next cut scatters.

    At most what the touches scatter by or the probe should, so that telling the two apart never widens a band; above
    zero even where the touches scatter less than the probe. Needs at least one spare touch. Valid where the probe's
    repeatability is as stated and touches scatter as cuts do.
    """
    spare = sum(one.spare for one in spreads)
    squares = math.fsum(one.squares_mm2 for one in spreads)
    probe = math.fsum(one.spare * one.probe_mm2 for one in spreads) / spare
    whole_mm = math.sqrt(max(squares / spare, probe))
    if probe == 0.0:
        return whole_mm
    variance, weight = _posterior(spreads, max(squares, 1e-9 * spare * probe), probe, spare)
    return min(_half_width(variance, weight) / coverage_factor(spare), whole_mm)


def _posterior(spreads: Sequence[Spread], squares: float, probe: float, spare: int) -> tuple[Array, Array]:
    """Process variances and their weights, at steps of x = S/(v + u²): χ² where all curves have the same u².

    The variance v is above zero up to x = S/u².
    """
    largest = min(squares / probe, spare + 12.0 * math.sqrt(2.0 * spare) + 40.0)
    root = (np.arange(STEPS) + 0.5) / STEPS
    x = largest * root**3  # small x, large variances: what few touches cannot exclude
    v = squares / x - probe
    log_weight, information = -4.0 * np.log(root), np.zeros(STEPS)
    for one in spreads:
        total = v + one.probe_mm2
        log_weight -= 0.5 * (one.spare * np.log(total) + one.squares_mm2 / total)
        information += one.spare / total**2
    log_weight += 0.5 * np.log(information)
    weight = np.exp(log_weight - np.max(log_weight))
    return v, weight / np.sum(weight)


def _half_width(variance: Array, weight: Array) -> float:
    """What holds `COVERAGE` of a normal scatter of these variances, by halving."""
    reach = np.sqrt(2.0 * variance)
    low, high = 0.0, 40.0 * float(np.max(reach))
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(weight @ erf(middle / reach)) < COVERAGE else (low, middle)
    return high
