"""Intersections of two features, each continued along its whole line or circle, and of a chain with itself.

A curve goes on beyond its ends along its circles of curvature.
"""

import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Line, Point

_PARALLEL: Final = 1e-13
"""Sine of the angle below which two lines count as parallel."""

TOUCH_MM: Final = 1e-9
"""A line or circle that misses a circle by less touches it."""


def intersections(first: Feature, second: Feature) -> list[Point]:
    """Points (x, z) in mm common to the whole line or circle of each feature: none, one or two; of curves any number.

    None for parallel lines and concentric circles, those that coincide included.
    """
    if isinstance(first, Curve):
        return _with_curve(first, second)
    if isinstance(second, Curve):
        return _with_curve(second, first)
    if isinstance(first, Line):
        return _line_line(first, second) if isinstance(second, Line) else _line_circle(first, second)
    return _line_circle(second, first) if isinstance(second, Line) else _circle_circle(first, second)


def crossings(features: Sequence[Feature], tolerance_mm: float) -> list[tuple[int, int, Point]]:
    """Pairs of features of a chain that cross or touch away from their common end, with the place (x, z) in mm.

    A curve that crosses itself makes a pair with itself.

    Neighbours that run along each other within `tolerance_mm` near their junction, as rounded tangent features do, do
    not cross.
    """
    overlapping = np.argwhere(np.triu(_boxes_overlap(features), k=1))
    curves = [(i, feature) for i, feature in enumerate(features) if isinstance(feature, Curve)]
    own = [(i, i, point) for i, curve in curves for point in own_crossings(curve)]
    return own + [
        (int(i), int(j), point)
        for i, j in overlapping
        for point in intersections(features[i], features[j])
        if _on_both(features[i], features[j], point)
        and not (j == i + 1 and _near_junction(features[i], features[j], point, tolerance_mm))
    ]


def _with_curve(curve: Curve, other: Feature) -> list[Point]:
    """Crossings on the curve itself, and those of its circles beyond its ends."""
    on_curve = curve.point_mm(sign_changes(curve, lambda points: other.locate(points)[1]))
    found = [(float(x), float(z)) for x, z in on_curve]
    for at_end in (False, True):
        for point in intersections(beyond_end(curve, at_end), other):
            along, off = (float(value) for value in curve.locate(point))
            is_beyond = along > curve.length_mm - TOUCH_MM if at_end else along < TOUCH_MM
            if is_beyond and abs(off) < 1e-6 and all(math.dist(point, known) > TOUCH_MM for known in found):
                found.append(point)
    return found


def _line_line(first: Line, second: Line) -> list[Point]:
    (x, z), (dx, dz), (ex, ez) = first.start_mm, first.tangent(0.0), second.tangent(0.0)
    cross = dx * ez - dz * ex
    if abs(cross) < _PARALLEL:
        return []
    along = ((second.start_mm[0] - x) * ez - (second.start_mm[1] - z) * ex) / cross
    return [(float(x + along * dx), float(z + along * dz))]


def _line_circle(line: Line, circle: Arc) -> list[Point]:
    along, distance = line.locate(circle.centre_mm)
    half_chord = _half_chord(circle.radius_mm, abs(float(distance)))
    return [] if half_chord is None else _pair(line, float(along), half_chord)


def _pair(line: Line, along: float, half_chord: float) -> list[Point]:
    ends = line.point_mm([along - half_chord, along + half_chord])
    return [(float(x), float(z)) for x, z in ends]


def _circle_circle(first: Arc, second: Arc) -> list[Point]:
    apart = math.dist(first.centre_mm, second.centre_mm)
    if apart < TOUCH_MM:
        return []
    to_chord = (apart + (first.radius_mm - second.radius_mm) * (first.radius_mm + second.radius_mm) / apart) / 2
    half_chord = _half_chord(first.radius_mm, abs(to_chord))
    if half_chord is None:
        return []
    centres = Line("", first.centre_mm, second.centre_mm)
    foot, across = centres.point_mm(to_chord), centres.outward_normal(0.0)
    return [(float(x), float(z)) for x, z in (foot - half_chord * across, foot + half_chord * across)]


def _half_chord(radius_mm: float, distance_mm: float) -> float | None:
    """Returns half the chord that a circle cuts from a line at a distance from its centre; None where it misses."""
    if distance_mm > radius_mm + TOUCH_MM:
        return None
    return math.sqrt(max((radius_mm - distance_mm) * (radius_mm + distance_mm), 0.0))


def _boxes_overlap(features: Sequence[Feature]) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    low, high = (np.array(side) for side in zip(*(_box(feature) for feature in features), strict=True))
    return np.asarray(((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(axis=-1))


def _box(feature: Feature) -> tuple[Array, Array]:
    """Corners of a box around the feature: its ends and middle, widened by the sagitta of the two halves."""
    if isinstance(feature, Curve):
        (s, points), tightest = feature.sampled_mm, min(feature.radius_range_mm())
        sagitta = float(np.max(np.diff(s))) ** 2 / (8 * tightest)
        return points.min(axis=0) - sagitta - TOUCH_MM, points.max(axis=0) + sagitta + TOUCH_MM
    points = feature.point_mm(np.array([0.0, 0.5, 1.0]) * feature.length_mm)
    sagitta = feature.radius_mm * (1 - math.cos(feature.sweep_rad / 4)) if isinstance(feature, Arc) else 0.0
    return points.min(axis=0) - sagitta - TOUCH_MM, points.max(axis=0) + sagitta + TOUCH_MM


def _on_both(first: Feature, second: Feature, point: Point) -> bool:
    return all(
        -TOUCH_MM <= float(feature.locate(point)[0]) <= feature.length_mm + TOUCH_MM for feature in (first, second)
    )


def _near_junction(before: Feature, after: Feature, point: Point, tolerance_mm: float) -> bool:
    """Returns whether the loop from the crossing to the junction is thinner than the tolerance."""
    halfway = before.point_mm((float(before.locate(point)[0]) + before.length_mm) / 2)
    return abs(float(after.locate(halfway)[1])) <= tolerance_mm


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
