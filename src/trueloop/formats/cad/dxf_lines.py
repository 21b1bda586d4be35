"""What the lines of a drawing mean by their type and layer: edges of the part, or its axis (ISO 128)."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from trueloop.errors import Code, Place, TrueloopError

if TYPE_CHECKING:
    from ezdxf.document import Drawing

NOT_PLOTTED: Final = "defpoints"
"""The layer on which CAD systems keep what belongs to dimensions."""
CENTRE: Final = ("center", "centre", "dashdot", "chain", "iso10", "iso04", "acad_iso10", "acad_iso04")
"""How the names of the line types begin in which axes are drawn."""
ONE_MM: Final = 1e-3
"""Axes whose heights differ by less are one."""


def is_edge(drawing: "Drawing", entity: Any) -> bool:
    """Whether it is drawn as visible edges are: in a continuous line, on a layer that is shown and plotted."""
    layer = _layer_of(drawing, entity)
    shown = layer is None or not (layer.is_off() or layer.is_frozen())
    named = str(entity.dxf.get("layer", "0")).casefold() != NOT_PLOTTED
    return shown and named and _line_type(drawing, entity) in ("continuous", "byblock", "")


def axis_of(drawing: "Drawing", mm_per_unit: float, path: Path) -> tuple[float, list[str]]:
    """The height y of the axis in mm, and a note where it is not 0: that of the only horizontal centre line.

    A drawing without one, or with one at 0, has its axis at 0. Raises GEO-DXF-CHOICE for several at other heights.
    """
    heights: list[float] = []
    for entity in drawing.modelspace():
        if entity.dxftype() != "LINE" or not _line_type(drawing, entity).startswith(CENTRE):
            continue
        a, b = (float(end.y) * mm_per_unit for end in (entity.dxf.start, entity.dxf.end))
        level = abs(a - b) <= ONE_MM and entity.dxf.start.x != entity.dxf.end.x
        if level and not any(abs(a - known) <= ONE_MM for known in heights):
            heights.append(a)
    if not heights or any(abs(height) <= ONE_MM for height in heights):
        return 0.0, []
    if len(heights) > 1:
        found = ", ".join(f"{height:g} mm" for height in sorted(heights))
        raise TrueloopError(
            Code.GEO_DXF_CHOICE,
            f"{len(heights)} horizontal centre lines at y = {found}, and none at y = 0",
            hint="move the drawing so that the part's axis is at y = 0, or leave its centre line alone",
            place=Place(str(path)),
        )
    return heights[0], [
        f"The axis is the centre line at y = {heights[0]:g} mm; z is counted from x = 0 of the drawing."
    ]


def _line_type(drawing: "Drawing", entity: Any) -> str:
    own = str(entity.dxf.get("linetype", "BYLAYER")).casefold()
    if own != "bylayer":
        return own
    layer = _layer_of(drawing, entity)
    return "continuous" if layer is None else str(layer.dxf.get("linetype", "CONTINUOUS")).casefold()


def _layer_of(drawing: "Drawing", entity: Any) -> Any:
    name = str(entity.dxf.get("layer", "0"))
    return drawing.layers.get(name) if name in drawing.layers else None
