"""Places where a curve crosses something, and itself."""

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Line

CROSSES_MM: Final = 1e-6
"""A signed distance that changes its sign jumps there, if it is not this small in between."""

ROUNDING_MM: Final = 1e-12
"""A point of the curve this near is on it: the last bits of its coordinates depend on how many are computed at once."""

STRAIGHT_PER_MM: Final = 1e-9
"""A curvature below this is none: over a metre the circle leaves its tangent by 0.5 µm."""

CHORDS: Final = 1000
"""With so many chords at most a curve is compared with itself."""


def sign_changes(curve: Curve, distance: Callable[[Array], Array]) -> Array:
    """Returns the arc lengths on the curve, ascending, where a signed distance of its points (n, 2) → (n,) is zero.

    A sample within `ROUNDING_MM`, the ends among them, is a crossing itself, whatever its sign.
    """
    s, points = curve.sampled_mm
    values = distance(points)
    values = np.where(np.abs(values) <= ROUNDING_MM, 0.0, values)

    def at(place: float) -> float:
        return float(distance(curve.point_mm(np.array([place])))[0])

    found = [float(place) for place in s[values == 0.0]]
    for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
        place = _root(at, float(s[k]), float(s[k + 1]))
        if abs(at(place)) < CROSSES_MM:
            found.append(place)
    return np.array(sorted(found))


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Returns the zero between two places whose samples differ in sign, or the nearer one if it is lost to rounding."""
    from scipy.optimize import brentq  # slow to import

    at_low, at_high = function(low), function(high)
    if (at_low < 0.0) == (at_high < 0.0):
        return low if abs(at_low) <= abs(at_high) else high
    return float(brentq(function, low, high, xtol=1e-13))


def beyond_end(curve: Curve, at_end: bool) -> Line | Arc:
    """Returns the continuation of the curve beyond one end: half of its circle of curvature, or its tangent."""
    s = curve.length_mm if at_end else 0.0
    point, tangent, normal = curve.point_mm(s), curve.tangent(s), curve.outward_normal(s)
    curvature, away = float(curve.curvature_per_mm(s)), 1.0 if at_end else -1.0
    if abs(curvature) < STRAIGHT_PER_MM:
        return Line(curve.name, _point(point), _point(point + away * tangent))
    centre = point - normal / curvature
    sweep_rad = math.copysign(math.pi, curvature) * away
    return Arc(curve.name, _point(point), _point(2 * centre - point), _point(centre), sweep_rad)


def own_crossings(curve: Curve) -> list[tuple[float, float]]:
    """Returns the places where the curve crosses itself; none if it turns by less than half a turn."""
    points = curve.sampled_mm[1]
    chords = points[:: max(1, len(points) // CHORDS)]
    steps = np.diff(chords, axis=0)
    turns = np.arctan2(
        steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0], np.sum(steps[:-1] * steps[1:], axis=1)
    )
    if np.sum(np.abs(turns)) < math.pi:
        return []
    a, b = chords[:-1], chords[1:]

    def side(of: Array, start: Array, end: Array) -> Array:
        """Returns the sign of the side of chord j on which point i lies, (i, j)."""
        along, to = end - start, of[:, None] - start[None]
        return np.asarray(np.sign(along[None, :, 1] * to[..., 0] - along[None, :, 0] * to[..., 1]))

    apart = side(a, a, b) * side(b, a, b) < 0
    crossing = np.argwhere(np.triu(apart & apart.T, k=2))
    return [(float(x), float(z)) for x, z in a[crossing[:1, 0]]]


def _point(xz: Array) -> tuple[float, float]:
    return float(xz[0]), float(xz[1])
