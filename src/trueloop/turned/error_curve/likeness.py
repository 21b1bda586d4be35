"""Touches that lie close: how far along a cut its scatter is alike, and what that does to the curve through them.

A process that varies along the cut over a millimetre or two displaces neighbouring touches alike. Taken for
independent, they scatter too little about a curve that follows them too well: with touches 1.5 mm apart, of a process
alike over 1 mm, bands of 95 % hold 91 %. Nobody knows the length beforehand, so the residuals of all curves say how
probable each is (`process_scatter`). What is alike over several millimetres looks like the feature's own error: no
touch of one part tells it, and `fit.between_cuts` holds it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.turned.error_curve.process_scatter import Spread, far_apart, process_scatter
from trueloop.turned.fit.chain_fit import ChainFit
from trueloop.turned.fit.spline import SplineFit
from trueloop.turned.touches.error_vectors import ErrorVectors

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
    roots = {i: near[i].response @ _root(one) for i, one in scattered.items() if fits[i].scattered is None}
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


def _root(covariance: Array) -> Array:
    values, directions = np.linalg.eigh(covariance)
    return np.asarray(directions * np.sqrt(np.maximum(values, 0.0)))
