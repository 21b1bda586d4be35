"""The correction of the next part, after each part of a series of one number: the weight is the Kalman gain.

The reports ask for weights of 0.50–0.75 that adjust themselves [4773 §2.5]. With a model of the series they follow
from it: the weight is what scatter, drift and the number of parts make of the Kalman gain. Two things that the model
does not know are dealt with beside it: the share of a correction that arrives is estimated, and a correction that no
inspected part has confirmed is applied with 0.75.

A local level with an actuator of unknown gain, scatter and drift unknown: filtered exactly on a grid of both.

    error_k = level_k − gain · correction_k + ε_k,   level_k = level_{k−1} + η_k

ε has the standard deviation `scatter`, η that of `drift` per part. For given scatter and drift this is linear in
(level, gain) and normal, as the correction is known: a Kalman filter with two states. Scatter and drift are not known:
one filter runs for each of a grid of both, weighted by prior times likelihood of the parts so far. All that is asked
of it is then averaged over them, so that bands are not too narrow when few parts are known. The same is done for what
a correction may do: act as meant, not act at all, or act the wrong way. Nothing of this is adjusted to data.

It stops being valid where a level drifts in one direction for long (it lags by drift per part over weight) and where
errors have heavy tails.

All arrays may have axes in front: many series at once.

A monitor of corrections by the signs of the remaining errors.

[4773 §2.5] warns of adjustments that "change their sign and steadily increase", and asks for a smaller weight; §3.5 has
the weight of a correction that changes its sign over several iterations reduced "by a standard percentage", and
increased where its value changes very little. Where the weight is right, what is left is white: a sign is as likely to
change as not.
"""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.estimate.weights import probabilities
from trueloop.units import UM_PER_MM
from trueloop.wording import Signed, Um, wording

REDUCED: Final = 0.8
"""The factor by which a weight is multiplied, or divided to increase it: the standard percentage is 20 %."""
LEAST: Final = 0.1
LATEST: Final = 12
"""Pairs of parts that the monitor looks at, and as many as it needs."""
SUSPECT: Final = 0.01
"""The probability of signs as uneven by chance below which the monitor reports them."""


@dataclass(frozen=True)
class PartReading:
    """One part as inspected: one number.

    `error_mm` is positive where material was left on; `correction_mm` is what the corrections in force took off when
    the part was cut, all together, positive where material was taken off. Nothing corrected: 0.

    `set_before`: the tool was set, turned or changed since the part before. `parts_since` counts the parts cut since
    the one before, itself included: 2 where one was not inspected. `counts` False: a record in quarantine, from which
    nothing is learned.
    """

    error_mm: float
    correction_mm: float = 0.0
    set_before: bool = False
    parts_since: float = 1.0
    counts: bool = True


@dataclass(frozen=True)
class Weight:
    """The share of a part's innovation by which the next correction moves, and the reason for its change."""

    value: float
    before: float | None
    reason: str


@dataclass(frozen=True)
class Step:
    """The step after one part: the correction of the next. Lengths in mm.

    `correction_mm` is the whole correction to be in force, `change_mm` how much more that is than this part had. The
    sign is that of `PartReading`: positive takes material off. `level_mm` is the error had nothing been corrected,
    now, with its standard uncertainty; `gain` the share of a correction that arrives. `predicted_mm` is the error to
    expect of the next part with that correction and `predicted_u_mm` the standard deviation of what an inspection
    will find about it, its scatter included. `innovation_mm` is what this part showed beyond what was predicted for
    it, with the standard deviation that it had to be expected with.

    Values that a rule without a model has no estimate of are None.
    """

    correction_mm: float
    change_mm: float
    weight: Weight
    predicted_mm: float
    predicted_u_mm: float | None = None
    level_mm: float | None = None
    level_u_mm: float | None = None
    scatter_mm: float | None = None
    drift_mm: float | None = None
    gain: float | None = None
    gain_u: float | None = None
    innovation_mm: float | None = None
    innovation_sd_mm: float | None = None
    held: bool = False
    """The correction stays as it is: what was corrected does not act, or acts the wrong way."""


@dataclass(frozen=True)
class LevelPrior:
    """The belief of a series before its first part; lengths in mm, of the error as inspected.

    Medians of general turning: 20 µm of setting; 2.5 µm of scatter, which is 2 µm of clamping and 1.5 µm of
    measurement; 0.5 µm of drift from part to part. Scatter and drift are log-normal with a standard deviation of
    their logarithm of `log_sd`: one standard deviation is a factor of 2.7. The share of a correction that arrives is
    normal, 1 ± `gain_sd`.
    """

    setting_mm: float = 20 / UM_PER_MM
    scatter_mm: float = 2.5 / UM_PER_MM
    drift_mm: float = 0.5 / UM_PER_MM
    log_sd: float = 1.0
    gain_sd: float = 0.3
    first_share: float = 0.75
    """The share of a correction that is applied while no inspected part has confirmed it."""


TURNING: Final = LevelPrior()


@dataclass(frozen=True)
class Whiteness:
    """The evidence that the signs of the latest innovations give of the weight. `agreeing` of `pairs` neighbours have
    the same sign; `probability` is that of an outcome as uneven by chance. `says` is empty where nothing is suspect.
    """

    pairs: int
    agreeing: int
    probability: float
    says: str = ""


def monitor(innovations: Array) -> Whiteness:
    """Tests the latest innovations of a series, (parts,): those of a right model are white.

    With fewer than twelve pairs nothing is reported: the probability is 1. Counts beyond chance are by the binomial
    distribution, two-sided. It notices a weight that is far off, not what a single part shows: see `memory.noticing`.
    """
    signs = np.sign(innovations[np.isfinite(innovations) & (innovations != 0)])[-LATEST - 1 :]
    same = signs[1:] == signs[:-1]
    seen = Whiteness(len(same), int(same.sum()), 1.0)
    if len(same) < LATEST:
        return seen
    from scipy.stats import binomtest

    seen = replace(seen, probability=float(binomtest(seen.agreeing, seen.pairs).pvalue))
    if seen.probability >= SUSPECT:
        return seen
    said = (
        wording("what is left keeps its sign: more of it could be corrected")
        if seen.agreeing > seen.pairs / 2
        else wording("what is left changes its sign from part to part: too much of it is corrected")
    )
    return replace(seen, says=said)


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
class LevelObservation:
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


def moved_on(levels: Levels, parts: Array | float, set_before: Array | bool, prior: LevelPrior) -> Levels:
    """Returns the state `parts` later: the level has drifted; it is unknown again where the tool was set."""
    anew = np.asarray(set_before)[..., None]
    drifted = levels.level_var + levels.drift**2 * np.asarray(parts, float)[..., None]
    return replace(
        levels,
        level=np.where(anew, 0.0, levels.level),
        level_var=np.where(anew, prior.setting_mm**2, drifted),
        covariance=np.where(anew, 0.0, levels.covariance),
    )


def predicted(levels: Levels, correction: Array | float) -> tuple[Array, Array]:
    """Predicts the error of a part with that correction, and its variance with scatter, of each case; (…, g)."""
    c = np.asarray(correction, float)[..., None]
    variance = levels.level_var - 2 * c * levels.covariance + c**2 * levels.gain_var + levels.scatter**2
    return levels.level - levels.gain * c, variance


def learned(levels: Levels, error: Array | float, correction: Array | float) -> tuple[Levels, LevelObservation]:
    """Returns the state after a part cut with that correction and measured with that error; its observation."""
    c, (expected, variance) = np.asarray(correction, float)[..., None], predicted(levels, correction)
    beyond = np.asarray(error, float)[..., None] - expected
    with_level = levels.level_var - c * levels.covariance
    with_gain = levels.covariance - c * levels.gain_var
    after = replace(
        levels,
        log_weight=levels.log_weight - 0.5 * (np.log(variance) + beyond**2 / variance),
        level=levels.level + with_level / variance * beyond,
        gain=levels.gain + with_gain / variance * beyond,
        level_var=levels.level_var - with_level**2 / variance,
        covariance=levels.covariance - with_level * with_gain / variance,
        gain_var=levels.gain_var - with_gain**2 / variance,
    )
    mean = levels.mean(expected)
    seen = LevelObservation(
        np.asarray(error) - mean, levels.total_u(expected, variance), after.mean(1 - levels.scatter**2 / variance)
    )
    return after, seen


def best_correction(levels: Levels) -> Array:
    """Returns the correction c that makes E[(level − gain · c)²] least: E[level · gain] / E[gain²], (…).

    It is smaller than level / gain where the gain is not well known. Corrections that do not act as meant have no best
    size: see `as_meant`; the averages are over the cases in which they do.
    """
    products = levels.level * levels.gain + levels.covariance
    squares = levels.gain**2 + levels.gain_var
    return np.asarray(levels.mean(levels.as_meant * products) / levels.mean(levels.as_meant * squares))


def cautious(correction: Array | float, largest_seen: Array | float, first_share: float) -> Array:
    """Limits a correction to what inspected parts confirm of corrections acting as meant, (…).

    Up to twice the largest correction that an inspected part was cut with, in size, it is applied whole; what goes
    beyond is held at that, and at `first_share` of the whole at least.
    """
    size = np.abs(correction)
    held = np.minimum(size, np.maximum(2 * np.asarray(largest_seen), first_share * size))
    return np.asarray(np.sign(correction) * held)


LEAST_GAIN: Final = 0.25
"""The least gain: where less of a correction arrives, something else than what is corrected makes the error."""
PROBABLE: Final = 0.5
"""Below this probability that corrections act as meant, none is changed."""
ALIKE: Final = 0.02
"""Weights that differ by less are called the same."""


@dataclass(frozen=True)
class _Past:
    """The state that one part passes to the next."""

    known: Levels
    largest_mm: float = 0.0
    parts: int = 0
    step: Step | None = None
    limited: bool = False


def steps(readings: Sequence[PartReading], prior: LevelPrior = TURNING) -> tuple[Step, ...]:
    """Returns one step a part, in the order in which they were cut; the last one holds the correction of the next part.

    Only parts before it and the part itself enter a step.

    >>> from trueloop.memory.level.kalman import steps
    >>> from trueloop.memory.level.kalman import PartReading
    >>> first, second = steps([PartReading(0.0200), PartReading(0.0070, correction_mm=0.0135)])
    >>> print(f"{1e3 * first.correction_mm:.1f} {1e3 * second.correction_mm:.1f} {second.gain:.2f}")
    13.0 20.0 0.97
    """
    return tuple(steps_as_they_come(readings, prior))


def steps_as_they_come(readings: Iterable[PartReading], prior: LevelPrior = TURNING) -> Iterator[Step]:
    """Yields each step of `steps` before the next reading is taken: a reading may depend on the step before it."""
    past = _Past(unknown(prior))
    for reading in readings:
        known = moved_on(past.known, reading.parts_since, reading.set_before, prior)
        after, seen = learned(known, reading.error_mm, reading.correction_mm)
        largest, parts = past.largest_mm, past.parts
        if reading.counts:
            known, largest, parts = after, max(largest, abs(reading.correction_mm)), parts + 1
        step, limited = _step(known, seen, reading, largest, prior)
        before = None if past.step is None else past.step.weight.value
        moved = Weight(step.weight.value, before, _reason(past, reading, step, limited, parts))
        past = _Past(known, largest, parts, replace(step, weight=moved), limited)
        assert past.step is not None
        yield past.step


def _step(
    levels: Levels, observation: LevelObservation, reading: PartReading, largest_mm: float, prior: LevelPrior
) -> tuple[Step, bool]:
    """Returns the step, its reason still to come, and whether the correction is limited as unconfirmed."""
    ahead = moved_on(levels, 1.0, False, prior)
    whole, gain = float(best_correction(ahead)), float(levels.mean(levels.gain))
    allowed = float(cautious(whole, largest_mm, prior.first_share))
    # The probability that corrections act as meant, (…)
    held = bool(gain < LEAST_GAIN or levels.mean(levels.as_meant * np.ones_like(levels.log_weight)) < PROBABLE)
    correction = reading.correction_mm if held else allowed
    applied = 0.0 if held or not reading.counts else allowed / whole if whole else 1.0
    expected, variance = predicted(ahead, correction)
    step = Step(
        correction_mm=correction,
        change_mm=correction - reading.correction_mm,
        weight=Weight(float(observation.weight) * applied, None, ""),
        predicted_mm=float(levels.mean(expected)),
        predicted_u_mm=float(levels.total_u(expected, variance)),
        level_mm=float(levels.mean(levels.level)),
        level_u_mm=float(levels.total_u(levels.level, levels.level_var)),
        scatter_mm=levels.typical(levels.scatter),
        drift_mm=levels.typical(levels.drift),
        gain=gain,
        gain_u=float(levels.total_u(levels.gain, levels.gain_var)),
        innovation_mm=float(observation.innovation),
        innovation_sd_mm=float(observation.deviation),
        held=held,
    )
    return step, allowed != whole


def _reason(past: _Past, reading: PartReading, step: Step, limited: bool, parts: int) -> str:
    """Explains the present weight."""
    plain = _plain_reason(past, reading, step, limited, parts)
    if plain is not None:
        return plain
    assert past.step is not None and past.step.drift_mm is not None and step.drift_mm is not None
    more = step.weight.value - past.step.weight.value
    if abs(more) < ALIKE:
        return wording("as before")
    if more > 0 and past.limited:
        return wording("this part confirms the correction: it is no longer applied in part")
    if more > 0:
        drift, before = Um(step.drift_mm, ".2f"), Um(past.step.drift_mm, ".2f")
        return wording("parts drift more than was known: {drift} a part, before {before}", drift=drift, before=before)
    scatter = Um(step.scatter_mm or 0.0)
    return wording("the level is known better, from {parts} parts that scatter by {u}", parts=parts, u=scatter)


def _plain_reason(past: _Past, reading: PartReading, step: Step, limited: bool, parts: int) -> str | None:
    """Explains the weight where this needs no comparison with the weight before; else returns None."""
    if not reading.counts:
        return wording("in quarantine: nothing is learned from this part")
    if step.held:
        return wording(
            "corrections do not act as meant, by {gain} of what was corrected: none is changed until the "
            "cause is found",
            gain=Signed(step.gain or 0.0, 2),
        )
    if limited:
        return wording("no inspected part confirms a correction of this size yet: it is applied in part")
    if reading.set_before:
        return wording("the tool was set before this part: its level is learned anew")
    return wording("first part: its level was unknown") if parts == 1 else None
