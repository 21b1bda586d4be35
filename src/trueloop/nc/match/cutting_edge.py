"""An edge that cuts: how the program calls it, its nose, and which surfaces a corner of an insert can touch at all."""

import math
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Feature
from trueloop.nc.program.called import Called

Corner: TypeAlias = Literal["left", "right", "outer", "inner"]

FACING: Final[dict[Corner, tuple[float, float]]] = {
    "left": (0.0, 1.0),
    "right": (0.0, -1.0),
    "outer": (-1.0, 0.0),
    "inner": (1.0, 0.0),
}
"""The direction (x, z) that the wall cut by a corner of a plunge or groove tool faces. The left corner is the one at
lower Z of the program, at the chuck; the wall that it cuts looks towards the free end. The outer corner of a face
groover cuts the outer wall, which looks towards the axis."""

_OTHER: Final[dict[Corner, Corner]] = {"left": "right", "right": "left", "outer": "inner", "inner": "outer"}
_SAID: Final[dict[Corner, str]] = {
    "left": '"left" is the corner at lower Z of this program',
    "right": '"right" is the corner at higher Z of this program',
    "outer": '"outer" is the corner farther from the axis',
    "inner": '"inner" is the corner nearer to the axis',
}

RELIEF_RAD: Final = math.radians(2.0)
"""Flanks of groove inserts are relieved by so little: a wall that leans more under the corner is out of its reach."""


@dataclass(frozen=True)
class CuttingEdge:
    """One edge of a job: its call, its nose radius, and which `corner` of a groove insert it is; None: none.

    `tip`: the orientation of the tip that the program moves without G41 or G42, 0 for the nose's centre.
    """

    called: Called
    nose_radius_mm: float
    corner: Corner | None = None
    name: str = ""
    tip: int = 0

    @property
    def words(self) -> str:
        """Returns `T3`; `T13 (left corner)`."""
        return self.called.words if self.corner is None else f"{self.called.words} ({self.corner} corner)"

    def require_reaches(self, feature: Feature, line: int | None = None) -> None:
        """Raises NC-EDGE for a feature that this corner cannot touch: it looks away from what the corner cuts."""
        if self.corner is None:
            return
        along = feature.outward_normal(np.linspace(0.0, feature.length_mm, 33)) @ np.array(FACING[self.corner])
        if (lowest := float(np.min(along))) < -math.sin(RELIEF_RAD):
            raise _out_of_reach(self, feature, lowest, line)


def _out_of_reach(edge: CuttingEdge, feature: Feature, lowest: float, line: int | None) -> TrueloopError:
    angle_deg = math.degrees(math.asin(min(-lowest, 1.0)))
    other = _OTHER[edge.corner or "left"]
    return Code.NC_EDGE.refusal(
        f"{edge.words} cuts '{feature.name}', which leans {angle_deg:.1f}° under that corner: it cannot touch it",
        hint=f"the {other} corner cuts it: call that one's offset there, or mend its `tools.groove_corner`: "
        f"{_SAID[other]}",
        place=Place(line=line),
        values={"feature": feature.name, "tool": edge.called.words},
    )
