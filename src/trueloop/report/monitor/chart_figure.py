"""Control charts of one characteristic: individuals, moving range, EWMA and CUSUM, one above the other."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from trueloop.report import style
from trueloop.report.monitor.chart_shapes import CharacteristicChartShape, ChartShape, ChartsShape, SegmentShape
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
    """What is drawn, in which unit, from which part on."""

    one: CharacteristicChartShape
    unit: str
    scale: float
    first: int
    say: Texts

    def hover(self, k: int) -> str:
        """What part k says."""
        part, say = self.one.parts[k], self.say
        value = say.spelled(style.signed(part.value * self.scale, 2))
        return say("part {serial}: {value} {unit}", serial=style.label(part.serial), value=value, unit=self.unit)


def chart_figure(one: CharacteristicChartShape, shown: ChartsShape, say: Texts = ENGLISH) -> Figure:
    """● parts, grey those of the baseline; dashed: limits; ▲ alarms; dotted: the tool was set.

    CUSUM downwards is plotted below zero. Colours are those of Okabe and Ito; shapes say the same.
    """
    um = shown.unit == "um"
    first = max(0, len(one.parts) - SHOWN)
    drawn = _Drawn(one, say.um if um else "σ", say.per_um if um else 1.0, first, say)
    data: list[Trace] = []
    layout: dict[str, Any] = {
        "xaxis": style.axis(say("part"), first + 0.4, len(one.parts) + 0.6, **_serials(one, first))
    }
    for axis, (name, domain) in PANELS.items():
        traces = [trace for segment in one.segments for trace in _panel(drawn, segment, name)]
        ends = style.padded([y for trace in traces for y in trace["y"] if y is not None], 0.08, 1e-3)
        traces = [*_tool_set(one, first, ends), *traces]
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


def _tool_set(one: CharacteristicChartShape, first: int, ends: tuple[float, float]) -> Iterator[Trace]:
    for k, part in enumerate(one.parts):
        if part.tool_set and k >= first:
            yield style.lines([k + 0.5, k + 0.5], list(ends), style.INK, 1.5, line={"dash": "dot"})


def _serials(one: CharacteristicChartShape, first: int) -> dict[str, Any]:
    """Serial numbers at some of the parts, no more than are legible."""
    parts = one.parts[first:]
    step = max(1, -(-len(parts) // TICKS), max(len(part.serial) for part in parts) * len(parts) // 45)
    at = list(range(0, len(parts), step))
    return {"tickvals": [first + k + 1 for k in at], "ticktext": [style.label(parts[k].serial) for k in at]}
