"""The assignment of several edges to the features of a profile that they cut, from the moves of each edge.

A move cuts a feature where it runs along it, at the edge's own nose radius from it. Where several edges do, the one
that goes deeper by more than edges err left the surface, whenever it runs; where none is that much deeper, the edge
that left the measured surface is not known, and has to be stated. What is to be left alone (a thread, raw stock, a
groove's floor in a cycle that is not followed) is not an edge's.

An edge that cuts: how the program calls it, its nose, the point of it that the program moves (the nose's centre or
the imaginary tip), which surfaces a corner of an insert can touch, and on which side of the profile a pass lies: a
bore taken for an outside turns the sign of every error.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.feature import Feature, Point
from trueloop.geometry.profile import Profile
from trueloop.nc.match.matching import TOLERANCE_MM, ContourMatch
from trueloop.nc.program.along import FeedMove
from trueloop.nc.program.called import CalledOffset
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.tool_path import NO_COMPENSATION, ToolPath
from trueloop.wording import wording

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


DEEPER_MM: Final = 0.02
"""An edge that is commanded deeper by more than this cuts what another left: edges are set to better than that."""

_SAMPLES: Final = 33
_PLACES: Final = 129
_ALONG: Final = 0.8
_SOME: Final = 0.1
"""An edge that runs along less than this share of a feature does not cut it."""


@dataclass(frozen=True)
class Cover:
    """The cut of one edge along one feature: `depth_mm` (n,) its contour's height over the nominal at even places, NaN
    where it does not run; `moves` are the indices of its moves there, `line` is that of the first.
    """

    depth_mm: Array
    moves: tuple[int, ...]
    line: int

    @property
    def share(self) -> float:
        """Returns the share of the feature's length along which the edge runs."""
        return float(np.mean(np.isfinite(self.depth_mm)))


@dataclass(frozen=True)
class Cutters:
    """Edges by feature: the one that cuts it, None where it is to be left alone, or why none is known. `covers[e][f]`:
    the cut of edge e along feature f.
    """

    edges: tuple[CuttingEdge, ...]
    found: tuple[CuttingEdge | TrueloopError | None, ...]
    covers: tuple[tuple[Cover | None, ...], ...]

    @property
    def edge_of(self) -> tuple[CuttingEdge | None, ...]:
        """Returns the edge of each feature; None: left alone. Raises the first refusal."""
        known = []
        for one in self.found:
            if isinstance(one, TrueloopError):
                raise one
            known.append(one)
        return tuple(known)

    def cuts(self, feature: int) -> bool:
        """Returns whether some edge runs along enough of a feature to have cut it."""
        return self.share(feature) >= _SOME

    def share(self, feature: int) -> float:
        """Returns the largest share of a feature's length that one edge runs along."""
        return max((cover.share for of in self.covers if (cover := of[feature]) is not None), default=0.0)

    def moves(self, edge: CuttingEdge, feature: int) -> tuple[int, ...]:
        """Indices of the edge's moves along a feature."""
        cover = self.covers[self.edges.index(edge)][feature]
        return () if cover is None else cover.moves


def cutters(
    profile: Profile,
    of_edge: Sequence[Sequence[FeedMove]],
    edges: Sequence[CuttingEdge],
    decided: Mapping[str, CalledOffset | None] | None = None,
    tolerance_mm: float = TOLERANCE_MM,
) -> Cutters:
    """Finds the edges. `of_edge`: each edge's feed moves; `decided`: the job's decision by feature, None: left alone.

    The refusal of a feature is NC-TOOLS where several edges cut it and none is deeper, NC-NO-MATCH where none does,
    NC-EDGE for a corner of a groove tool that cannot touch it.
    """
    covers = tuple(
        tuple(_cover(feature, edge.nose_radius_mm, own, tolerance_mm) for feature in profile.features)
        for edge, own in zip(edges, of_edge, strict=True)
    )
    decided = decided or {}
    found: list[CuttingEdge | TrueloopError | None] = []
    for index, feature in enumerate(profile.features):
        if feature.name in decided and decided[feature.name] is None:
            found.append(None)
            continue
        by_edge = [(edge, cover) for edge, cover in zip(edges, (of[index] for of in covers), strict=True) if cover]
        try:
            edge, line = _cutter(feature, by_edge, edges, decided.get(feature.name), tolerance_mm)
            edge.require_reaches(feature, line)
            found.append(edge)
        except TrueloopError as refusal:
            found.append(refusal)
    return Cutters(tuple(edges), tuple(found), covers)


def _cutter(
    feature: Feature,
    covers: Sequence[tuple[CuttingEdge, Cover]],
    edges: Sequence[CuttingEdge],
    decided: CalledOffset | None,
    tolerance_mm: float,
) -> tuple[CuttingEdge, int | None]:
    """The edge, and the line from which on it cuts the feature."""
    if decided is not None:
        named = next(edge for edge in edges if edge.called == decided)
        return named, next((cover.line for edge, cover in covers if edge == named), None)
    cutting = [(edge, cover) for edge, cover in covers if cover.share >= _SOME]
    if not cutting:
        raise _uncut(feature, edges, tolerance_mm)
    for edge, cover in cutting:
        if all(other is edge or _is_deeper(cover, beside) for other, beside in cutting):
            return edge, cover.line
    raise _several(feature, cutting)


def _is_deeper(cover: Cover, other: Cover) -> bool:
    """Returns whether an edge surely cuts away what the other left, wherever that runs."""
    where = np.isfinite(other.depth_mm)
    return bool(np.all(other.depth_mm[where] - cover.depth_mm[where] > DEEPER_MM))


def _cover(feature: Feature, nose_radius_mm: float, moves: Sequence[FeedMove], tolerance_mm: float) -> Cover | None:
    places = np.linspace(0.0, feature.length_mm, _PLACES)
    depth_mm, along, line = np.full(_PLACES, np.nan), [], 0
    for move in moves:
        offset_mm = 0.0 if move.on_contour else nose_radius_mm
        s, off = feature.locate(move.path.point_mm(np.linspace(0.0, move.path.length_mm, _SAMPLES)))
        stretch = (
            1.0 + float(feature.curvature_per_mm(float(np.clip(np.median(s), 0.0, feature.length_mm)))) * offset_mm
        )
        runs = stretch > 0 and abs(float(s[-1] - s[0])) * stretch >= _ALONG * move.path.length_mm
        if not runs or np.abs(off - offset_mm).max() > tolerance_mm:
            continue
        order = np.argsort(s)
        inside = (places >= s[order[0]]) & (places <= s[order[-1]])
        if np.any(inside):
            depth_mm[inside] = np.interp(places[inside], s[order], off[order] - offset_mm)
            along.append(move.index)
            line = line or move.line
    return Cover(depth_mm, tuple(along), line) if along else None


def _uncut(feature: Feature, edges: Sequence[CuttingEdge], tolerance_mm: float) -> TrueloopError:
    called = ", ".join(edge.words for edge in edges)
    return Code.NC_NO_MATCH.refusal(
        wording(
            "none of the {n} edges of the job ({called}) cuts '{feature}' within {tolerance_mm:.3f} mm",
            n=len(edges),
            called=called,
            feature=feature.name,
            tolerance_mm=tolerance_mm,
        ),
        hint="list every tool that cuts the profile in [[tools]], with the number of its offset and its nose radius; "
        f"what is to be left alone: [feature.{feature.name}] tool = 0",
        values={"feature": feature.name},
    )


def _several(feature: Feature, cutting: Sequence[tuple[CuttingEdge, Cover]]) -> TrueloopError:
    last_first = sorted(cutting, key=lambda one: -one[1].line)
    shown = ", ".join(
        f"{edge.words} from line {cover.line} on ({100 * cover.share:.0f} %)" for edge, cover in last_first
    )
    return Code.NC_TOOLS.refusal(
        wording(
            "'{feature}' is cut by {n} tools, none of them surely deeper than the others: {shown}",
            feature=feature.name,
            n=len(cutting),
            shown=shown,
        ),
        hint=f"state which one leaves the surface: [feature.{feature.name}] tool = {last_first[0][0].called.number}; "
        "where each leaves a part of it, make two features of it",
        place=Place(line=last_first[0][1].line),
        values={"feature": feature.name, "tools": [edge.called.words for edge, _ in cutting]},
    )
