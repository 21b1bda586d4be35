"""How far the contour that a program cuts stands off a nominal point, measured on the tool path itself.

Independent of how the path was made: the surface point on the normal through a nominal point is where the nearest nose
centre is exactly the nose radius away.
"""

import math
from collections.abc import Sequence

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Point
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.compensation.moves import Move


def feed_moves_of(path: ToolPath) -> list[Move]:
    """Feed moves in (x, z)."""
    return [
        Move(
            _point(path.start_mm[k]),
            _point(path.end_mm[k]),
            _point(path.centre_mm[k]) if path.motion[k] == Motion.ARC else None,
            float(path.sweep_rad[k]),
        )
        for k in range(len(path))
        if path.motion[k] in (Motion.LINE, Motion.ARC) and not np.allclose(path.start_mm[k], path.end_mm[k])
    ]


def standoff_mm(moves: Sequence[Move], nominal: Array, normal: Array, nose_radius_mm: float) -> float:
    """Distance along the outward normal from the nominal point to the surface that the nose leaves."""
    near = [move for move in moves if _distance(move, nominal) < nose_radius_mm + 1.0]
    low, high = -0.5, 0.5
    while high - low > 1e-10:
        middle = (low + high) / 2
        clear = min(_distance(move, nominal + middle * normal) for move in near) - nose_radius_mm
        low, high = (low, middle) if clear < 0 else (middle, high)
    return (low + high) / 2


def _distance(move: Move, point: Array) -> float:
    """Distance to a move, ends included."""
    start, end = np.asarray(move.start_mm), np.asarray(move.end_mm)
    ends = min(float(np.linalg.norm(point - start)), float(np.linalg.norm(point - end)))
    if move.centre_mm is None:
        chord = end - start
        share = float((point - start) @ chord / (chord @ chord))
        return float(np.linalg.norm(point - start - share * chord)) if 0 <= share <= 1 else ends
    centre = np.asarray(move.centre_mm)
    radius = float(np.linalg.norm(start - centre))
    turned = _angle(start - centre) - _angle(point - centre)
    turned = turned % (2 * math.pi) if move.sweep_rad > 0 else -(-turned % (2 * math.pi))
    on_arc = abs(turned) <= abs(move.sweep_rad)
    return abs(float(np.linalg.norm(point - centre)) - radius) if on_arc else ends


def _angle(arm: Array) -> float:
    return math.atan2(arm[0], arm[1])


def _point(xyz: Array) -> Point:
    return float(xyz[0]), float(xyz[2])
