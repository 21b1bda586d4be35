"""What earlier parts of the edge and today's touches together say of arcs, as a table over contact angle.

Errors of an arc are the nose's, by contact angle, and what one finish cut does otherwise than its semi-finish cut
repeats from part to part. Who knows earlier parts of the edge fills this table; the fit takes it for the error of the
next cut, and today's touches are in it already. It says nothing of straight features: cones deviate by 11 to 30 µm
from what the same nose did on domes [6811 Tables 8, 10].
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.chain import Chain

GRID_RAD: Final = math.radians(1.0)
"""Steps of the table. A nose whose form turns by 20 µm within 20° deviates from straight steps by 0.01 µm."""


@by_content
@dataclass(frozen=True)
class Remembered:
    """Errors of the next cut had nothing been corrected, at n contact angles, ascending; positive = material left on.

    `mean_mm` (n,) is expected, `covariance_mm2` (n, n) that of the next cut's error about it, its scatter included:
    nothing is to be added for what cuts do differently. A correction of 1 is expected to take off `gain`, so that
    `correct_mm` (n,) is what to correct by. It holds for the arcs `features`, by index. `corrects`: False where the
    correction is the touches' own curve, and the table only says what that leaves.
    """

    contact_angle_rad: Array
    mean_mm: Array
    covariance_mm2: Array
    correct_mm: Array
    features: tuple[int, ...]
    gain: float = 1.0
    corrects: bool = True

    @property
    def standard_u_mm(self) -> Array:
        """Standard uncertainty of the next cut's error about the mean, (n,)."""
        return np.sqrt(np.diag(self.covariance_mm2))

    def at(self, table: Array, angle_rad: Array) -> Array:
        """Values of the table (n,) or (n, m) at contact angles (k,), in straight steps."""
        grid = self.contact_angle_rad
        upper = np.clip(np.searchsorted(grid, angle_rad), 1, len(grid) - 1)
        share = np.clip((angle_rad - grid[upper - 1]) / (grid[upper] - grid[upper - 1]), 0.0, 1.0)
        share = share.reshape(-1, *(1,) * (table.ndim - 1))
        return np.asarray((1.0 - share) * table[upper - 1] + share * table[upper])

    def knows(self, chain: Chain) -> bool:
        """Whether it tells all of a chain."""
        return set(chain.features) <= set(self.features)


def grid_of(profile: Profile, features: Iterable[int]) -> Array:
    """Contact angles for a table that holds for some arcs of a profile, by index: their ends, and steps, (n,)."""
    angles = [angles_along(profile, i)[1] for i in features]
    low_high = [(float(np.min(angle)), float(np.max(angle))) for angle in angles]
    inside = [
        GRID_RAD * k
        for low, high in low_high
        for k in range(math.ceil(low / GRID_RAD), math.floor(high / GRID_RAD) + 1)
    ]
    return np.unique(np.round([*inside, *(end for ends in low_high for end in ends)], 9))


def angles_along(profile: Profile, index: int) -> tuple[Array, Array]:
    """Arc lengths along a feature, its ends among them, at most a step of contact angle apart; and these angles."""
    feature = profile.features[index]
    turn = feature.length_mm * abs(float(feature.curvature_per_mm(0.0)))
    s = np.linspace(0.0, feature.length_mm, max(math.ceil(turn / GRID_RAD - 1e-9), 8) + 1)
    return s, profile.contact_along_rad(index, s)
