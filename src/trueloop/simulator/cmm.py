"""The virtual coordinate measuring machine: an independent look at the finished part."""

import math
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.simulator.mill import MilledStock
from trueloop.simulator.stock import Stock


@dataclass(frozen=True)
class VirtualCmm:
    """A measuring machine with its own errors.

    `frame_mm` is the standard deviation by which it finds the part's origin on each axis, `tilt_rad` that of the turned
    part's axis, or of the milled part's turn about each axis.
    Its length error is at most `mpe_mm` + L · `mpe_per_mm` at distance L from the origin (maximum permissible error,
    ISO 10360-2), uniform.
    """

    frame_mm: float = 0.0
    tilt_rad: float = 0.0
    mpe_mm: float = 0.0
    mpe_per_mm: float = 0.0

    def measure(self, stock: Stock | MilledStock, points_mm: Array, normal: Array, rng: np.random.Generator) -> Array:
        """Part errors along the nominal normals, (n,), positive = material left on, as this machine finds them.

        Points and normals are (n, 2) in the plane of a turned part, (n, 3) on a milled one.
        """
        moved = self.frame_mm * rng.standard_normal(points_mm.shape[1]) + np.zeros_like(points_mm)
        moved = moved + self.tilt_rad * _turned(points_mm, rng)
        most = self.mpe_mm + self.mpe_per_mm * np.linalg.norm(points_mm, axis=1)
        found: Array = stock.height_mm(points_mm, normal) + np.einsum("ij,ij->i", moved, normal)
        found += most * (2.0 * rng.random(len(points_mm)) - 1.0)
        return found

    @property
    def standard_u_mm(self) -> float:
        """Standard uncertainty of one point near the origin: frame and length error together."""
        return math.hypot(self.frame_mm, self.mpe_mm / math.sqrt(3.0))


def _turned(points_mm: Array, rng: np.random.Generator) -> Array:
    """Displacement of points by a random small turn about the origin, in mm per radian of standard deviation."""
    if points_mm.shape[1] == 2:
        return rng.standard_normal() * np.column_stack([points_mm[:, 1], -points_mm[:, 0]])
    return np.cross(rng.standard_normal(3), points_mm)
