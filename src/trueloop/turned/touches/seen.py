"""A reading as a functional of the part's errors: a weighted sum of them over places of the profile."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, by_content


@by_content
@dataclass(frozen=True)
class Seen:
    """One reading as it sees the error curves: `value_mm` = Σ weight · e(feature, arc length), arrays of shape (n,).

    `standard_u_mm` is that of the value, from gauging alone; 0: it holds by definition. `value_mm` is a deviation,
    actual − nominal, in mm and of an angle in rad, whose weights then are per mm.
    """

    name: str
    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    weight: Array
    value_mm: float
    standard_u_mm: float

    @classmethod
    def at(cls, name: str, places: "tuple[tuple[int, float, float], ...]", value_mm: float, u_mm: float) -> "Seen":
        """Of places (feature, arc length, weight)."""
        index, along, weight = zip(*places, strict=True)
        return cls(name, np.array(index, dtype=np.intp), np.array(along), np.array(weight), value_mm, u_mm)

    def less(self, error_mm: Array) -> "Seen":
        """Returns the functional of the remainder when these errors, (n,) at its places, are taken out."""
        return replace(self, value_mm=self.value_mm - float(self.weight @ error_mm))
