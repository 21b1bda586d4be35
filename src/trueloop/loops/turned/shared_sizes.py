"""Lengths between features that two edges cut: each edge's correction says where its own face will be, and how surely.

The two errors have nothing in common but the frame of the part, so that their variances add. Along one face all places
are taken to err together, which is on the safe side.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.judged import Judged
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART, SetupFrame
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.in_setup import index_in
from trueloop.loops.turned.outcome import expected_mm
from trueloop.nc.match.own_contour import OwnContour
from trueloop.statistics import NORMAL_95
from trueloop.tolerances.conformance import judge
from trueloop.turned.characteristics.measurand import measurand


@dataclass(frozen=True)
class Share:
    """What one edge cuts, and its correction; `frame` is that of the contour."""

    contour: OwnContour
    correction: Correction
    frame: SetupFrame = PART

    def cuts(self, profile: Profile, feature: int) -> bool:
        """Whether one of the part's features is cut by this edge."""
        placed = index_in(self.frame, feature, len(profile.features))
        return any(placed in parts for parts in self.contour.parts)

    def at(self, profile: Profile, feature: int, arc_length_mm: Array) -> tuple[Array, Array]:
        """Expected errors after the next cut and their standard uncertainties at places of one of the part's features.

        By an offset the program's own deviation stays; by the contour no more of it than the control resolves.
        """
        own, made = self.contour.index_of(index_in(self.frame, feature, len(profile.features))), self.correction
        points = self.frame.points(profile.features[feature].point_mm(arc_length_mm))
        s = np.array([float(self.contour.profile.features[own].locate(point)[0]) for point in points])
        kept = made.commanded[own].shifted.off_nominal_mm(s) if made.by_offset[own] else np.zeros(len(s))
        return expected_mm(made, own, s) + kept, made.next_cut(own, s).expanded_u_mm / NORMAL_95


def shared_sizes(
    profile: Profile, asked: Sequence[Characteristic], touched: Integers, shares: Sequence[Share]
) -> tuple[Judged, ...]:
    """Those characteristics that are lengths between two edges' features, judged as expected after the next cut.

    `touched` counts touches by feature. Lengths of an edge that was not measured are left out. Raises TOL errors.
    """
    found = (_judged(profile, one, touched, shares) for one in asked if one.quantity is Quantity.LENGTH and one.other)
    return tuple(one for one in found if one is not None)


def _judged(profile: Profile, asked: Characteristic, touched: Integers, shares: Sequence[Share]) -> Judged | None:
    sizes = measurand(profile, asked, np.asarray(touched, dtype=np.intp))
    gains, error_mm, variance = sizes.gains[0], np.zeros(len(sizes.feature_index)), 0.0
    cutting = []
    for feature in np.unique(sizes.feature_index):
        share = next((one for one in shares if one.cuts(profile, int(feature))), None)
        if share is None:
            return None
        cutting.append(share)
        rows = np.flatnonzero(sizes.feature_index == feature)
        error_mm[rows], u_mm = share.at(profile, int(feature), sizes.arc_length_mm[rows])
        variance += float(np.sum(np.abs(gains[rows])) * np.max(u_mm)) ** 2
    if len({id(one) for one in cutting}) < len(cutting):
        return None  # of one edge, which judges it by itself
    value = float(sizes.nominal[0] + gains @ error_mm)
    return Judged(asked, None, judge(value, variance**0.5, None, asked.lower_limit, asked.upper_limit))
