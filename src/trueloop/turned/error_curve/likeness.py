"""Touches that lie close: how far along a cut its scatter is alike, and what that does to the curve through them.

A process that varies along the cut over a millimetre or two displaces neighbouring touches alike. Taken for
independent, they scatter too little about a curve that follows them too well: with touches 1.5 mm apart, of a process
alike over 1 mm, bands of 95 % hold 91 %. Nobody knows the length beforehand, so the residuals of all curves say how
probable each is (`process_scatter`). What is alike over several millimetres looks like the feature's own error: no
touch of one part tells it, and `fit.between_cuts` holds it.

The scatter of the next cut by itself: the scatter of the touches less that of the probe.

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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from scipy.special import erf

from trueloop.arrays import Array
from trueloop.estimate.weights import probabilities
from trueloop.statistics import root_of
from trueloop.turned.error_curve.curve import COVERAGE, coverage_factor
from trueloop.turned.fit.chain_fit import ChainFit
from trueloop.turned.fit.spline import SplineFit
from trueloop.turned.touches.error_vectors import ErrorVectors

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


LENGTHS_MM: Final = (0.25, 0.75, 1.25, 1.75)
"""ℓ of the correlation exp(−d²/2ℓ²) of the process's scatter at two places d apart: any up to 2 mm is as probable as
any other, of which these are the middles of four parts. Mixed, they follow other shapes of correlation as well."""

SEEN: Final = 0.01
"""Touches are far apart where no two of a curve have more than this in common at the largest length."""

LEAST_SHARE: Final = 1e-6
"""The least share of the process's variance in a sum of residuals: two touches in one place differ by rounding
still."""

MOST: Final = 500
"""Touches of one curve; more know it so well that what they have in common no longer matters to its band."""


@dataclass(frozen=True, eq=False)
class Likeness:
    """`process_mm` as `ProcessScatter.standard_mm`, None without a touch to spare.

    `roots_mm`: of chains fitted to their touches, by index, a square root of their coefficients' covariance from the
    touches' scatter, (coefficients, touches). `touches_mm2`: of chains whose touches lie close, the covariance of their
    scatter, (touches, touches).
    """

    process_mm: float | None
    roots_mm: Mapping[int, Array] = field(default_factory=dict)
    touches_mm2: Mapping[int, Array] = field(default_factory=dict)


def likeness_of(
    fits: Mapping[int, ChainFit], scatter_mm: Mapping[int, float], vectors: ErrorVectors, stated_mm: float | None = None
) -> Likeness:
    """Estimates the likeness from the touches of all chains; `scatter_mm` is the standard deviation of a touch, by
    chain.

    `stated_mm`: the length over which the process is alike, where it is known.
    """
    lengths_mm = LENGTHS_MM if stated_mm is None else (stated_mm,)
    solved = {i: _solved(fit, vectors) for i, fit in fits.items()}
    near = {i: one for i, one in solved.items() if one is not None and _near(one.apart_mm, lengths_mm[-1])}
    spreads = [_spread(fit, near.get(i), vectors, lengths_mm) for i, fit in fits.items() if fit.spare > 0]
    if not spreads:
        return Likeness(None)
    process = process_scatter(spreads)
    weights = process.length_weights
    if len(weights) < len(lengths_mm):  # no touches to spare lie close
        weights = np.full(len(lengths_mm), 1.0 / len(lengths_mm))
    scattered = {}
    for i, one in near.items():
        alike = sum(w * _alike(one.apart_mm, length) for w, length in zip(weights, lengths_mm, strict=True))
        own_mm2 = max(scatter_mm[i] ** 2 - process.standard_mm**2, _probe_mm2(fits[i], vectors))
        scattered[i] = process.standard_mm**2 * alike + own_mm2 * np.eye(len(one.apart_mm))
    roots = {i: near[i].response @ root_of(one) for i, one in scattered.items() if fits[i].scattered is None}
    return Likeness(process.standard_mm, roots, scattered)


@dataclass(frozen=True, eq=False)
class _Solved:
    """A least-squares fit as what it does to the touches' errors.

    Its coefficients follow them by `response` (coefficients, n); `spare` (n, ν) are orthonormal sums of them that no
    curve of its shape can have; `apart_mm` (n, n) distances along the chain.
    """

    response: Array
    spare: Array
    apart_mm: Array


def _solved(fit: ChainFit, vectors: ErrorVectors) -> _Solved | None:
    """None where the curve was not fitted to its touches, or to too many of them."""
    through = fit.through_touches
    if through is None or not 0 < len(fit.touches) <= MOST:
        return None
    spline, s = through.spline, fit.places_mm(vectors)
    free = _free(through)
    rows = spline.value_form(s).dense(len(spline.coefficients_mm)) @ free
    q, r = np.linalg.qr(rows, mode="complete")
    unknowns = rows.shape[1]
    response = free @ np.linalg.solve(r[:unknowns], q[:, :unknowns].T)
    return _Solved(response, q[:, unknowns:], np.abs(np.subtract.outer(s, s)))


def _free(through: SplineFit) -> Array:
    """Directions in which the coefficients may go under the end conditions, (coefficients, unknowns), orthonormal."""
    spline, count = through.spline, len(through.spline.coefficients_mm)
    ends = (0.0, 0.0, spline.length_mm, spline.length_mm)
    forms = (spline.value_form, spline.slope_form) * 2
    held = [
        form(at).dense(count)[0]
        for form, at, number in zip(forms, ends, through.conditions.numbers, strict=True)
        if number is not None
    ]
    if not held:
        return np.eye(count)
    return np.linalg.qr(np.array(held).T, mode="complete")[0][:, len(held) :]


def _spread(fit: ChainFit, near: _Solved | None, vectors: ErrorVectors, lengths_mm: Sequence[float]) -> Spread:
    """Returns the spread of one chain; `near` None: touches lie far apart, or its curve does not go through them."""
    residual, probe = fit.scattered_mm, _probe_mm2(fit, vectors)
    if near is None:
        return far_apart(fit.spare, float(np.sum(residual**2)), probe)
    sums = near.spare.T @ residual
    found = [np.linalg.eigh(near.spare.T @ _alike(near.apart_mm, length) @ near.spare) for length in lengths_mm]
    squares = np.array([(directions.T @ sums) ** 2 for _, directions in found])
    return Spread(squares, np.array([np.maximum(shares, LEAST_SHARE) for shares, _ in found]), probe)


def _probe_mm2(fit: ChainFit, vectors: ErrorVectors) -> float:
    return float(np.mean(vectors.own_u_mm[fit.touches] ** 2))


def _near(apart_mm: Array, longest_mm: float) -> bool:
    apart = apart_mm[~np.eye(len(apart_mm), dtype=bool)]
    return bool(np.any(_alike(apart, longest_mm) > SEEN))


def _alike(apart_mm: Array, length_mm: float) -> Array:
    """Returns the correlation of the process's scatter at places this far apart."""
    if length_mm == 0.0:
        return np.where(apart_mm == 0.0, 1.0, 0.0)
    return np.exp(-0.5 * (apart_mm / length_mm) ** 2)
