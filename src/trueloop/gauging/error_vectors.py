"""Error vectors: what every gauging point says of the part, along the nominal normal."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trueloop.geometry.feature import Array


@dataclass(frozen=True)
class ErrorVectors:
    """Part errors at gauging points, ordered along the profile; all arrays have shape (n,) but the last two (n, 2).

    `error_mm` is `n · (measured − nominal)`: positive = material left on [6876 glossary, PARTERROR]. `standard_u_mm` is
    its standard uncertainty from gauging. `at_reference` marks the points whose error is zero by definition, because
    the part's z was taken from them [6811 §5.1].
    """

    point: tuple[str, ...]
    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    error_mm: Array
    standard_u_mm: Array
    at_reference: NDArray[np.bool_]
    nominal_mm: Array
    outward_normal: Array

    def of_feature(self, index: int) -> NDArray[np.intp]:
        """Positions of the gauging points that lie on feature `index`, in order of arc length."""
        return np.flatnonzero(self.feature_index == index)

    @property
    def own_u_mm(self) -> Array:
        """What of `standard_u_mm` differs from touch to touch, (n,): without what all have from the reference point."""
        reference = np.flatnonzero(self.at_reference)
        if not len(reference):
            return self.standard_u_mm
        k = reference[0]
        shared = self.outward_normal[:, 1] / self.outward_normal[k, 1] * self.standard_u_mm[k]
        own = np.sqrt(np.maximum(self.standard_u_mm**2 - shared**2, 0.0))
        return np.where(self.at_reference, self.standard_u_mm, own)
