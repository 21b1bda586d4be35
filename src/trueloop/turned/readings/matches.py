"""The result for each value of an inspection: matched with a feature, kept as no error of the profile, or neither."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from trueloop.domain.inspection import CmmPoint, Reading, Touch
from trueloop.turned.readings.matched import By, MatchedReading

Axis: TypeAlias = Literal["x", "y", "z", "-x", "-y", "-z"]
"""The axis of an inspection's frame that runs along the spindle; minus: towards the chuck."""


@dataclass(frozen=True, slots=True)
class MatchedTouch:
    """A touch of the part's plane (x, z) with the feature it is on, by its index.

    `distance_mm` is how far the nominal point is from the feature; of a point without one, which has the nearest place
    as its nominal, how far the surface that was touched is. `touch.error_mm` is the part error: the ball is taken off.
    """

    touch: Touch
    feature_index: int
    by: By
    distance_mm: float


@dataclass(frozen=True)
class Left:
    """A value that was not matched, why, and the features that it may be of, where there are several.

    `is_error`: whether it is an error of the profile at all; runout, form and positions are not, and are kept.
    """

    value: Reading | Touch | CmmPoint
    reason: str
    candidates: tuple[str, ...] = ()
    is_error: bool = True


@dataclass(frozen=True)
class Matches:
    """An inspection on a profile. `axis` is that of its frame along the spindle; None where it has no points."""

    readings: tuple[MatchedReading, ...]
    touches: tuple[MatchedTouch, ...]
    left: tuple[Left, ...]
    axis: Axis | None = None

    @property
    def unmatched(self) -> tuple[Left, ...]:
        """Returns the values that should be errors of the profile, of a feature that was not identified."""
        return tuple(one for one in self.left if one.is_error)

    @property
    def kept(self) -> tuple[Left, ...]:
        """Values that are no errors of the profile."""
        return tuple(one for one in self.left if not one.is_error)

    @property
    def count(self) -> int:
        """Returns how many values were matched."""
        return len(self.readings) + len(self.touches)
