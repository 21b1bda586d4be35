"""The profile of a part, in its own frame, with what each set-up cuts in a colour of its own (SVG)."""

from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature, is_curved
from trueloop.loops.turned.part import PartCorrection
from trueloop.report import style
from trueloop.report.markup import esc
from trueloop.report.turned.contour_picture import COLOURS

WIDTH_PX: Final = 900.0
MARGIN_PX: Final = 30.0
ROW_PX: Final = 20.0
PLACES: Final = 33
"""Places along a curved feature."""


def drawing(corrected: PartCorrection) -> str:
    """Draws both halves of the section about the axis; below, a line for each set-up with where its +Z points."""
    of = {name: k for k, one in enumerate(corrected.setups) for name in one.features}
    ways = [(_places(feature), of.get(feature.name)) for feature in corrected.profile.features]
    every = np.concatenate([places for places, _ in ways])
    low, high, most = every[:, 1].min(), every[:, 1].max(), every[:, 0].max()
    scale = (WIDTH_PX - 2 * MARGIN_PX) / max(high - low, 2 * most)
    axis_px = MARGIN_PX + most * scale
    below_px = axis_px + most * scale + MARGIN_PX

    def points(places: Array, side: float) -> str:
        x, y = MARGIN_PX + (places[:, 1] - low) * scale, axis_px - side * places[:, 0] * scale
        return " ".join(f"{a:.2f},{b:.2f}" for a, b in zip(x, y, strict=True))

    body = [
        f'<polyline points="{points(places, side)}" fill="none" stroke="{_colour(k)}" stroke-width="3" '
        'stroke-linecap="round"/>'
        for places, k in ways
        for side in (1.0, -1.0)
    ]
    right_px = MARGIN_PX + (high - low) * scale
    body.append(
        f'<path d="M{MARGIN_PX / 3} {axis_px:.2f}H{right_px + 2 * MARGIN_PX / 3:.2f}" stroke="{style.SOFT}" '
        'stroke-dasharray="14 4 3 4"/>'
    )
    for k, one in enumerate(corrected.setups):
        y = below_px + k * ROW_PX
        arrow = "←" if one.frame.backwards else "→"
        body.append(f'<text x="{MARGIN_PX}" y="{y:.1f}" fill="{_colour(k)}">■ {esc(one.frame.name)}: +Z {arrow}</text>')
    height = below_px + len(corrected.setups) * ROW_PX
    return (
        f'<svg role="img" viewBox="0 0 {WIDTH_PX:.0f} {height:.0f}" width="100%" font-size="14" '
        f'xmlns="http://www.w3.org/2000/svg">{"".join(body)}</svg>'
    )


def _colour(setup: int | None) -> str:
    return style.SOFT if setup is None else COLOURS[setup % len(COLOURS)]


def _places(feature: Feature) -> Array:
    return feature.point_mm(np.linspace(0.0, feature.length_mm, PLACES if is_curved(feature) else 2))
