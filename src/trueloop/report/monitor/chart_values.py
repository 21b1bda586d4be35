"""Charts as shapes: values of the loop in the unit of the page."""

import math
from collections.abc import Iterator, Sequence
from typing import Final, Literal

from pydantic import SkipValidation

from trueloop.errors import Finding
from trueloop.loops.monitor.chart import ChartOptions, Episode, MonitoredSeries
from trueloop.monitoring.capability import Capability
from trueloop.monitoring.charts import Alarm, Chart
from trueloop.monitoring.segments import Segment
from trueloop.report.series.values import FindingShape, findings_shape
from trueloop.report.shape import Shape
from trueloop.report.style import plain, signed
from trueloop.units import UM_PER_MM


class ValueShape(Shape):
    """One part on a chart, in the order in which the parts were cut."""

    serial: str
    """Its serial number."""
    value: float
    """In the unit of the chart."""
    in_baseline: bool
    """True if limits come from it, among others."""
    tool_set: bool
    """The tool was set or changed before it."""


class ChartShape(Shape):
    """One chart of one segment: what is plotted of each part, with its limits."""

    name: str
    """individuals, moving range, EWMA, CUSUM upwards, CUSUM downwards."""
    centre: float
    """Its middle line."""
    plotted: list[float | None]
    """Null where a part has none: the first moving range."""
    low: list[float]
    """Lower limits."""
    high: list[float]
    """Upper limits."""


class SegmentShape(Shape):
    """Parts with one centre."""

    first: int
    """Index of its first part, from 0."""
    stop: int
    """Index after its last part."""
    centre: float | None
    """Mean of its baseline; null: too few parts, and no charts."""
    charts: list[ChartShape]
    """All charts of it."""


class AlarmShape(Shape):
    """A signal of one chart at one part."""

    serial: str
    """The part at which the pattern is complete."""
    chart: str
    """Which chart."""
    meaning: SkipValidation[str]
    """Which rule, in words."""


class CauseShape(Shape):
    """Something that happened and may explain an alarm."""

    kind: SkipValidation[str]
    """tool set, proposal accepted, another program, correction not run, wear, temperature, another device, gauge; of a
    diagnosis the key of its cause."""
    words: SkipValidation[str]
    """Its description."""
    probability: float
    """That it is the cause, among those known and none of them."""
    size: float
    """How far it moved the values, in the unit of the chart, if it did."""
    size_u: float
    """Standard uncertainty of that."""


class EpisodeShape(Shape):
    """Alarms of consecutive parts."""

    first: str
    """Serial number of the first alarming part."""
    last: str
    """Of the last."""
    since: str
    """The part with which a step would begin with the greatest probability."""
    alarms: list[AlarmShape]
    """Each."""
    causes: list[CauseShape]
    """Likeliest first."""
    unknown: float
    """Probability of a step that nobody knows of."""
    chance: float
    """Probability that nothing moved."""


class IndexShape(Shape):
    """An index of capability or performance."""

    name: str
    """Pp, Ppk, Cp or Cpk, as ISO 22514-2 has them."""
    value: float | None
    """Null where a limit that it needs is not stated."""
    low: float | None
    """Lower end of its 95 % interval."""
    high: float | None
    """Upper end."""


class CapabilityShape(Shape):
    """Capability and performance against the limits."""

    count: int
    """Parts."""
    mean: float
    """Mean error."""
    sigma: float
    """Standard deviation of all parts."""
    short_sigma: float
    """That within segments, from moving ranges."""
    normal_p: float
    """Probability of values as unlike the normal distribution (Shapiro, Wilk)."""
    indices: list[IndexShape]
    """Pp, Ppk, Cp, Cpk."""


class CharacteristicChartShape(Shape):
    """The charts of one characteristic."""

    characteristic: str
    """Its name."""
    quantity: str
    """diameter, radius, length or position."""
    nominal_mm: float
    """A diameter is a diameter."""
    lower_limit_mm: float | None
    """Smallest size; null: no limit."""
    upper_limit_mm: float | None
    """Largest size; null: no limit."""
    sigma: float
    """Short-term standard deviation, in the unit of the chart."""
    baseline: int
    """Parts that it comes from."""
    correlation: float
    """Of neighbours in the baseline."""
    parts: list[ValueShape]
    """All, as they were cut."""
    segments: list[SegmentShape]
    """Parts between settings of the tool, where that was asked for; else one."""
    alarms: list[EpisodeShape]
    """In order of the parts."""
    capability: CapabilityShape | None
    """Null of residuals and without limits."""
    remarks: list[SkipValidation[str]]
    """Warnings about limits and indices."""


class ChartsShape(Shape):
    """Charts of a part type."""

    part_type: str
    """Its name."""
    what: Literal["value", "residual"]
    """Errors as inspected, or residuals after correction."""
    unit: Literal["um", "sigma"]
    """Of values, centres and limits."""
    rules: list[int]
    """Nelson's tests on the individuals."""
    characteristics: list[CharacteristicChartShape]
    """Each with values enough."""
    findings: list[FindingShape]
    """The findings about the parts."""


NAMED: Final = 0.05
"""Causes with a smaller probability stand in the JSON alone."""
UNITS: Final = {"um": "µm", "sigma": "σ"}


def chart_head(shown: ChartsShape) -> tuple[str, ...]:
    """Returns the head of the table."""
    unit = UNITS[shown.unit]
    indices = ("Cpk", "Ppk") if shown.what == "value" else ()
    return ("characteristic", "parts", f"mean ({unit})", f"σ ({unit})", "baseline", "alarms", *indices)


def chart_rows(shown: ChartsShape) -> Iterator[tuple[str, ...]]:
    """Cells of the table, one row a characteristic."""
    for characteristic in shown.characteristics:
        mean = sum(part.value for part in characteristic.parts) / len(characteristic.parts)
        yield (
            characteristic.characteristic,
            str(len(characteristic.parts)),
            signed(mean),
            plain(characteristic.sigma, 2),
            str(characteristic.baseline),
            str(len(characteristic.alarms)),
            *(index_text(characteristic.capability, name) for name in ("Cpk", "Ppk") if shown.what == "value"),
        )


def index_text(capability: CapabilityShape | None, name: str) -> str:
    """Formats an index with its interval; empty where there is none."""
    one = None if capability is None else next(each for each in capability.indices if each.name == name)
    if one is None or one.value is None or one.low is None or one.high is None:
        return ""
    return f"{plain(one.value, 2)} ({plain(one.low, 2)} to {plain(one.high, 2)})"


def alarm_lines(chart: CharacteristicChartShape, shown: ChartsShape) -> Iterator[str]:
    """Alarms of a characteristic with what explains them, and its remarks."""
    for episode in chart.alarms:
        yield f"{chart.characteristic}: alarm at {_parts(episode)}"
        meanings = dict.fromkeys(f"{alarm.chart}: {alarm.meaning}" for alarm in episode.alarms)
        yield from (f"  {said}" for said in meanings)
        for cause in episode.causes:
            if cause.probability >= NAMED:
                size = f"{signed(cause.size)} ± {plain(1.96 * cause.size_u)} {UNITS[shown.unit]}"
                yield f"  {100 * cause.probability:.0f} %  {cause.kind}: {cause.words} ({size})"
        yield f"  {100 * episode.unknown:.0f} %  a step that nobody knows of: it would begin at part {episode.since}"
        yield f"  {100 * episode.chance:.0f} %  chance: nothing moved"
    yield from (f"{chart.characteristic}: {remark}" for remark in chart.remarks)


def _parts(episode: EpisodeShape) -> str:
    return f"part {episode.first}" if episode.first == episode.last else f"parts {episode.first} to {episode.last}"


def charts_shape(
    part_type: str, charted: Sequence[MonitoredSeries], options: ChartOptions, findings: Sequence[Finding]
) -> ChartsShape:
    """Makes the shape of the charts of a part type."""
    scale = UM_PER_MM if options.what == "value" else 1.0
    return ChartsShape(
        part_type=part_type,
        what=options.what,
        unit="um" if options.what == "value" else "sigma",
        rules=list(options.rules),
        characteristics=[_characteristic(series, scale) for series in charted],
        findings=findings_shape(findings),
    )


def _characteristic(series: MonitoredSeries, scale: float) -> CharacteristicChartShape:
    asked, found = series.characteristic, series.charted
    base = next(each.base for each in found.segments if each.base is not None)
    return CharacteristicChartShape(
        characteristic=asked.name,
        quantity=asked.quantity.value,
        nominal_mm=asked.nominal,
        lower_limit_mm=asked.lower_limit,
        upper_limit_mm=asked.upper_limit,
        sigma=_round(base.sigma * scale),
        baseline=base.count,
        correlation=round(series.correlation.lag_1, 4),
        parts=[
            ValueShape(serial=serial, value=_round(value * scale), in_baseline=bool(base_), tool_set=anew)
            for serial, value, base_, anew in zip(
                series.serials, found.values.tolist(), found.in_baseline.tolist(), series.set_before, strict=True
            )
        ],
        segments=[segment_shape(each, scale) for each in found.segments],
        alarms=[_episode(each, series, base.sigma * scale) for each in series.episodes],
        capability=None if series.capability is None else _capability(series.capability, scale),
        remarks=list(series.remarks),
    )


def segment_shape(segment: Segment, scale: float) -> SegmentShape:
    """Makes the shape of a segment with its charts, values times `scale`."""
    return SegmentShape(
        first=segment.first,
        stop=segment.stop,
        centre=None if segment.base is None else _round(segment.base.centre * scale),
        charts=[_chart(each, scale) for each in segment.charts],
    )


def _chart(chart: Chart, scale: float) -> ChartShape:
    return ChartShape(
        name=chart.name,
        centre=_round(chart.centre * scale),
        plotted=[None if math.isnan(value) else _round(value * scale) for value in chart.plotted.tolist()],
        low=[_round(value * scale) for value in chart.low.tolist()],
        high=[_round(value * scale) for value in chart.high.tolist()],
    )


def _episode(episode: Episode, of: MonitoredSeries, sigma: float) -> EpisodeShape:
    why = episode.explained
    return EpisodeShape(
        first=of.serials[episode.first],
        last=of.serials[episode.last],
        since=of.serials[why.since],
        alarms=[
            AlarmShape(serial=of.serials[alarm.index], chart=alarm.chart, meaning=alarm.meaning)
            for alarm in episode.alarms
        ],
        causes=[
            CauseShape(
                kind=each.kind,
                words=each.words,
                probability=round(each.probability, 4),
                size=_round(each.size * sigma),
                size_u=_round(each.size_u * sigma),
            )
            for each in why.likely
        ],
        unknown=round(why.unknown, 4),
        chance=round(why.chance, 4),
    )


def alarm_shapes(alarms: Sequence[Alarm], labels: Sequence[str]) -> list[EpisodeShape]:
    """Alarms each on its own, of which nothing is known that may explain them."""
    return [
        EpisodeShape(
            first=labels[alarm.index],
            last=labels[alarm.index],
            since=labels[alarm.index],
            alarms=[AlarmShape(serial=labels[alarm.index], chart=alarm.chart, meaning=alarm.meaning)],
            causes=[],
            unknown=0.0,
            chance=0.0,
        )
        for alarm in alarms
    ]


def _capability(capability: Capability, scale: float) -> CapabilityShape:
    return CapabilityShape(
        count=capability.count,
        mean=_round(capability.mean * scale),
        sigma=_round(capability.sigma * scale),
        short_sigma=_round(capability.short_sigma * scale),
        normal_p=round(capability.normal_p, 4),
        indices=[
            IndexShape(name=each.name, value=_index(each.value), low=_index(each.low), high=_index(each.high))
            for each in capability.indices
        ],
    )


def _index(value: float | None) -> float | None:
    return None if value is None else round(value, 3) + 0.0


def _round(value: float) -> float:
    return round(value, 4) + 0.0
