"""SVG by hand: shapes as texts, in colours that follow the reader's light or dark."""

from collections.abc import Sequence
from html import escape
from math import atan2, cos, pi, sin
from typing import Final

Point = tuple[float, float]

STYLE: Final = """
text { font: 15px system-ui, "DejaVu Sans", sans-serif; fill: #1d2733; }
.small { font-size: 13px; fill: #55616d; }
.strong { font-weight: 600; }
.line { fill: none; stroke: #1d2733; stroke-width: 2; }
.thin { fill: none; stroke: #55616d; stroke-width: 1.2; }
.axis { fill: none; stroke: #55616d; stroke-width: 1.2; stroke-dasharray: 14 4 3 4; }
.dash { fill: none; stroke: #55616d; stroke-width: 1.5; stroke-dasharray: 6 4; }
.metal { fill: #dde4ea; }
.plus, .plus text { stroke: #c8102e; } .minus { stroke: #1558b0; } .good { stroke: #00796b; }
.plus, .minus, .good { fill: none; stroke-width: 2.5; }
.on { fill: #c8102e; } .off { fill: #1558b0; } .ok { fill: #00796b; }
.box { fill: #f4f6f8; stroke: #55616d; stroke-width: 1.5; }
@media (prefers-color-scheme: dark) {
  text { fill: #e4e9ee; } .small { fill: #b4bec8; }
  .line { stroke: #e4e9ee; } .thin, .axis, .dash { stroke: #b4bec8; }
  .metal { fill: #3a444e; } .box { fill: #252b32; stroke: #b4bec8; }
  .plus { stroke: #ff7a8a; } .minus { stroke: #7db4ff; } .good { stroke: #4fd1bd; }
  .on { fill: #ff7a8a; } .off { fill: #7db4ff; } .ok { fill: #4fd1bd; }
}
"""
HEAD_PX: Final = 9.0


def drawing(width: int, height: int, title: str, shapes: Sequence[str]) -> str:
    """A whole file."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        f'role="img">\n<title>{escape(title)}</title>\n<style>{STYLE}</style>\n' + "\n".join(shapes) + "\n</svg>\n"
    )


def line(points: Sequence[Point], kind: str = "line") -> str:
    """Straight from point to point."""
    return f'<polyline class="{kind}" points="{_list(points)}"/>'


def area(points: Sequence[Point], kind: str = "metal") -> str:
    """What the points enclose."""
    return f'<polygon class="{kind}" points="{_list(points)}"/>'


def curve(d: str, kind: str = "line") -> str:
    """A path in SVG's own words."""
    return f'<path class="{kind}" d="{d}"/>'


def circle(at: Point, radius: float, kind: str) -> str:
    """A circle or a dot."""
    return f'<circle class="{kind}" cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{radius:g}"/>'


def arrow(start: Point, end: Point, kind: str = "line") -> str:
    """From start to end, with a head there."""
    angle = atan2(end[1] - start[1], end[0] - start[0])
    wings = [(end[0] - HEAD_PX * cos(angle + turn), end[1] - HEAD_PX * sin(angle + turn)) for turn in (pi / 7, -pi / 7)]
    return line((start, end), kind) + line((wings[0], end, wings[1]), kind)


def text(at: Point, words: str, kind: str = "", anchor: str = "start") -> str:
    """A line of words; `anchor` says which end of it is there: start, middle, end."""
    marked = f' class="{kind}"' if kind else ""
    return f'<text{marked} x="{at[0]:g}" y="{at[1]:g}" text-anchor="{anchor}">{escape(words, quote=False)}</text>'


def texts(at: Point, lines: Sequence[str], kind: str = "", anchor: str = "start", step: float = 19) -> str:
    """Lines of words, one below the other."""
    return "".join(text((at[0], at[1] + step * k), words, kind, anchor) for k, words in enumerate(lines))


def _list(points: Sequence[Point]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
