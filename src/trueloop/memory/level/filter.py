"""A local level with an actuator of unknown gain, scatter and drift unknown: filtered exactly on a grid of both.

    error_k = level_k − gain · correction_k + ε_k,   level_k = level_{k−1} + η_k

ε has the standard deviation `scatter`, η that of `drift` per part. For given scatter and drift this is linear in
(level, gain) and normal, as the correction is known: a Kalman filter with two states. Scatter and drift are not known:
one filter runs for each of a grid of both, weighted by prior times likelihood of the parts so far. All that is asked
of it is then averaged over them, so that bands are not too narrow when few parts are known. The same is done for what
a correction may do: act as meant, not act at all, or act the wrong way. Nothing of this is adjusted to data.

It stops being valid where a level drifts in one direction for long (it lags by drift per part over weight) and where
errors have heavy tails.

All arrays may have axes in front: many series at once.
"""

import itertools
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.estimate.grid import probabilities
from trueloop.memory.level.step import LevelPrior

ACTS: Final = ((1.0, 1.0, 0.98), (0.0, 0.3, 0.01), (-1.0, 1.0, 0.01))
"""The possible effects of corrections, each with its gain, the gain's standard deviation in that of the prior, and its
probability: as meant; none, because something else makes the error; the wrong way."""
DEVIATIONS: Final = np.arange(-3.0, 3.01, 0.5)
"""The nodes of the grid, in standard deviations of the prior."""


@dataclass(frozen=True)
class Levels:
    """The knowledge of level and gain, for each of g cases of scatter, drift and effect of a correction; (…, g), mm.

    `log_weight` is not normalised; `as_meant` (g,) flags the cases in which corrections act as meant.
    """

    as_meant: Flags
    scatter: Array
    drift: Array
    log_weight: Array
    level: Array
    gain: Array
    level_var: Array
    covariance: Array
    gain_var: Array

    @property
    def share(self) -> Array:
        """Returns the probability of each case, (…, g)."""
        return probabilities(self.log_weight)

    def mean(self, values: Array) -> Array:
        """Returns the average over the cases, (…)."""
        return np.asarray((self.share * values).sum(axis=-1))

    def typical(self, deviations: Array) -> float:
        """Returns the geometric mean over the cases, of one series."""
        return float(np.exp(self.mean(np.log(deviations))))

    def total_u(self, means: Array, variances: Array) -> Array:
        """Returns the standard deviation, (…), including that of the cases' means about their average."""
        about = means - self.mean(means)[..., None]
        return np.asarray(np.sqrt(self.mean(variances + about**2)))


@dataclass(frozen=True)
class Seen:
    """The observation of one part: innovation and its standard deviation, mm; weight: share of it that is expected
    again of the next part with the same correction, the Kalman gain of level − gain · correction. All (…).
    """

    innovation: Array
    deviation: Array
    weight: Array


def unknown(prior: LevelPrior, shape: tuple[int, ...] = ()) -> Levels:
    """Returns the state before the first part."""
    cases = np.array(list(itertools.product(DEVIATIONS, DEVIATIONS, ACTS)), dtype=object)
    scatter, drift = cases[:, 0].astype(float), cases[:, 1].astype(float)
    gain, gain_sd, probability = np.array(list(cases[:, 2]), float).T
    full = np.ones((*shape, len(cases)))
    return Levels(
        as_meant=gain == 1.0,
        scatter=prior.scatter_mm * np.exp(prior.log_sd * scatter),
        drift=prior.drift_mm * np.exp(prior.log_sd * drift),
        log_weight=(np.log(probability) - 0.5 * (scatter**2 + drift**2)) * full,
        level=0.0 * full,
        gain=gain * full,
        level_var=prior.setting_mm**2 * full,
        covariance=0.0 * full,
        gain_var=(gain_sd * prior.gain_sd) ** 2 * full,
    )


def moved_on(known: Levels, parts: Array | float, set_before: Array | bool, prior: LevelPrior) -> Levels:
    """Returns the state before the part that comes `parts` later: the level has drifted; it is unknown again where the
    tool was set.
    """
    anew = np.asarray(set_before)[..., None]
    drifted = known.level_var + known.drift**2 * np.asarray(parts, float)[..., None]
    return replace(
        known,
        level=np.where(anew, 0.0, known.level),
        level_var=np.where(anew, prior.setting_mm**2, drifted),
        covariance=np.where(anew, 0.0, known.covariance),
    )


def predicted(known: Levels, correction: Array | float) -> tuple[Array, Array]:
    """Predicts the error of a part with that correction, and its variance with scatter, of each case; (…, g)."""
    c = np.asarray(correction, float)[..., None]
    variance = known.level_var - 2 * c * known.covariance + c**2 * known.gain_var + known.scatter**2
    return known.level - known.gain * c, variance


def learned(known: Levels, error: Array | float, correction: Array | float) -> tuple[Levels, Seen]:
    """Returns the state after a part cut with that correction and measured with that error; its observation."""
    c, (expected, variance) = np.asarray(correction, float)[..., None], predicted(known, correction)
    beyond = np.asarray(error, float)[..., None] - expected
    with_level = known.level_var - c * known.covariance
    with_gain = known.covariance - c * known.gain_var
    after = replace(
        known,
        log_weight=known.log_weight - 0.5 * (np.log(variance) + beyond**2 / variance),
        level=known.level + with_level / variance * beyond,
        gain=known.gain + with_gain / variance * beyond,
        level_var=known.level_var - with_level**2 / variance,
        covariance=known.covariance - with_level * with_gain / variance,
        gain_var=known.gain_var - with_gain**2 / variance,
    )
    mean = known.mean(expected)
    seen = Seen(
        np.asarray(error) - mean, known.total_u(expected, variance), after.mean(1 - known.scatter**2 / variance)
    )
    return after, seen


def best_correction(known: Levels) -> Array:
    """Returns the correction c that makes E[(level − gain · c)²] least: E[level · gain] / E[gain²], (…).

    It is smaller than level / gain where the gain is not well known. Corrections that do not act as meant have no best
    size: see `as_meant`; the averages are over the cases in which they do.
    """
    products = known.level * known.gain + known.covariance
    squares = known.gain**2 + known.gain_var
    return np.asarray(known.mean(known.as_meant * products) / known.mean(known.as_meant * squares))


def probably_acts(known: Levels) -> Array:
    """Returns the probability that corrections act as meant, (…)."""
    return known.mean(known.as_meant * np.ones_like(known.log_weight))


def cautious(correction: Array | float, largest_seen: Array | float, first_share: float) -> Array:
    """Limits a correction to what inspected parts confirm of corrections acting as meant, (…).

    Up to twice the largest correction that an inspected part was cut with, in size, it is applied whole; what goes
    beyond is held at that, and at `first_share` of the whole at least.
    """
    size = np.abs(correction)
    held = np.minimum(size, np.maximum(2 * np.asarray(largest_seen), first_share * size))
    return np.asarray(np.sign(correction) * held)
