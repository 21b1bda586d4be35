"""The additions of a correction along one move of the control, by share of the move, 0 to 1.

In (x as a radius, z), mm. Where the move cuts, it is the corrected path of the nose's centre less the commanded one at
the same place of the part; before and after, it fades as the ends of those moves do in the corrected program.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from trueloop.arrays import Array
from trueloop.turned.compensation.contour import ShiftedFeature
from trueloop.turned.compensation.moves import Move
from trueloop.turned.compensation.targets import CutEnds


class Added(Protocol):
    """The addition at shares (n,) of a move, (n, 2)."""

    def at(self, share: Array) -> Array:
        """Returns the addition by share of the move's length, or of an arc's angle."""


@dataclass(frozen=True)
class Fading:
    """From one vector evenly to another: a straight move whose ends are displaced."""

    start_mm: Array
    end_mm: Array

    def at(self, share: Array) -> Array:
        """Returns the addition between both ends."""
        return np.asarray(self.start_mm + share[:, None] * (self.end_mm - self.start_mm))


@dataclass(frozen=True)
class AboutCorner:
    """An arc about an edge, and the same between displaced ends."""

    before: Move
    after: Move

    def at(self, share: Array) -> Array:
        """Returns the difference of both at the same share of either angle."""
        return _along(self.after, share) - _along(self.before, share)


@dataclass(frozen=True)
class Cutting:
    """A move that cuts a feature: from the commanded path of the nose's centre to the corrected one, each between its
    own ends, so that corners go to corners. `offset_mm` comes on top.
    """

    before: ShiftedFeature
    after: ShiftedFeature
    ends_before: CutEnds
    ends_after: CutEnds
    offset_mm: Array

    def at(self, share: Array) -> Array:
        """Returns the correction at these shares."""
        was = self.before.centre_mm(_between(self.ends_before, share))
        return np.asarray(self.after.centre_mm(_between(self.ends_after, share)) - was + self.offset_mm)


def _between(ends: CutEnds, share: Array) -> Array:
    return np.asarray(ends.start_mm + share * (ends.end_mm - ends.start_mm))


def _along(move: Move, share: Array) -> Array:
    """Points of an arc at shares of its angle; a positive sweep is clockwise, z to the right and x up."""
    assert move.centre_mm is not None
    centre = np.asarray(move.centre_mm)
    x, z = np.asarray(move.start_mm) - centre
    angle = np.arctan2(x, z) - share * move.sweep_rad
    return np.asarray(centre + np.hypot(x, z) * np.stack([np.sin(angle), np.cos(angle)], axis=1))
