"""Figures of diagnoses: errors over the parts, repeats of a fixturing, probabilities.

The surface/error diagram of [6876 Fig. 12–15]: every surface and every vector at one gauging point.

All of them lie on one line, along the outward normal; the diagram draws them one below the other. Surfaces are places,
counted from NOMINALSURFACE_CMM; errors and compensations are arrows from one surface to another.
"""

from collections.abc import Sequence
from typing import Any, Final

from trueloop.report import style
from trueloop.report.diagnosis.shapes import FeatureMeansShape, FixturingShape, PointShape, SeenPartShape
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts

WIDE: Final = (980, 190)
NARROW: Final = (480, 188)
"""Width of the picture and of the names at its left."""
ROW: Final = 23
FIRST: Final = "NOMINALSURFACE CMM"


def surfaces_um(point: PointShape, say: Texts = ENGLISH) -> dict[str, float]:
    """Returns the place of each surface, µm, by its name in the report."""
    compensated = point.comp_mtg_um + point.comp_proc_um
    return {
        FIRST: 0.0,
        "NOMINALSURFACE MT": point.error_mtg_resid_um,
        say("the same, uncompensated"): point.error_mtg_um,
        say("detected surface"): point.error_pp_um,
        say("GT compensated surface"): point.error_pp_um - point.comp_proc_um,
        say("uncompensated surface"): point.error_pp_um - compensated,
    }


def vectors_um(point: PointShape) -> dict[str, tuple[float, float]]:
    """Returns start and end of each vector, µm, by its name in the report."""
    detected, nominal, free_nominal = point.error_pp_um, point.error_mtg_resid_um, point.error_mtg_um
    gt = detected - point.comp_proc_um
    return {
        "ERROR_PP": (0.0, detected),
        "ERROR_MTG": (0.0, free_nominal),
        "COMP_MTG": (free_nominal, nominal),
        "ERROR_MTG,RESID": (0.0, nominal),
        "ERROR_PROC": (nominal, gt),
        "COMP_PROC": (gt, detected),
        "ERROR_PROC,RESID": (nominal, detected),
        "COMP_MTG + PROC": (gt - point.comp_mtg_um, detected),
    }


def surface_figures(point: PointShape, say: Texts = ENGLISH) -> dict[str, Figure]:
    """Draws the diagram for a wide and for a narrow window."""
    return {"wide": surface_figure(point, say, WIDE), "narrow": surface_figure(point, say, NARROW)}


def surface_figure(point: PointShape, say: Texts = ENGLISH, size: tuple[int, int] = WIDE) -> Figure:
    """Draws one gauging point. ◆ surfaces, with a dotted line over all rows; arrows: red where material is left on,
    blue where too much was taken, green compensations; behind them what the part errs by.
    """
    surfaces, vectors, scale = surfaces_um(point, say), vectors_um(point), say.per_um
    names = [*surfaces, *vectors]
    row = {name: float(len(names) - k) for k, name in enumerate(names)}
    low, high = (end * scale for end in style.padded(surfaces.values(), 0.24))
    beside = (high - low) * (0.02 if size is WIDE else 0.035)
    detected = point.error_pp_um
    data = [_behind(detected * scale, len(names), style.colour_of(detected))]
    notes = []
    for name, at in surfaces.items():
        data += _surface(at * scale, row[name], name == FIRST)
        notes.append(_value(at * scale, row[name], say.error(at), beside, "left", style.INK))
    for name, (start, end) in vectors.items():
        colour = style.AFTER if name.startswith("COMP") else style.colour_of(end - start)
        data += _arrow(start * scale, end * scale, row[name], colour)
        right = end >= start
        beyond = beside if right else -beside
        notes.append(
            _value(end * scale, row[name], say.error(end - start), beyond, "left" if right else "right", colour)
        )
    layout = style.layout(
        size[0],
        ROW * len(names) + 76,
        margin={"l": size[1], "r": 12, "t": 8, "b": 54},
        xaxis=style.axis(say("along the outward normal ({um})"), low, high, 8 if size is WIDE else 5),
        yaxis=style.axis(
            "", 0.3, len(names) + 0.7, tickvals=list(row.values()), ticktext=names, gridcolor=style.PALE_STEEL
        ),
        annotations=notes,
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


def _behind(detected: float, rows: int, colour: str) -> Trace:
    """From the nominal to the detected surface, in the colour of the part's error."""
    return style.area(
        [0.0, detected, detected, 0.0], [0.3, 0.3, rows + 0.7, rows + 0.7], f"rgba({_channels(colour)},0.09)"
    )


def _channels(colour: str) -> str:
    return ",".join(str(int(colour[k : k + 2], 16)) for k in (1, 3, 5))


def _surface(at: float, row: float, first: bool) -> list[Trace]:
    """A mark in its row, and a line from there down over all vectors."""
    line = style.lines([at, at], [0.3, row], style.SOFT if first else style.FAINT, 1.2, line={"dash": "dot"})
    return [line, style.dots([at], [row], [""], color=style.INK, symbol="diamond", size=9)]


def _arrow(start: float, end: float, row: float, colour: str) -> list[Trace]:
    head = "triangle-right" if end >= start else "triangle-left"
    return [
        style.lines([start, end], [row, row], colour, 3),
        style.dots([end], [row], [""], color=colour, symbol=head if start != end else "circle-open", size=8),
    ]


def _value(at: float, row: float, text: str, beyond: float, anchor: str, colour: str) -> dict[str, object]:
    return style.note(at + beyond, row, text, xanchor=anchor, font={"color": colour})


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
    """Draws one error over the parts: ○ the machine's probe, ◆ CMM, bars of 95 %, dotted: a tool set; no standards."""
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
        for shape in part.errors.get(device, ()):
            if (shape.feature, shape.other, shape.kind) == (
                of.feature,
                of.other,
                of.kind,
            ) and shape.value_um is not None:
                x.append(at + beside)
                y.append(shape.value_um)
                bars.append(COVERAGE * (shape.standard_u_um or 0.0))
                says.append(f"{style.label(part.serial)}: {say.error(shape.value_um)} {say.um}" if few else "")
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
    step = max(1, -(-len(parts) // TICKS), max(len(part.serial) for part in parts) * len(parts) // 45)
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
