"""Maps of deviations over a surface: flat, and in three dimensions on the page, one colour scale for all.

Red is material left on, blue too much taken, white none.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.geometry.feature import Array
from trueloop.report.style import FAINT, FONT, INK, LEFT_ON, TAKEN, Figure, Trace, plain, round_step
from trueloop.units import UM_PER_MM

SCALE: Final[list[tuple[float, str]]] = [
    (0.0, TAKEN),
    (0.25, "#86aede"),
    (0.5, "#ffffff"),
    (0.75, "#e88a9c"),
    (1.0, LEFT_ON),
]
"""Explicit, because Plotly's named scales run opposite ways in Python and JavaScript."""
WIDTH: Final = 480
SOLID_HEIGHT: Final = 520
CELLS: Final = 60


@dataclass(frozen=True, eq=False)
class DeviationMap:
    """Errors in mm on a grid of places (rows, columns) of a surface, `points_mm` (rows, columns, 3)."""

    name: str
    title: str
    points_mm: Array
    error_mm: Array


def colour_range_um(maps: list[DeviationMap]) -> float:
    """The round number of µm that all maps' colours reach to, either way."""
    largest = max(float(np.nanmax(np.abs(m.error_mm), initial=0.0)) for m in maps) * UM_PER_MM
    step = round_step(2 * max(largest, 0.1), 10)
    return float(np.ceil(largest / step - 1e-9) * step) or step


def solid(maps: list[DeviationMap], range_um: float) -> Figure:
    """The surface in three dimensions, coloured by one of the maps; buttons choose which."""
    camera = {"eye": {"x": -0.9, "y": -2.1, "z": 1.5}, "center": {"x": 0, "y": 0, "z": -0.1}}
    axes = {f"{a}axis": {"title": {"text": f"{a} (mm)"}, "color": INK} for a in "xyz"}
    buttons = [
        {"label": m.title, "method": "restyle", "args": [{"visible": [other is m for other in maps]}]} for m in maps
    ]
    menu = {
        "type": "dropdown",
        "buttons": buttons,
        "active": 0,
        "x": 0.0,
        "xanchor": "left",
        "y": 1.0,
        "yanchor": "top",
    }
    layout = {"width": 2 * WIDTH, "height": SOLID_HEIGHT, "font": FONT, "paper_bgcolor": "#ffffff", "yaxis": {}}
    layout |= {"scene": {"aspectmode": "data", "camera": camera, **axes}, "updatemenus": [menu]}
    return {
        "data": [_trace(m, range_um, visible=m is maps[0]) for m in maps],
        "layout": {**layout, "margin": {"l": 0, "r": 0, "t": 8, "b": 0}},
    }


def _trace(shown: DeviationMap, range_um: float, *, visible: bool) -> Trace:
    x, y, z = (shown.points_mm[..., k].round(4).tolist() for k in range(3))
    return {
        "type": "surface", "x": x, "y": y, "z": z, "surfacecolor": (shown.error_mm * UM_PER_MM).round(3).tolist(),
        "visible": visible, "cmin": -range_um, "cmax": range_um, "colorscale": [list(stop) for stop in SCALE],
        "colorbar": {"title": {"text": "µm"}, "thickness": 12, "len": 0.8},
        "hovertemplate": "x %{x:.3f} y %{y:.3f} z %{z:.3f} mm<br>%{surfacecolor:.2f} µm<extra></extra>",
        "lighting": {"ambient": 0.9, "diffuse": 0.2, "specular": 0.0},
    }  # fmt: skip


def flat(deviations: DeviationMap, range_um: float) -> str:
    """One map flat (SVG), rows upwards, with its colour bar: for the page and for paper."""
    error = _thinned(deviations.error_mm) * UM_PER_MM
    rows, columns = error.shape
    side = 340.0 / max(rows, columns)
    cells = "".join(
        f'<rect x="{10 + j * side:.2f}" y="{10 + (rows - 1 - i) * side:.2f}" width="{side + 0.3:.2f}" '
        f'height="{side + 0.3:.2f}" fill="{colour(float(error[i, j]), range_um)}"/>'
        for i in range(rows)
        for j in range(columns)
    )
    frame = (
        f'<rect x="10" y="10" width="{columns * side:.1f}" height="{rows * side:.1f}" fill="none" stroke="{FAINT}"/>'
    )
    return (
        f'<svg viewBox="0 0 {WIDTH} 360" role="img" aria-label="{deviations.name}" '
        f'font-family="sans-serif" font-size="12">{cells}{frame}{_bar(range_um, 20 + columns * side)}</svg>'
    )


def colour(error_um: float, range_um: float) -> str:
    """The colour of an error: linear between the scale's stops, its ends beyond; grey for none measured."""
    if np.isnan(error_um):
        return "#c8ced4"
    share = float(np.clip((error_um / range_um + 1) / 2, 0.0, 1.0))
    stops = [stop for stop, _ in SCALE]
    k = min(int(np.searchsorted(stops, share, side="right")) - 1, len(SCALE) - 2)
    part = (share - SCALE[k][0]) / (SCALE[k + 1][0] - SCALE[k][0])
    low, high = (_rgb(SCALE[i][1]) for i in (k, k + 1))
    return "#" + "".join(f"{round(a + (b - a) * part):02x}" for a, b in zip(low, high, strict=True))


def _bar(range_um: float, x: float) -> str:
    steps = 40
    boxes = "".join(
        f'<rect x="{x:.1f}" y="{10 + k * 8.5:.2f}" width="14" height="8.8" '
        f'fill="{colour(range_um * (1 - 2 * (k + 0.5) / steps), range_um)}"/>'
        for k in range(steps)
    )
    labels = "".join(
        f'<text x="{x + 20:.1f}" y="{10 + 340 * (1 - share) / 2:.1f}" dy=".35em">{plain(range_um * share)} µm</text>'
        for share in (1.0, 0.5, 0.0, -0.5, -1.0)
    )
    return boxes + labels


def _thinned(error: Array) -> Array:
    """At most so many cells a side: a picture needs no more."""
    step = [max(1, -(-n // CELLS)) for n in error.shape]
    return error[:: step[0], :: step[1]]


def _rgb(code: str) -> tuple[int, ...]:
    return tuple(int(code[k : k + 2], 16) for k in (1, 3, 5))
