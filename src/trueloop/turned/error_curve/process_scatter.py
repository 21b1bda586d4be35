"""The scatter of the next cut by itself: the scatter of the touches less that of the probe.

Touches scatter about their curve by process and probe together, the next cut by the process alone. Touches that lie
close have the process's scatter partly in common, and show less of it than there is; over which length it is alike,
they show as well (`likeness`). With the probe's variance u² known, and for a length ℓ, the residuals of a curve with ν
spare touches are ν independent sums, of variance λ v + u² each: v the process's variance, λ its share in the sum, 1
for touches far apart. That is the restricted likelihood of v and ℓ. An estimate of v alone is none to build a band on:
it is uncertain by more than either, may be negative, and says nothing of that. So v and ℓ are given the distribution
that the touches leave them (Jeffreys' prior of v ≥ 0, all lengths as probable as each other), and the next cut is a
normal scatter of unknown variance v. Far apart and without a probe's share that is Student's distribution, to which the
result is referred. With few touches, or a process finer than its probe, the bands hold more than they promise.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import erf

from trueloop.arrays import Array
from trueloop.estimate.grid import probabilities
from trueloop.turned.error_curve.coverage import COVERAGE, coverage_factor

STEPS: Final = 400
"""Of the integral over the process's variance: what is held is known to 1e-4."""

ROUNDING_MM2: Final = 1e-30
"""A residual sum of squares below this is rounding of touches that have no scatter."""


@dataclass(frozen=True, eq=False)
class Spread:
    """The evidence of one curve on the scatter: independent sums of its residuals, as many as it has touches to spare.

    `squares_mm2` are theirs, `shares` the part of the process's variance that each has beside the probe's `probe_mm2`;
    both (lengths, spare), a row for each length over which the process may be alike, or one row for all.
    """

    squares_mm2: Array
    shares: Array
    probe_mm2: float

    @property
    def spare(self) -> int:
        """Touches to spare."""
        return int(self.shares.shape[1])

    @property
    def total_mm2(self) -> float:
        """Returns the residual sum of squares."""
        return float(np.sum(self.squares_mm2[0]))


def far_apart(spare: int, squares_mm2: float, probe_mm2: float) -> Spread:
    """Returns the spread of touches that have nothing of the process in common."""
    return Spread(np.full((1, spare), squares_mm2 / spare), np.ones((1, spare)), probe_mm2)


@dataclass(frozen=True, eq=False)
class ProcessScatter:
    """`standard_mm` times Student's k (of all spare touches) holds 95 % of what the next cut scatters.

    `length_weights` (lengths,): how probable each length is over which the process may be alike.
    """

    standard_mm: float
    length_weights: Array


def process_scatter(spreads: Sequence[Spread]) -> ProcessScatter:
    """Estimates the scatter of the process from all curves together.

    At most what the touches scatter by or the probe should, so that telling the two apart never widens a band; above
    zero even where the touches scatter less than the probe. Needs at least one spare touch. Valid where the probe's
    repeatability is as stated and touches scatter as cuts do.
    """
    spare = sum(one.spare for one in spreads)
    squares = math.fsum(one.total_mm2 for one in spreads)
    probe = math.fsum(one.spare * one.probe_mm2 for one in spreads) / spare
    lengths = max(len(one.shares) for one in spreads)
    k = coverage_factor(spare)
    independent = squares < ROUNDING_MM2 or all(np.all(one.shares == 1.0) for one in spreads)
    whole_mm = math.sqrt(squares / spare)
    if not independent:
        whole_mm = _half_width(*_posterior(spreads, squares, 0.0, spare)) / k
    if independent and probe == 0.0:
        return ProcessScatter(whole_mm, np.full(lengths, 1.0 / lengths))
    variance, weight = _posterior(spreads, max(squares, 1e-9 * spare * probe), probe, spare)
    standard_mm = min(_half_width(variance, weight) / k, max(whole_mm, math.sqrt(probe)))
    return ProcessScatter(standard_mm, np.sum(weight, axis=1))


def _posterior(spreads: Sequence[Spread], squares: float, probe: float, spare: int) -> tuple[Array, Array]:
    """Process variances (steps,), and the weights of each with each length, (lengths, steps).

    At steps of x = S/(v + u²), which is χ² far apart where all curves have the same u². The variance v is above zero up
    to x = S/u². `probe` 0: the curves' own probe shares do not count.
    """
    largest = spare + 12.0 * math.sqrt(2.0 * spare) + 40.0
    largest = min(squares / probe, largest) if probe > 0.0 else largest
    root = (np.arange(STEPS) + 0.5) / STEPS
    x = largest * root**3  # small x, large variances: what few touches cannot exclude
    v = squares / x - probe
    log_weight: Array = -4.0 * np.log(root)[None, :]
    information: Array = np.zeros((1, STEPS))
    for one in spreads:
        shares, squared = one.shares[:, None, :], one.squares_mm2[:, None, :]
        total = v[:, None] * shares + (one.probe_mm2 if probe > 0.0 else 0.0)
        log_weight = log_weight - 0.5 * np.sum(np.log(total) + squared / total, axis=-1)
        information = information + np.sum((shares / total) ** 2, axis=-1)
    log_weight = log_weight + 0.5 * np.log(information)
    return v, probabilities(log_weight, axis=None)


def _half_width(variance: Array, weight: Array) -> float:
    """Returns the half width that holds `COVERAGE` of a normal scatter of these variances, by halving."""
    reach, weight = np.sqrt(2.0 * variance), np.sum(weight, axis=0)
    low, high = 0.0, 40.0 * float(np.max(reach))
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(weight @ erf(middle / reach)) < COVERAGE else (low, middle)
    return high
