"""The maps of one part, and the choice of a part on the page: a script paints its numbers over those of the first."""

import json
from typing import Final

import numpy as np

from trueloop.loops.surface.surface import SurfaceModel
from trueloop.report.markup import esc
from trueloop.report.style import signed
from trueloop.report.surface.maps import SCALE, DeviationMap, rgb
from trueloop.surface.pattern.part_maps import PartMaps
from trueloop.surface.separation.places import Places
from trueloop.units import UM_PER_MM

MOST: Final = 50
"""Parts that can be chosen: more would make the page heavy."""
TITLES: Final = {
    "measured": "measured",
    "deterministic": "deterministic",
    "random": "random",
    "predicted": "predicted, corrected by the others’ pattern",
}


def maps_of_part(model: SurfaceModel, own: PartMaps) -> list[DeviationMap]:
    """What was measured on one part, taken apart, and what is predicted of it."""
    return [map_of_part(model, own, name, f"{esc(own.name)}: {title}") for name, title in TITLES.items()]


def map_of_part(model: SurfaceModel, own: PartMaps, name: str, title: str) -> DeviationMap:
    """One of a part's maps, a grid where all parts are."""
    at = own.places
    shape = _shape(at) if _on_one_grid(model) else (len(at.u),)
    points, uv = at.points_mm.reshape(*shape, 3), np.stack([at.u, at.v], axis=1).reshape(*shape, 2)
    return DeviationMap(name, title, points, uv, getattr(own, f"{name}_mm").reshape(shape))


def part_choice(parts: list[list[DeviationMap]], names: list[str], range_um: float) -> str:
    """The list of parts to choose from, with the numbers of their maps (HTML)."""
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
    """A map's title and between which errors it lies (HTML)."""
    low, high = (float(f(shown.error_mm)) * UM_PER_MM for f in (np.nanmin, np.nanmax))
    return f"<b>{shown.title}</b>: {signed(low)} to {signed(high)} µm"


def _shape(places: Places) -> tuple[int, ...]:
    if places.rows is None or places.columns is None:
        return (len(places.u),)
    return len(places.rows), len(places.columns)


def _on_one_grid(model: SurfaceModel) -> bool:
    """Whether all parts were measured on grids of as many rows and columns; else they are drawn as single places."""
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
