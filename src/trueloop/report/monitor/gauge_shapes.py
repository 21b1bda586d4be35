"""The shapes of checks of gauges as JSON. Deviations are found less calibrated, in µm."""

from collections.abc import Sequence
from datetime import datetime

from pydantic import SkipValidation

from trueloop.loops.monitor.gauge import GaugeSeries
from trueloop.report.monitor.chart_shapes import CharacteristicChartShape, ChartsShape, SegmentShape, ValueShape
from trueloop.report.monitor.chart_values import alarm_shapes, segment_shape
from trueloop.report.shape import Shape
from trueloop.units import UM_PER_MM


class CheckShape(Shape):
    """One check."""

    at: datetime | None
    """When."""
    deviation_um: float
    """Mean of its repeats."""
    repeats: int
    """Readings."""
    e_n: float | None
    """Deviation over the expanded uncertainty of gauge and calibration; beyond ±1 the check fails."""
    fails: SkipValidation[str]
    """Why, in words; empty: it does not."""


class GaugeShape(Shape):
    """A device on one characteristic of a standard part."""

    device: str
    """The gauge or probe."""
    standard: str
    """Serial number of the standard part."""
    characteristic: str
    """Of it."""
    bias_um: float
    """Mean deviation: positive where the device shows too much."""
    expanded_u_um: float | None
    """Of the bias, k = 2, with the calibration's; null: not known."""
    repeatability_um: float | None
    """Standard deviation of repeats within one check."""
    between_um: float | None
    """Standard deviation from check to check."""
    drift_um_per_day: float | None
    """Slope of the deviations."""
    drift_half_width_um: float | None
    """Its 95 % interval is ± this."""
    alarm: bool
    """A check fails or the chart alarms at the last one, the bias or the drift is significant."""
    remarks: list[SkipValidation[str]]
    """What is to be known, and done."""
    checks: list[CheckShape]
    """In order of time."""
    chart: CharacteristicChartShape
    """Control charts of the deviations; without segments' charts below eight checks."""


class GaugesShape(Shape):
    """All devices asked for."""

    gauges: list[GaugeShape]
    """One a device, standard part and characteristic."""


def gauges_shape(checked: Sequence[GaugeSeries]) -> GaugesShape:
    """Checks as shapes."""
    return GaugesShape(gauges=[_gauge(one) for one in checked])


def charts_of(shown: GaugesShape) -> ChartsShape:
    """The charts alone, as a page of charts has them."""
    charts = [one.chart for one in shown.gauges]
    return ChartsShape(part_type="", what="value", unit="um", rules=[1], characteristics=charts, findings=[])


def _gauge(one: GaugeSeries) -> GaugeShape:
    found, slope = one.drift, one.drift.slope
    fails = [one.failing(k) for k in range(len(one.checks))]
    return GaugeShape(
        device=one.device,
        standard=one.standard,
        characteristic=one.characteristic,
        bias_um=_um(found.bias),
        expanded_u_um=None if found.bias_u is None else _um(2.0 * found.bias_u),
        repeatability_um=None if found.repeatability is None else _um(found.repeatability),
        between_um=None if found.between is None else _um(found.between),
        drift_um_per_day=None if slope is None else _um(slope.per_day),
        drift_half_width_um=None if slope is None else _um(slope.half_width),
        alarm=bool(fails[-1]) or found.biased or (slope is not None and slope.significant),
        remarks=list(one.remarks),
        checks=[
            CheckShape(
                at=check.at,
                deviation_um=_um(check.deviation_mm),
                repeats=len(check.deviations_mm),
                e_n=None if check.e_n is None else round(check.e_n, 3) + 0.0,
                fails=said,
            )
            for check, said in zip(one.checks, fails, strict=True)
        ],
        chart=_chart(one),
    )


def _chart(one: GaugeSeries) -> CharacteristicChartShape:
    labels = [f"{k}" if check.at is None else f"{k}: {check.at:%m-%d}" for k, check in enumerate(one.checks, 1)]
    found = one.charted
    count = len(one.checks) if found is None else int(found.in_baseline.sum())
    return CharacteristicChartShape(
        characteristic=one.characteristic,
        quantity="",
        nominal_mm=0.0,
        lower_limit_mm=None,
        upper_limit_mm=None,
        sigma=0.0 if found is None else _um(found.sigma),
        baseline=count,
        correlation=0.0,
        parts=[
            ValueShape(serial=label, value=_um(check.deviation_mm), in_baseline=k < count, tool_set=False)
            for k, (label, check) in enumerate(zip(labels, one.checks, strict=True))
        ],
        segments=[SegmentShape(first=0, stop=len(labels), centre=None, charts=[])]
        if found is None
        else [segment_shape(each, UM_PER_MM) for each in found.segments],
        alarms=alarm_shapes(one.alarms, labels),
        capability=None,
        remarks=[],
    )


def _um(value_mm: float) -> float:
    return round(value_mm * UM_PER_MM, 4) + 0.0
