"""Explanations of an alarm: hypotheses of how values left their centre, by their marginal likelihoods.

Each hypothesis is a shape f (n,): z = size · f + scatter of 1, where the size is normal about 0 with `SIZE` σ. With
S = Σ f z and A = Σ f² the evidence against "nothing acts" is (1 + A·SIZE²)^(−1/2) exp(S² SIZE² / (2 (1 + A·SIZE²))).
Beforehand each known event, a step at some part that nobody knows of (shared by all parts), and that nothing acts have
the same weight. Valid for one change; the causes of two together share the probability between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content

SIZE: Final = 5.0
"""The standard deviation beforehand of the size of a change, in standard deviations of the values."""


@by_content
@dataclass(frozen=True)
class Explanation:
    """Something known to have happened: `kind` and `words` of it, and the `shape` (n,) that its effect has. `size`:
    that of the effect in σ, where it is known too; then the evidence is exp(S·size − A·size²/2).
    """

    kind: str
    words: str
    shape: Array
    size: float | None = None


@dataclass(frozen=True)
class Likely:
    """An explanation with its probability, and how much it moved the values, size ± its standard deviation, in σ."""

    kind: str
    words: str
    probability: float
    size: float
    size_u: float


@dataclass(frozen=True)
class ExplainedAlarm:
    """The explanations of an alarm, likeliest first.

    `unknown` is the probability of a step that nobody knows of, `chance` that nothing acts: a false alarm. `since` is
    the index from which on a step would begin with the greatest probability, known or not.
    """

    likely: tuple[Likely, ...]
    unknown: float
    chance: float
    since: int


def explained(z: Array, explanations: Sequence[Explanation]) -> ExplainedAlarm:
    """Returns the known explanations of z (n,) in σ, alarming last; a shape of zeros explains nothing."""
    steps = np.tri(len(z)).T  # row k: a step from value k on
    of_steps = np.array([_evidence(z, step) for step in steps])
    of_known = np.array(
        [
            _evidence(z, explanation.shape, explanation.size) if np.any(explanation.shape) else -np.inf
            for explanation in explanations
        ]
    )
    top = max([0.0, of_steps.max(), *of_known])
    chance, unknown, shares = float(np.exp(-top)), float(np.exp(of_steps - top).mean()), np.exp(of_known - top)
    total = chance + unknown + float(shares.sum())
    likely = [
        Likely(explanation.kind, explanation.words, float(share) / total, *_size(z, explanation.shape))
        for explanation, share in zip(explanations, shares, strict=True)
    ]
    ordered = sorted(likely, key=lambda one: one.probability, reverse=True)
    return ExplainedAlarm(tuple(ordered), unknown / total, chance / total, int(of_steps.argmax()))


def _evidence(z: Array, shape: Array, size: float | None = None) -> float:
    """Returns the logarithm of the marginal likelihood against that of nothing."""
    if size is not None:
        return float(size * (shape @ z) - 0.5 * size**2 * (shape @ shape))
    wide = 1.0 + SIZE**2 * float(shape @ shape)
    return float(-0.5 * np.log(wide) + 0.5 * SIZE**2 * float(shape @ z) ** 2 / wide)


def _size(z: Array, shape: Array) -> tuple[float, float]:
    """Returns the size of a change if it happened: mean and standard deviation of its posterior."""
    wide = 1.0 / SIZE**2 + float(shape @ shape)
    return float(shape @ z) / wide, float(wide**-0.5)
