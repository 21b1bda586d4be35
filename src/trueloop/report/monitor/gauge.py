"""The check of a gauge: shapes of its JSON, lines and page."""

from collections.abc import Iterator, Sequence
from datetime import datetime

from pydantic import SkipValidation

from trueloop.loops.monitor.gauge import GaugeSeries
from trueloop.report.markup import esc, figure_block, html_page, items, on_screen, section, table
from trueloop.report.monitor.chart_page import chart_figure
from trueloop.report.monitor.chart_values import (
    CharacteristicChartShape,
    ChartsShape,
    SegmentShape,
    ValueShape,
    alarm_shapes,
    segment_shape,
)
from trueloop.report.shape import Shape, known_um, um
from trueloop.report.style import plain, signed
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.units import UM_PER_MM


class CheckShape(Shape):
    """One check of a gauge."""

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
    """Findings and actions."""
    checks: list[CheckShape]
    """In order of time."""
    chart: CharacteristicChartShape
    """Control charts of the deviations; without segments' charts below eight checks."""


class GaugesShape(Shape):
    """All devices asked for."""

    gauges: list[GaugeShape]
    """One a device, standard part and characteristic."""


def gauges_shape(checked: Sequence[GaugeSeries]) -> GaugesShape:
    """Returns the shapes of checks."""
    return GaugesShape(gauges=[_gauge(series) for series in checked])


def control_charts(shown: GaugesShape) -> ChartsShape:
    """Returns the charts alone, as a page of charts has them."""
    charts = [gauge.chart for gauge in shown.gauges]
    return ChartsShape(part_type="", what="value", unit="um", rules=[1], characteristics=charts, findings=[])


def _gauge(series: GaugeSeries) -> GaugeShape:
    found, slope = series.drift, series.drift.slope
    fails = [series.failing(k) for k in range(len(series.checks))]
    return GaugeShape(
        device=series.device,
        standard=series.standard,
        characteristic=series.characteristic,
        bias_um=um(found.bias),
        expanded_u_um=None if found.bias_u is None else um(2.0 * found.bias_u),
        repeatability_um=known_um(found.repeatability),
        between_um=known_um(found.between),
        drift_um_per_day=None if slope is None else um(slope.per_day),
        drift_half_width_um=None if slope is None else um(slope.half_width),
        alarm=bool(fails[-1]) or found.biased or (slope is not None and slope.significant),
        remarks=list(series.remarks),
        checks=[
            CheckShape(
                at=check.at,
                deviation_um=um(check.deviation_mm),
                repeats=len(check.deviations_mm),
                e_n=None if check.e_n is None else round(check.e_n, 3) + 0.0,
                fails=said,
            )
            for check, said in zip(series.checks, fails, strict=True)
        ],
        chart=_chart(series),
    )


def _chart(series: GaugeSeries) -> CharacteristicChartShape:
    labels = [f"{k}" if check.at is None else f"{k}: {check.at:%m-%d}" for k, check in enumerate(series.checks, 1)]
    found = series.charted
    count = len(series.checks) if found is None else int(found.in_baseline.sum())
    return CharacteristicChartShape(
        characteristic=series.characteristic,
        quantity="",
        nominal_mm=0.0,
        lower_limit_mm=None,
        upper_limit_mm=None,
        sigma=0.0 if found is None else um(found.sigma),
        baseline=count,
        correlation=0.0,
        parts=[
            ValueShape(serial=label, value=um(check.deviation_mm), in_baseline=k < count, tool_set=False)
            for k, (label, check) in enumerate(zip(labels, series.checks, strict=True))
        ],
        segments=[SegmentShape(first=0, stop=len(labels), centre=None, charts=[])]
        if found is None
        else [segment_shape(each, UM_PER_MM) for each in found.segments],
        alarms=alarm_shapes(series.alarms, labels),
        capability=None,
        remarks=[],
    )


HEAD = (
    *("device", "standard", "characteristic", "checks"),
    *("bias ± U µm", "repeatability µm", "drift µm/day", "E_n", "alarm"),
)


def gauge_rows(shown: GaugesShape) -> Iterator[tuple[str, ...]]:
    """Cells of a table, one row a series."""
    for gauge in shown.gauges:
        last, drift = gauge.checks[-1].e_n, gauge.drift_um_per_day
        yield (
            gauge.device,
            gauge.standard,
            gauge.characteristic,
            str(len(gauge.checks)),
            signed(gauge.bias_um, 2) + ("" if gauge.expanded_u_um is None else f" ± {plain(gauge.expanded_u_um, 2)}"),
            "" if gauge.repeatability_um is None else plain(gauge.repeatability_um, 2),
            "" if drift is None else f"{signed(drift, 3)} ± {plain(gauge.drift_half_width_um or 0.0, 3)}",
            "" if last is None else plain(last, 2),
            "yes" if gauge.alarm else "",
        )


def remark_lines(gauge: GaugeShape) -> Iterator[str]:
    """Yields what failed, and what to do."""
    name = f"{gauge.device}, {gauge.standard}, {gauge.characteristic}"
    yield from (f"{name}: {text}" for text in gauge.remarks)
    yield from (check.fails for check in gauge.checks if check.fails)


def gauge_page(shown: GaugesShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    charts = control_charts(shown)
    figures = "".join(
        figure_block(f"gauge-{k}", chart_figure(shape.chart, charts, say), _named(shape), small=True)
        for k, shape in enumerate(shown.gauges, 1)
    )
    alarms = [gauge for gauge in shown.gauges if gauge.alarm]
    words = say("Alarm: {names}.", names=", ".join(map(_named, alarms))) if alarms else say("No device alarms.")
    note = say(
        "Deviations are found less calibrated: positive where the device shows too much. E_n is the deviation over the "
        "expanded uncertainty of device and calibration; beyond ±1 a check fails."
    )
    meta = say("{n} devices on standard parts.", n=len({gauge.device for gauge in shown.gauges}))
    body = (
        f'<header><p class="kicker">{say("trueloop · quality monitor")}</p><h1>{say("Gauges and probes")}</h1>'
        f'<p class="meta">{meta}</p><p class="verdict">{words}</p><p class="note">{note}</p></header>'
        + section("devices", say("Devices"), _table(shown, say), _remarks(shown, say))
        + section("charts", say("Charts"), on_screen(say), f'<div class="figures pairs">{figures}</div>')
    )
    return html_page(say("Gauges and probes"), body, language=say.language)


def _named(gauge: GaugeShape) -> str:
    return esc(f"{gauge.device}, {gauge.standard}, {gauge.characteristic}")


def _table(shown: GaugesShape, say: Texts) -> str:
    head = (
        say("device"), say("standard part"), say("characteristic"), say("checks"), say("bias ± U<br>({um})"),
        say("repeatability<br>({um})"), say("check to check<br>({um})"), say("drift a day<br>({um})"), say("last E_n"),
        say("alarm"),
    )  # fmt: skip
    return table(head, [_row(gauge, say) for gauge in shown.gauges], words=(0, 1, 2, 9), name="gauges", stacks=True)


def _row(gauge: GaugeShape, say: Texts) -> list[str]:
    last = gauge.checks[-1].e_n
    drift = gauge.drift_um_per_day
    return [
        esc(gauge.device),
        esc(gauge.standard),
        esc(gauge.characteristic),
        str(len(gauge.checks)),
        say.error(gauge.bias_um, 2) + ("" if gauge.expanded_u_um is None else f" ± {say.size(gauge.expanded_u_um, 2)}"),
        "" if gauge.repeatability_um is None else say.size(gauge.repeatability_um, 2),
        "" if gauge.between_um is None else say.size(gauge.between_um, 2),
        "" if drift is None else f"{say.error(drift, 3)} ± {say.size(gauge.drift_half_width_um or 0.0, 3)}",
        "" if last is None else say.number(last, 2),
        f"<b>{say('yes')}</b>" if gauge.alarm else "",
    ]


def _remarks(shown: GaugesShape, say: Texts) -> str:
    failed = [f"{esc(say.note(check.fails))}" for gauge in shown.gauges for check in gauge.checks if check.fails]
    said = [f"<b>{_named(gauge)}</b>: {esc(say.note(text))}" for gauge in shown.gauges for text in gauge.remarks]
    return items([*said, *failed]) if said or failed else ""
