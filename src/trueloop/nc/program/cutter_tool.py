"""Tools as cutter compensation (G41, G42) and length offsets (G43) need them."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

ToolRow: TypeAlias = tuple[int | None, float, int | None, float | None, tuple[float, float, float] | None, int | None]


@dataclass(frozen=True)
class CutterTool:
    """Radius of a nose or a cutter in mm, and how the control calls it.

    `tip` is the control's number of a lathe tool's orientation: where the controlled point lies from the nose's centre,
    0 and 9 being the centre itself. `number` is D, or that of the offset or the tool; None for whichever is called.
    `length_mm` is what G43 adds along Z, and a Sinumerik's D of a mill across the plane; `offset_mm` (x, y, z) what
    T0101 or D of a lathe adds, geometry and wear together, x a radius: machine = program + work offset + this. None
    where they are not known. `edge` is D of a Sinumerik, None for any.
    """

    radius_mm: float
    tip: int | None = None
    number: int | None = None
    length_mm: float | None = None
    offset_mm: tuple[float, float, float] | None = None
    edge: int | None = None


def tool_rows(tools: Iterable[CutterTool]) -> list[ToolRow]:
    """Tools as the Rust core takes them."""
    return [(tool.number, tool.radius_mm, tool.tip, tool.length_mm, tool.offset_mm, tool.edge) for tool in tools]
