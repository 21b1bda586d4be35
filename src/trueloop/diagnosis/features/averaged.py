"""Readings of one point taken together: their mean, with what they scatter by in its uncertainty."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.diagnosis.features.seen_points import SeenPoints

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
    the offset of the probe) is no part of u, and is not averaged away by it: it is a cause to be found.
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
        points.nominal_mm[first],
        points.normal[first],
        mean,
        np.sqrt((chi_squared / spare if excess else 1.0) / total),
        points.spindle_rad[first],
        len(u),
        spare if excess else None,
    )


def _same_point(points: SeenPoints) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], int]:
    """Number of the point of every reading, from 0, and how many points there are."""
    angle = np.where(np.isnan(points.spindle_rad), -1.0, np.mod(points.spindle_rad, 2.0 * np.pi))
    places = np.round(np.column_stack([points.nominal_mm, angle]), DECIMALS)
    numbers: dict[tuple[float, ...], int] = {}
    which = np.array([numbers.setdefault(tuple(row), len(numbers)) for row in places.tolist()], dtype=np.intp)
    return which, len(numbers)
