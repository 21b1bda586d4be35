"""The surface in three dimensions, coloured by one of its maps: what `space.js` draws on the page."""

import json
import math
from typing import Final

from trueloop.report.surface.maps import DeviationMap
from trueloop.units import UM_PER_MM

WIDTH: Final = 960
HEIGHT: Final = 520


def space_figure(maps: list[DeviationMap]) -> str:
    """The figure and the list of maps to choose from (HTML); colours and parts are those of `part_choice`."""
    drawn = [shown.thinned for shown in maps]
    places = list({_key(shown): shown for shown in drawn}.values())
    data = {"places": [_places(shown) for shown in places], "maps": [_numbers(shown, places) for shown in drawn]}
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    options = "".join(f'<option value="{shown.name}">{shown.title}</option>' for shown in maps)
    return (
        f'<figure id="space"><p><label>On the surface <select>{options}</select></label></p>'
        f'<canvas width="{2 * WIDTH}" height="{2 * HEIGHT}" tabindex="0"></canvas>'
        f'<script type="application/json">{text}</script><figcaption>Turn it with the mouse or the arrow keys; '
        "point at a place for its error. Axes in mm.</figcaption></figure>"
    )


def _key(shown: DeviationMap) -> bytes:
    """Maps of one part share their places."""
    return shown.points_mm.tobytes()


def _places(shown: DeviationMap) -> dict[str, object]:
    """`rows` is 0 where places are scattered."""
    rows = shown.error_mm.shape[0] if shown.error_mm.ndim == 2 else 0
    return {"rows": rows, "xyz": shown.points_mm.reshape(-1, 3).T.round(3).tolist()}


def _numbers(shown: DeviationMap, places: list[DeviationMap]) -> dict[str, object]:
    at = [_key(place) for place in places].index(_key(shown))
    error = [None if math.isnan(e) else round(e, 2) for e in (shown.error_mm.ravel() * UM_PER_MM).tolist()]
    return {"name": shown.name, "at": at, "error": error}
