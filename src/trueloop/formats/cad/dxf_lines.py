"""Meanings of a drawing's lines by type and layer: edges of the part, hidden ones, or axes (ISO 128)."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from trueloop.arrays import Array
from trueloop.formats.cad.dxf_chain import Segment
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


def is_shown(drawing: "Drawing", entity: Any) -> bool:
    """Returns whether it is on a layer that is shown and plotted."""
    layer = _layer_of(drawing, entity)
    shown = layer is None or not (layer.is_off() or layer.is_frozen())
    return shown and layer_of(entity).casefold() != NOT_PLOTTED


def is_edge(drawing: "Drawing", entity: Any) -> bool:
    """Returns whether it is drawn as visible edges are: in a continuous line, and not on a layer of axes."""
    plain = _line_type(drawing, entity) in ("continuous", "byblock", "")
    return is_shown(drawing, entity) and plain and not is_centre(drawing, entity)


def is_hidden_edge(drawing: "Drawing", entity: Any) -> bool:
    """Returns whether it is drawn as hidden edges are: dashed."""
    return is_shown(drawing, entity) and _line_type(drawing, entity).startswith(HIDDEN)


def is_centre(drawing: "Drawing", entity: Any) -> bool:
    """Returns whether it is drawn as axes are, by its line type or its layer's name."""
    return _line_type(drawing, entity).startswith(CENTRE) or layer_of(entity).casefold().startswith(CENTRE)


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


def layer_of(entity: Any) -> str:
    """Returns the layer it is on; 0, as the format has it, where it names none."""
    return str(entity.dxf.get("layer", "0"))


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


def _line_type(drawing: "Drawing", entity: Any) -> str:
    own = str(entity.dxf.get("linetype", "BYLAYER")).casefold()
    if own != "bylayer":
        return own
    layer = _layer_of(drawing, entity)
    return "continuous" if layer is None else str(layer.dxf.get("linetype", "CONTINUOUS")).casefold()


def _layer_of(drawing: "Drawing", entity: Any) -> Any:
    name = layer_of(entity)
    return drawing.layers.get(name) if name in drawing.layers else None
