"""The frame of a set-up: where the zero of its program lies on the part, and which way its Z points.

In a set-up in which the part is turned round, or the control mirrors Z, the program's +Z points to the part's −z. X is
the same in all set-ups. A profile seen so runs the other way: mirrored alone, its material would be on the left.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.curve import Curve, mapped
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.profile import Profile


@dataclass(frozen=True)
class SetupFrame:
    """The program's Z is 0 at z = `zero_at_z_mm` of the part; its +Z points to the part's +z, or to −z where the part
    is turned round (`flipped`) or the control mirrors Z (`mirrored_z`).
    """

    name: str
    zero_at_z_mm: float = 0.0
    flipped: bool = False
    mirrored_z: bool = False

    @property
    def backwards(self) -> bool:
        """Returns whether the program's +Z points to the part's −z."""
        return self.flipped or self.mirrored_z

    @property
    def sign(self) -> float:
        """Returns the change of Z per change of the part's z: 1 or −1."""
        return -1.0 if self.backwards else 1.0

    @property
    def the_other_way(self) -> "SetupFrame":
        """Returns a frame with this zero and Z reversed."""
        return replace(self, flipped=not self.backwards, mirrored_z=False)

    @property
    def back(self) -> "SetupFrame":
        """Returns the frame that maps the program's places to those of the part: z = zero ± Z."""
        return replace(self, zero_at_z_mm=-self.sign * self.zero_at_z_mm)

    @property
    def words(self) -> str:
        """Returns the equation of the program's Z by the part's z, mm: `Z = −80.0000 − z`, `Z = z + 80.0000`."""
        sized = f"{abs(self.zero_at_z_mm):.4f}"
        below = self.zero_at_z_mm < 0.0
        if self.backwards:
            return f"Z = {'−' if below else ''}{sized} − z"
        return f"Z = z {'+' if below else '−'} {sized}" if self.zero_at_z_mm else "Z = z"

    def z_mm(self, part_z_mm: float) -> float:
        """Returns the program's Z of a z of the part."""
        return self.sign * (part_z_mm - self.zero_at_z_mm)

    def point(self, point_mm: Point) -> Point:
        """Returns the program's (x, Z), x a radius, of a point of the part."""
        x, z = point_mm
        return x, self.z_mm(z)

    def points(self, points_mm: ArrayLike) -> Array:
        """Returns the program's (x, Z) of points (..., 2)."""
        return (np.asarray(points_mm, dtype=np.float64) - [0.0, self.zero_at_z_mm]) * [1.0, self.sign]

    def directions(self, of_part: ArrayLike) -> Array:
        """Directions (..., 2) of the part as those of the program."""
        return np.asarray(of_part, dtype=np.float64) * [1.0, self.sign]

    def feature(self, feature: Feature) -> Feature:
        """Maps a feature of the part into the program's frame, its material on the right again."""
        placed = self._placed(feature)
        return placed.reversed() if self.backwards else placed

    def _placed(self, feature: Feature) -> Feature:
        if isinstance(feature, Curve):
            return mapped(feature, np.diag([1.0, self.sign]), self.points([0.0, 0.0]))
        start, end = self.point(feature.start_mm), self.point(feature.end_mm)
        if isinstance(feature, Line):
            return Line(feature.name, start, end)
        return Arc(feature.name, start, end, self.point(feature.centre_mm), self.sign * feature.sweep_rad)

    def profile(self, profile: Profile) -> Profile:
        """Maps the part's profile into the program's frame: in the opposite order where Z points backwards.

        Junctions are the same: who goes the other way about a corner that was mirrored turns as before.
        """
        features = tuple(self.feature(feature) for feature in profile.features)
        if not self.backwards:
            return replace(profile, features=features)
        return replace(profile, features=features[::-1], junctions=profile.junctions[::-1])


PART: Final = SetupFrame("")
"""The frame of a part with one set-up: the part's own."""
