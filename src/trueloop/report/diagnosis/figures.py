"""Figures of diagnoses: errors over the parts, repeats of a fixturing, probabilities."""

from collections.abc import Sequence
from typing import Any, Final

from trueloop.report import style
from trueloop.report.diagnosis.shapes import FeatureMeansShape, FixturingShape, SeenPartShape
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts

WIDTH: Final = 480
HEIGHT: Final = 300
SHOWN: Final = 400
"""The latest parts of a longer series."""
SPOKEN: Final = 60
"""Marks of more parts are smaller, have no bars and say nothing when pointed at."""
TICKS: Final = 8
MACHINE: Final = style.IN
CMM: Final = style.INK
COVERAGE: Final = 2.0
"""Bars are twice the standard uncertainty: 95 %."""


def series_figure(
    parts: Sequence[SeenPartShape], of: FeatureMeansShape, say: Texts = ENGLISH, width: int = WIDTH
) -> Figure:
    """Draws one error over the parts: ○ by the machine's probe, ◆ by the CMM, bars of 95 %, dotted: a tool set.

    Standard parts are not drawn: nothing was cut on them.
    """
    shown = [part for part in parts if not part.standard][-SHOWN:]
    drawn = [(k + 1.0, part) for k, part in enumerate(shown)]
    data, ends = [], [0.0]
    for device, colour, symbol in (("machine", MACHINE, "circle-open"), ("CMM", CMM, "diamond")):
        traces, values = _seen_by(device, drawn, of, colour, symbol, say)
        data += traces
        ends += values
    low, high = (end * say.per_um for end in style.padded(ends, 0.08, 1.0))
    settings: list[Trace] = [
        style.lines([at - 0.5, at - 0.5], [low, high], style.SOFT, 1.5, line={"dash": "dot"})
        for at, part in drawn
        if part.tool_set
    ]
    layout = style.layout(
        width,
        HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(say("part"), 0.4, len(shown) + 0.6, **_serials(shown)),
        yaxis=style.axis(say("error ({um})"), low, high, 6),
        separators=say.separators,
    )
    return {"data": settings + data, "layout": layout}


def _seen_by(
    device: str,
    drawn: Sequence[tuple[float, SeenPartShape]],
    of: FeatureMeansShape,
    colour: str,
    symbol: str,
    say: Texts,
) -> tuple[list[Trace], list[float]]:
    """Marks of one device and what they reach to, µm; the two devices stand a little apart."""
    beside = -0.12 if device == "machine" else 0.12
    few = len(drawn) <= SPOKEN
    x, y, bars, says = [], [], [], []
    for at, part in drawn:
        for one in part.errors.get(device, ()):
            if (one.feature, one.other, one.kind) == (of.feature, of.other, of.kind) and one.value_um is not None:
                x.append(at + beside)
                y.append(one.value_um)
                bars.append(COVERAGE * (one.standard_u_um or 0.0))
                says.append(f"{style.label(part.serial)}: {say.error(one.value_um)} {say.um}" if few else "")
    if not x:
        return [], []
    scale = say.per_um
    marks = style.dots(x, [v * scale for v in y], says, color=colour, symbol=symbol, size=7 if few else 4)
    if few:
        marks |= {"error_y": {"array": [b * scale for b in bars], "color": colour, "thickness": 1}}
    reach = [v + sign * b * few for v, b in zip(y, bars, strict=True) for sign in (-1, 1)]
    return [marks], reach


def _serials(parts: Sequence[SeenPartShape]) -> dict[str, Any]:
    """Serial numbers at some of the parts, no more than are legible."""
    if not parts:
        return {"tickvals": [], "ticktext": []}
    step = max(1, -(-len(parts) // TICKS), max(len(one.serial) for one in parts) * len(parts) // 45)
    at = list(range(0, len(parts), step))
    return {"tickvals": [k + 1 for k in at], "ticktext": [_short(parts[k].serial, len(at)) for k in at]}


def _short(serial: str, ticks: int) -> str:
    """The end of a serial number too long to stand at a tick: there they differ."""
    most = 45 // max(ticks, 1)
    return style.label(serial if len(serial) <= most else f"…{serial[1 - most :]}")


def fixturing_figure(one: FixturingShape, say: Texts = ENGLISH) -> Figure:
    """Repeats in order with bars of 95 %, the drift or the step where it is significant, limits dashed."""
    values, scale = [value * say.per_um for value in one.values_um], say.per_um
    x = [float(k) for k in range(1, len(values) + 1)]
    limits = [] if one.limit_um is None else [-one.limit_um * scale, one.limit_um * scale]
    bar = COVERAGE * one.standard_u_um * scale
    reach = [value + sign * bar for value in values for sign in (-1, 1)]
    low, high = style.padded([*reach, *limits], 0.1, 0.5)
    ends: list[float | None] = [0.4, len(values) + 0.6]
    data = [style.lines(list(ends), [limit, limit], style.INK, 1.2, line={"dash": "dash"}) for limit in limits]
    data += _trend(one, x, scale)
    marks = style.dots(
        x, values, [f"{say.error(v)} {say.um}" for v in one.values_um], color=style.IN if one.stable else style.OUT
    )
    data.append(marks | {"error_y": {"array": [bar] * len(x), "color": style.FAINT, "thickness": 1.5}})
    layout = style.layout(
        WIDTH,
        HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(say("repeat"), 0.4, len(values) + 0.6, min(len(values), 10) + 1),
        yaxis=style.axis(say("reading less mean ({um})"), low, high, 6),
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


def _trend(fixturing: FixturingShape, x: Sequence[float], scale: float) -> list[Trace]:
    """A step as two levels, else a drift as a line through the middle, where they are beyond chance."""
    if fixturing.step.significant and fixturing.step_after is not None:
        k, values = fixturing.step_after, fixturing.values_um
        before, after = sum(values[:k]) / max(k, 1) * scale, sum(values[k:]) / max(len(values) - k, 1) * scale
        xs: list[float | None] = [0.5, k + 0.5, k + 0.5, len(values) + 0.5]
        return [style.lines(xs, [before, before, after, after], style.SOFT, 2)]
    if fixturing.drift.significant:
        half = fixturing.drift.value_um * scale / 2
        return [style.lines([x[0], x[-1]], [-half, half], style.SOFT, 2)]
    return []


def bar(share: float, label: str, sound: bool = False) -> str:
    """Draws a probability as a bar from 0 to 1; `label` is the text for a screen reader."""
    kind = "share sound" if sound else "share"
    return (
        f'<svg class="{kind}" viewBox="0 0 100 4" preserveAspectRatio="none" role="img" aria-label="{label}">'
        f'<rect class="all" width="100" height="4"/><rect class="of" width="{100 * share:.2f}" height="4"/></svg>'
    )
