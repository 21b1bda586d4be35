"""The envelope by its definition: slow, readable, without a Newton step or a box.

A convex nose swept along a segment is the set of points q with q·m ≤ h(m) + max(a·m, b·m) for every direction m. A ray
enters that set where the last of these half planes takes it in, and leaves it where the first lets it go.
"""

import itertools
from collections.abc import Callable

import numpy as np

from trueloop.arrays import Array

SPREAD = 41
ROUNDS = 12
"""Each round looks 20 times as close: after twelve the angle is known to rounding."""


def entries(
    nodes: Array, radius_over_angle: Callable[[Array], Array], rays: tuple[Array, Array], reach: float
) -> Array:
    """Where each ray (origins and directions, (q, 2)) first meets the swept region; +reach where it meets nothing.

    `radius_over_angle` gives R + w(φ) at contact angles: the nose's extent towards −n(φ).
    """
    return np.array(
        [
            min([reach, *(_entry(a, b, radius_over_angle, origin, direction) for a, b in itertools.pairwise(nodes))])
            for origin, direction in zip(*rays, strict=True)
        ]
    )


def _entry(a: Array, b: Array, radius_over_angle: Callable[[Array], Array], origin: Array, direction: Array) -> float:
    """Where a ray enters what the nose sweeps on its way from a to b; infinite where it passes by."""
    facing = np.arctan2(*direction)

    def crossing(angle: Array) -> Array:
        """Where the ray crosses the half planes of these contact angles."""
        angle = np.remainder(angle + np.pi, 2 * np.pi) - np.pi
        m = -np.column_stack([np.sin(angle), np.cos(angle)])
        beyond = radius_over_angle(angle) + np.maximum(m @ a, m @ b) - m @ origin
        with np.errstate(divide="ignore"):  # a ray along a half plane's edge never crosses it: that is at infinity
            crossed: Array = beyond / (m @ direction)
        return crossed

    enters = _largest(lambda turned: crossing(facing + turned))
    leaves = -_largest(lambda turned: -crossing(facing + np.pi + turned))
    return enters if enters <= leaves else np.inf


def _largest(value: Callable[[Array], Array]) -> float:
    """The largest value over the half circle, looked at ever closer around the best place found.

    The directions that keep a point of the ray out of a convex set are neighbours, so there is one hill to climb.
    """
    low, high, best = -np.pi / 2, np.pi / 2, -np.inf
    for _ in range(ROUNDS):
        turned = np.linspace(low, high, SPREAD + 2)[1:-1]
        values = value(turned)
        k = int(np.argmax(values))
        step = turned[1] - turned[0]
        low, high, best = turned[k] - step, turned[k] + step, max(best, float(values[k]))
    return best
