"""What the finish cut does otherwise than the cuts before it, on every part alike."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import contact_angle_rad
from trueloop.simulator.path import CentrePath


@dataclass(frozen=True)
class Transfer:
    """Part error that the finish cut adds, over contact angle (0 on a face, 90° on a cylinder): positive = left on.

    Straight between the `error_mm` at `angle_rad` (ascending, as many of each), constant beyond them; none without any.
    It moves the nose along the normal of its path: a loop that measures the cut before it cannot see it. Raises
    SIM-TRANSFER for tables that do not go together.
    """

    angle_rad: tuple[float, ...] = ()
    error_mm: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        ascending = len(self.angle_rad) == len(self.error_mm) and all(np.diff(self.angle_rad) > 0.0)
        if not (ascending and all(math.isfinite(number) for number in (*self.angle_rad, *self.error_mm))):
            raise TrueloopError(
                Code.SIM_TRANSFER,
                f"what the finish cut does otherwise is given by {len(self.angle_rad)} angles and "
                f"{len(self.error_mm)} errors",
                hint="give contact angles in ascending order and an error for each, or neither",
                values={"angles": len(self.angle_rad), "errors": len(self.error_mm)},
            )

    def displacement_mm(self, path: CentrePath) -> Array:
        """Displacement of the nose centre, (n, 2)."""
        if not self.angle_rad:
            return np.zeros_like(path.centre_mm)
        error = np.interp(contact_angle_rad(path.normal), self.angle_rad, self.error_mm)
        return np.asarray(error[:, None] * path.normal)


SAME: Final = Transfer()
"""A finish cut that does what the cuts before it did."""
