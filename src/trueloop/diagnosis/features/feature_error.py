"""Errors of features by name: what a diagnosis reasons about."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from trueloop.geometry.feature import Feature


@dataclass(frozen=True)
class FeaturePlace:
    """Where a feature is: `kind` "shaft", "face", "cone" or "arc"; x as a radius and z in the part's frame, mm.

    `z_mm` and `radius_mm` are ranges, low to high. `tool` is the name of the tool that finished it. `shape` is its line
    or arc, by which measured values are matched with it; None: they say themselves which feature they are of.
    """

    name: str
    kind: str
    radius_mm: tuple[float, float]
    z_mm: tuple[float, float]
    tool: str = ""
    shape: Feature | None = None


class ErrorKind(StrEnum):
    """Feature errors [4773 §4.2 a–f]; roundness, one wave a turn and three waves, is our own."""

    RADIUS = "radius"  # a: mean error along the normal of a shaft, near the chuck
    LENGTH = "length"  # b: error of the farther face less that of the nearer one, along z
    SHAFT_TAPER = "taper of a shaft"  # c: error at the free end less that near the chuck
    FACE_TAPER = "taper of a face"  # d: error at the largest radius less that at the smallest
    EDGE = "edge"  # e: no touch sees it
    STRAIGHTNESS = "straightness"  # f: peak to valley of what is smooth, line taken out
    WAVINESS = "waviness"  # f: root mean square of what is neither smooth nor noise of the device
    ECCENTRICITY = "eccentricity"  # amplitude of one wave a turn
    LOBING = "lobing"  # amplitude of three waves a turn


@dataclass(frozen=True)
class FeatureError:
    """One error of one feature: `value_mm` with its standard uncertainty and degrees of freedom (None: known).

    Radius, length and tapers are signed, positive where material is left on; the others are sizes. `other` is the
    nearer face of a length. `points` were used. `more` holds further numbers by names that end with their unit.
    """

    feature: str
    kind: ErrorKind
    value_mm: float
    standard_u_mm: float
    points: int
    degrees_of_freedom: int | None = None
    other: str = ""
    more: Mapping[str, float] = field(default_factory=dict)
