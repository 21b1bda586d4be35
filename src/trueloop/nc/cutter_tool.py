"""Tools as cutter compensation (G41, G42) needs them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class CutterTool:
    """Radius of a nose or a cutter in mm, and how the control calls it.

    `tip` is the control's number of a lathe tool's orientation: where the controlled point lies from the nose's centre,
    0 and 9 being the centre itself. `number` is D, or that of the offset or the tool; None for whichever is called.
    """

    radius_mm: float
    tip: int | None = None
    number: int | None = None
