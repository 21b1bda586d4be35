"""A series in segments, each with its own centre, all with one standard deviation: charts of each, alarms of all.

Where a tool is set anew, where its tip lies changes and how the process scatters does not: so the centre of a segment
comes from its own values, the standard deviation from the moving ranges of all of them. No range crosses a boundary.
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
