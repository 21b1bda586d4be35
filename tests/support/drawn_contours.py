"""Generated contours of lines with corners between them, in each control's own words."""

import math
from typing import Final

from hypothesis import strategies as st

from tests.support.spelled_moves import PLANES, Style, head

DRAWING: Final = ("fanuc-lathe", "fanuc-lathe-b", "haas-lathe", "fanuc-mill", "haas-mill", "siemens", "heidenhain")
"""The dialects that have corners."""
INCREMENTAL: Final = ("fanuc-mill", "haas-mill", "siemens", "fanuc-lathe-b")
"""Those that have G91 for them."""
LATHES: Final = ("fanuc-lathe", "fanuc-lathe-b", "haas-lathe")
Point = tuple[float, float]


@st.composite
def drawn_contours(draw: st.DrawFn, dialect: str) -> str:
    """A program: a rapid, then lines, with corners at the ends of some."""
    lathe = dialect in LATHES
    klartext = dialect == "heidenhain"
    plane = 18 if lathe else 17 if klartext else draw(st.sampled_from(sorted(PLANES)))
    diameter = lathe or (dialect == "siemens" and draw(st.booleans()))
    style = Style(dialect, not klartext and draw(st.booleans()), diameter, plane)
    return "\n".join([head(style), *_Drawing(draw, style).blocks(), "M30", ""])


class _Drawing:
    """Points are in units of the program, (first, second) axis of the plane, X a radius."""

    def __init__(self, draw: st.DrawFn, style: Style) -> None:
        self.draw, self.style = draw, style
        self.axes = {17: "XY", 18: "ZX", 19: "YZ"}[style.plane]
        self.scale = 0.04 if style.inch else 1.0
        self.at: Point = (0.0, 0.0)
        self.heading = 0.0
        self.increments = style.dialect in INCREMENTAL and draw(st.booleans())

    def blocks(self) -> list[str]:
        self.at = (self._length(), self._length())
        self.heading = self.draw(st.integers(-179, 180))
        first = " ".join(self._word(axis, value) for axis, value in zip(self.axes, self.at, strict=True))
        third = next(axis for axis in "XYZ" if axis not in self.axes)
        if self.style.axes == "XYZ":
            first += " " + self.style.word(third, self.style.value(third, 1.5))
        klartext = self.style.dialect == "heidenhain"
        lines = [f"L {first} FMAX" if klartext else f"G00 {first}", *(["G91"] if self.increments else [])]
        count = self.draw(st.integers(2, 7))
        for number in range(count):
            lines += self._step(first=number == 0, last=number + 1 == count)
        return lines

    def _step(self, *, first: bool, last: bool) -> list[str]:
        """A line, with a corner at its end unless it is the last; or an arc."""
        self.heading += self.draw(st.sampled_from([-1, 1])) * self.draw(st.integers(20, 150)) if not first else 0
        way = math.radians(self.heading)
        length = self.scale * self.draw(st.integers(20, 40))
        to = (self._rounded(self.at[0] + length * math.cos(way)), self._rounded(self.at[1] + length * math.sin(way)))
        line = self._line(to, first=first)
        self.at = to
        if last:
            return [line]
        corner = self._corner()
        feed = self.draw(st.sampled_from(["", f"F{self.draw(st.integers(1, 99))}."]))
        if self.style.dialect == "heidenhain":
            return [line, *([f"{corner} {feed.rstrip('.')}".strip()] if corner else [])]
        return [" ".join(filter(None, [line, corner, feed]))]

    def _line(self, to: Point, *, first: bool) -> str:
        named = dict(zip(self.axes, to, strict=True))
        code = "L" if self.style.dialect == "heidenhain" else "G01" if first else ""
        feed = ("F50" if self.style.dialect == "heidenhain" else "F50.") if first else ""
        words = [self._word(axis, value) for axis, value in named.items()]
        if self.increments:
            words = [self._word(a, self._rounded(named[a] - at)) for a, at in zip(self.axes, self.at, strict=True)]
            return " ".join(filter(None, [code, *words, feed]))
        increments = {"fanuc-lathe": "UVW", "haas-lathe": "UVW", "siemens": "IC", "heidenhain": "I"}
        if self.style.dialect in increments and self.draw(st.booleans()):
            words[0] = self._increment(self.axes[0], to[0] - self.at[0])
        return " ".join(filter(None, [code, *words, feed]))

    def _increment(self, axis: str, way: float) -> str:
        value = self.style.value(axis, self._rounded(way))
        if self.style.dialect == "siemens":
            return f"{axis}=IC({value:.6f})"
        if self.style.dialect == "heidenhain":
            return "I" + self.style.word(axis, value)
        return self.style.word(dict(zip("XYZ", "UVW", strict=True))[axis], value)

    def _corner(self) -> str:
        """None, a rounding or a chamfer, none larger than the shortest line allows at the sharpest corner."""
        size = round(self.scale * self.draw(st.integers(100, 2500)) / 1000, 4)
        kinds = {
            "siemens": ["", f"RND={size}", f"CHF={size}", f"CHR={size}"],
            "heidenhain": ["", f"RND R{size}", f"CHF {size}"],
        }
        return self.draw(st.sampled_from(kinds.get(self.style.dialect, ["", f",R{size}", f",C{size}"])))

    def _word(self, axis: str, value: float) -> str:
        return self.style.word(axis, self.style.value(axis, value))

    def _length(self) -> float:
        return self._rounded(self.scale * self.draw(st.integers(-50_000, 50_000)) / 1000)

    @staticmethod
    def _rounded(value: float) -> float:
        return round(value, 3) + 0.0  # never minus zero
