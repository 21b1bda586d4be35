"""How far two tool paths lie apart, every point from every piece, a move at a time: what the quick one must equal."""

import numpy as np
from numpy.typing import NDArray

from trueloop.nc.match.difference import SAGITTA_MM
from trueloop.nc.program.along import lengths_mm, points_along
from trueloop.nc.program.tool_path import Motion, ToolPath

Array = NDArray[np.float64]


def largest_distance_mm(one: ToolPath, other: ToolPath, spacing_mm: float) -> float:
    """The larger of the largest distances from the points of the cuts of one to the chords of those of the other."""
    chords, others = (chords_of(path, spacing_mm) for path in (one, other))
    return max(one_way_mm(chords.reshape(-1, 3), others), one_way_mm(others.reshape(-1, 3), chords))


def one_way_mm(points: Array, chords: Array) -> float:
    """The largest distance from points (n, 3) to the nearest of chords (m, 2, 3)."""
    return max(distance_mm(point, chords) for point in points)


def distance_mm(point: Array, chords: Array) -> float:
    """The distance from a point to the nearest chord."""
    start, way = chords[:, 0], chords[:, 1] - chords[:, 0]
    square = np.einsum("ij,ij->i", way, way)
    share = np.einsum("ij,ij->i", point - start, way) / np.where(square > 0.0, square, 1.0)
    return float(np.linalg.norm(point - start - np.clip(share, 0.0, 1.0)[:, None] * way, axis=1).min())


def chords_of(path: ToolPath, spacing_mm: float) -> Array:
    """The cuts of a path in chords (m, 2, 3) no longer than the spacing and no further off an arc than the sagitta."""
    chords = []
    for move in np.flatnonzero(path.motion != Motion.RAPID):
        count = max(1, int(np.ceil(lengths_mm(path, np.array([move]))[0] / spacing_mm)))
        if path.motion[move] == Motion.ARC:
            radius_mm = np.linalg.norm(path.start_mm[move] - path.centre_mm[move])
            count = max(count, int(np.ceil(abs(path.sweep_rad[move]) * np.sqrt(radius_mm / 8 / SAGITTA_MM))))
        points = points_along(path, np.intp(move), np.linspace(0.0, 1.0, count + 1))
        chords.append(np.stack([points[:-1], points[1:]], axis=1))
    return np.concatenate(chords)
