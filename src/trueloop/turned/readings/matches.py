"""The result for each value of an inspection: matched with a feature, kept as no error of the profile, or neither."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from trueloop.domain.inspection import CmmPoint, Reading, Touch, index_of_name
from trueloop.geometry.profile import Profile

By: TypeAlias = Literal["name", "geometry"]


@dataclass(frozen=True)
class MatchedReading:
    """A reading with the feature it is of, by its index in the profile.

    `other_index` is the feature from which a length counts; None: it counts from the part's zero, or is not a length.
    `by`: found by the feature's name, or by place and nominal value; then `distance_mm` is how far these are from the
    feature's own.
    """

    reading: Reading
    feature_index: int
    other_index: int | None = None
    by: By = "name"
    distance_mm: float = 0.0


def match_by_name(profile: Profile, reading: Reading) -> MatchedReading | None:
    """Returns the reading on the feature that it names; None where it names none of the profile's.

    A length whose `other` is not empty needs both by name. A reading without a feature is taken by its characteristic.
    """
    index = feature_named(profile, reading.feature or reading.characteristic)
    other = feature_named(profile, reading.other) if reading.other else None
    if index is None or (reading.other and other is None):
        return None
    return MatchedReading(reading, index, other)


def feature_named(profile: Profile, name: str) -> int | None:
    """Returns the index of the feature of that name, as `index_of_name` finds it."""
    return index_of_name(profile.names, name)


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
        return tuple(left for left in self.left if left.is_error)

    @property
    def kept(self) -> tuple[Left, ...]:
        """Values that are not errors of the profile."""
        return tuple(left for left in self.left if not left.is_error)

    @property
    def count(self) -> int:
        """Returns how many values were matched."""
        return len(self.readings) + len(self.touches)
