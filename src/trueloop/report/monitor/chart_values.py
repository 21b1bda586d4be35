"""Charts as shapes: values of the loop in the unit of the page."""

import math
from collections.abc import Sequence

from trueloop.errors import Finding
from trueloop.loops.monitor.chart import Episode, MonitoredSeries
from trueloop.loops.monitor.options import ChartOptions
from trueloop.monitoring.capability import Capability
from trueloop.monitoring.charts import Alarm, Chart
from trueloop.monitoring.segments import Segment
from trueloop.report.monitor.chart_shapes import (
    AlarmShape,
    CapabilityShape,
    CauseShape,
    CharacteristicChartShape,
    ChartShape,
    ChartsShape,
    EpisodeShape,
    IndexShape,
    SegmentShape,
    ValueShape,
)
from trueloop.report.series.shapes import FindingShape
from trueloop.units import UM_PER_MM


def charts_shape(
    part_type: str, charted: Sequence[MonitoredSeries], options: ChartOptions, findings: Sequence[Finding]
) -> ChartsShape:
    """The charts of a part type."""
    scale = UM_PER_MM if options.what == "value" else 1.0
    return ChartsShape(
        part_type=part_type,
        what=options.what,
        unit="um" if options.what == "value" else "sigma",
        rules=list(options.rules),
        characteristics=[_characteristic(one, scale) for one in charted],
        findings=[
            FindingShape(severity=one.severity.value, code=one.code.value, message=one.message, hint=one.hint)
            for one in findings
        ],
    )


def _characteristic(one: MonitoredSeries, scale: float) -> CharacteristicChartShape:
    asked, found = one.characteristic, one.charted
    base = next(each.base for each in found.segments if each.base is not None)
    return CharacteristicChartShape(
        characteristic=asked.name,
        quantity=asked.quantity.value,
        nominal_mm=asked.nominal,
        lower_limit_mm=asked.lower_limit,
        upper_limit_mm=asked.upper_limit,
        sigma=_round(base.sigma * scale),
        baseline=base.count,
        correlation=round(one.correlation.lag_1, 4),
        parts=[
            ValueShape(serial=serial, value=_round(value * scale), in_baseline=bool(base_), tool_set=anew)
            for serial, value, base_, anew in zip(
                one.serials, found.values.tolist(), found.in_baseline.tolist(), one.set_before, strict=True
            )
        ],
        segments=[segment_shape(each, scale) for each in found.segments],
        alarms=[_episode(each, one, base.sigma * scale) for each in one.episodes],
        capability=None if one.capability is None else _capability(one.capability, scale),
        remarks=list(one.remarks),
    )


def segment_shape(one: Segment, scale: float) -> SegmentShape:
    """A segment with its charts, values times `scale`."""
    return SegmentShape(
        first=one.first,
        stop=one.stop,
        centre=None if one.base is None else _round(one.base.centre * scale),
        charts=[_chart(each, scale) for each in one.charts],
    )


def _chart(one: Chart, scale: float) -> ChartShape:
    return ChartShape(
        name=one.name,
        centre=_round(one.centre * scale),
        plotted=[None if math.isnan(value) else _round(value * scale) for value in one.plotted.tolist()],
        low=[_round(value * scale) for value in one.low.tolist()],
        high=[_round(value * scale) for value in one.high.tolist()],
    )


def _episode(one: Episode, of: MonitoredSeries, sigma: float) -> EpisodeShape:
    why = one.explained
    return EpisodeShape(
        first=of.serials[one.first],
        last=of.serials[one.last],
        since=of.serials[why.since],
        alarms=[
            AlarmShape(serial=of.serials[alarm.index], chart=alarm.chart, meaning=alarm.meaning) for alarm in one.alarms
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
            first=labels[one.index],
            last=labels[one.index],
            since=labels[one.index],
            alarms=[AlarmShape(serial=labels[one.index], chart=one.chart, meaning=one.meaning)],
            causes=[],
            unknown=0.0,
            chance=0.0,
        )
        for one in alarms
    ]


def _capability(one: Capability, scale: float) -> CapabilityShape:
    return CapabilityShape(
        count=one.count,
        mean=_round(one.mean * scale),
        sigma=_round(one.sigma * scale),
        short_sigma=_round(one.short_sigma * scale),
        normal_p=round(one.normal_p, 4),
        indices=[
            IndexShape(name=each.name, value=_index(each.value), low=_index(each.low), high=_index(each.high))
            for each in one.indices
        ],
    )


def _index(value: float | None) -> float | None:
    return None if value is None else round(value, 3) + 0.0


def _round(value: float) -> float:
    return round(value, 4) + 0.0
