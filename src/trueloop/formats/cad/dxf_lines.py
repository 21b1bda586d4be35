"""Meanings of a drawing's lines by type and layer: edges of the part, hidden ones, or axes (ISO 128)."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

from trueloop.arrays import Array
from trueloop.formats.cad.dxf_chain import Segment
from trueloop.formats.cad.dxf_document import Drawn
from trueloop.geometry.feature import Line

if TYPE_CHECKING:
    from ezdxf.document import Drawing

NOT_PLOTTED: Final = "defpoints"
"""The layer on which CAD systems keep what belongs to dimensions."""
CENTRE: Final = ("center", "centre", "dashdot", "chain", "iso10", "iso04", "acad_iso10", "acad_iso04", "mitte", "achse")
"""Beginnings of the names of line types, and of layers, of axes."""
HIDDEN: Final = ("hidden", "dashed", "verdeckt", "iso02", "acad_iso02")
"""Beginnings of the names of line types of hidden edges."""
ONE_MM: Final = 1e-3
"""Axes whose places differ by less are one."""


@dataclass(frozen=True)
class CentreLine:
    """A horizontal or vertical line of the sheet, in mm: at a height y, or at an x, from the lower to the higher end.

    `source` says in words how it was found.
    """

    vertical: bool
    at_mm: float
    low_mm: float
    high_mm: float
    source: str

    @property
    def length_mm(self) -> float:
        """Returns the length from end to end."""
        return self.high_mm - self.low_mm

    def distance_mm(self, place: Array) -> float:
        """Returns the distance of a place of the sheet, (x, z) up and right, from the line or its nearer end."""
        across, along = (place[1], place[0]) if self.vertical else (place[0], place[1])
        beyond = max(self.low_mm - along, along - self.high_mm, 0.0)
        return math.hypot(across - self.at_mm, beyond)

    @property
    def where(self) -> str:
        """Its place on the sheet."""
        return f"{'x' if self.vertical else 'y'} = {self.at_mm:g} mm"


class Meanings:
    """What lines of a drawing mean, by their own line type and their layer, of which a drawing has few."""

    def __init__(self, drawing: "Drawing") -> None:
        self._layers = drawing.layers
        self._edge, self._hidden, self._centre = map(
            lru_cache(maxsize=4096), (self._is_edge, self._is_hidden, self._is_centre)
        )

    def is_edge(self, one: Drawn) -> bool:
        """Returns whether it is drawn as visible edges are: in a continuous line, and not on a layer of axes."""
        return self._edge(one.layer, one.line_type)

    def is_hidden_edge(self, one: Drawn) -> bool:
        """Returns whether it is drawn as hidden edges are: dashed."""
        return self._hidden(one.layer, one.line_type)

    def is_centre(self, one: Drawn) -> bool:
        """Returns whether it is drawn as axes are, by its line type or its layer's name."""
        return self._centre(one.layer, one.line_type)

    def _is_edge(self, layer: str, own: str) -> bool:
        plain = self._line_type(layer, own) in ("continuous", "byblock", "")
        return self._is_shown(layer) and plain and not self._is_centre(layer, own)

    def _is_hidden(self, layer: str, own: str) -> bool:
        return self._is_shown(layer) and self._line_type(layer, own).startswith(HIDDEN)

    def _is_centre(self, layer: str, own: str) -> bool:
        return self._line_type(layer, own).startswith(CENTRE) or layer.casefold().startswith(CENTRE)

    def _is_shown(self, layer: str) -> bool:
        """Whether a layer is shown and plotted."""
        known = self._layer(layer)
        return (known is None or not (known.is_off() or known.is_frozen())) and layer.casefold() != NOT_PLOTTED

    def _line_type(self, layer: str, own: str) -> str:
        if own != "bylayer":
            return own
        known = self._layer(layer)
        return "continuous" if known is None else str(known.dxf.get("linetype", "CONTINUOUS")).casefold()

    def _layer(self, name: str) -> Any:
        return self._layers.get(name) if name in self._layers else None


def centre_lines(segments: Sequence[Segment]) -> list[CentreLine]:
    """Returns horizontal and vertical lines of segments drawn as axes; those in one line with a gap between are one."""
    found: list[CentreLine] = []
    for one in _level(segments):
        for k, known in enumerate(found):
            if known.vertical == one.vertical and abs(known.at_mm - one.at_mm) <= ONE_MM and _meet(known, one):
                low, high = min(known.low_mm, one.low_mm), max(known.high_mm, one.high_mm)
                found[k] = CentreLine(one.vertical, known.at_mm, low, high, known.source)
                break
        else:
            found.append(one)
    return found


def _level(segments: Sequence[Segment]) -> Iterator[CentreLine]:
    for one in segments:
        if not isinstance(one.feature, Line):
            continue
        (y0, x0), (y1, x1) = one.ends
        if abs(y0 - y1) <= ONE_MM:
            yield CentreLine(False, y0, min(x0, x1), max(x0, x1), "centre line")
        elif abs(x0 - x1) <= ONE_MM:
            yield CentreLine(True, x0, min(y0, y1), max(y0, y1), "centre line")


def _meet(a: CentreLine, b: CentreLine) -> bool:
    """Whether two pieces on one line are closer than the shorter of them is long."""
    gap = max(a.low_mm, b.low_mm) - min(a.high_mm, b.high_mm)
    return gap <= min(a.length_mm, b.length_mm)
