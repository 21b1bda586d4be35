"""Milling cutters whose edge is a torus: ball end, bull nose, flat end; where they touch a surface, and how deep.

The tool's tip (x, y, z of the program) lies on its axis at the lowest point. A ball-end cutter is the torus without a
ring, a flat one that without a corner.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.surface import Surface
from trueloop.geometry.surface_closest import Feet, closest

ROUNDS: Final = 40
STILL_MM: Final = 1e-10


@dataclass(frozen=True)
class Cutter:
    """`radius_mm` of the tool, `corner_mm` of its edge: equal for a ball end, zero for a flat end."""

    radius_mm: float
    corner_mm: float

    def __post_init__(self) -> None:
        if not 0 <= self.corner_mm <= self.radius_mm or not self.radius_mm > 0:
            raise TrueloopError(
                Code.SRF_CUTTER,
                f"a cutter of radius {self.radius_mm} mm with corners of {self.corner_mm} mm",
                hint="the corner radius is between 0 (flat end) and the tool's radius (ball end)",
                values={"radius_mm": self.radius_mm, "corner_mm": self.corner_mm},
            )

    @property
    def ring_mm(self) -> float:
        """Radius of the circle on which the corner's centre runs."""
        return self.radius_mm - self.corner_mm


@dataclass(frozen=True, eq=False)
class Contacts:
    """Where the cutter comes nearest to a surface: feet, and the gap there (negative: into the material), in mm."""

    feet: Feet
    gap_mm: Array


def contacts(
    surface: Surface, cutter: Cutter, tips_mm: Array, axes: Array, near: tuple[Array, Array] | None = None
) -> Contacts:
    """Contacts of a cutter with its tip at (n, 3) and its axis along unit vectors (n, 3), out of the material.

    The point of the corner's circle nearest to the surface is where the surface's normal leans away from the axis:
    q = tip + r a − (R − r) h with h the normal's part across the axis, found by iterating foot and lean. Where the
    normal is the axis, the whole circle is equally near, and the centre is taken.
    """
    centres = tips_mm + cutter.corner_mm * axes
    if cutter.ring_mm == 0:
        feet = closest(surface, centres, near)
        return Contacts(feet, feet.distance_mm - cutter.corner_mm)
    points = centres
    for _ in range(ROUNDS):
        feet = closest(surface, points, near)
        near = (feet.u, feet.v)
        moved = centres - cutter.ring_mm * _lean(feet.normal, axes)
        step = float(np.max(np.abs(moved - points), initial=0.0))
        points = moved
        if step < STILL_MM:
            break
    feet = closest(surface, points, near)
    return Contacts(feet, feet.distance_mm - cutter.corner_mm)


def edge_centres_mm(cutter: Cutter, tips_mm: Array, axes: Array, count: int) -> Iterator[Array]:
    """The corner's centre at so many places around the edge, (n, 3) each; none for a ball end, which has no ring."""
    if cutter.ring_mm == 0:
        return
    aside = np.eye(3)[np.argmin(np.abs(axes), axis=1)]
    first = np.cross(axes, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(axes, first)
    for angle in np.linspace(0.0, 2 * np.pi, count, endpoint=False):
        yield tips_mm + cutter.corner_mm * axes + cutter.ring_mm * (np.cos(angle) * first + np.sin(angle) * second)


def _lean(normal: Array, axes: Array) -> Array:
    across = normal - np.sum(normal * axes, axis=1, keepdims=True) * axes
    length = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(np.where(length > 1e-9, across / np.maximum(length, 1e-300), 0.0))
