"""One characteristic over the parts: errors before and after correction, bands, weights; tool and alarms marked."""

from collections.abc import Sequence
from typing import Any, Final

from trueloop.domain.proposal import Effect
from trueloop.report import style
from trueloop.report.series.values import CharacteristicSeriesShape, PartShape
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM

PROPOSAL_WIDTH: Final = 480
"""As wide as a telephone shows it."""
PROPOSAL_HEIGHT: Final = 300
APART: Final = 0.16
"""How far both marks of a characteristic stand from its middle."""
LONGEST: Final = 60
"""Letters of all names below the axis together."""


def proposal_figure(effects: Sequence[Effect], say: Texts = ENGLISH) -> Figure:
    """Draws ● without the proposal, ◆ with it; bars hold 95 % of parts. Errors are actual less nominal size: their sign
    does not tell whether material is left on, which is less in a bore that is too large.
    """
    before, after = ([effect.error_before_mm for effect in effects], [effect.error_after_mm for effect in effects])
    u = [NORMAL_95 * effect.standard_u_mm for effect in effects]
    seen = [UM_PER_MM * (e + sign * w) for e, w in zip(before + after, u + u, strict=True) for sign in (-1, 1)]
    low, high = style.padded(seen)
    data = [
        _proposal_marks(-APART, before, u, say, color=BEFORE, symbol="circle", size=9),
        _proposal_marks(APART, after, u, say, color=style.AFTER, symbol="diamond", size=11),
    ]
    layout = style.layout(
        PROPOSAL_WIDTH,
        PROPOSAL_HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(say("characteristic"), 0.5, len(effects) + 0.5) | _names(effects),
        yaxis=style.axis(say("error ({um})"), low * say.per_um, high * say.per_um, 6),
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


def _names(effects: Sequence[Effect]) -> dict[str, list[object]]:
    most = max(LONGEST // len(effects), 3)
    names = [one if len(one) <= most else f"{one[: most - 1]}…" for one in (each.characteristic for each in effects)]
    return {"tickvals": [k + 1 for k in range(len(effects))], "ticktext": [style.label(name) for name in names]}


def _proposal_marks(
    shift: float, errors_mm: Sequence[float], u_mm: Sequence[float], say: Texts, **marker: object
) -> Trace:
    um = [one * UM_PER_MM * say.per_um for one in errors_mm]
    bars = [one * UM_PER_MM * say.per_um for one in u_mm]
    hover = [
        f"{say.error(UM_PER_MM * e)} ± {say.size(UM_PER_MM * w)} {say.um}" for e, w in zip(errors_mm, u_mm, strict=True)
    ]
    x = [k + 1 + shift for k in range(len(um))]
    error_y = {"type": "data", "array": bars, "color": style.INK, "thickness": 1.2, "width": 3}
    return style.dots(x, um, hover, **marker) | {"error_y": error_y}


WIDTH: Final = 480
"""As wide as a telephone shows it; on a screen two stand side by side."""
HEIGHT: Final = 330
SHOWN: Final = 60
"""The latest parts of a longer series."""
ERRORS: Final = (0.34, 1.0)
WEIGHTS: Final = (0.0, 0.24)
"""Shares of the height: errors above, weights below."""
BEFORE: Final = style.SOFT
AFTER: Final = style.IN
ALARM: Final = style.OUT
LIMIT: Final = style.INK
TICKS: Final = 8


def series_figure(series: CharacteristicSeriesShape, say: Texts = ENGLISH) -> Figure:
    """Draws ○ before and ● after correction with the band expected of ●, limits where they are near, ▲ alarms.

    Colours are those of Okabe and Ito; shapes say the same, so that none depends on colour.
    """
    parts = series.parts[-SHOWN:]
    scale = say.per_um
    low, high = style.padded(_seen(parts), 0.08, 1.0)
    x = [float(k) for k in range(1, len(parts) + 1)]
    data = [
        *_bands(x, parts, scale),
        *_limits(series, x, (low, high), scale),
        *_tool_set(x, parts, (low * scale, high * scale)),
        *_marks(x, parts, say),
        *_weights(x, parts, say),
    ]
    layout = style.layout(
        WIDTH,
        HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(say("part"), 0.4, len(parts) + 0.6, **_serials(parts)),
        yaxis=style.axis(say("error ({um})"), low * scale, high * scale, 6, domain=list(ERRORS)),
        yaxis2=style.axis(say("weight"), 0.0, 1.05, 2, domain=list(WEIGHTS)),
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


def _seen(parts: Sequence[PartShape]) -> list[float]:
    """The range of the axis: marks, and bands as far as those of parts after the first go."""
    marks = [value for part in parts for value in (part.before_um, part.after_um)]
    bands = [
        value
        for part in parts[1:]
        if part.expected_um is not None and part.band_um is not None
        for value in (part.expected_um - part.band_um, part.expected_um + part.band_um)
    ]
    return marks + bands


def _serials(parts: Sequence[PartShape]) -> dict[str, Any]:
    """Serial numbers at some of the parts, no more than are legible."""
    step = max(1, -(-len(parts) // TICKS), max(len(part.serial) for part in parts) * len(parts) // 45)
    at = list(range(0, len(parts), step))
    return {"tickvals": [k + 1 for k in at], "ticktext": [style.label(parts[k].serial) for k in at]}


def _bands(x: Sequence[float], parts: Sequence[PartShape], scale: float) -> list[Trace]:
    """Of every part a bar from the lower to the upper end of its band."""
    xs: list[float | None] = []
    ys: list[float | None] = []
    for at, part_shape in zip(x, parts, strict=True):
        if part_shape.expected_um is not None and part_shape.band_um is not None:
            xs += [at, at, None]
            ys += [
                (part_shape.expected_um - part_shape.band_um) * scale,
                (part_shape.expected_um + part_shape.band_um) * scale,
                None,
            ]
    return [style.lines(xs, ys, style.STEEL, 9)] if xs else []


def _limits(
    series: CharacteristicSeriesShape, x: Sequence[float], ends: tuple[float, float], scale: float
) -> list[Trace]:
    """Limits within the picture."""
    found = []
    for limit in (series.lower_limit_mm, series.upper_limit_mm):
        um = None if limit is None else (limit - series.nominal_mm) * 1000.0
        if um is not None and ends[0] < um < ends[1]:
            found.append(style.lines([0.4, x[-1] + 0.6], [um * scale] * 2, LIMIT, 1.2, line={"dash": "dash"}))
    return found


def _tool_set(x: Sequence[float], parts: Sequence[PartShape], ends: tuple[float, float]) -> list[Trace]:
    """A dotted line before a part for which the tool was set."""
    return [
        style.lines([at - 0.5, at - 0.5], list(ends), style.INK, 1.5, line={"dash": "dot"})
        for at, part_shape in zip(x, parts, strict=True)
        if part_shape.tool_set
    ]


def _marks(x: Sequence[float], parts: Sequence[PartShape], say: Texts) -> list[Trace]:
    scale = say.per_um
    pairs = list(zip(x, parts, strict=True))
    other = [(at, part_shape) for at, part_shape in pairs if part_shape.correction_um != 0.0]
    traces = []
    if other:
        before = [part_shape.before_um * scale for _, part_shape in other]
        traces.append(
            style.dots([at for at, _ in other], before, [""] * len(other), color=BEFORE, symbol="circle-open", size=6)
        )
    says = [_hover(part, say) for part in parts]
    after = [part.after_um * scale for part in parts]
    traces.append(style.dots(list(x), after, says, color=AFTER, size=6))
    alarms = [(at, part_shape) for at, part_shape in pairs if part_shape.alarm]
    if alarms:
        where, height = [at for at, _ in alarms], [part_shape.after_um * scale for _, part_shape in alarms]
        words = [_hover(part_shape, say) for _, part_shape in alarms]
        traces.append(style.dots(where, height, words, color=ALARM, symbol="triangle-up", size=12))
    return traces


def _hover(part: PartShape, say: Texts) -> str:
    band = "" if part.band_um is None or part.expected_um is None else say(
        "<br>expected {expected} ± {band} {um}", expected=say.error(part.expected_um), band=say.size(part.band_um)
    )  # fmt: skip
    return say(
        "part {serial}: {error} {um}", serial=style.label(part.serial), error=say.error(part.after_um)
    ) + band  # fmt: skip


def _weights(x: Sequence[float], parts: Sequence[PartShape], say: Texts) -> list[Trace]:
    values = [part.weight for part in parts]
    line = style.lines(list(x), list(values), style.SOFT, 1.2, yaxis="y2")
    dots = style.dots(list(x), values, [""] * len(values), color=style.INK, size=4)
    return [line, dots | {"yaxis": "y2"}]
