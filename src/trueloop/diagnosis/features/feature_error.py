"""Errors of features by name: what a diagnosis reasons about."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers, by_content
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


@by_content
@dataclass(frozen=True)
class SeenPoints:
    """n points of one part: `feature` their names, `nominal_mm` (n, 2) x as a radius and z in the part's frame.

    `normal` (n, 2) is outward, (x, z). `error_mm` (n,) is along it, positive where material is left on, with standard
    uncertainties `standard_u_mm` (n,). `spindle_rad` (n,) is the angle of the part about its axis, NaN where it is not
    known. `repeat` (n,) counts readings of one point, from 1.
    """

    feature: tuple[str, ...]
    nominal_mm: Array
    normal: Array
    error_mm: Array
    standard_u_mm: Array
    spindle_rad: Array
    repeat: Integers

    def of(self, feature: str) -> "SeenPoints":
        """Those of one feature."""
        rows = np.array([name == feature for name in self.feature], dtype=bool)
        names = tuple(name for name in self.feature if name == feature)
        arrays = (self.nominal_mm, self.normal, self.error_mm, self.standard_u_mm, self.spindle_rad, self.repeat)
        return SeenPoints(names, *(values[rows] for values in arrays))


DECIMALS: Final = 6
"""Two nominal points (mm), or two angles (rad), that agree so far are one."""
EXACT_MM: Final = 1e-9
"""Standard uncertainty of a point that is stated to have none: a datum, which is zero by definition."""


@by_content
@dataclass(frozen=True)
class Averaged:
    """m different points of one feature, arrays as in SeenPoints; `readings` were averaged.

    `degrees_of_freedom` are those of `standard_u_mm`; None: as stated by the device.
    """

    nominal_mm: Array
    normal: Array
    error_mm: Array
    standard_u_mm: Array
    spindle_rad: Array
    readings: int
    degrees_of_freedom: int | None


def averaged(points: SeenPoints) -> Averaged:
    """Means of the repeats, weighted by 1/u²; u of a mean of n is u/√n.

    Repeats that scatter by more than is stated, over all points of the feature together, enlarge every uncertainty by
    √(χ²/ν), which then has ν degrees of freedom. What all readings of a feature have in common (the radius of the ball,
    the offset of the probe) is not part of u, and is not averaged away by it: it is a cause to be found.
    """
    u = np.maximum(points.standard_u_mm, EXACT_MM)
    which, count = _same_point(points)
    weight = np.zeros((count, len(u)))
    weight[which, np.arange(len(u))] = u**-2.0
    total = weight.sum(axis=1)
    mean = weight @ points.error_mm / total
    first = np.array([int(np.flatnonzero(which == k)[0]) for k in range(count)], dtype=np.intp)
    spare = len(u) - count
    chi_squared = float(np.sum(((points.error_mm - mean[which]) / u) ** 2))
    excess = spare > 0 and chi_squared > spare
    return Averaged(
        nominal_mm=points.nominal_mm[first],
        normal=points.normal[first],
        error_mm=mean,
        standard_u_mm=np.sqrt((chi_squared / spare if excess else 1.0) / total),
        spindle_rad=points.spindle_rad[first],
        readings=len(u),
        degrees_of_freedom=spare if excess else None,
    )


def _same_point(points: SeenPoints) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], int]:
    """Number of the point of every reading, from 0, and how many points there are."""
    angle = np.where(np.isnan(points.spindle_rad), -1.0, np.mod(points.spindle_rad, 2.0 * np.pi))
    places = np.round(np.column_stack([points.nominal_mm, angle]), DECIMALS)
    numbers: dict[tuple[float, ...], int] = {}
    which = np.array([numbers.setdefault(tuple(row), len(numbers)) for row in places.tolist()], dtype=np.intp)
    return which, len(numbers)
