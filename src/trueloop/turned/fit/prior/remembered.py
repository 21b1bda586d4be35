"""The prediction of the next cut from earlier parts of the edge and today's touches, along the features of a profile.

Who knows earlier parts of the edge fills this table; the fit takes it for the error of the next cut, and today's
touches are in it already.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, by_content
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.chain import Chain

GRID_RAD: Final = math.radians(0.5)
"""Steps of the table. A nose whose form turns by 20 µm within 20° deviates from straight steps by 0.01 µm."""


@by_content
@dataclass(frozen=True)
class Remembered:
    """The errors of the next cut had nothing been corrected, at n places; positive = material left on.

    Places are by feature index and arc length, (n,), those of a feature ascending from its start to its end. `mean_mm`
    (n,) is expected, `covariance_mm2` (n, n) that of the next cut's error about it, its scatter included: nothing is to
    be added for what cuts do differently. A correction of 1 is expected to take off `gain`, so that `correct_mm` (n,)
    is what to correct by. `corrects`: False where the correction is the touches' own curve, and the table only says
    what that leaves.
    """

    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    mean_mm: Array
    covariance_mm2: Array
    correct_mm: Array
    gain: float = 1.0
    corrects: bool = True

    def knows(self, chain: Chain) -> bool:
        """Returns whether it has all of a chain."""
        return set(chain.features) <= set(self.feature_index.tolist())

    def of(self, chain: Chain) -> tuple[NDArray[np.intp], Array]:
        """Returns which of the places lie on a chain, in their order along it, and arc lengths along it, (k,)."""
        rows = [np.flatnonzero(self.feature_index == i) for i in chain.features]
        s = [start + self.arc_length_mm[at] for start, at in zip(chain.starts_mm, rows, strict=True)]
        return np.concatenate(rows), np.concatenate(s)


def angles_along(profile: Profile, index: int) -> tuple[Array, Array]:
    """Returns arc lengths along a feature, its ends among them, a step of contact angle apart at most; these angles."""
    feature = profile.features[index]
    turn = feature.length_mm * abs(float(feature.curvature_per_mm(0.0)))
    s = np.linspace(0.0, feature.length_mm, max(math.ceil(turn / GRID_RAD - 1e-9), 8) + 1)
    return s, profile.contact_along_rad(index, s)
