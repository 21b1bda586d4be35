"""The prior knowledge of a chain's next cut, beside its curve."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, by_content


@by_content
@dataclass(frozen=True)
class NextCut:
    """The prediction of the next cut of a chain, at n arc lengths along it: expected error and standard uncertainty,
    mm.

    The uncertainty holds everything, the scatter of that cut and what it does otherwise included. A correction of 1 is
    expected to take off `gain`.
    """

    arc_length_mm: Array
    mean_mm: Array
    standard_u_mm: Array
    gain: float

    def expected_mm(self, arc_length_mm: Array) -> Array:
        """Returns the expected error, (k,)."""
        return np.atleast_1d(np.interp(arc_length_mm, self.arc_length_mm, self.mean_mm))

    def u_mm(self, arc_length_mm: Array) -> Array:
        """Returns its standard uncertainty, (k,)."""
        return np.atleast_1d(np.interp(arc_length_mm, self.arc_length_mm, self.standard_u_mm))
