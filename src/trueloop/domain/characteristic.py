"""Characteristics: what a drawing asks of a part, each with its nominal value and limits."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal, TypeAlias


class Quantity(StrEnum):
    """The quantity of a characteristic."""

    DIAMETER = "diameter"
    RADIUS = "radius"
    LENGTH = "length"  # the distance of two features, or of one from the part's zero; of a turned part along z
    ANGLE = "angle"  # degrees; of a turned part between a feature and the axis
    RUNOUT = "runout"  # repeats with the turn of the part: no error of its profile
    POSITION = "position"  # one coordinate of a feature
    FORM = "form"  # straightness, roundness, flatness, profile: never negative
    OTHER = "other"

    @property
    def unit(self) -> str:
        """Returns the unit of its values: millimetres, or degrees of an angle."""
        return "deg" if self is Quantity.ANGLE else "mm"

    @property
    def is_zone(self) -> bool:
        """Returns whether a value is the width of a zone, which counts from 0 and is never negative."""
        return self in (Quantity.RUNOUT, Quantity.FORM)


@dataclass(frozen=True)
class Characteristic:
    """One size as the drawing asks for it, in mm, of angles in degrees; a diameter is a diameter.

    `feature` is that of the part's profile; `other` the one from which a length counts, empty: from the part's zero.
    `at_z_mm`: where along the feature it holds; None: everywhere. Limits are absolute; None: no limit on that side.
    `tolerance` is how the drawing says them: "h6", "ISO 2768-m", "±0.02".
    """

    name: str
    quantity: Quantity
    feature: str
    nominal: float
    lower_limit: float | None = None
    upper_limit: float | None = None
    other: str = ""
    at_z_mm: float | None = None
    tolerance: str = ""


Verdict: TypeAlias = Literal["in", "out", "undecided"]
"""By ISO 14253-1: proven inside, proven outside, or neither with the stated uncertainty."""


@dataclass(frozen=True)
class Judgement:
    """One value of a characteristic held against its limits; mm, of angles degrees.

    `standard_u` is the standard uncertainty of `value` with `degrees_of_freedom` (None: as good as infinite).
    `probability_in` is that of being inside the limits; `margin` the distance to the nearer limit, negative outside.
    Without limits there is nothing to judge: all three are None.
    """

    value: float
    standard_u: float
    degrees_of_freedom: int | None
    probability_in: float | None
    margin: float | None
    verdict: Verdict | None


@dataclass(frozen=True)
class Judged:
    """One characteristic: `before` of the part as it was measured, `after` as expected of the next cut.

    `before` is None where the part was measured before its finish cut, so that it has the allowance left on.
    """

    characteristic: Characteristic
    before: Judgement | None
    after: Judgement
