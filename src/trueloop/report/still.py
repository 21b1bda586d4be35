"""A figure as a picture (SVG): a Plotly specification drawn without Plotly, for pages and paper.

It draws what the figures of this folder are made of and nothing else: scatter traces (lines, markers, text, filled
outlines, symmetric error bars), one x axis, one or more y axes stacked by their `domain`, and annotations. Text in a
specification is escaped already; of tags only <b> is meant.
"""

import re
from dataclasses import dataclass
from typing import Any, Final

from trueloop.report import style
from trueloop.report.style import Figure, Trace

DASHES: Final = {"solid": "", "dash": "7 5", "dot": "2 4", "dashdot": "9 4 2 4"}
SAID: Final = 60
"""Places along a line that say its value."""
TITLE: Final = 54
"""From an upright axis to the middle of its title, px: beyond five digits of its ticks."""
ANCHORS: Final = {"left": "start", "center": "middle", "right": "end"}


@dataclass(frozen=True)
class Panel:
    """One pair of axes and the rectangle of the picture, in px, that shows their ranges."""

    xaxis: dict[str, Any]
    yaxis: dict[str, Any]
    left: float
    top: float
    width: float
    height: float

    def x(self, value: float) -> float:
        """Returns the picture coordinate of a value of the x axis."""
        low, high = self.xaxis["range"]
        return self.left + self.width * float((value - low) / (high - low))

    def y(self, value: float) -> float:
        """Returns the picture coordinate of a value of the y axis."""
        low, high = self.yaxis["range"]
        return self.top + self.height * float((high - value) / (high - low))


def svg(figure: Figure, title: str) -> str:
    """Draws the picture; `title` (escaped already) is the text for a screen reader."""
    layout = figure["layout"]
    width, height, font = layout["width"], layout["height"], layout["font"]
    panels = _panels(layout)
    decimal = layout.get("separators", ".,")[0]
    body = [part for panel in panels.values() for part in _axes(panel, decimal)]
    for name, panel in panels.items():
        traces = [trace for trace in figure["data"] if trace.get("yaxis", "y") == name]
        body.append(_clipped(panel, [part for trace in traces for part in _trace(trace, panel)]))
    body += [_note(note, panels["y"]) for note in layout.get("annotations", [])]
    return (
        f'<svg class="still" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
        f'aria-label="{title}" font-family="{font["family"].replace(chr(34), chr(39))}" font-size="{font["size"]}" '
        f'fill="{font["color"]}">{"".join(body)}</svg>'
    )


def _clipped(panel: Panel, parts: list[str]) -> str:
    """An inner picture: what leaves the panel is cut off at its edge."""
    box = (panel.left, panel.top, panel.width, panel.height)
    x, y, width, height = (f"{number:.1f}" for number in box)
    edges = f'x="{x}" y="{y}" width="{width}" height="{height}" viewBox="{x} {y} {width} {height}"'
    return f"<svg {edges}>{''.join(parts)}</svg>"


def _panels(layout: dict[str, Any]) -> dict[str, Panel]:
    """The panels by the name that traces use ("y", "y2"), each in its part of the plotting area."""
    margin = layout["margin"]
    left, top = margin["l"], margin["t"]
    width = layout["width"] - left - margin["r"]
    height = layout["height"] - top - margin["b"]
    panels = {}
    for key in (key for key in layout if key.startswith("yaxis")):
        yaxis = layout[key]
        low, high = yaxis.get("domain", [0.0, 1.0])
        panel = Panel(
            xaxis=layout["xaxis"],
            yaxis=yaxis,
            left=left,
            top=top + (1 - high) * height,
            width=width,
            height=(high - low) * height,
        )
        panels[key.replace("axis", "")] = _to_equal_scale(panel) if "scaleanchor" in yaxis else panel
    return panels


def _to_equal_scale(panel: Panel) -> Panel:
    """The panel shrunk about its middle so that a unit is as long on either axis."""
    spans = [high - low for low, high in (panel.xaxis["range"], panel.yaxis["range"])]
    scale = min(panel.width / spans[0], panel.height / spans[1])
    width, height = scale * spans[0], scale * spans[1]
    left, top = panel.left + (panel.width - width) / 2, panel.top + (panel.height - height) / 2
    return Panel(xaxis=panel.xaxis, yaxis=panel.yaxis, left=left, top=top, width=width, height=height)


def _axes(panel: Panel, decimal: str) -> list[str]:
    right, bottom = panel.left + panel.width, panel.top + panel.height
    parts = []
    for value, words in _ticks(panel.yaxis, decimal):
        y = panel.y(value)
        parts.append(_stroke([(panel.left - 5, y), (right, y)], panel.yaxis["gridcolor"], 1))
        parts.append(_text(panel.left - 9, y, words, "end"))
    shows_x = panel.yaxis.get("domain", [0.0])[0] == 0.0
    for value, words in _ticks(panel.xaxis, decimal):
        x = panel.x(value)
        parts.append(_stroke([(x, panel.top), (x, bottom + 5 * shows_x)], panel.xaxis["gridcolor"], 1))
        if shows_x:
            parts.append(_text(x, bottom + 16, words, "middle"))
    if panel.yaxis.get("zeroline", True) and panel.yaxis["range"][0] < 0 < panel.yaxis["range"][1]:
        parts.append(_stroke([(panel.left, panel.y(0)), (right, panel.y(0))], panel.yaxis["zerolinecolor"], 1.5))
    parts.append(_stroke([(panel.left, panel.top), (panel.left, bottom), (right, bottom)], panel.xaxis["linecolor"], 1))
    if shows_x:
        parts.append(_text((panel.left + right) / 2, bottom + 38, panel.xaxis["title"]["text"], "middle"))
    middle = (panel.top + bottom) / 2
    turned = f' transform="rotate(-90 {panel.left - TITLE:.1f} {middle:.1f})"'
    return [*parts, _text(panel.left - TITLE, middle, panel.yaxis["title"]["text"], "middle", turned)]


def _ticks(axis: dict[str, Any], decimal: str) -> list[tuple[float, str]]:
    """Places of the ticks and what stands at them: as the axis lists them, else at its round steps."""
    if "tickvals" in axis:
        return list(zip(axis["tickvals"], axis["ticktext"], strict=True))
    return [(value, style.tick(value, decimal)) for value in style.round_ticks(axis["range"], axis["dtick"])]


def _trace(trace: Trace, panel: Panel) -> list[str]:
    xs, ys = trace["x"], trace["y"]
    parts = []
    opacity = trace.get("opacity", 1)
    if "lines" in trace["mode"]:
        line = trace["line"]
        for stroke in _strokes(xs, ys, panel):
            if "fill" in trace:
                parts.append(f'<path d="{_path(stroke)}Z" fill="{trace["fillcolor"]}"/>')
            if line["width"]:
                parts.append(_stroke(stroke, line["color"], line["width"], line.get("dash", "solid"), opacity))
        if "markers" not in trace["mode"]:
            parts += _said_along(xs, ys, trace.get("hovertext", []), panel)
    if "error_y" in trace:
        for x, y, u in zip(xs, ys, trace["error_y"]["array"], strict=True):
            bar = [(panel.x(x), panel.y(y - u)), (panel.x(x), panel.y(y + u))]
            parts.append(_stroke(bar, trace["error_y"]["color"], trace["error_y"]["thickness"]))
    if "markers" in trace["mode"]:
        says = trace.get("hovertext", [""] * len(xs))
        parts += [
            _marker(panel.x(x), panel.y(y), trace["marker"], k, _title(says[k]))
            for k, (x, y) in enumerate(zip(xs, ys, strict=True))
        ]
    if "text" in trace["mode"]:
        font = f' font-size="{trace["textfont"]["size"]}" fill="{trace["textfont"]["color"]}"'
        parts += [
            _text(panel.x(x), panel.y(y), words, "middle", font)
            for x, y, words in zip(xs, ys, trace["text"], strict=True)
        ]
    return parts


def _said_along(xs: list[float], ys: list[float], hover: list[str], panel: Panel) -> list[str]:
    """Draws the hover texts of a line: places without extent along it, as many as can be distinguished."""
    some = range(0, len(hover), max(1, len(hover) // SAID))
    return [f'<path d="M{panel.x(xs[k]):.1f} {panel.y(ys[k]):.1f}h0">{_title(hover[k])}</path>' for k in some]


def _strokes(xs: list[float | None], ys: list[float | None], panel: Panel) -> list[list[tuple[float, float]]]:
    """The unbroken runs of a polyline, in picture coordinates."""
    runs: list[list[tuple[float, float]]] = [[]]
    for x, y in zip(xs, ys, strict=True):
        if x is None or y is None:
            runs.append([])
        else:
            runs[-1].append((panel.x(x), panel.y(y)))
    return [run for run in runs if run]


def _title(hover: str) -> str:
    """Returns the hover text of a mark; its only tags are <br> and <b>."""
    return f"<title>{re.sub('</?b>', '', hover).replace('<br>', chr(10))}</title>" if hover else ""


def _marker(x: float, y: float, marker: dict[str, Any], index: int, title: str) -> str:
    colour = marker["color"] if isinstance(marker["color"], str) else marker["color"][index]
    r = marker["size"] / 2
    symbol = marker.get("symbol", "circle")
    fill = "#ffffff" if symbol.endswith("-open") else colour
    shape = symbol.removesuffix("-open")
    paint = f'fill="{fill}" stroke="{colour}" stroke-width="1.5"'
    if shape == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:g}" {paint}>{title}</circle>'
    corners = {
        "diamond": [(0, -r), (r, 0), (0, r), (-r, 0)],
        "triangle-up": [(0, -r), (r, r), (-r, r)],
        "triangle-down": [(0, r), (r, -r), (-r, -r)],
        "triangle-right": [(r, 0), (-r, r), (-r, -r)],
        "triangle-left": [(-r, 0), (r, r), (r, -r)],
        "square": [(-r, -r), (r, -r), (r, r), (-r, r)],
    }[shape]
    return f'<path d="{_path([(x + dx, y + dy) for dx, dy in corners])}Z" {paint}>{title}</path>'


def _note(note: dict[str, Any], panel: Panel) -> str:
    font = note["font"]
    bold = note["text"].startswith("<b>")
    words = note["text"].removeprefix("<b>").removesuffix("</b>")
    more = f' font-size="{font["size"]}" fill="{font["color"]}"' + (' font-weight="600"' if bold else "")
    return _text(panel.x(note["x"]), panel.y(note["y"]), words, ANCHORS[note["xanchor"]], more)


def _text(x: float, y: float, words: str, anchor: str, more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" dy=".35em" text-anchor="{anchor}"{more}>{words}</text>'


def _path(points: list[tuple[float, float]]) -> str:
    return "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in points)


def _stroke(
    points: list[tuple[float, float]], colour: str, width: float, dash: str = "solid", opacity: float = 1
) -> str:
    extra = (f' stroke-dasharray="{DASHES[dash]}"' if DASHES[dash] else "") + (
        f' opacity="{opacity}"' if opacity != 1 else ""
    )
    return f'<path d="{_path(points)}" fill="none" stroke="{colour}" stroke-width="{width:g}"{extra}/>'
