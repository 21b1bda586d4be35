"""The page of checks of gauges: bias, repeatability and drift of each device, its charts, what to do."""

from trueloop.report.markup import esc, items, section, table
from trueloop.report.monitor.chart_figure import chart_figure
from trueloop.report.monitor.gauge_shapes import GaugeShape, GaugesShape, charts_of
from trueloop.report.shell import figure_block, html_page, on_screen
from trueloop.report.texts.texts import ENGLISH, Texts


def gauge_page(shown: GaugesShape, say: Texts = ENGLISH) -> str:
    """The page as HTML in one file."""
    charts = charts_of(shown)
    figures = "".join(
        figure_block(f"gauge-{k}", chart_figure(one.chart, charts, say), _named(one), small=True)
        for k, one in enumerate(shown.gauges, 1)
    )
    alarms = [one for one in shown.gauges if one.alarm]
    words = say("Alarm: {names}.", names=", ".join(map(_named, alarms))) if alarms else say("No device alarms.")
    note = say(
        "Deviations are found less calibrated: positive where the device shows too much. E_n is the deviation over the "
        "expanded uncertainty of device and calibration; beyond ±1 a check fails."
    )
    meta = say("{n} devices on standard parts.", n=len({one.device for one in shown.gauges}))
    body = (
        f'<header><p class="kicker">{say("trueloop · quality monitor")}</p><h1>{say("Gauges and probes")}</h1>'
        f'<p class="meta">{meta}</p><p class="verdict">{words}</p><p class="note">{note}</p></header>'
        + section("devices", say("Devices"), _table(shown, say), _remarks(shown, say))
        + section("charts", say("Charts"), on_screen(say), f'<div class="figures pairs">{figures}</div>')
    )
    return html_page(say("Gauges and probes"), body, language=say.language)


def _named(one: GaugeShape) -> str:
    return esc(f"{one.device}, {one.standard}, {one.characteristic}")


def _table(shown: GaugesShape, say: Texts) -> str:
    head = (
        say("device"), say("standard part"), say("characteristic"), say("checks"), say("bias ± U<br>({um})"),
        say("repeatability<br>({um})"), say("check to check<br>({um})"), say("drift a day<br>({um})"), say("last E_n"),
        say("alarm"),
    )  # fmt: skip
    return table(head, [_row(one, say) for one in shown.gauges], words=(0, 1, 2, 9), name="gauges", stacks=True)


def _row(one: GaugeShape, say: Texts) -> list[str]:
    last = one.checks[-1].e_n
    drift = one.drift_um_per_day
    return [
        esc(one.device),
        esc(one.standard),
        esc(one.characteristic),
        str(len(one.checks)),
        say.error(one.bias_um, 2) + ("" if one.expanded_u_um is None else f" ± {say.size(one.expanded_u_um, 2)}"),
        "" if one.repeatability_um is None else say.size(one.repeatability_um, 2),
        "" if one.between_um is None else say.size(one.between_um, 2),
        "" if drift is None else f"{say.error(drift, 3)} ± {say.size(one.drift_half_width_um or 0.0, 3)}",
        "" if last is None else say.number(last, 2),
        f"<b>{say('yes')}</b>" if one.alarm else "",
    ]


def _remarks(shown: GaugesShape, say: Texts) -> str:
    failed = [f"{esc(say.note(check.fails))}" for one in shown.gauges for check in one.checks if check.fails]
    said = [f"<b>{_named(one)}</b>: {esc(say.note(text))}" for one in shown.gauges for text in one.remarks]
    return items([*said, *failed]) if said or failed else ""
