"""Finished parts over their profile, a panel each, all on one scale: red is material left on, blue too much taken."""

from typing import Any, Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.report import style
from trueloop.report.realtime.run import FinishedPart
from trueloop.report.style import Figure

PANEL_PX: Final = 170
GAP_PX: Final = 26
MARGINS: Final = {"l": 68, "r": 16, "t": 24, "b": 52}
MOST: Final = 1500
"""Places of a part that are drawn: between them the largest and the least of each stretch."""


def parts_figure(parts: tuple[FinishedPart, ...], width: int) -> Figure:
    """Deviations, µm, over arc length."""
    ends = style.padded([float(value) for part in parts for value in part.deviation_um if np.isfinite(value)])
    start = min(float(part.along_mm.min()) for part in parts)
    end = max(float(part.along_mm.max()) for part in parts)
    whole = len(parts) * PANEL_PX + (len(parts) - 1) * GAP_PX
    height = MARGINS["t"] + MARGINS["b"] + whole
    axes: dict[str, Any] = {
        "xaxis": style.axis("arc length from the chuck end (mm)", start, end, 10 if width > 600 else 5)
    }
    data: list[dict[str, Any]] = []
    for k, part in enumerate(parts, 1):
        key = "" if k == 1 else str(k)
        top = whole - (k - 1) * (PANEL_PX + GAP_PX)
        domain = [0.0 if k == len(parts) else (top - PANEL_PX) / whole, top / whole]
        axes[f"yaxis{key}"] = style.axis(f"{style.label(part.name)} (µm)", *ends, 5) | {"domain": domain}
        data += _part(part, f"y{key}", end - start)
    return {"data": data, "layout": style.layout(width, height, margin=MARGINS, **axes)}


def _part(part: FinishedPart, panel: str, span_mm: float) -> list[dict[str, Any]]:
    """What is above zero filled red, below it blue; the line over both says its values."""
    order = np.argsort(part.along_mm, kind="stable")
    chosen = order[_telling(part.deviation_um[order])]
    along, deviation = part.along_mm[chosen], part.deviation_um[chosen]
    traces = []
    for run in _together(along, span_mm):
        x, y = _with_crossings(along[run], deviation[run])
        for colour, side in ((style.LEFT_ON, np.maximum), (style.TAKEN, np.minimum)):
            outline = [*side(y, 0.0).tolist(), 0.0, 0.0]
            filled = style.area([*x.tolist(), float(x[-1]), float(x[0])], outline, colour, yaxis=panel)
            traces.append(filled | {"opacity": 1})
        hover = [
            f"{style.label(part.name)}, {style.label(part.feature[i])}, {a:.2f} mm<br>{style.signed(d, 2)} µm"
            for i, a, d in zip(chosen[run], along[run], deviation[run], strict=True)
        ]
        line = style.lines([*along[run].tolist()], [*deviation[run].tolist()], style.INK, 0.7, yaxis=panel)
        traces.append(line | {"hovertext": hover, "hoverinfo": "text", "name": part.name})
    return traces


def _telling(values: Array) -> Integers:
    """Places to draw: all, or the least and the largest of each of many equal stretches, and both ends."""
    if len(values) <= MOST:
        return np.arange(len(values))
    kept = {0, len(values) - 1}
    for stretch in np.array_split(np.arange(len(values)), MOST // 2):
        kept |= {int(stretch[np.argmin(values[stretch])]), int(stretch[np.argmax(values[stretch])])}
    return np.array(sorted(kept))


def _together(along: Array, span_mm: float) -> list[slice]:
    """Runs without a gap of a twentieth of the profile or more, where nothing was measured."""
    breaks = (np.flatnonzero(np.diff(along) > span_mm / 20) + 1).tolist()
    return [slice(a, b) for a, b in zip([0, *breaks], [*breaks, len(along)], strict=True)]


def _with_crossings(x: Array, y: Array) -> tuple[Array, Array]:
    """With a place at every crossing of zero, so that both colours meet there."""
    k = np.flatnonzero(y[:-1] * y[1:] < 0)
    share = y[k] / (y[k] - y[k + 1])
    return np.insert(x, k + 1, x[k] + share * (x[k + 1] - x[k])), np.insert(y, k + 1, 0.0)
