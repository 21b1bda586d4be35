"""A picture (SVG) of a drawing or of a solid's section: what is drawn, and the contours of it that one may choose."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature, Line
from trueloop.geometry.profile import Side
from trueloop.report import style

if TYPE_CHECKING:  # slow to import
    from trueloop.formats.cad.dxf import DxfSheet
    from trueloop.formats.cad.dxf_sheet import Candidate
    from trueloop.formats.cad.step_profile import StepSolid
import math
from dataclasses import asdict

from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc
from trueloop.geometry.offset import CentrePath
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame

STRAIGHT_MM: Final = 1e6
"""A least radius of curvature from a kilometre on is none."""


def profile_as_dict(
    name: str, profile: Profile, centre: CentrePath, setups: Sequence[SetupFrame] = ()
) -> dict[str, object]:
    """Converts a profile with a nose's reach and its set-ups' frames; x is a radius, convex turns positive."""
    frames = [asdict(setup) | {"z_of_program": setup.words} for setup in setups]
    return ({"setups": frames} if frames else {}) | {
        "part": name,
        "length_mm": profile.length_mm,
        "nose_radius_mm": centre.nose_radius_mm,
        "features": [
            {
                "name": feature.name,
                "kind": kind_in_words(feature),
                "start_mm": feature.start_mm,
                "end_mm": feature.end_mm,
                "length_mm": feature.length_mm,
                "reachable_mm": reachable.tolist(),
            }
            for feature, reachable in zip(profile.features, centre.reachable_mm, strict=True)
        ],
        "junctions": [
            {"kind": junction.kind, "turn_deg": math.degrees(junction.turn_rad), "by_design": junction.by_design}
            for junction in profile.junctions
        ],
    }


def kind_in_words(feature: Feature) -> str:
    """Describes a line, an arc with its radius and sense, or a curve with its least radii of curvature."""
    if isinstance(feature, Curve):
        concave, convex = feature.radius_range_mm()
        radii = [f"{sense} R ≥ {r:.4f}" for sense, r in (("convex", convex), ("concave", concave)) if r < STRAIGHT_MM]
        return f"curve {', '.join(radii)}" if radii else "curve"
    if not isinstance(feature, Arc):
        return "line"
    sense = "convex" if feature.sweep_rad > 0 else "concave"
    return f"{sense} arc R {feature.radius_mm:.4f}, {math.degrees(abs(feature.sweep_rad)):.2f}°"


WIDTH_PX: Final = 1000.0
MARGIN_PX: Final = 30.0
HIGHEST_PX: Final = 800.0
ROW_PX: Final = 22.0
COLOURS: Final = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""Of the contours, apart also for those who see red and green alike (Okabe and Ito)."""
PLACES: Final = 33
"""Places along a curved feature."""


@dataclass(frozen=True)
class Way:
    """A contour in the picture: its places, to the right and up in mm; the chosen one is drawn bold."""

    number: int
    text: str
    places: Array
    chosen: bool = False


def picture_of_sheet(read: "DxfSheet", outline: int | None) -> str:
    """Draws the sheet of a drawing with the contours of the requested side."""
    chosen = 1 if outline is None and len(read.contours) == 1 else outline
    edges = [_places(feature)[:, ::-1] for feature in read.sheet.edges.features]
    axes = [
        np.array([[view.axis.at_mm, end] if view.axis.vertical else [end, view.axis.at_mm] for end in ends])
        for view in read.sheet.views
        if np.all(np.isfinite(ends := np.array([view.axis.low_mm, view.axis.high_mm])))
    ]
    ways = [
        Way(k, f"{candidate.side}, {candidate.described}", _on_sheet(candidate), k == chosen)
        for k, candidate in enumerate(read.contours, 1)
    ]
    return picture(read.file.name, edges, axes, ways)


def picture_of_solid(solid: "StepSolid", side: Side, outline: int | None) -> str:
    """Draws the section of a solid above its axis, both sides of it, with the contours of the requested one."""
    wanted = [one for one in solid.found if one.contour.side is side]
    chosen = 1 if outline is None and len(wanted) == 1 else outline
    whole = [piece.feature for one in solid.found for piece in one.contour.pieces]
    edges = [_places(feature)[:, ::-1] * sign for feature in whole for sign in ([1, 1], [1, -1])]
    z = np.concatenate([edge[:, 0] for edge in edges]) if edges else np.zeros(1)
    axis = np.array([[z.min() - 0.05 * np.ptp(z), 0.0], [z.max() + 0.05 * np.ptp(z), 0.0]])
    ways = [
        Way(k, str(one), np.concatenate([_places(piece.feature) for piece in one.contour.pieces])[:, ::-1], k == chosen)
        for k, one in enumerate(wanted, 1)
    ]
    return picture(solid.file.name, edges, [axis], ways)


def picture(title: str, edges: Sequence[Array], axes: Sequence[Array], ways: Sequence[Way]) -> str:
    """Draws the SVG; below the picture a line for every contour, with its number."""
    everything = np.concatenate([*edges, *axes, *(way.places for way in ways), np.zeros((0, 2))])
    low, high = (everything.min(axis=0), everything.max(axis=0)) if len(everything) else (np.zeros(2), np.ones(2))
    span = np.maximum(high - low, 1e-6)
    scale = float(min((WIDTH_PX - 2 * MARGIN_PX) / span[0], HIGHEST_PX / span[1]))
    drawn_px = span[1] * scale + 2 * MARGIN_PX
    height = drawn_px + ROW_PX * (len(ways) + 2)

    def line(places: Array, more: str) -> str:
        x = MARGIN_PX + (places[:, 0] - low[0]) * scale
        y = MARGIN_PX + (high[1] - places[:, 1]) * scale
        points = " ".join(f"{a:.2f},{b:.2f}" for a, b in zip(x, y, strict=True))
        return f'<polyline points="{points}" fill="none" stroke-linejoin="round" {more}/>'

    body = [line(edge, f'stroke="{style.FAINT}" stroke-width="1"') for edge in edges]
    body += [line(axis, f'stroke="{style.SOFT}" stroke-width="1" stroke-dasharray="14 4 3 4"') for axis in axes]
    for way in sorted(ways, key=lambda way: way.chosen):
        colour = COLOURS[(way.number - 1) % len(COLOURS)]
        body.append(line(way.places, f'stroke="{colour}" stroke-width="{5 if way.chosen else 2}"'))
        x, y = way.places[len(way.places) // 2]
        at = MARGIN_PX + (x - low[0]) * scale, MARGIN_PX + (high[1] - y) * scale
        body += _number(way.number, at, colour)
    for row, way in enumerate(ways, 1):
        y = drawn_px + ROW_PX * row
        body += _number(way.number, (MARGIN_PX, y - 5), COLOURS[(way.number - 1) % len(COLOURS)])
        weight = ' font-weight="bold"' if way.chosen else ""
        words = f"{way.text}{' (chosen)' if way.chosen else ''}"
        body.append(f'<text x="{MARGIN_PX + 18}" y="{y:.0f}" fill="{style.INK}"{weight}>{escape(words)}</text>')
    if not ways:
        body.append(f'<text x="{MARGIN_PX}" y="{drawn_px + ROW_PX:.0f}" fill="{style.INK}">no contour found</text>')
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH_PX:.0f} {height:.0f}" width="{WIDTH_PX:.0f}" '
        f'height="{height:.0f}" font-family="{escape(str(style.FONT["family"]), quote=True)}" font-size="13">'
    )
    return "\n".join([head, f"<title>{escape(title)}</title>", '<rect width="100%" height="100%" fill="white"/>',
                      *body, "</svg>", ""])  # fmt: skip


def _number(number: int, at: tuple[float, float], colour: str) -> list[str]:
    x, y = at
    return [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="10" fill="white" stroke="{colour}" stroke-width="2"/>',
        f'<text x="{x:.1f}" y="{y + 4.5:.1f}" text-anchor="middle" fill="{colour}" font-weight="bold">{number}</text>',
    ]


def _on_sheet(candidate: "Candidate") -> Array:
    return candidate.view.on_sheet(np.concatenate([_places(feature) for feature in candidate.features]))


def _places(feature: Feature) -> Array:
    count = 2 if isinstance(feature, Line) else PLACES
    return feature.point_mm(np.linspace(0.0, feature.length_mm, count))
