"""How far the commanded contour of one feature is moved along its outward normal, as a function of arc length."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from trueloop.arrays import Array

ShiftFunction: TypeAlias = Callable[[ArrayLike], Array]


@dataclass(frozen=True)
class Shift:
    """Displacement along the outward normal in mm (positive = away from the material) and its slope, of arc length."""

    value_mm: ShiftFunction
    slope: ShiftFunction


ZERO = Shift(value_mm=lambda s: np.zeros(np.shape(s)), slope=lambda s: np.zeros(np.shape(s)))
"""A feature that stays where it is."""


def weighted_sum(parts: tuple[tuple[float, Shift], ...]) -> Shift:
    """Σ weight · shift."""

    def value_mm(s: ArrayLike) -> Array:
        return np.asarray(sum(weight * part.value_mm(s) for weight, part in parts))

    def slope(s: ArrayLike) -> Array:
        return np.asarray(sum(weight * part.slope(s) for weight, part in parts))

    return Shift(value_mm, slope)


def sampled(arc_length_mm: Array, values_mm: Array) -> Shift:
    """The piecewise linear shift through samples (n,), carried on straight beyond the first and last.

    A constant through one sample. Sample positions ascend.
    """
    if len(arc_length_mm) == 1:
        constant = float(values_mm[0])
        return Shift(lambda s: np.full(np.shape(s), constant), ZERO.slope)
    slopes = np.diff(values_mm) / np.diff(arc_length_mm)

    def interval(s: ArrayLike) -> "np.ndarray[tuple[int], np.dtype[np.intp]]":
        return np.clip(np.searchsorted(arc_length_mm, np.asarray(s), side="right") - 1, 0, len(slopes) - 1)

    def value_mm(s: ArrayLike) -> Array:
        k = interval(s)
        return np.asarray(values_mm[k] + slopes[k] * (np.asarray(s) - arc_length_mm[k]))

    return Shift(value_mm, lambda s: np.asarray(slopes[interval(s)]))
