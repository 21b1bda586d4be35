"""Rules that correct the next part from earlier ones, for many series of one number at once: ours and its rivals.

A rule is made for a number of series; then it takes what the last parts were found with and corrected by, and whether
the tool was set since, all (series,), mm, and gives what to correct the next parts by. After a setting nothing is
corrected: a tool is set to be right.
"""

from collections.abc import Callable
from typing import Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.memory.level.kalman import (
    TURNING,
    LevelPrior,
    best_correction,
    cautious,
    learned,
    moved_on,
    predicted,
    unknown,
)

Rule: TypeAlias = Callable[[Array, Array, bool], Array]
"""(error, correction, set before this part) → correction of the next part."""
Maker: TypeAlias = Callable[[int], Rule]


def fixed(weight: float) -> Maker:
    """The same share of every error."""
    return lambda series: lambda error, correction, anew: correction + weight * error


def percentage(share: float = 0.7, null_mm: float = 0.005) -> Maker:
    """A control's process-control function: a share of the last error where it exceeds a null band."""
    return lambda series: (
        lambda error, correction, anew: correction + share * np.where(np.abs(error) > null_mm, error, 0)
    )


def averaging(least: float) -> Maker:
    """Mean of all errors uncorrected so far, each new part counting for `least` at least: 0 is the running mean, else
    an exponentially weighted one (EWMA) that begins as a mean does.
    """

    def made(series: int) -> Rule:
        parts = 0

        def rule(error: Array, correction: Array, anew: bool) -> Array:
            nonlocal parts
            parts = 1 if anew else parts + 1
            return correction + max(least, 1 / parts) * error

        return rule

    return made


def known_gain(scatter_mm: float, drift_mm: float, gain: float, setting_mm: float) -> Maker:
    """The Kalman gain of a local level whose scatter, drift and actuator are known beforehand: the best there is."""

    def made(series: int) -> Rule:
        variance = setting_mm**2

        def rule(error: Array, correction: Array, anew: bool) -> Array:
            nonlocal variance
            variance = setting_mm**2 if anew else variance + drift_mm**2
            share = variance / (variance + scatter_mm**2)
            variance *= 1 - share
            return correction + share * error / gain

        return rule

    return made


FIRST_WEIGHT: Final = 0.75
"""Of those "between 0.50 and 0.75" [4773 §2.5], that of its Fig. 9."""
REDUCED: Final = 0.8
LEAST_WEIGHT: Final = 0.1


def whitening(series: int) -> Rule:
    """The weight by the signs of what is left: [4773 §3.5] reduces it "by a standard percentage" where a correction
    changes its sign over several iterations, and increases it where it hardly changes.
    """
    weight, signs = np.full(series, FIRST_WEIGHT), np.empty((series, 0))

    def rule(error: Array, correction: Array, anew: bool) -> Array:
        nonlocal weight, signs
        signs = np.column_stack([np.empty((series, 0)) if anew else signs, np.sign(error)])[:, -3:]
        if signs.shape[-1] == 3:
            same = signs[:, :-1] * signs[:, 1:]
            changed, stayed = (same < 0).all(axis=-1), (same > 0).all(axis=-1)
            factor = np.where(changed, REDUCED, np.where(stayed, 1 / REDUCED, 1.0))
            weight = np.clip(weight * factor, LEAST_WEIGHT, 1.0)
        return correction + weight * error

    return rule


class Memory:
    """What `memory.level.kalman.steps` does. `z` collects by how many standard deviations each part differed."""

    def __init__(self, series: int, prior: LevelPrior = TURNING) -> None:
        self._known, self._largest, self._prior = unknown(prior, (series,)), np.zeros(series), prior
        self.z: list[Array] = []

    def __call__(self, error: Array, correction: Array, anew: bool) -> Array:
        """The rule."""
        ahead = moved_on(self._known, 1.0, anew, self._prior)
        expected, variance = predicted(ahead, correction)
        self.z.append((error - ahead.mean(expected)) / ahead.total_u(expected, variance))
        self._known, _ = learned(ahead, error, correction)
        self._largest = np.maximum(self._largest, np.abs(correction))
        whole = best_correction(moved_on(self._known, 1.0, False, self._prior))
        return cautious(whole, self._largest, self._prior.first_share)


def run(rule: Rule, uncorrected_mm: Array, noise_mm: Array, gain: float = 1.0, set_at: int | None = None) -> Array:
    """True errors left (series, parts) of parts cut one after the other: `uncorrected_mm` with what differs from part
    to part, `noise_mm` of the inspection.
    """
    left, correction = np.empty_like(uncorrected_mm), np.zeros(len(uncorrected_mm))
    for k in range(uncorrected_mm.shape[1]):
        if k == set_at:
            correction = np.zeros(len(uncorrected_mm))
        left[:, k] = uncorrected_mm[:, k] - gain * correction
        correction = rule(left[:, k] + noise_mm[:, k], correction, k == set_at)
    return left


RIVALS: dict[str, Maker] = {
    "fixed 0.5": fixed(0.5),
    "fixed 0.75": fixed(0.75),
    "fixed 1": fixed(1.0),
    "running mean": averaging(0.0),
    "EWMA, 0.2": averaging(0.2),
    "percentage, 70 % over 5 µm": percentage(),
    "whitening rule": whitening,
}
