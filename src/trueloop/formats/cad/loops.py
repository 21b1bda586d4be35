"""The loops of edges that bound a face, taken from one surface and put on another with the same parameters.

Points of a face's surface that its trimming curves cut away, for a million points in seconds.

The kernel's classifier takes up to a millisecond a point. It is used only near the face's edges, found on a raster of
the parameters, and once for each stretch of the raster that no edge runs through.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.kernel import edge_curves, kernel
from trueloop.geometry.surface import Surface, closest_parameters
from trueloop.surface.deviations.points import BEYOND_MM

Loop: TypeAlias = tuple[Array, ...]
"""A closed chain of smooth pieces, (n, 2) each: places in order, parameters of the surface as shares in [0, 1]. The
face is on the left.
"""

SAMPLES: Final = 129
"""Places of a smooth piece; a spline through them is its curve."""
ALIKE_MM: Final = 1e-7
AT_EDGE: Final = 1e-9
"""Shares this near to 0 or 1 are on the patch's edge."""


def loops_of(surface: Surface, face: Any) -> tuple[Loop, ...]:
    """Returns the loops of a kernel face whose surface is given as B-spline patch; none where it is the whole patch."""
    occ = kernel()
    forward = occ.as_face(face.Oriented(occ.FORWARD))
    wires = occ.Explorer(forward, occ.WIRE)
    found: list[Loop] = []
    while wires.More():
        pieces = list(_pieces(forward, occ.as_wire(wires.Current())))
        away = _turns_away(surface, occ.surface_of(forward), np.concatenate(pieces))
        found.append(_closed([_shares(surface, forward, piece - away) for piece in pieces]))
        wires.Next()
    whole = len(found) == 1 and all(_along_edge(piece) for piece in found[0])
    return () if whole else tuple(found)


def exchanged(loops: Sequence[Loop]) -> tuple[Loop, ...]:
    """Returns the loops with u and v exchanged and their direction reversed: the face is on the left again."""
    return tuple(tuple(piece[::-1, ::-1] for piece in loop[::-1]) for loop in loops)


def trimmed_face(patch: Any, surface: Surface, loops: Sequence[Loop]) -> Any:
    """Makes a face of the kernel: a patch, which is the surface, bounded by loops. None where the kernel rejects it."""
    occ = kernel()
    outer, *holes = (_wire(occ, patch, surface, loop) for loop in sorted(loops, key=_area, reverse=True))
    made = occ.MakeFace(patch, outer.Wire(), True)
    for hole in holes:
        made.Add(hole.Wire())
    face = made.Face()
    occ.build_curves(face)
    occ.same_parameter(face, ALIKE_MM, False)
    return face if occ.Check(face).IsValid() else None


def _wire(occ: Any, patch: Any, surface: Surface, loop: Loop) -> Any:
    wire = occ.MakeWire()
    for piece in loop:
        wire.Add(occ.MakeEdge(_curve(occ, surface, piece), patch).Edge())
    return wire


def _pieces(face: Any, wire: Any) -> Iterator[Array]:
    """Every edge of a wire in order, cut where it has corners: parameters of the face's own surface (n, 2)."""
    walk = kernel().WireExplorer(wire, face)
    while walk.More():
        yield from _pieces_of(face, walk.Current())
        walk.Next()


def _pieces_of(face: Any, edge: Any) -> list[Array]:
    occ = kernel()
    curve = occ.Curve2d(edge, face)
    ends = occ.Reals(1, curve.NbIntervals(occ.C1) + 1)
    curve.Intervals(ends, occ.C1)
    corners = [ends.Value(k) for k in range(ends.Lower(), ends.Upper() + 1)]
    at = [np.linspace(low, high, SAMPLES).tolist() for low, high in pairwise(corners)]
    pieces = [np.array([[p.X(), p.Y()] for p in map(curve.Value, along)]) for along in at]
    return [piece[::-1] for piece in pieces[::-1]] if edge.Orientation() == occ.REVERSED else pieces


def _turns_away(surface: Surface, own: Any, at: Array) -> Array:
    """Whole periods of a closed surface by which a loop stands beside the patch, (2,)."""
    found = np.zeros(2)
    for axis, (periodic, period) in enumerate(((own.IsUPeriodic, own.UPeriod), (own.IsVPeriodic, own.VPeriod))):
        if periodic():
            past = (np.min(at[:, axis]) - surface.domain[axis][0]) / period()
            found[axis] = np.floor(past + AT_EDGE) * period()
    return found


def _shares(surface: Surface, face: Any, at: Array) -> Array:
    """Parameters of the face's own surface (n, 2) as shares of the patch that stands for it.

    A rational patch of a cylinder or cone does not have its angles: points are then looked up, except at the patch's
    edges, which are those of the face, and where a seam would have two places for a point.
    """
    occ = kernel()
    (u0, u1), (v0, v1) = surface.domain
    low, width = np.array([u0, v0]), np.array([u1 - u0, v1 - v0])
    same = np.clip((at - low) / width, 0.0, 1.0)
    own = occ.surface_of(face)
    points = np.array([[p.X(), p.Y(), p.Z()] for p in (own.Value(u, v) for u, v in at.tolist())])
    if np.max(np.abs(surface.point_mm(*(low + same * width).T) - points)) < ALIKE_MM:
        return np.asarray(same)
    found = (closest_parameters(surface, points) - low) / width
    return np.asarray(np.where((same < AT_EDGE) | (same > 1 - AT_EDGE), same, found))


def _closed(pieces: list[Array]) -> Loop:
    """Each piece begins where the one before ends: files state that to a tolerance only."""
    for before, piece in zip([pieces[-1], *pieces[:-1]], pieces, strict=True):
        piece[0] = before[-1]
    return tuple(pieces)


def _along_edge(piece: Array) -> bool:
    return any(np.ptp(side) < AT_EDGE and min(abs(side[0]), abs(1 - side[0])) < AT_EDGE for side in piece.T)


def _area(loop: Loop) -> float:
    u, v = np.concatenate(loop).T
    return abs(float(np.sum(u * np.roll(v, -1) - v * np.roll(u, -1))))


def _curve(occ: Any, surface: Surface, shares: Array) -> Any:
    """A curve of the kernel through places: a straight line where they stand on one."""
    (u0, u1), (v0, v1) = surface.domain
    at = np.array([u0, v0]) + shares * np.array([u1 - u0, v1 - v0])
    chord, ways = at[-1] - at[0], at - at[0]
    aside = np.abs(chord[0] * ways[:, 1] - chord[1] * ways[:, 0])
    if np.max(aside) < AT_EDGE * np.sum(chord**2):  # never where a piece closes on itself
        at = at[[0, -1]]
    through = occ.Points2d(1, len(at))
    for k, (u, v) in enumerate(at.tolist(), 1):
        through.SetValue(k, occ.Pnt2d(u, v))
    spline = occ.Interpolate(through, False, 1e-12)
    spline.Perform()
    return spline.Curve()


CELLS: Final = 512
"""Cells of the raster a side."""
EDGE_SAMPLES: Final = 1024
"""Places of an edge, joined by straight lines on the raster."""
EDGE_SHARE: Final = 1e-9
"""The kernel takes so much off the edge for on the edge, in the units of the parameters, whatever those are in mm."""
STRIDES: Final = 8
"""Steps of such a line: an edge is then seen in every cell unless it runs through four in a thousandth of itself."""


@dataclass(frozen=True, eq=False)
class Outline:
    """A face's raster (CELLS, CELLS): -1 near an edge, 0 the face, 1 cut away; `edges_mm` (EDGE_SAMPLES, 3)."""

    surface: Surface
    face: Any
    edges_mm: Sequence[Array]
    raster: np.ndarray

    def cut_away(self, u: Array, v: Array) -> np.ndarray:
        """Returns which places (n,) lie in a hole or outside by more than a touch may."""
        found = self.raster[_cells(self.surface, u, v)]
        near = np.flatnonzero(found < 0)
        points = self.surface.point_mm(u[near], v[near])
        found[near] = classified(self.face, points) & (distance_mm(self.edges_mm, points) > BEYOND_MM)
        return np.asarray(found == 1)


def outline_of(surface: Surface, face: Any) -> Outline:
    """Returns the raster of a face of the kernel whose surface is given as B-spline surface, in its own parameters."""
    from scipy.ndimage import binary_dilation, label  # slow to import

    edges = np.zeros((CELLS, CELLS), bool)
    along = edges_mm(face)
    for points in along:
        edges[_line(surface, points)] = True
    edges = binary_dilation(edges, np.ones((3, 3), bool))
    stretches, count = label(~edges)
    _, first = np.unique(stretches, return_index=True)
    place = first[-count:] if count else first[:0]
    (u0, u1), (v0, v1) = surface.domain
    u = u0 + (u1 - u0) * (place // CELLS + 0.5) / CELLS
    v = v0 + (v1 - v0) * (place % CELLS + 0.5) / CELLS
    status = classified(face, surface.point_mm(u, v)).astype(np.int8)
    return Outline(surface, face, along, np.concatenate([[np.int8(-1)], status])[stretches])


def classified(face: Any, points_mm: Array) -> np.ndarray:
    """Returns whether each point (n, 3) of a face lies outside, by however little, as the kernel classifies it."""
    occ = kernel()
    classifier = occ.FaceClassifier()
    outside = np.zeros(len(points_mm), bool)
    for k, (x, y, z) in enumerate(points_mm.tolist()):
        classifier.Perform(face, occ.Pnt(x, y, z), EDGE_SHARE)
        outside[k] = classifier.State() == occ.OUT
    return outside


def distance_mm(edges_mm: Sequence[Array], points_mm: Array) -> Array:
    """Distances (n,) of points (n, 3) from the nearest edge, taken as a chain of straight lines."""
    from scipy.spatial import KDTree  # slow to import

    if not len(points_mm):
        return np.zeros(0)
    first, last = (np.concatenate([edge[part] for edge in edges_mm]) for part in (np.s_[:-1], np.s_[1:]))
    _, near = KDTree((first + last) / 2).query(points_mm, k=min(2, len(first)))
    near = near.reshape(len(points_mm), -1)
    along, ways = (last - first)[near], points_mm[:, None] - first[near]
    square = np.maximum(np.sum(along**2, axis=2), np.finfo(float).tiny)
    share = np.clip(np.sum(ways * along, axis=2) / square, 0.0, 1.0)
    return np.asarray(np.min(np.linalg.norm(ways - share[..., None] * along, axis=2), axis=1))


def edges_mm(face: Any) -> list[Array]:
    """Returns places along every edge of the face, (EDGE_SAMPLES, 3) each."""
    found = []
    for curve in edge_curves(face):
        at = np.linspace(curve.FirstParameter(), curve.LastParameter(), EDGE_SAMPLES)
        found.append(np.array([[p.X(), p.Y(), p.Z()] for p in map(curve.Value, at.tolist())]))
    return found


def _line(surface: Surface, points_mm: Array) -> tuple[np.ndarray, np.ndarray]:
    """The cells that an edge runs through."""
    at = closest_parameters(surface, points_mm)
    width = np.ptp(np.array(surface.domain), axis=1)
    step = np.diff(at, axis=0)
    step[np.any(np.abs(step) > width / 2, axis=1)] = 0.0  # over a seam
    share = np.arange(STRIDES)[:, None, None] / STRIDES
    line = np.concatenate([(at[:-1] + share * step).reshape(-1, 2), at[-1:]])
    return _cells(surface, line[:, 0], line[:, 1])


def _cells(surface: Surface, u: Array, v: Array) -> tuple[np.ndarray, np.ndarray]:
    (u0, u1), (v0, v1) = surface.domain
    along, across = (u - u0) / (u1 - u0), (v - v0) / (v1 - v0)
    i, j = (np.clip((CELLS * share).astype(int), 0, CELLS - 1) for share in (along, across))
    return i, j
