"""An edge that cuts: how the program calls it, its nose, the point of it that the program moves (the nose's centre or
the imaginary tip), which surfaces a corner of an insert can touch, and on which side of the profile a pass lies: a
bore taken for an outside turns the sign of every error.
"""

import math
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Feature, Point
from trueloop.nc.match.contour_match import ContourMatch
from trueloop.nc.program.called import CalledOffset
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.tool_path import NO_COMPENSATION, ToolPath

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

    called: CalledOffset
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


CENTRE: Point = (0.0, 0.0)
ORIENTATIONS = range(1, 9)
"""Those whose tip is not the nose's centre."""


def tip_mm(dialect: Dialect, orientation: int, nose_radius_mm: float) -> Point:
    """Returns the position of the tip of that orientation, by the control's number, from the nose's centre, (x, z)."""
    x, z = dialect.tips[orientation]
    return x * nose_radius_mm, z * nose_radius_mm


def of_centre(path: ToolPath, tip: Point) -> ToolPath:
    """Returns the path of the nose's centre, of a program that moves the point `tip` (x, z) off it.

    Moves under G41 and G42 stay: theirs is the contour.
    """
    if tip == CENTRE:
        return path
    off = np.where(path.compensation == NO_COMPENSATION, 1.0, 0.0)[:, None] * np.array([tip[0], 0.0, tip[1]])
    return replace(path, start_mm=path.start_mm - off, end_mm=path.end_mm - off, centre_mm=path.centre_mm - off)


FACES_X: Final = 0.5
"""Share of the normal along x from which on a surface is one of an outside or of a bore, and no face."""


@dataclass(frozen=True)
class SidesOfCuts:
    """Indices of cuts whose rapid moves show on which side the tool is; of others they do not.

    `boring`: cuts retract towards the axis, and rapid moves run nearer to it. `turning`: the other way in both.
    """

    boring: frozenset[int] = frozenset()
    turning: frozenset[int] = frozenset()


def require_side(match: ContourMatch, shown: SidesOfCuts) -> None:
    """Raises NC-BORE where rapid moves show a feature's pass on the other side than the profile has it.

    Under G41 and G42 the sides are compared by the code itself (`match_contour`).
    """
    for feature in match.features:
        n_x = float(feature.feature.outward_normal(feature.feature.length_mm / 2)[0])
        other = shown.boring if n_x > FACES_X else shown.turning if n_x < -FACES_X else frozenset()
        for matched in feature.moves:
            move = matched.move
            if not move.on_contour and move.index in other:
                here, there = ("an outside", "bores") if n_x > 0 else ("a bore", "turns an outside")
                raise Code.NC_BORE.refusal(
                    f"line {move.line} cuts {feature.feature.name!r}, {here} of the profile, and its rapid moves show "
                    f"that it {there}",
                    hint="state `part.side`, and order the features of a bore from the free end to the chuck end",
                    place=Place(line=move.line),
                )
