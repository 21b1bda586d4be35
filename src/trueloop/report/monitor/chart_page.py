"""The page of control charts: which characteristics alarm and why, charts of each, capability."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from trueloop.report import style
from trueloop.report.markup import as_room_allows, esc, figure_block, html_page, items, on_screen, section, table
from trueloop.report.monitor.chart_values import (
    NAMED,
    CapabilityShape,
    CharacteristicChartShape,
    ChartShape,
    ChartsShape,
    EpisodeShape,
    SegmentShape,
)
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts

WIDTH: Final = 480
HEIGHT: Final = 560
SHOWN: Final = 120
"""The latest parts of a longer series."""
PANELS: Final = {
    "y": ("individuals", (0.62, 1.0)),
    "y2": ("moving range", (0.44, 0.57)),
    "y3": ("EWMA", (0.23, 0.39)),
    "y4": ("CUSUM", (0.0, 0.18)),
}
"""Axes with the charts that they show and their shares of the height."""
TICKS: Final = 8


@dataclass(frozen=True)
class _Drawn:
    """Series to draw, its unit and its first part."""

    one: CharacteristicChartShape
    unit: str
    scale: float
    first: int
    say: Texts

    def hover(self, k: int) -> str:
        """Returns the text of part k when pointed at."""
        part, say = self.one.parts[k], self.say
        value = say.spelled(style.signed(part.value * self.scale, 2))
        return say("part {serial}: {value} {unit}", serial=style.label(part.serial), value=value, unit=self.unit)


def chart_figure(chart: CharacteristicChartShape, shown: ChartsShape, say: Texts = ENGLISH) -> Figure:
    """Draws ● parts, grey those of the baseline; dashed: limits; ▲ alarms; dotted: the tool was set.

    CUSUM downwards is plotted below zero. Colours are those of Okabe and Ito; shapes say the same.
    """
    um = shown.unit == "um"
    first = max(0, len(chart.parts) - SHOWN)
    drawn = _Drawn(chart, say.um if um else "σ", say.per_um if um else 1.0, first, say)
    data: list[Trace] = []
    layout: dict[str, Any] = {
        "xaxis": style.axis(say("part"), first + 0.4, len(chart.parts) + 0.6, **_serials(chart, first))
    }
    for axis, (name, domain) in PANELS.items():
        traces = [trace for segment in chart.segments for trace in _panel(drawn, segment, name)]
        ends = style.padded([y for trace in traces for y in trace["y"] if y is not None], 0.08, 1e-3)
        traces = [*_tool_set(chart, first, ends), *traces]
        data += [trace | ({} if axis == "y" else {"yaxis": axis}) for trace in traces]
        title = f"{_title(name, say)} ({drawn.unit})"
        layout[axis.replace("y", "yaxis")] = style.axis(title, *ends, 4 if axis == "y" else 2, domain=list(domain))
    margin = {"l": 64, "r": 10, "t": 10, "b": 50}
    return {"data": data, "layout": style.layout(WIDTH, HEIGHT, margin=margin, separators=say.separators, **layout)}


def _title(name: str, say: Texts) -> str:
    return {"individuals": say("value"), "moving range": say("range")}.get(name, name)


def _panel(drawn: _Drawn, segment: SegmentShape, name: str) -> Iterator[Trace]:
    """The charts of that name of one segment; without one its values, pale."""
    for chart in segment.charts:
        if chart.name.startswith(name):
            yield from _chart(drawn, segment, chart)
    if not segment.charts and name == "individuals":
        own = range(max(segment.first, drawn.first), segment.stop)
        yield _dots(drawn, [(k, drawn.one.parts[k].value * drawn.scale) for k in own], color=style.FAINT, size=6)


def _chart(drawn: _Drawn, segment: SegmentShape, chart: ChartShape) -> Iterator[Trace]:
    sign = -drawn.scale if chart.name.endswith("downwards") else drawn.scale
    span = slice(max(drawn.first - segment.first, 0), None)
    own = list(range(segment.first, segment.stop))[span]
    both = chart.name in ("individuals", "EWMA")
    for limit in (chart.low, chart.high) if both else (chart.high,):
        yield _level(own, [sign * value for value in limit][span], style.OUT, "dash")
    yield _level(own, [sign * chart.centre] * len(own), style.SOFT, "solid")
    values = [None if value is None else sign * value for value in chart.plotted][span]
    yield style.lines([k + 1.0 for k in own], list(values), style.IN, 1.2)
    marks = [(k, value) for k, value in zip(own, values, strict=True) if value is not None]
    main = chart.name == "individuals"
    if main:
        parts = drawn.one.parts
        yield _dots(drawn, [mark for mark in marks if parts[mark[0]].in_baseline], color=style.SOFT, size=6)
        yield _dots(drawn, [mark for mark in marks if not parts[mark[0]].in_baseline], color=style.IN, size=6)
    alarms = {alarm.serial for each in drawn.one.alarms for alarm in each.alarms if alarm.chart == chart.name}
    hit = [(k, value) for k, value in marks if drawn.one.parts[k].serial in alarms]
    yield _dots(drawn, hit, color=style.OUT, symbol="triangle-up", size=12 if main else 9)


def _level(own: Sequence[int], values: Sequence[float], colour: str, dash: str) -> Trace:
    """A limit over the parts, half a part longer on either side."""
    if not own:
        return style.lines([], [], colour)
    x: list[float | None] = [own[0] + 0.5, *(k + 1.0 for k in own), own[-1] + 1.5]
    return style.lines(x, [values[0], *values, values[-1]], colour, 1.2, line={"dash": dash})


def _dots(drawn: _Drawn, marks: Sequence[tuple[int, float]], **marker: Any) -> Trace:
    hover = [drawn.hover(k) for k, _ in marks]
    return style.dots([k + 1.0 for k, _ in marks], [value for _, value in marks], hover, **marker)


def _tool_set(chart: CharacteristicChartShape, first: int, ends: tuple[float, float]) -> Iterator[Trace]:
    for k, part in enumerate(chart.parts):
        if part.tool_set and k >= first:
            yield style.lines([k + 0.5, k + 0.5], list(ends), style.INK, 1.5, line={"dash": "dot"})


def _serials(chart: CharacteristicChartShape, first: int) -> dict[str, Any]:
    """Serial numbers at some of the parts, no more than are legible."""
    parts = chart.parts[first:]
    step = max(1, -(-len(parts) // TICKS), max(len(part.serial) for part in parts) * len(parts) // 45)
    at = list(range(0, len(parts), step))
    return {"tickvals": [first + k + 1 for k in at], "ticktext": [style.label(parts[k].serial) for k in at]}


LARGEST: Final = 600_000
"""Bytes of figures on one page: what is beyond stands in the table alone."""


def chart_page(shown: ChartsShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    figures, left_out = _figures(shown, say)
    note = say("{n} more characteristics stand in the table alone.", n=left_out) if left_out else ""
    of = say("errors of the parts as inspected") if shown.what == "value" else say("residuals after correction")
    body = (
        f'<header><p class="kicker">{say("trueloop · quality monitor")}</p><h1>{esc(shown.part_type)}</h1>'
        f'<p class="meta">{say("Control charts of {n} characteristics: {of}.", n=len(shown.characteristics), of=of)}'
        f"</p>{_verdict(shown, say)}{_how_to_read(shown, say)}</header>"
        + _alarms(shown, say)
        + section("capability", say("Characteristics"), _table(shown, say))
        + section(
            "charts", say("Charts"), on_screen(say), f'<div class="figures pairs">{figures}</div>',
            f"<p class='note'>{note}</p>" if note else "",
        )
        + _findings(shown)
    )  # fmt: skip
    return html_page(f"{esc(shown.part_type)} – {say('quality monitor')}", body, language=say.language)


def _verdict(shown: ChartsShape, say: Texts) -> str:
    alarms = [characteristic for characteristic in shown.characteristics if characteristic.alarms]
    if not alarms:
        words = say("No alarm in {n} characteristics.", n=len(shown.characteristics))
    else:
        said = [f"{alarm.characteristic} ({alarm.alarms[-1].last})" for alarm in alarms]
        words = say("Alarm: {names}; in brackets the latest part that alarms.", names=esc(", ".join(said)))
    return f'<p class="verdict">{words}</p>'


def _how_to_read(shown: ChartsShape, say: Texts) -> str:
    words = say(
        "Grey ●: parts of the baseline, from which limits come; blue ●: others; ▲ alarm; dashed: limits; dotted: the "
        "tool was set. Individuals with ± 3 σ, moving ranges, EWMA of weight 0.2, CUSUM with an allowance of 0.5 σ "
        "(upwards above zero, downwards below)."
    )
    more = say(
        "Residuals are what memory did not expect of a part, in standard deviations of its expectation: with what was "
        "corrected taken into account."
    )
    return f"<p class='note'>{words}</p>" + (f"<p class='note'>{more}</p>" if shown.what == "residual" else "")


def _alarms(shown: ChartsShape, say: Texts) -> str:
    blocks = [block for characteristic in shown.characteristics for block in _episodes(characteristic, shown, say)]
    if not blocks:
        return ""
    note = say(
        "Probabilities compare what is known to have happened with a step at any part that nobody knows of; they hold "
        "for one change at a time. Sizes: how far the values moved, ± 95 %, if that is the cause."
    )
    return section("alarms", say("Alarms and what explains them"), *blocks, f"<p class='note'>{note}</p>")


def _episodes(chart: CharacteristicChartShape, shown: ChartsShape, say: Texts) -> Iterator[str]:
    head = (say("cause"), say("what is known"), say("probability"), say("size ({unit})", unit=_unit(shown, say)))
    for episode in chart.alarms:
        rows = [
            [say.note(cause.kind), esc(say.note(cause.words)), _percent(cause.probability, say), size]
            for cause in episode.causes
            if cause.probability >= NAMED
            for size in [f"{_number(cause.size, shown, say)} ± {_number(1.96 * cause.size_u, shown, say)}"]
        ]
        since = say("a step would begin at part {serial}", serial=esc(episode.since))
        rows.append([say("not known"), since, _percent(episode.unknown, say), ""])
        rows.append([say("chance"), say("nothing moved: a false alarm"), _percent(episode.chance, say), ""])
        yield f"<h3>{esc(chart.characteristic)}: {_parts(episode, say)}</h3>{items(_meanings(episode, say))}"
        yield table(head, rows, words=(0, 1), stacks=True)


def _meanings(episode: EpisodeShape, say: Texts) -> Iterator[str]:
    yield from dict.fromkeys(f"{esc(alarm.chart)}: {esc(say.note(alarm.meaning))}" for alarm in episode.alarms)


def _parts(episode: EpisodeShape, say: Texts) -> str:
    if episode.first == episode.last:
        return say("part {serial}", serial=esc(episode.first))
    return say("parts {first} to {last}", first=esc(episode.first), last=esc(episode.last))


def _percent(share: float, say: Texts) -> str:
    return f"{say.number(100 * share, 0)} %"


def _unit(shown: ChartsShape, say: Texts) -> str:
    return say.um if shown.unit == "um" else "σ"


def _number(value: float, shown: ChartsShape, say: Texts) -> str:
    return say.size(value) if shown.unit == "um" else say.number(value, 2)


def _table(shown: ChartsShape, say: Texts) -> str:
    unit = _unit(shown, say)
    head = (
        say("characteristic"), say("parts"), say("mean ({unit})", unit=unit),
        say("σ short term<br>({unit})", unit=unit), say("σ of all<br>({unit})", unit=unit),
        "Cp", "Cpk", "Pp", "Ppk", say("alarms"),
    )  # fmt: skip
    rows = [_row(characteristic, shown, say) for characteristic in shown.characteristics]
    note = say(
        "Indices with their 95 % intervals [ISO 22514-2]: Cp and Cpk with the short-term deviation, Pp and Ppk with "
        "that of all parts; for values that are normally distributed."
    )
    remarks = items(
        f"<b>{esc(characteristic.characteristic)}</b>: {esc(say.note(remark))}"
        for characteristic in shown.characteristics
        for remark in characteristic.remarks
    )
    return table(head, rows, words=(0,), name="monitor", stacks=True) + f"<p class='note'>{note}</p>" + remarks


def _row(chart: CharacteristicChartShape, shown: ChartsShape, say: Texts) -> list[str]:
    found = chart.capability
    mean = sum(part.value for part in chart.parts) / len(chart.parts)
    return [
        esc(chart.characteristic),
        str(len(chart.parts)),
        _number(mean, shown, say),
        _number(chart.sigma, shown, say),
        "" if found is None else _number(found.sigma, shown, say),
        *(_index(found, name, say) for name in ("Cp", "Cpk", "Pp", "Ppk")),
        esc(", ".join(each.first for each in chart.alarms)),
    ]


def _index(capability: CapabilityShape | None, name: str, say: Texts) -> str:
    one = None if capability is None else next(each for each in capability.indices if each.name == name)
    if one is None or one.value is None or one.low is None or one.high is None:
        return ""
    return f"{say.number(one.value, 2)}<br>({say.number(one.low, 2)} … {say.number(one.high, 2)})"


def _figures(shown: ChartsShape, say: Texts) -> tuple[str, int]:
    """Figures of all characteristics as far as the page has room, and how many it has none for."""
    blocks = (
        figure_block(f"chart-{k}", chart_figure(shape, shown, say), _caption(shape, say), small=True)
        for k, shape in enumerate(shown.characteristics, 1)
    )
    return as_room_allows(blocks, len(shown.characteristics), LARGEST)


def _caption(chart: CharacteristicChartShape, say: Texts) -> str:
    more = ""
    if len(chart.parts) > SHOWN:
        more = say(", the latest {shown} of {all} parts", shown=SHOWN, all=len(chart.parts))
    limits = [say.mm(limit, 4) for limit in (chart.lower_limit_mm, chart.upper_limit_mm) if limit is not None]
    between = f" ({' … '.join(limits)})" if limits else ""
    return f"<b>{esc(chart.characteristic)}</b>, {say.mm(chart.nominal_mm, 4)}{between} {say.mm_name}{more}"


def _findings(shown: ChartsShape) -> str:
    if not shown.findings:
        return ""
    return items(f"{esc(finding.code)}: {esc(finding.message)} – {esc(finding.hint)}" for finding in shown.findings)
