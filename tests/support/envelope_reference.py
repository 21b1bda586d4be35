"""The envelope by its definition: slow, readable, without a Newton step or a box.

A convex nose swept along a segment is the set of points q with q·m ≤ h(m) + max(a·m, b·m) for every direction m. A ray
enters that set where the last of these half planes takes it in.
"""

import itertools
from collections.abc import Callable

import numpy as np

from trueloop.geometry.feature import Array

ANGLES = np.linspace(-np.pi, np.pi, 14401)[:-1]


def entries(
    nodes: Array, radius_over_angle: Callable[[Array], Array], rays: tuple[Array, Array], reach: float
) -> Array:
    """Where each ray (origins and directions, (q, 2)) first meets the swept region; +reach where it meets nothing.

    `radius_over_angle` gives R + w(φ) at contact angles: the nose's extent towards −n(φ). The half planes along a
    segment's straight sides are among those looked at; the others are 0.025° apart.
    """
    found = []
    for origin, direction in zip(*rays, strict=True):
        best = reach
        for a, b in itertools.pairwise(nodes):
            m, h = _half_planes(b - a, radius_over_angle)
            limit = h + np.maximum(m @ a, m @ b) - m @ origin
            speed = m @ direction
            enters = np.max(limit[speed < 0] / speed[speed < 0])
            leaves = np.min(limit[speed > 0] / speed[speed > 0])
            if enters <= leaves:
                best = min(best, enters)
        found.append(best)
    return np.array(found)


def _half_planes(along: Array, radius_over_angle: Callable[[Array], Array]) -> tuple[Array, Array]:
    side = np.arctan2(along[1], -along[0])
    angles = np.concatenate([ANGLES, [side, side - np.copysign(np.pi, side)]])
    return -np.column_stack([np.sin(angles), np.cos(angles)]), radius_over_angle(angles)
