"""The prediction of the next finish cut from memory and today's touches together."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array, Integers, by_content


@by_content
@dataclass(frozen=True)
class Expected:
    """The finish error had nothing been corrected, at n places: E_k given earlier parts and own touches, mm.

    `mean_mm` (n,) is the correction that takes it all out, so it is already divided by `gain`, what the actuator makes
    of a correction of 1, with standard uncertainty `gain_u`. `covariance_mm2` (n, n) is that of one part's error once
    the mean is corrected, scatter of the cut included: predicted error after the correction is 0 ± 1.96 √diag.
    `memory_mm` (n,) is the share of the mean that there would be without a touch of today; `weight` (n,) the share of
    the mean to command (1: all; less until an inspected part confirms the first correction). `own_fit`: correct by the
    fit of today's touches instead of the mean, as for the first part of an edge. `feature_index` and `arc_length_mm`
    (n,) say where on the profile the places are; None: nowhere in particular.

    `parts` is the number of inspected parts behind it; `nearest_rad` (n,) how far the nearest contact angle seen by
    them or by today's touches is. `enough_touches` is the number of today's touches, placed best, that would have given
    standard uncertainties within 10 % of these: advice for the next plan.
    """

    contact_angle_rad: Array
    mean_mm: Array
    covariance_mm2: Array
    memory_mm: Array
    weight: Array
    nearest_rad: Array
    parts: int
    enough_touches: int
    notes: tuple[str, ...] = ()
    gain: float = 1.0
    gain_u: float = 0.0
    own_fit: bool = False
    feature_index: Integers | None = None
    arc_length_mm: Array | None = None

    def rows(self, feature: int) -> Integers:
        """Returns which of the places lie on a feature of the profile, by index, in order of arc length; none where the
        prediction is by contact angle alone.
        """
        return np.flatnonzero(np.array([]) if self.feature_index is None else self.feature_index == feature)

    def along(self, values_mm: Array, feature: int, arc_length_mm: ArrayLike) -> Array:
        """Values at the places, (n,), at arc lengths (k,) of a feature, in straight steps; 0 where it has no place."""
        rows, s = self.rows(feature), np.atleast_1d(np.asarray(arc_length_mm, dtype=np.float64))
        if not len(rows) or self.arc_length_mm is None:
            return np.zeros(len(s))
        return np.asarray(np.interp(s, self.arc_length_mm[rows], values_mm[rows]))
