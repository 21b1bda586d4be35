"""The chart of one characteristic: its alarms with their explanations, its capability, remarks on both."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, Literal

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.diagnosis.causes.cause import Candidate, Diagnosis
from trueloop.domain.characteristic import Characteristic
from trueloop.errors import Code
from trueloop.loops.monitor.known import PartFacts, known, only
from trueloop.loops.post_process.tracked import TrackedPart, TrackedSeries
from trueloop.monitoring.capability import SHARE_OF_FREEDOM, Capability, capability
from trueloop.monitoring.charts import FEWEST, MOVING_RANGE, RULES, Alarm
from trueloop.monitoring.segments import (
    Correlation,
    ExplainedAlarm,
    Explanation,
    Likely,
    SegmentedSeries,
    charted,
    correlation,
    explained,
)
from trueloop.wording import wording

BASELINE: Final = 20
"""The number of parts of the baseline where none is stated: its standard deviation is then known to 20 %."""


@dataclass(frozen=True)
class ChartOptions:
    """`rules`: numbers of Nelson's tests. `baseline`: from how many parts at the beginning of each segment limits come,
    or from which to which serial number of the series. `anew`: a tool set anew begins a new segment.

    `what`: errors of the parts as inspected, or residuals after correction: what memory did not expect of a part, in
    standard deviations of its expectation.
    """

    rules: tuple[int, ...] = (1,)
    baseline: int | tuple[str, str] = BASELINE
    anew: bool = False
    what: Literal["value", "residual"] = "value"


def with_diagnosis(alarm: ExplainedAlarm, diagnosis: Diagnosis, sigma_mm: float) -> ExplainedAlarm:
    """Adds the candidates of a diagnosis to the explained alarm: they share the probability that nothing known
    explains.

    A candidate gets its probability of that share, less where all of them together have more than 1; what is left
    stays unknown. Sizes are in `sigma_mm`, the charts' standard deviation.
    """
    total = max(1.0, sum(candidate.probability for candidate in diagnosis.candidates))
    added = [
        _likely(candidate, alarm.unknown * candidate.probability / total, sigma_mm)
        for candidate in diagnosis.candidates
    ]
    ordered = sorted([*alarm.likely, *added], key=lambda likely: likely.probability, reverse=True)
    left = alarm.unknown - sum(likely.probability for likely in added)
    return replace(alarm, likely=tuple(ordered), unknown=max(left, 0.0))


def _likely(candidate: Candidate, probability: float, sigma_mm: float) -> Likely:
    words = candidate.supports[0] if candidate.supports else candidate.cause.name
    return Likely(
        candidate.cause.key, words, probability, candidate.size_mm / sigma_mm, candidate.standard_u_mm / sigma_mm
    )


NORMAL: Final = 0.05
"""Values with a smaller probability under a normal distribution are not taken as normal."""


@dataclass(frozen=True)
class Episode:
    """Alarms of consecutive parts `first` to `last`, and what may explain them."""

    first: int
    last: int
    alarms: tuple[Alarm, ...]
    explained: ExplainedAlarm


@by_content
@dataclass(frozen=True)
class MonitoredSeries:
    """A characteristic's chart. Values are errors in mm, or residuals in standard deviations of what was expected.

    `set_before` marks the parts for which the tool was set. `remarks` say what limits or indices are not good for.
    """

    characteristic: Characteristic
    serials: tuple[str, ...]
    set_before: tuple[bool, ...]
    charted: SegmentedSeries
    episodes: tuple[Episode, ...]
    capability: Capability | None
    correlation: Correlation
    remarks: tuple[str, ...]


def chart_of(
    tracked: TrackedSeries, facts: Sequence[PartFacts], options: ChartOptions, diagnosis: Diagnosis | None = None
) -> MonitoredSeries:
    """Charts a series; `facts` are those of its parts, one each. `diagnosis`: of the series, where there is one.

    Raises MON-FEW for a baseline that is too short, MON-NONE for a baseline of parts that the series does not have.
    """
    chosen = [k for k, part in enumerate(tracked.parts) if _value(part, options) is not None]
    parts, own = [tracked.parts[k] for k in chosen], [facts[k] for k in chosen]
    values = np.array([_value(part, options) for part in parts], dtype=np.float64)
    begins = [k for k, part in enumerate(parts) if part.made.set_before] if options.anew else []
    base = _baseline(parts, begins, options)
    found = charted(values, base, begins, [rule for rule in RULES if rule.number in options.rules])
    sigma_mm = found.sigma if options.what == "value" else None
    causes = known([part.made for part in parts], own, base, sigma_mm)
    index = _capability(tracked, values, found) if options.what == "value" else None
    like, episodes = _correlation(found), tuple(_episodes(found, causes, options))
    if diagnosis is not None and options.what == "value":
        episodes = tuple(
            replace(episode, explained=with_diagnosis(episode.explained, diagnosis, found.sigma))
            for episode in episodes
        )
    return MonitoredSeries(
        characteristic=tracked.series.characteristic,
        serials=tuple(part.made.serial for part in parts),
        set_before=tuple(part.made.set_before for part in parts),
        charted=found,
        episodes=episodes,
        capability=index,
        correlation=like,
        remarks=tuple(_remarks(tracked, found, index, like, options, alarming=bool(episodes))),
    )


def _value(tracked_part: TrackedPart, options: ChartOptions) -> float | None:
    if options.what == "value":
        return tracked_part.made.error_mm
    if tracked_part.expected_mm is None or not tracked_part.expected_u_mm:
        return None
    return (tracked_part.made.error_mm - tracked_part.expected_mm) / tracked_part.expected_u_mm


def _baseline(parts: Sequence[TrackedPart], begins: Sequence[int], options: ChartOptions) -> Flags:
    """Marks the parts from which limits come: never those that are to teach nothing."""
    counts = np.array([part.made.counts for part in parts], dtype=bool)
    if isinstance(options.baseline, tuple):
        first, last = (_place(parts, serial) for serial in options.baseline)
        return counts & (np.arange(len(parts)) >= first) & (np.arange(len(parts)) <= last)
    chosen = np.zeros(len(parts), dtype=bool)
    for a, b in pairwise([0, *begins, len(parts)]):
        chosen[a:b] = counts[a:b] & (np.cumsum(counts[a:b]) <= options.baseline)
    return chosen


def _serials(parts: Sequence[TrackedPart]) -> str:
    """Returns the serial numbers of all parts, of more than six the first and the last."""
    serials = [part.made.serial for part in parts]
    return ", ".join(serials if len(serials) <= 6 else [serials[0], "…", serials[-1]])


def _place(parts: Sequence[TrackedPart], serial: str) -> int:
    for k, part in enumerate(parts):
        if part.made.serial == serial:
            return k
    raise Code.MON_NONE.refusal(
        f"the series has no part {serial!r} ({len(parts)} parts: {_serials(parts)})",
        hint="name parts by their serial numbers: `--baseline 101..120`; `trueloop series status` shows them",
        values={"characteristic": serial},
    )


def _episodes(series: SegmentedSeries, causes: Sequence[Explanation], options: ChartOptions) -> Iterator[Episode]:
    """Yields the alarms, neighbours joined as one. Explanations are sought among the parts since the episode before.

    A residual of a step fades as memory learns it: only parts up to the first alarm tell of its cause. The moving range
    begins none: it signals once in 110 parts by chance, and what it sees single values show too.
    """
    for segment in series.segments:
        start = segment.first
        own = [alarm for alarm in series.alarms if segment.first <= alarm.index < segment.stop]
        runs: list[tuple[int, int]] = []
        for k in sorted({alarm.index for alarm in own if alarm.chart != MOVING_RANGE}):
            if runs and k == runs[-1][1] + 1:
                runs[-1] = (runs[-1][0], k)
            else:
                runs.append((k, k))
        for first, last in runs:
            span = slice(start, (last if options.what == "value" else first) + 1)
            why = explained(series.z[span], only(causes, span))
            of_it = tuple(alarm for alarm in own if first <= alarm.index <= last)
            yield Episode(first, last, of_it, replace(why, since=start + why.since))
            start = last + 1


def _capability(tracked: TrackedSeries, values: Array, series: SegmentedSeries) -> Capability | None:
    """Returns the capability of all parts; the short-term deviation is that of the charts. None without limits."""
    asked = tracked.series.characteristic
    if asked.lower_limit is None and asked.upper_limit is None:
        return None
    limits = [None if one is None else one - asked.nominal for one in (asked.lower_limit, asked.upper_limit)]
    base = next(segment.base for segment in series.segments if segment.base is not None)
    return capability(values, limits[0], limits[1], base=base)


def _correlation(series: SegmentedSeries) -> Correlation:
    """Returns the correlation of the baseline, each value about the centre of its segment."""
    return correlation(series.z[series.in_baseline & np.isfinite(series.z)])


def _remarks(
    tracked: TrackedSeries,
    series: SegmentedSeries,
    index: Capability | None,
    like: Correlation,
    options: ChartOptions,
    *,
    alarming: bool,
) -> Iterator[str]:
    count = next(segment.base.count for segment in series.segments if segment.base is not None)
    unsure = 100.0 / np.sqrt(2.0 * SHARE_OF_FREEDOM * (count - 1))
    if count < 2 * FEWEST + 4:
        yield wording(
            "limits come from {n} parts: their distance is uncertain by {share:.0f} % (one standard deviation), and "
            "false alarms are more frequent than with limits that are known",
            n=count, share=float(unsure),
        )  # fmt: skip
    if like.significant and like.lag_1 > 0.0:
        yield wording(
            "neighbours are alike (correlation {r:.2f}): limits from moving ranges are {share:.0f} % of their right "
            "width, and alarms are not to be trusted; chart the residuals",
            r=like.lag_1, share=100.0 * like.width,
        )  # fmt: skip
    if like.significant and like.lag_1 < 0.0:
        yield wording(
            "neighbours differ more than chance makes them (correlation {r:.2f}): limits are too wide, as after "
            "correcting too much",
            r=like.lag_1,
        )  # fmt: skip
    left = sum(segment.base is None for segment in series.segments)
    if left:
        yield wording("{n} segments are too short for a centre and have no chart", n=left)
    asked = tracked.series.characteristic
    if options.what == "value" and asked.lower_limit is None and asked.upper_limit is None:
        yield wording("no limits are stated: no capability")
    if index is not None and alarming:
        yield wording("the series alarms: Cp and Cpk describe no process that is in control")
    if index is not None and index.normal_p < NORMAL:
        yield wording(
            "the values are not normally distributed (p = {p:.1g}): the indices do not say how many parts are out",
            p=index.normal_p,
        )  # fmt: skip
