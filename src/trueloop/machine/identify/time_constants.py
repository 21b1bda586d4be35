"""Time constants of lags: those with which the terms, fitted anew for each, leave least of the readings."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity
from trueloop.machine.model.history import Lag
from trueloop.machine.model.model import MachineModel

GRID = 9
"""Constants tried for each lag in turn, from bound to bound in equal ratios, before all are refined together."""

STEPS = 20
SMALL = 1e-6
"""A step of ln τ that ends the search: far below any uncertainty."""

Badness = Callable[[tuple[Lag, ...]], float]
"""Sum of squares that the best coefficients leave with lags of these constants."""

Step = Callable[[tuple[Lag, ...]], Array]
"""Gauss and Newton's step of ln τ from there, one number a lag that is sought."""


def sought_constants(lags: Sequence[Lag], badness: Badness, step: Step) -> tuple[Lag, ...]:
    """The lags with their constants found, those without bounds as they are: the best of a grid, then Gauss–Newton."""
    found = tuple(lags)
    for k, lag in enumerate(lags):
        tried = [_with_constant(found, k, tau) for tau in np.geomspace(*lag.between_s, GRID)] if lag.between_s else []
        found = min(tried, key=badness, default=found)
    least = badness(found)
    for _ in range(STEPS if any(lag.between_s for lag in lags) else 0):
        whole = step(found)
        for share in (1.0, 0.5, 0.25, 0.125, 0.0625):
            tried_lags = _moved(found, share * whole)
            if (error := badness(tried_lags)) <= least:
                break
        else:
            break
        found, least = tried_lags, error
        if np.abs(whole).max() < SMALL:
            break
    return found


def _with_constant(lags: tuple[Lag, ...], k: int, constant_s: float) -> tuple[Lag, ...]:
    return (*lags[:k], replace(lags[k], constant_s=float(constant_s)), *lags[k + 1 :])


def _moved(lags: tuple[Lag, ...], logarithms: Array) -> tuple[Lag, ...]:
    """Constants changed by factors exp(…), within their bounds."""
    sought = [k for k, lag in enumerate(lags) if lag.between_s]
    for k, by in zip(sought, logarithms, strict=True):
        lag = lags[k]
        assert lag.between_s is not None
        low, high = lag.between_s
        # a step of more than e-fold is beyond what the derivative says
        lags = _with_constant(lags, k, min(max(lag.constant_s * float(np.exp(np.clip(by, -1, 1))), low), high))
    return lags


def at_bounds(lags: Sequence[Lag]) -> list[Finding]:
    """A warning for each constant that came out at a bound: it was not found there, it was stopped there."""
    return [
        Finding(
            Severity.WARNING,
            Code.MCH_LAG,
            f"the time constant of {lag.name!r} ended at a bound: {lag.constant_s:.3g} s",
            hint="widen its bounds, or take the lag out: the readings do not show it",
            values={"lag": lag.name, "constant_s": lag.constant_s},
        )
        for lag in lags
        if lag.between_s is not None and min(abs(np.log(lag.constant_s / end)) for end in lag.between_s) < 1e-3
    ]


def with_lag_covariance(model: MachineModel, rows: Array, free: Array, scatter: float, slopes: Array) -> MachineModel:
    """Covariance of coefficients and ln τ together: of the problem made linear at its solution.

    `rows` and `slopes` are the weighted readings' derivatives by the free coefficients and by each ln τ.
    """
    sought = [k for k, lag in enumerate(model.lags) if lag.between_s is not None]
    both = np.hstack([rows, slopes[:, sought]])
    scale = np.maximum(np.linalg.norm(both, axis=0), 1e-300)
    variance = scatter**2 * (len(rows) - rows.shape[1]) / max(len(rows) - both.shape[1], 1)
    small = variance * np.linalg.pinv((both / scale).T @ (both / scale)) / np.outer(scale, scale)
    spread = np.zeros((len(free) + len(model.lags), both.shape[1]))
    spread[: len(free), : rows.shape[1]] = free
    spread[len(free) + np.array(sought, dtype=int), rows.shape[1] + np.arange(len(sought))] = 1.0
    covariance = spread @ small @ spread.T
    deviation = np.sqrt(np.diag(covariance)[len(free) :])
    lags = tuple(replace(lag, u_relative=float(u)) for lag, u in zip(model.lags, deviation, strict=True))
    return replace(model, covariance=covariance, lags=lags)
