"""The axis of a turned solid: the line about which most of its faces are turned."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import CadFace
from trueloop.geometry.feature import Point

WITHIN_MM: Final = 1e-4
"""Ends that lie closer are one point, axes that lie closer are one axis."""
PARALLEL: Final = 1e-6
HAS_AXIS: Final = ("CylindricalSurface", "ConicalSurface", "ToroidalSurface", "SurfaceOfRevolution")


@dataclass(frozen=True, eq=False)
class Axis:
    """A line: its point nearest to the file's origin, and the direction in which z grows.

    `share` of the turned area is turned about it, `rival` about the next one.
    """

    origin: Array
    direction: Array
    share: float = 1.0
    rival: float = 0.0

    def flat(self, point: Any) -> Point:
        """Returns (x, z) of a point of the kernel: its distance from the axis, and its place along it."""
        return self.flattened([point])[0]

    def flattened(self, points: Sequence[Any]) -> list[Point]:
        """Returns several points as radius and place along the axis."""
        away = np.array([(point.X(), point.Y(), point.Z()) for point in points]) - self.origin
        z = away @ self.direction
        x = np.linalg.norm(away - z[:, None] * self.direction, axis=1)
        return list(zip(x.tolist(), z.tolist(), strict=True))

    def aside(self, point: Any) -> Array:
        """Returns the vector from the axis to a point of the kernel, perpendicular to the axis."""
        away: Array = xyz(point) - self.origin
        return away - (away @ self.direction) * self.direction

    def is_parallel(self, direction: Any) -> bool:
        """Returns whether the kernel's direction is along the axis, either way."""
        return float(np.linalg.norm(np.cross(xyz(direction), self.direction))) < PARALLEL

    def is_of(self, place: Any, direction: Any) -> bool:
        """Returns whether a line through the place in the direction is this axis."""
        return self.is_parallel(direction) and self.flat(place)[0] < WITHIN_MM

    def at(self, point: Point, turn_rad: float) -> Array:
        """Returns the place of (x, z) in space when turned about the axis."""
        first, second = self._square
        return self.origin + point[1] * self.direction + point[0] * (math.cos(turn_rad) * first
                                                                    + math.sin(turn_rad) * second)  # fmt: skip

    @cached_property
    def _square(self) -> tuple[Array, Array]:
        first = np.cross(self.direction, np.eye(3)[int(np.argmin(np.abs(self.direction)))])
        first /= np.linalg.norm(first)
        return first, np.cross(self.direction, first)


def axis_of(faces: Sequence[CadFace]) -> Axis | None:
    """Returns the line about which most of the area is turned; None where no face is."""
    groups: list[tuple[Array, Array, float]] = []
    for face in faces:
        if face.kind not in HAS_AXIS:
            continue
        own = kernel().surface_of(face.handle).Axis()
        point, direction = xyz(own.Location()), xyz(own.Direction())
        direction = direction * np.sign(direction[np.argmax(np.abs(np.round(direction, 6)))])
        foot = point - (point @ direction) * direction
        for k, (at, along, area) in enumerate(groups):
            if np.linalg.norm(at - foot) < WITHIN_MM and np.linalg.norm(along - direction) < PARALLEL:
                groups[k] = at, along, area + face.area_mm2
                break
        else:
            groups.append((foot, direction, face.area_mm2))
    if not groups:
        return None
    (at, along, area), *others = sorted(groups, key=lambda group: -group[2])
    whole = area + math.fsum(group[2] for group in others)
    return Axis(at, along, area / whole, others[0][2] / whole if others else 0.0)


def xyz(point: Any) -> Array:
    """Coordinates of a point or a direction of the kernel."""
    return np.array([point.X(), point.Y(), point.Z()])
