"""Errors at points of a turned part's surface, as one device saw them."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, Integers, by_content


@by_content
@dataclass(frozen=True)
class SeenPoints:
    """n points of one part: `feature` their names, `nominal_mm` (n, 2) x as a radius and z in the part's frame.

    `normal` (n, 2) is outward, (x, z). `error_mm` (n,) is along it, positive where material is left on, with standard
    uncertainties `standard_u_mm` (n,). `spindle_rad` (n,) is the angle of the part about its axis, NaN where it is not
    known. `repeat` (n,) counts readings of one point, from 1.
    """

    feature: tuple[str, ...]
    nominal_mm: Array
    normal: Array
    error_mm: Array
    standard_u_mm: Array
    spindle_rad: Array
    repeat: Integers

    def of(self, feature: str) -> "SeenPoints":
        """Those of one feature."""
        rows = np.array([name == feature for name in self.feature], dtype=bool)
        names = tuple(name for name in self.feature if name == feature)
        arrays = (self.nominal_mm, self.normal, self.error_mm, self.standard_u_mm, self.spindle_rad, self.repeat)
        return SeenPoints(names, *(values[rows] for values in arrays))
