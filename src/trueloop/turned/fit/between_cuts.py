"""The differences of the finish cut from the semi-finish cut, before anything is known of them: a prior.

One part's touches show how the semi-finish cut scatters along itself. They do not show what comes out differently in
the next cut: the correction takes out the errors of a cut that is over. In turning in general, standard deviations:

| of the finish cut against the semi-finish cut | common to the cut | varies along it |
|---|--:|--:|
| turret indexed for the probe and back, slides reversed (ISO 230-2: R of 3 to 6 µm, four deviations) | 1.5 µm | |
| heat: 10 to 20 µm an hour while a machine warms up (ISO 13041-8), some minutes of probing | 2 µm | 0.5 µm |
| the edge: wear, built-up edge, thinnest chip, which go by contact angle and cutting speed | 1 µm | 2 µm |
| ball radius and pre-travel of the probe, as calibrated | 1 µm | 0.5 µm |
| root of the sum of squares | 2.9 µm | 2.1 µm |

Either cut brings half of the variance: 2 µm that move a whole cut, along x and z each, and 1.5 µm that vary along it.
The figures are of machines in good order and of small, equal depths of cut; they hold neither a change of tool or feed
between the cuts nor a finish cut of another depth. They were set before they were held against measured parts
(docs/nist-parts.md), and give way to what is known: the job's figures, or what earlier parts of the tool have shown.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.wording import wording


@dataclass(frozen=True)
class BetweenCuts:
    """Standard deviations of one cut, mm: the cut that was touched and the next one both bring their share.

    `common_mm` moves a whole cut, along x and z each, and so along any normal; `scatter_mm` varies along the cut, over
    more than the distance of touches. `source` says in words where the figures come from.
    """

    common_mm: float
    scatter_mm: float
    source: str

    @property
    def common_difference_mm(self) -> float:
        """Returns the standard uncertainty along the normal of the next cut's displacement against the one touched."""
        return math.sqrt(2.0) * self.common_mm

    @property
    def scatter_difference_mm(self) -> float:
        """Returns the standard uncertainty along the normal of the differences that vary along the cut."""
        return math.sqrt(2.0) * self.scatter_mm

    @property
    def difference_mm(self) -> float:
        """Returns both together, at one place."""
        return math.hypot(self.common_difference_mm, self.scatter_difference_mm)

    def covariance_mm2(self, normal: Array, gains: Array, alike: Array) -> Array:
        """Returns the covariance of functionals (m, n) of the differences at n places with normals (n, 2), (m, m);
        `alike` (n, n) is the correlation of those that vary along the cut.
        """
        moved = gains @ normal * self.common_difference_mm
        return np.asarray(moved @ moved.T + gains @ alike @ gains.T * self.scatter_difference_mm**2)


PRIOR: Final = BetweenCuts(0.002, 0.0015, wording("prior for turning in general"))
"""The assumption where nothing is known of the differences of cuts."""

NONE: Final = BetweenCuts(0.0, 0.0, wording("switched off"))
"""Two cuts of one process that differ by nothing but their scatter."""


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
