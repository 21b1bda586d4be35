"""A free-form surface milled with a ball-end cutter: what really stays, cusps included.

The surface is not that of the design displaced by errors: it is the envelope of the ball along the actual passes.
Between two passes a cusp is left, which on a plane is R − √(R² − s²/4) high for a step-over s.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trueloop._core import CutterSweep
from trueloop.geometry.feature import Array

Displacement: TypeAlias = Callable[[Array], Array]
"""Actual less commanded position of the cutter's centre: (n, 3) → (n, 3), mm."""

REACH_MM = 2.0


@dataclass(frozen=True)
class BallEndMill:
    """A ball-end cutter. `radius_error_mm` is by how much it is larger than the program believes (negative: worn)."""

    radius_mm: float
    radius_error_mm: float = 0.0

    def centres_mm(self, contact_mm: Array, normal: Array) -> Array:
        """Programmed centres for contacts and surface normals out of the material, (…, 3) → (…, 3)."""
        centres: Array = contact_mm + self.radius_mm * normal
        return centres


@dataclass(frozen=True)
class MilledStock:
    """Endless material less the passes cut so far."""

    passes: tuple[CutterSweep, ...] = ()

    def cut_by(
        self, cutter: BallEndMill, passes_mm: Iterable[Array], displacement: Displacement | None = None
    ) -> "MilledStock":
        """The stock after passes of programmed centres, (n, 3) each, at which the cutter really stands displaced."""
        radius = cutter.radius_mm + cutter.radius_error_mm
        actual = (p if displacement is None else p + displacement(p) for p in passes_mm)
        return MilledStock((*self.passes, *(CutterSweep(np.ascontiguousarray(p), radius) for p in actual)))

    def height_mm(self, points_mm: Array, normal: Array, reach_mm: float = REACH_MM) -> Array:
        """Where a line through each nominal point (n, 3) along its normal (n, 3) leaves the material, (n,).

        Positive = material left on; +reach where nothing was cut within reach.
        """
        height = np.full(len(points_mm), reach_mm)
        origins, directions = np.ascontiguousarray(points_mm), np.ascontiguousarray(normal)
        for swept in self.passes:
            np.minimum(height, swept.entries(origins, directions, reach_mm), out=height)
        return height


def raster(contact_mm: Array, normal: Array, cutter: BallEndMill) -> Sequence[Array]:
    """Passes along the rows of a grid of contacts (rows, n, 3) with normals alike, every other one backwards."""
    centres = cutter.centres_mm(contact_mm, normal)
    return [row if k % 2 == 0 else row[::-1] for k, row in enumerate(centres)]


def cusp_height_mm(step_over_mm: float, cutter_radius_mm: float, curvature_per_mm: float = 0.0) -> float:
    """Height of the cusp between two passes that touch the surface `step_over_mm` of chord apart.

    `curvature_per_mm` is that of the surface across the passes, positive where it is convex. Both contacts lie on a
    circle of the surface, the cusp where the two balls' outlines meet in the plane between them. Valid for a step-over
    below the cutter's diameter, and in a hollow for a cutter smaller than its radius.
    """
    half, radius = step_over_mm / 2, cutter_radius_mm
    if curvature_per_mm == 0.0:
        return float(radius - np.sqrt(radius**2 - half**2))
    surface = 1.0 / curvature_per_mm  # signed: negative in a hollow
    along = np.sqrt(surface**2 - half**2) * np.sign(surface)
    centre_height = along * (1.0 + radius / surface)
    centre_aside = half * (1.0 + radius / surface)
    return float(centre_height - np.sqrt(radius**2 - centre_aside**2) - surface)
