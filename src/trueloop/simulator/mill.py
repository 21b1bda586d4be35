"""What a ball-end cutter leaves on a surface: the envelope of its path, seen along the surface's normals."""

from typing import Final

import numpy as np

from trueloop.geometry.feature import Array
from trueloop.nc.tool_path import Motion, ToolPath

STEP_MM: Final = 0.02
"""Distance of the balls whose union stands for the swept ball: ridges between them are under 0.02 µm at 3 mm radius."""


def left_on_mm(points_mm: Array, normals: Array, centres_mm: Array, radius_mm: float, reach_mm: float = 0.5) -> Array:
    """Material left on at points (n, 3) of a surface, along outward unit normals, by a ball through centres (m, 3).

    Positive above the surface. `reach_mm` is the height of the blank: what no ball reaches is left at that. The path
    is followed in steps of 0.02 mm.
    """
    from scipy.spatial import KDTree  # slow to import

    balls = _densified(centres_mm)
    tree = KDTree(balls)
    left = np.full(len(points_mm), reach_mm)
    wide = float(np.sqrt(max(radius_mm**2 - (radius_mm - reach_mm) ** 2, 0.0))) + reach_mm
    near = tree.query_ball_point(points_mm + radius_mm * normals, wide)
    for k, index in enumerate(near):
        off = balls[index] - points_mm[k]
        along = off @ normals[k]
        inside = radius_mm**2 - np.sum(off**2, axis=1) + along**2
        hit = inside > 0
        if np.any(hit):
            left[k] = min(left[k], float(np.min(along[hit] - np.sqrt(inside[hit]))))
    return left


def ball_centres(path: ToolPath, radius_mm: float, axis: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Array:
    """Centres along the straight feed moves of a program whose programmed point is the tip."""
    up = np.asarray(axis) / np.linalg.norm(axis)
    at_feed = path.motion == Motion.LINE
    ends = np.stack([path.start_mm[at_feed], path.end_mm[at_feed]], axis=1).reshape(-1, 3)
    return np.asarray(ends + radius_mm * up)


def _densified(centres: Array) -> Array:
    length = np.linalg.norm(np.diff(centres, axis=0), axis=1)
    pieces = np.maximum(1, np.ceil(length / STEP_MM)).astype(int)
    start = np.repeat(centres[:-1], pieces, axis=0)
    step = np.repeat(np.diff(centres, axis=0) / pieces[:, None], pieces, axis=0)
    count = np.arange(len(start)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.concatenate([start + count[:, None] * step, centres[-1:]])
