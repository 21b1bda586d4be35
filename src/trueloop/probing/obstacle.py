"""The obstacle that a probe must not run into: the part with its stock, and the bar behind it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature, pieces_within
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile

CHORD_MM: Final = 2e-3
"""Arcs are taken as polygons that deviate from them by at most this much; clearances are that much uncertain."""

BAR_MM: Final = 1000.0


@dataclass(frozen=True)
class Obstacle:
    """A closed polygon in the (x, z) plane; corner k to k + 1 belongs to `side[k]`, which names it in messages."""

    corners_mm: Array
    side: tuple[str, ...]

    def distance_mm(self, start_mm: Array, end_mm: Array) -> tuple[float, str]:
        """Returns the distance of the segment between two points to the polygon, 0 inside, and what is nearest."""
        a, b = self.corners_mm, np.roll(self.corners_mm, -1, axis=0)
        if self._holds(start_mm) or self._holds(end_mm):
            return 0.0, self.side[int(np.argmin(_point_to_segments(start_mm, a, b)))]
        between = np.minimum(_point_to_segments(start_mm, a, b), _point_to_segments(end_mm, a, b))
        between = np.minimum(between, _points_to_segment(a, start_mm, end_mm))
        between = np.where(_cross(a, b, start_mm, end_mm), 0.0, between)
        nearest = int(np.argmin(between))
        return float(between[nearest]), self.side[nearest]

    def _holds(self, point_mm: Array) -> bool:
        a, b = self.corners_mm, np.roll(self.corners_mm, -1, axis=0)
        straddles = (a[:, 1] > point_mm[1]) != (b[:, 1] > point_mm[1])
        height = b[straddles, 1] - a[straddles, 1]
        x = a[straddles, 0] + (point_mm[1] - a[straddles, 1]) / height * (b - a)[straddles, 0]
        return bool(np.count_nonzero(x > point_mm[0]) % 2)


def stock_obstacle(profile: Profile, allowance_mm: float = 0.0, bar_radius_mm: float | None = None) -> Obstacle:
    """Returns the turned part with an allowance on it, and behind its chuck end a bar (or chuck) of that radius.

    Without `bar_radius_mm` the bar is as thick as the profile where that begins.
    """
    features: Sequence[Feature] = profile.features
    if allowance_mm > 0.0:
        features = nose_centre_path(profile, allowance_mm).features
    corners, sides = [], []
    for feature in features:
        s = np.linspace(0.0, feature.length_mm, pieces_within(feature, CHORD_MM) + 1)[:-1]
        corners.append(feature.point_mm(s))
        sides += [feature.name] * len(s)
    (x_start, z_start), (_, z_end) = features[0].start_mm, features[-1].end_mm
    bar_mm = x_start if bar_radius_mm is None else bar_radius_mm
    tail = [features[-1].end_mm, (0.0, z_end), (0.0, z_start - BAR_MM), (bar_mm, z_start - BAR_MM), (bar_mm, z_start)]
    corners.append(np.array(tail))
    return Obstacle(np.concatenate(corners), (*sides, *("the bar",) * len(tail)))


def _point_to_segments(point: Array, a: Array, b: Array) -> Array:
    along = b - a
    square = np.maximum(np.sum(along**2, axis=1), 1e-300)
    share = np.clip(np.sum((point - a) * along, axis=1) / square, 0.0, 1.0)
    distance: Array = np.hypot(*(a + share[:, None] * along - point).T)
    return distance


def _points_to_segment(points: Array, a: Array, b: Array) -> Array:
    """From each of several points to one segment."""
    along = b - a
    share = np.clip((points - a) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
    distance: Array = np.hypot(*(a + share[:, None] * along - points).T)
    return distance


def _cross(a: Array, b: Array, c: Array, d: Array) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
    """Which of the segments a–b cross the segment c–d."""

    def side(p: Array, q: Array, r: Array) -> Array:
        turned: Array = (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (
            r[..., 0] - p[..., 0]
        )
        return turned

    crossed = (side(c, d, a) * side(c, d, b) < 0.0) & (side(a, b, c) * side(a, b, d) < 0.0)
    return np.asarray(crossed)
