"""Points of a face's surface that its trimming curves cut away, for a million points in seconds.

The kernel's classifier takes up to a millisecond a point. It is used only near the face's edges, found on a raster of
the parameters, and once for each stretch of the raster that no edge runs through.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.kernel import kernel
from trueloop.geometry.surface import Surface, closest_parameters
from trueloop.surface.deviations.plausibility import BEYOND_MM

CELLS: Final = 512
"""Cells of the raster a side."""
SAMPLES: Final = 1024
"""Places of an edge, joined by straight lines on the raster."""
AT_EDGE: Final = 1e-9
"""The kernel takes so much off the edge for on the edge, in the units of the parameters, whatever those are in mm."""
STRIDES: Final = 8
"""Steps of such a line: an edge is then seen in every cell unless it runs through four in a thousandth of itself."""


@dataclass(frozen=True, eq=False)
class Outline:
    """A face's raster (CELLS, CELLS): -1 near an edge, 0 where the face is, 1 where it is cut away. `edges_mm`: places
    along every edge, (SAMPLES, 3) each.
    """

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
        classifier.Perform(face, occ.Pnt(x, y, z), AT_EDGE)
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
    """Places along every edge of the face, (SAMPLES, 3) each; what is only a point in space bounds nothing."""
    occ = kernel()
    explorer = occ.Explorer(face, occ.EDGE)
    found = []
    while explorer.More():
        edge = occ.as_edge(explorer.Current())
        if not occ.degenerated(edge):
            curve = occ.Curve(edge)
            at = np.linspace(curve.FirstParameter(), curve.LastParameter(), SAMPLES)
            found.append(np.array([[p.X(), p.Y(), p.Z()] for p in map(curve.Value, at.tolist())]))
        explorer.Next()
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
