"""What an end mill leaves, by its definition: position after position, marching along the ray. Slow and plain."""

from collections.abc import Callable

import numpy as np

from trueloop.arrays import Array

CLOSE = 41
"""Places of every piece that are looked at before the lowest is refined."""


def distance(point: Array, centre: Array, axis: Array, ring_mm: float) -> float:
    """Of a point from a disc of a ring's radius."""
    off = point - centre
    height = float(off @ axis)
    beyond = max(float(np.linalg.norm(off - height * axis)) - ring_mm, 0.0)
    return float(np.hypot(height, beyond))


def entry(origin: Array, direction: Array, centre: Array, axis: Array, end: tuple[float, float], reach: float) -> float:
    """Where a ray first comes within a corner's radius of the disc: no step is longer than what is still clear."""
    ring, corner = end
    t = -reach
    for _ in range(4000):
        clear = distance(origin + t * direction, centre, axis, ring) - corner
        if clear < 1e-10:
            return t
        t += clear
        if t >= reach:
            break
    return reach


def lowest(origin: Array, direction: Array, nodes: Array, axes: Array, end: tuple[float, float], reach: float) -> float:
    """The lowest entry on the way along the pieces; axes (n, 3), between two nodes by way of their chord."""
    best = reach
    for k in range(len(nodes) - 1):

        def at(share: float, k: int = k) -> float:
            centre, axis = (both[k] + share * (both[k + 1] - both[k]) for both in (nodes, axes))
            if (centre - origin) @ direction <= -reach:
                return reach
            return entry(origin, direction, centre, axis / np.linalg.norm(axis), end, reach)

        shares = np.linspace(0.0, 1.0, CLOSE)
        heights = [at(share) for share in shares]
        middle = int(np.argmin(heights))
        best = min(best, heights[middle])
        if heights[middle] < best + 0.05:
            best = min(best, refined(at, shares[max(middle - 1, 0)], shares[min(middle + 1, CLOSE - 1)]))
    return best


def refined(at: Callable[[float], float], low: float, high: float) -> float:
    """The least value between two places, by thirds."""
    for _ in range(40):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, b) if at(a) <= at(b) else (a, high)
    return at(0.5 * (low + high))
