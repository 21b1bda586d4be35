"""Maps of deviations over a surface: flat, and in three dimensions on the page, one colour scale for all.

Red is material left on, blue too much taken, white none.
"""

import json
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.surface.surface import SurfaceModel
from trueloop.report.markup import esc
from trueloop.report.style import FAINT, INK, LEFT_ON, SOFT, TAKEN, plain, round_step, signed
from trueloop.surface.pattern.pattern import PartMaps, Pattern
from trueloop.surface.separation.spline_surface import Places
from trueloop.units import UM_PER_MM

SCALE: Final[list[tuple[float, str]]] = [
    (0.0, TAKEN),
    (0.25, "#86aede"),
    (0.5, "#ffffff"),
    (0.75, "#e88a9c"),
    (1.0, LEFT_ON),
]
"""Explicit: libraries disagree on which end of a named scale is red."""
WIDTH: Final = 480
CELLS: Final = 60
XYZ: Final = "xyz"
ALONG: Final = 0.9
"""Cosine from which a side of a map is along a coordinate of the part."""
LEFT: Final = 26
TOP: Final = 8
BOX: Final = 336
HEIGHT: Final = BOX + TOP + 24
"""A flat map: where its box begins, its longer side, and what is left below for words."""


@dataclass(frozen=True, eq=False)
class DeviationMap:
    """Errors in mm on a grid of places (rows, columns) of a surface, or at scattered ones (n,); `points_mm` and their
    parameters `uv` on [0, 1] have 3 and 2 numbers a place; nan where nothing is known or no face is. `title` is HTML.
    `bare`: which places of a grid no measurement supports; they are hatched.
    """

    name: str
    title: str
    points_mm: Array
    uv: Array
    error_mm: Array
    bare: np.ndarray | None = None

    @property
    def thinned(self) -> "DeviationMap":
        """Returns the map with at most `CELLS` places a side, or as many scattered ones: a picture needs no more."""
        most = CELLS if self.error_mm.ndim == 2 else CELLS**2
        some = tuple(slice(None, None, max(1, -(-n // most))) for n in self.error_mm.shape)
        bare = None if self.bare is None else self.bare[some]
        return replace(self, points_mm=self.points_mm[some], uv=self.uv[some], error_mm=self.error_mm[some], bare=bare)

    @property
    def sides_mm(self) -> tuple[float, float]:
        """Returns about how long the surface is along u and along v, mm."""
        along, across = (float(np.linalg.norm(slope)) for slope in self._slopes)
        return along, across

    @property
    def axis_words(self) -> tuple[str, str]:
        """Returns what runs along u and v: a coordinate of the part, from where to where, else a share of each."""
        points, uv = self.points_mm.reshape(-1, 3), self.uv.reshape(-1, 2)
        words = []
        for axis, slope in enumerate(self._slopes):
            length = float(np.linalg.norm(slope))
            k = int(np.argmax(np.abs(slope)))
            if abs(slope[k]) >= ALONG * length > 0:
                at = float(points[:, k].mean()) - slope[k] * float(uv[:, axis].mean())
                words.append(f"{XYZ[k]} {plain(at)} → {plain(at + slope[k])} mm")
            else:
                shares = ", ".join(
                    f"{name} {plain(share, 2)}" for name, share in zip(XYZ, slope / (length or 1.0), strict=True)
                )
                words.append(f"along ({shares}) → {plain(length)} mm")
        return words[0], words[1]

    @property
    def _slopes(self) -> Array:
        """How far points are apart along u and along v, a row each, mm a unit."""
        points, uv = self.points_mm.reshape(-1, 3), self.uv.reshape(-1, 2)
        return np.asarray(np.linalg.lstsq(uv - uv.mean(axis=0), points - points.mean(axis=0), rcond=None)[0])


def colour_range_um(maps: list[DeviationMap]) -> float:
    """Returns the round number of µm that all maps' colours reach to, either way."""
    largest = max(float(np.nanmax(np.abs(m.error_mm), initial=0.0)) for m in maps) * UM_PER_MM
    step = round_step(2 * max(largest, 0.1), 20)
    return float(np.ceil(largest / step - 1e-9) * step) or step


def flat(deviations: DeviationMap, range_um: float) -> str:
    """Draws one map flat (SVG): u upwards, v to the right, sides in proportion, with its colour bar.

    Its sides are named by the coordinates of the part that run along them.
    """
    u_mm, v_mm = deviations.sides_mm
    across, up = (BOX * side / max(u_mm, v_mm) for side in (v_mm, u_mm))
    draw = _dots if deviations.error_mm.ndim == 1 else _cells
    box = f'x="{LEFT}" y="{TOP}" width="{across:.1f}" height="{up:.1f}"'
    frame = f'<rect class="frame" {box} fill="none" stroke="{FAINT}"/>'
    middle, below = TOP + up / 2, TOP + up + 16
    of_u, of_v = deviations.axis_words
    axes = (
        f'<text x="{LEFT + across / 2:.1f}" y="{below:.1f}" text-anchor="middle" fill="{SOFT}">'
        f"{of_v}</text>"
        f'<text transform="translate({LEFT - 8} {middle:.1f}) rotate(-90)" text-anchor="middle" fill="{SOFT}">'
        f"{of_u}</text>"
    )
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{deviations.title}" font-family="sans-serif" '
        f'font-size="12"><g class="marks">{draw(deviations.thinned, range_um, across, up)}</g>'
        f"{_hatched(deviations.thinned, across, up)}{frame}{axes}"
        f"{_bar(range_um, LEFT + across + 10)}</svg>"
    )


def sheet(maps: list[DeviationMap]) -> str:
    """Draws all maps on one sheet, a file of its own (SVG), one colour scale for all."""
    range_um, gap = colour_range_um(maps), 26
    width, height = 2 * WIDTH, -(-len(maps) // 2) * (HEIGHT + gap)
    drawn = "".join(
        f'<svg x="{k % 2 * WIDTH}" y="{k // 2 * (HEIGHT + gap)}" width="{WIDTH}" height="{HEIGHT + gap}">'
        f'<text x="{LEFT}" y="18" font-family="sans-serif" font-size="14" font-weight="bold" fill="{INK}">'
        f"{m.title}</text>"
        f'<svg y="{gap}" width="{WIDTH}" height="{HEIGHT}">{flat(m, range_um)}</svg></svg>'
        for k, m in enumerate(maps)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
        f"<title>Deviations in µm: red is material left on, blue too much taken</title>{drawn}</svg>\n"
    )


def _cells(deviations: DeviationMap, range_um: float, across: float, up: float) -> str:
    error = deviations.error_mm * UM_PER_MM
    rows, columns = error.shape
    wide, high = across / columns, up / rows
    return "".join(
        f'<rect x="{LEFT + j * wide:.2f}" y="{TOP + (rows - 1 - i) * high:.2f}" width="{wide + 0.3:.2f}" '
        f'height="{high + 0.3:.2f}" fill="{colour(float(error[i, j]), range_um)}"/>'
        for i in range(rows)
        for j in range(columns)
    )


def _hatched(deviations: DeviationMap, across: float, up: float) -> str:
    """A stroke over every second cell that no measurement supports."""
    if deviations.bare is None or not np.any(deviations.bare):
        return ""
    rows, columns = deviations.bare.shape
    wide, high = across / columns, up / rows
    strokes = "".join(
        f"M{LEFT + j * wide:.1f} {TOP + (rows - i) * high:.1f}l{wide:.1f} {-high:.1f}"
        for i, j in np.argwhere(deviations.bare).tolist()
        if (i - j) % 2 == 0
    )
    return f'<path class="bare" d="{strokes}" stroke="{INK}" stroke-width="0.8" fill="none"/>'


def _dots(deviations: DeviationMap, range_um: float, across: float, up: float) -> str:
    """Scattered places as dots, about as large as their distance."""
    radius = min(8.0, 0.5 * np.sqrt(across * up / len(deviations.error_mm)))
    return "".join(
        f'<circle cx="{LEFT + v * across:.2f}" cy="{TOP + (1 - u) * up:.2f}" r="{radius:.2f}" '
        f'fill="{colour(float(error) * UM_PER_MM, range_um)}" stroke="{FAINT}" stroke-width="0.3"/>'
        for (u, v), error in zip(deviations.uv, deviations.error_mm, strict=True)
    )


def colour(error_um: float, range_um: float) -> str:
    """Returns the colour of an error: linear between the scale's stops, its ends beyond; grey for none measured."""
    if np.isnan(error_um):
        return "#c8ced4"
    share = float(np.clip((error_um / range_um + 1) / 2, 0.0, 1.0))
    stops = [stop for stop, _ in SCALE]
    k = min(int(np.searchsorted(stops, share, side="right")) - 1, len(SCALE) - 2)
    part = (share - SCALE[k][0]) / (SCALE[k + 1][0] - SCALE[k][0])
    low, high = (rgb(SCALE[i][1]) for i in (k, k + 1))
    return "#" + "".join(f"{round(a + (b - a) * part):02x}" for a, b in zip(low, high, strict=True))


def _bar(range_um: float, x: float) -> str:
    steps = 40
    boxes = "".join(
        f'<rect x="{x:.1f}" y="{TOP + k * BOX / steps:.2f}" width="14" height="{BOX / steps + 0.3:.2f}" '
        f'fill="{colour(range_um * (1 - 2 * (k + 0.5) / steps), range_um)}"/>'
        for k in range(steps)
    )
    labels = "".join(
        f'<text x="{x + 20:.1f}" y="{TOP + BOX * (1 - share) / 2:.1f}" dy=".35em">{plain(range_um * share)} µm</text>'
        for share in (1.0, 0.5, 0.0, -0.5, -1.0)
    )
    return boxes + labels


def rgb(code: str) -> tuple[int, ...]:
    """Returns red, green and blue of a colour such as #1558b0, 0 to 255."""
    return tuple(int(code[k : k + 2], 16) for k in (1, 3, 5))


MOST: Final = 50
"""Parts that can be chosen: more would make the page heavy."""
TITLES: Final = {
    "measured": "measured",
    "deterministic": "deterministic",
    "random": "random",
    "predicted": "predicted, corrected by the others’ pattern",
}


def maps_of_part(model: SurfaceModel, own: PartMaps) -> list[DeviationMap]:
    """Returns what was measured on one part, taken apart, and what is predicted of it."""
    titles = TITLES if model.pattern.parts > 1 else TITLES | {"predicted": "measured, less its own pattern"}
    return [map_of_part(model, own, name, f"{esc(own.name)}: {title}") for name, title in titles.items()]


def between_parts(pattern: Pattern) -> str:
    """Returns the title of the map of how much parts differ."""
    return "Standard deviation between parts" + ("" if pattern.own_mm is None else ", assumed")


def map_of_part(model: SurfaceModel, own: PartMaps, name: str, title: str) -> DeviationMap:
    """Returns one of a part's maps, a grid where all parts are."""
    at = own.places
    shape = _shape(at) if _on_one_grid(model) else (len(at.u),)
    points, uv = at.points_mm.reshape(*shape, 3), np.stack([at.u, at.v], axis=1).reshape(*shape, 2)
    return DeviationMap(name, title, points, uv, getattr(own, f"{name}_mm").reshape(shape))


def part_choice(parts: list[list[DeviationMap]], names: list[str], range_um: float) -> str:
    """Writes the list of parts to choose from, with the numbers of their maps (HTML)."""
    shown = [_shown(name, maps) for name, maps in zip(names[:MOST], parts, strict=False)]
    data = {"range": range_um, "stops": [[share, rgb(code)] for share, code in SCALE], "parts": shown}
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
    options = "".join(f"<option>{esc(name)}</option>" for name in names[:MOST])
    left = f" The first {MOST} of {len(names)}; NAME-maps.csv holds every part’s." if len(names) > MOST else ""
    return (
        f'<p id="choice"><label>Part <select>{options}</select></label>{left}'
        f'<script type="application/json">{text}</script></p>'
    )


def caption(shown: DeviationMap) -> str:
    """Writes a map's title and between which errors it lies (HTML)."""
    low, high = (float(f(shown.error_mm)) * UM_PER_MM for f in (np.nanmin, np.nanmax))
    return f"<b>{shown.title}</b>: {signed(low)} to {signed(high)} µm"


def _shape(places: Places) -> tuple[int, ...]:
    if places.rows is None or places.columns is None:
        return (len(places.u),)
    return len(places.rows), len(places.columns)


def _on_one_grid(model: SurfaceModel) -> bool:
    """Returns whether all parts were measured on grids of as many rows and columns; else they are drawn as single
    places.
    """
    shapes = {_shape(part.separation.places) for part in model.parts}
    return len(shapes) == 1 and len(shapes.pop()) == 2


def _shown(name: str, maps: list[DeviationMap]) -> dict[str, object]:
    """A part's numbers, fewer where there are very many; places where they are not those of a grid."""
    drawn = [shown.thinned for shown in maps]
    shown: dict[str, object] = {"name": name, "maps": [_numbers(*pair) for pair in zip(maps, drawn, strict=True)]}
    if drawn[0].error_mm.ndim == 1:
        shown["uv"] = drawn[0].uv.T.round(5).tolist()
        shown["xyz"] = drawn[0].points_mm.T.round(4).tolist()
    return shown


def _numbers(shown: DeviationMap, drawn: DeviationMap) -> dict[str, object]:
    error = (drawn.error_mm * UM_PER_MM).round(2).tolist()
    return {"name": shown.name, "title": shown.title, "said": caption(shown), "error": error}
