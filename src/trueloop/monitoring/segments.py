"""A series in segments, each with its own centre, all with one standard deviation: charts of each, alarms of all.

Where a tool is set anew, where its tip lies changes and how the process scatters does not: so the centre of a segment
comes from its own values, the standard deviation from the moving ranges of all of them. No range crosses a boundary.

Explanations of an alarm: hypotheses of how values left their centre, by their marginal likelihoods.

Each hypothesis is a shape f (n,): z = size · f + scatter of 1, where the size is normal about 0 with `SIZE` σ. With
S = Σ f z and A = Σ f² the evidence against "nothing acts" is (1 + A·SIZE²)^(−1/2) exp(S² SIZE² / (2 (1 + A·SIZE²))).
Beforehand each known event, a step at some part that nobody knows of (shared by all parts), and that nothing acts have
the same weight. Valid for one change; the causes of two together share the probability between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.errors import Code
from trueloop.monitoring import charts
from trueloop.monitoring.charts import D2, FEWEST, Alarm, Baseline, Chart, Rule
from trueloop.statistics import NORMAL_95

LEAST_CENTRE: Final = 3
"""Values of its own that a segment needs for its centre."""


@by_content
@dataclass(frozen=True)
class Segment:
    """Values `first` to `stop` − 1 of a series. `charts` is empty where too few are in the baseline for a centre."""

    first: int
    stop: int
    base: Baseline | None
    charts: tuple[Chart, ...] = ()


@by_content
@dataclass(frozen=True)
class SegmentedSeries:
    """A series (n,) with its segments. `in_baseline` marks the values from which centre and deviation come."""

    values: Array
    in_baseline: Flags
    segments: tuple[Segment, ...]

    @property
    def sigma(self) -> float:
        """Returns the short-term standard deviation, in the unit of the values."""
        return next(segment.base.sigma for segment in self.segments if segment.base is not None)

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Returns the alarms of all charts, in the order of the values; `index` counts in the whole series."""
        found = [
            replace(alarm, index=segment.first + alarm.index)
            for segment in self.segments
            for chart in segment.charts
            for alarm in chart.alarms
        ]
        return tuple(sorted(found, key=lambda alarm: alarm.index))

    @property
    def z(self) -> Array:
        """Values about the centre of their segment in standard deviations, (n,); nan where there is no centre."""
        z = np.full(len(self.values), np.nan)
        for segment in self.segments:
            if segment.base is not None:
                z[segment.first : segment.stop] = (
                    self.values[segment.first : segment.stop] - segment.base.centre
                ) / segment.base.sigma
        return z


def charted(
    values: Array, in_baseline: Flags, begins: Sequence[int] = (), rules: Sequence[Rule] = ()
) -> SegmentedSeries:
    """Charts of values (n,): individuals with `rules`, moving range, EWMA and CUSUM, of every segment.

    `begins` are the indices with which a new segment begins. Raises MON-FEW where the baseline has fewer than eight
    values in segments with a centre, or none that differ.
    """
    ends = [0, *sorted({k for k in begins if 0 < k < len(values)}), len(values)]
    own = [in_baseline[a:b].sum() >= LEAST_CENTRE for a, b in pairwise(ends)]
    base = _common(values, in_baseline, [span for span, enough in zip(pairwise(ends), own, strict=True) if enough])
    segments = [
        _segment(values, in_baseline, span, base, rules) if enough else Segment(*span, None)
        for span, enough in zip(pairwise(ends), own, strict=True)
    ]
    return SegmentedSeries(values, in_baseline, tuple(segments))


def _common(values: Array, in_baseline: Flags, spans: Sequence[tuple[int, int]]) -> Baseline:
    """Returns the common standard deviation of segments: their mean moving range over d2; its centre is not theirs."""
    own = [values[a:b][in_baseline[a:b]] for a, b in spans]
    ranges = np.concatenate([np.abs(np.diff(one)) for one in own]) if own else np.zeros(0)
    count, sigma = sum(map(len, own)), float(ranges.mean() / D2) if len(ranges) else 0.0
    if count < FEWEST or sigma == 0.0:
        raise Code.MON_FEW.refusal(
            f"{count} values with a mean moving range of {sigma * D2:g} say no standard deviation",
            hint=f"chart {FEWEST} values that differ at least",
            values={"count": count},
        )
    return Baseline(0.0, sigma, count)


def _segment(
    values: Array, in_baseline: Flags, span: tuple[int, int], common: Baseline, rules: Sequence[Rule]
) -> Segment:
    own = values[slice(*span)]
    base = replace(common, centre=float(own[in_baseline[slice(*span)]].mean()))
    made = (
        charts.individuals(own, base, rules),
        charts.moving_range(own, base),
        charts.ewma(own, base),
        *charts.cusum(own, base),
    )
    return Segment(*span, base, made)


@dataclass(frozen=True)
class Correlation:
    """That of neighbours, `lag_1` of `count` values; `limit` is what independent ones stay below with 95 %."""

    lag_1: float
    limit: float
    count: int

    @property
    def significant(self) -> bool:
        """Returns whether it is more than chance."""
        return abs(self.lag_1) > self.limit

    @property
    def width(self) -> float:
        """Returns the share of their right width that limits from the moving range have: E|x₂ − x₁| = d2 σ √(1 − ρ)."""
        return float(np.sqrt(max(1.0 - self.lag_1, 0.0)))


def correlation(values: Array) -> Correlation:
    """Estimates the correlation of values (n,) in their order, n ≥ 3, without its bias of −1/n [Box, Jenkins 1976]."""
    about, n = values - values.mean(), len(values)
    lag_1 = float(about[1:] @ about[:-1] / (about @ about)) + 1.0 / n if np.any(about) else 0.0
    return Correlation(lag_1, NORMAL_95 / float(np.sqrt(n)), n)


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
