"""The match of a program with a profile: the moves of each feature, and the deviation of the commanded contour."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature, Line, LineOrArc
from trueloop.geometry.profile import Profile
from trueloop.nc.program.feed_moves import FeedMove


@dataclass(frozen=True)
class MatchedMove:
    """One move that cuts a feature.

    `start_mm` and `end_mm` are the arc lengths, on the nominal feature, of the feet of the move's ends: less than 0 or
    more than the feature's length where it runs beyond, falling in a reversed program.
    """

    move: FeedMove
    start_mm: float
    end_mm: float


@dataclass(frozen=True)
class FeatureMatch:
    """The moves that cut one feature, in order of arc length. `offset_mm` is nose radius plus allowance."""

    feature: Feature
    moves: tuple[MatchedMove, ...]
    backwards: bool
    offset_mm: float

    def deviation_mm(self, arc_length_mm: ArrayLike) -> Array:
        """Returns the commanded contour's deviation from nominal (plus allowance) along the normal, (...) → (...).

        Measured from the nominal centre path to the commanded one along the nominal normal, which equals the distance
        of the contours up to R·slope²/2. Exact and linear for a line on a line. Beyond the first and last move these
        go on along their line or circle.
        """
        s = np.asarray(arc_length_mm, dtype=np.float64)
        normal = self.feature.outward_normal(s)
        origin = self.feature.point_mm(s) + self.offset_mm * normal
        turns = np.array([max(min(m.start_mm, m.end_mm), 0.0) for m in self.moves[1:]])
        piece = np.searchsorted(turns, s, side="right")
        deviation = np.empty_like(s)
        for k, matched in enumerate(self.moves):
            here = piece == k
            deviation[here] = _along_normal(matched.move.path, origin[here], normal[here])
        return deviation


@dataclass(frozen=True)
class ContourMatch:
    """All features of a profile with the moves that cut them.

    Of the other moves in the same uninterrupted chains of feed moves, `lead` come before or after (approach, pull-out),
    `run_out` only lengthen the profile's first or last feature beyond its end, and `between` lie between two features
    (an arc about an edge, say). Sorted by their place in the program.
    """

    profile: Profile
    features: tuple[FeatureMatch, ...]
    lead: tuple[FeedMove, ...]
    run_out: tuple[FeedMove, ...]
    between: tuple[FeedMove, ...]

    @property
    def on_contour(self) -> bool:
        """Returns whether the moves are those of the contour, under G41 or G42, and not of the nose's centre."""
        return self.features[0].moves[0].move.on_contour


def _along_normal(commanded: LineOrArc, origin: Array, normal: Array) -> Array:
    """Signed distance from `origin` (n, 2) along `normal` to the line or circle of a move: the nearer crossing."""
    if isinstance(commanded, Line):
        across = commanded.outward_normal(0.0)
        to_line: Array = (np.asarray(commanded.start_mm) - origin) @ across / (normal @ across)
        return to_line
    from_centre = origin - np.asarray(commanded.centre_mm)
    along = np.einsum("ij,ij->i", normal, from_centre)
    power = np.einsum("ij,ij->i", from_centre, from_centre) - commanded.radius_mm**2
    to_circle: Array = -power / (along + np.copysign(np.sqrt(np.maximum(along**2 - power, 0.0)), along))
    return to_circle
