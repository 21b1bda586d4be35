"""One feature of a turned profile: a line, an arc or a curve with arc length, tangent, outward normal and curvature.

The plane is (x, z): x is the radius in mm, z runs along the spindle axis away from the chuck. The material lies to the
right of the direction of travel as seen with z to the right and x up, so that the outward normal is the tangent turned
left by 90 degrees: an outside runs from chuck end to free end, a bore from free end to chuck end.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.curve import Curve

Point: TypeAlias = tuple[float, float]


def contact_angle_rad(outward_normal: ArrayLike) -> Array:
    """Returns the angle of the outward normal from +z towards +x, in [−π, π]. Shape (..., 2) → (...).

    0 on an end face, π/2 on a cylinder, −π/2 in a bore. `Profile.contact_angle_rad` carries it on over back faces.
    """
    normal = np.asarray(outward_normal, dtype=np.float64)
    return np.arctan2(normal[..., 0], normal[..., 1])


def _normal_of(tangent: Array) -> Array:
    """Returns the outward normal (n_x, n_z) = (t_z, −t_x) of a tangent (t_x, t_z)."""
    return np.stack([tangent[..., 1], -tangent[..., 0]], axis=-1)


@dataclass(frozen=True, slots=True)
class Line:
    """A straight feature: cylinder, face or cone. Points are (x, z) in mm, x a radius."""

    name: str
    start_mm: Point
    end_mm: Point

    @property
    def length_mm(self) -> float:
        """Returns the arc length from start to end."""
        return math.dist(self.start_mm, self.end_mm)

    def point_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the point at arc length, (...) → (..., 2). Beyond the ends the line goes on straight."""
        s = np.asarray(arc_length_mm, dtype=np.float64)[..., None]
        return np.asarray(self.start_mm) + s * self._direction

    def tangent(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the unit tangent in the direction of travel, (...) → (..., 2)."""
        s = np.asarray(arc_length_mm, dtype=np.float64)
        return np.broadcast_to(self._direction, (*s.shape, 2))

    def outward_normal(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the unit normal out of the material, (...) → (..., 2)."""
        return _normal_of(self.tangent(arc_length_mm))

    @property
    def turn_rad(self) -> float:
        """Returns the angle by which the tangent turns to the right from start to end: 0."""
        return 0.0

    def curvature_per_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns zero: dn/ds = κ t."""
        return np.zeros_like(np.asarray(arc_length_mm, dtype=np.float64))

    def locate(self, points_mm: ArrayLike) -> tuple[Array, Array]:
        """Returns the arc length of the foot of the normal and the distance along it (positive outside)."""
        offset = np.asarray(points_mm, dtype=np.float64) - np.asarray(self.start_mm)
        direction = self._direction
        return offset @ direction, offset @ _normal_of(direction)

    def reversed(self) -> "Line":
        """Returns this line run from its end to its start: the material changes sides."""
        return Line(self.name, self.end_mm, self.start_mm)

    @property
    def _direction(self) -> Array:
        along: Array = np.asarray(self.end_mm) - np.asarray(self.start_mm)
        return along / self.length_mm


@dataclass(frozen=True)
class Arc:
    """A circular feature. `sweep_rad` is how far the tangent turns from start to end, up to a full turn.

    Positive sweep turns right as seen with z right and x up (clockwise: G02): the normal turns towards +z, the arc is
    convex (dome, knob). Negative is concave (a fillet).
    """

    name: str
    start_mm: Point
    end_mm: Point
    centre_mm: Point
    sweep_rad: float

    @property
    def radius_mm(self) -> float:
        """Returns the distance of the start from the centre."""
        return math.dist(self.start_mm, self.centre_mm)

    @property
    def length_mm(self) -> float:
        """Returns the arc length from start to end."""
        return self.radius_mm * abs(self.sweep_rad)

    def point_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the point at arc length, (...) → (..., 2). Beyond the ends the circle goes on."""
        return np.asarray(self.centre_mm) + self.radius_mm * self._radial(arc_length_mm)

    def tangent(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the unit tangent in the direction of travel, (...) → (..., 2)."""
        radial = self._radial(arc_length_mm)
        return self._side * np.stack([-radial[..., 1], radial[..., 0]], axis=-1)

    def outward_normal(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the unit normal out of the material, (...) → (..., 2): away from the centre on a convex arc."""
        return self._side * self._radial(arc_length_mm)

    @property
    def turn_rad(self) -> float:
        """Returns the angle by which the tangent turns to the right from start to end: the sweep."""
        return self.sweep_rad

    def curvature_per_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the signed κ with dn/ds = κ t: positive on a convex arc, where offsetting outwards lengthens it."""
        return np.full_like(np.asarray(arc_length_mm, dtype=np.float64), self._side / self.radius_mm)

    def locate(self, points_mm: ArrayLike) -> tuple[Array, Array]:
        """Returns the arc length of the foot of the normal and the distance along it (positive outside the material).

        The arc length of a point beyond the ends is measured on from the nearer end (negative before the start).
        """
        offset = np.asarray(points_mm, dtype=np.float64) - np.asarray(self.centre_mm)
        turned = self._side * (self._start_angle_rad - np.arctan2(offset[..., 0], offset[..., 1]))
        half_gap = math.pi - abs(self.sweep_rad) / 2
        turned = (turned + half_gap) % (2 * math.pi) - half_gap
        distance = self._side * (np.hypot(offset[..., 0], offset[..., 1]) - self.radius_mm)
        return turned * self.radius_mm, distance

    def reversed(self) -> "Arc":
        """Returns this arc run from its end to its start: convex becomes concave."""
        return Arc(self.name, self.end_mm, self.start_mm, self.centre_mm, -self.sweep_rad)

    @property
    def _side(self) -> float:
        return math.copysign(1.0, self.sweep_rad)

    @property
    def _start_angle_rad(self) -> float:
        """Returns the angle of the start as seen from the centre, from +z towards +x."""
        return math.atan2(self.start_mm[0] - self.centre_mm[0], self.start_mm[1] - self.centre_mm[1])

    def _radial(self, arc_length_mm: ArrayLike) -> Array:
        s = np.asarray(arc_length_mm, dtype=np.float64)
        angle = self._start_angle_rad - self._side * s / self.radius_mm
        return np.stack([np.sin(angle), np.cos(angle)], axis=-1)


LineOrArc: TypeAlias = Line | Arc
"""A feature that one move of a program cuts."""

Feature: TypeAlias = Line | Arc | Curve


def is_curved(feature: Feature) -> bool:
    """Returns whether the contact angle of a nose turns along the feature: on arcs and curves, not on lines."""
    return not isinstance(feature, Line)


def least_radius_mm(feature: Feature) -> float:
    """Returns the least radius of curvature along a feature; infinite on a line."""
    if isinstance(feature, Curve):
        return min(feature.radius_range_mm())
    return feature.radius_mm if isinstance(feature, Arc) else math.inf


def pieces_within(feature: Feature, chord_mm: float) -> int:
    """Returns the number of equal pieces of a feature whose chords deviate from it by no more than the tolerance."""
    return max(1, math.ceil(feature.length_mm / math.sqrt(8.0 * least_radius_mm(feature) * chord_mm)))


def distance_mm(feature: Feature, point_mm: Point) -> float:
    """Returns the distance of a point (x, z) from a feature, its ends included."""
    arc_length, distance = (float(value) for value in feature.locate(point_mm))
    if 0 <= arc_length <= feature.length_mm:
        return abs(distance)
    return min(math.dist(point_mm, feature.start_mm), math.dist(point_mm, feature.end_mm))
