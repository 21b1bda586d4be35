"""How every figure looks: colours, axes with round ticks, hover labels. A figure is a Plotly specification, a dict.

Colours are explicit, because Plotly's named scales run opposite ways in Python and JavaScript. Text is escaped here,
because Plotly reads tags and entities in it.
"""

import html
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from statistics import fmean
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from trueloop import wording
from trueloop.errors import Code
from trueloop.extras import install_command

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure


Figure: TypeAlias = dict[str, Any]
Trace: TypeAlias = dict[str, Any]

LEFT_ON: Final = "#c8102e"
"""Red: material left on, positive error."""
TAKEN: Final = "#1558b0"
"""Blue: too much taken, negative error."""
INK: Final = "#1d2733"
SOFT: Final = "#6b7885"
FAINT: Final = "#aab4be"
GRID: Final = "#e6eaee"
STEEL: Final = "#dde4ea"
PALE_STEEL: Final = "#f1f4f7"
BAND: Final = "rgba(29,39,51,0.13)"
AFTER: Final = "#00796b"
IN: Final = "#0072b2"
"""Blue of Okabe and Ito: a characteristic inside its limits."""
OUT: Final = "#d55e00"
"""Their vermillion: outside. Who sees no red or green tells the two apart; a sign or a word stands beside either."""
VERDICTS: Final = {"in": (IN, "✓"), "out": (OUT, "✗"), "undecided": (SOFT, "?")}
"""Colour and sign by verdict."""
FONT: Final = {"family": "system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif", "size": 13, "color": INK}

MINUS: Final = wording.MINUS


def signed(value: float, decimals: int = 1) -> str:
    """Formats a number with its sign and a true minus; a zero after rounding has no sign; nan is a dash."""
    if math.isnan(value):
        return "–"
    text = f"{value:+.{decimals}f}"
    return text[1:] if float(text) == 0 else text.replace("-", MINUS)


def plain(value: float, decimals: int = 1) -> str:
    """Formats a number without plus; a zero after rounding has no minus; nan is a dash."""
    return signed(value, decimals).removeprefix("+")


def label(text: str) -> str:
    """Escapes user text for a figure: tags and entities are shown, not obeyed."""
    return html.escape(text)


def colour_of(error_um: float) -> str:
    """Returns red for material left on, blue for too much taken, grey for what is written as 0.0 µm."""
    if round(error_um, 1) == 0:
        return SOFT
    return LEFT_ON if error_um > 0 else TAKEN


def round_step(span: float, about: int) -> float:
    """Returns the step of 1, 2 or 5 times a power of ten that divides a span into at most `about` parts."""
    raw = span / about
    power = 10.0 ** math.floor(math.log10(raw))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= raw * (1 - 1e-9))


def round_ticks(ends: Sequence[float], step: float) -> list[float]:
    """Returns the multiples of a step within a range."""
    low, high = ends
    return [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def tick(value: float, decimal: str = ".") -> str:
    """Formats a number at a tick."""
    return f"{round(value, 9):g}".replace("-", MINUS).replace(".", decimal) if abs(value) > 1e-9 else "0"


def axis(title: str, low: float, high: float, about: int = 8, **more: Any) -> dict[str, Any]:
    """Makes an axis with its range and round ticks stated, so that every renderer shows the same."""
    return {
        "title": {"text": title, "standoff": 8},
        "range": [low, high],
        "dtick": round_step(high - low, about),
        "tick0": 0,
        "gridcolor": GRID,
        "linecolor": FAINT,
        "zerolinecolor": FAINT,
        "showline": True,
        "ticks": "outside",
        "tickcolor": FAINT,
    } | more


def padded(values: Iterable[float], share: float = 0.1, least: float = 1.0) -> tuple[float, float]:
    """Returns the range of values and zero, widened by a share of itself on either side, at least `least` wide."""
    seen = [0.0, *(value for value in values if math.isfinite(value))]
    low, high = min(seen), max(seen)
    pad = share * max(high - low, least)
    return low - pad, high + pad


def scaled(drawn: dict[str, Any], x: float, y: float) -> dict[str, Any]:
    """Converts a trace or a note with its coordinates, and its error bars, to other units."""
    if x == y == 1.0:
        return drawn
    other = drawn | {"x": _times(drawn["x"], x), "y": _times(drawn["y"], y)}
    bars = drawn.get("error_y")
    return other if bars is None else other | {"error_y": bars | {"array": _times(bars["array"], y)}}


def _times(values: Any, factor: float) -> Any:
    if isinstance(values, list):
        return [None if value is None else value * factor for value in values]
    return values * factor


def layout(width: int, height: int, **more: Any) -> dict[str, Any]:
    """Returns what all figures share. Width and height are those on paper; a page may scale both."""
    return {
        "width": width,
        "height": height,
        "font": FONT,
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "margin": {"l": 64, "r": 16, "t": 30, "b": 52},
        "hovermode": "closest",
        "hoverlabel": {"bgcolor": "#ffffff", "bordercolor": FAINT, "font": FONT, "align": "left"},
        "showlegend": False,
    } | more


def lines(x: list[float | None], y: list[float | None], colour: str, width: float = 1.5, **more: Any) -> Trace:
    """Draws a polyline; None breaks it. It shows nothing when pointed at."""
    line = {"color": colour, "width": width} | more.pop("line", {})
    return {"type": "scatter", "mode": "lines", "x": x, "y": y, "line": line, "hoverinfo": "skip"} | more


def area(x: list[float], y: list[float], colour: str, **more: Any) -> Trace:
    """Draws a filled closed outline without a line."""
    return lines(list(x), list(y), "rgba(0,0,0,0)", 0, fill="toself", fillcolor=colour, **more)


def dots(x: list[float], y: list[float], hover: list[str], **marker: Any) -> Trace:
    """Markers that say `hover` when pointed at; `hover` is escaped already, lines separated by <br>."""
    return {
        "type": "scatter",
        "mode": "markers",
        "x": x,
        "y": y,
        "hovertext": hover,
        "hoverinfo": "text",
        "marker": {"size": 7} | marker,
    }


def note(x: float, y: float, text: str, **more: Any) -> dict[str, Any]:
    """Words at a place of the first pair of axes; `text` is escaped already."""
    font = {"size": 12, "color": SOFT} | more.pop("font", {})
    return {"x": x, "y": y, "text": text, "showarrow": False, "xanchor": "center", "yanchor": "middle"} | {
        "font": font, **more,
    }  # fmt: skip


def apart(ends: Mapping[str, float], least: float) -> dict[str, float]:
    """Places for names at their lines' ends, in the same order, `least` apart, shifted as a whole to their middle."""
    order = sorted(ends, key=lambda name: ends[name])
    places: list[float] = []
    for name in order:
        places.append(max(ends[name], places[-1] + least) if places else ends[name])
    shift = fmean(ends.values()) - fmean(places) if places else 0.0
    return {name: place + shift for name, place in zip(order, places, strict=True)}


DARK: Final = {
    LEFT_ON: "#ff7a8a",
    TAKEN: "#7db4ff",
    AFTER: "#4fd1bd",
    IN: "#66b8ea",
    OUT: "#ff9d4d",
    INK: "#e8edf2",
    SOFT: "#b4bec8",
    FAINT: "#6d7a86",
    GRID: "#39424b",
    STEEL: "#3a4652",
    PALE_STEEL: "#2b343d",
    BAND: "rgba(232,237,242,0.2)",
    "#ffffff": "#242424",
}
"""By the colour on white; the last one is the ground, which fills open marks."""
_COLOUR: Final = re.compile("|".join(f'(?<="){re.escape(one)}(?=")' for one in DARK))


def in_the_dark(svg: str) -> str:
    """Changes a still's colours; red stays material left on, blue too much taken. Words stay as they are."""
    return _COLOUR.sub(lambda found: DARK[found.group()], svg)


def shown(figure: Figure) -> "PlotlyFigure":
    """A figure as Plotly's own object, which a notebook shows where it is the last value of a cell.

    Raises OUT-FIGURE where Plotly, the extra `notebook`, is not installed.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> figure = trueloop.before_and_after(trueloop.compensate(job.inputs))
    >>> trueloop.shown(figure).layout.width
    980
    """
    try:
        from plotly.graph_objects import Figure as PlotlyFigure
    except ImportError as missing:
        raise Code.OUT_FIGURE.refusal(
            f"figures are shown by Plotly, which cannot be loaded: {str(missing)!r}", hint=install_command("notebook")
        ) from None
    return PlotlyFigure(figure)
