"""The part while it is being cut: everything but what the nose has passed over."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop._core import NoseSweep
from trueloop.arrays import Array
from trueloop.simulator.nose import Nose

REACH_MM: Final = 1.0
"""How far from a nominal point the surface is looked for, either way: less than a wall, more than any error."""


def sweep(centre_mm: Array, nose: Nose) -> NoseSweep:
    """What a nose passes over along positions of its centre (n, 2)."""
    return NoseSweep(np.ascontiguousarray(centre_mm), nose.radius_mm, nose.first_rad, nose.step_rad, nose.pieces)


@dataclass(frozen=True)
class Stock:
    """An endless bar less the swept regions of all cuts so far. x is a radius."""

    sweeps: tuple[NoseSweep, ...] = ()

    def cut_by(self, sweeps: Iterable[NoseSweep]) -> "Stock":
        """The stock after further cuts."""
        return Stock((*self.sweeps, *sweeps))

    def height_mm(self, points_mm: Array, direction: Array, reach_mm: float = REACH_MM) -> Array:
        """Where a line through each point (n, 2) along its unit direction (n, 2) leaves the material, (n,).

        Measured from the point, positive outside; +reach where nothing was cut away within reach. It is the true
        surface: no error terms are added up, no curvature is neglected.
        """
        height = np.full(len(points_mm), reach_mm)
        origins, directions = np.ascontiguousarray(points_mm), np.ascontiguousarray(direction)
        for swept in reversed(self.sweeps):  # the last cut is nearly everywhere the lowest: the others soon give up
            height = swept.entries(origins, directions, height, reach_mm)
        return height
