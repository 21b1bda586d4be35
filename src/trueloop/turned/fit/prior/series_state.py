"""The error of the next part of a series that was measured finished, by all of its parts.

Errors are those had nothing been corrected. The level of the parts walks, and what wears goes on: the state has both
(`estimate.catalogue`), with sizes that the parts before the latest show. A plain mean over earlier parts would lag
behind the wear; the latest part alone would hand its own clamping and its reading to the next.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from trueloop.arrays import Array
from trueloop.estimate.catalogue import PRIORS
from trueloop.estimate.observed import Observed
from trueloop.estimate.places import Places
from trueloop.estimate.sizes import fitted_sizes
from trueloop.estimate.state import Normal, State
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.prior.part_state import catalogue_of, in_frame, observed_of
from trueloop.turned.touches.error_vectors import ErrorVectors

WEAR_MM: Final = PRIORS["wear"].median
"""Wear to be expected, a part: an edge that wears leaves material on, along every normal."""

FITTED_PARTS: Final = 8
"""The largest number of parts to which sizes are fitted."""

BY_CHANCE: Final = 1e-3
"""A part that differs from the parts before it by so much that chance makes less than this share of parts do so is of
another series: the tool was set, or an insert changed."""


@dataclass(frozen=True, eq=False)
class SeriesState:
    """The state after the `parts` of a series, of which `vectors` is the latest."""

    profile: Profile
    vectors: ErrorVectors
    state: State
    parts: int

    def next_part(self, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Normal:
        """Predicts the errors of the next part at places (n,), its own scatter included."""
        places, functional = in_frame(self.profile, self.vectors, feature_index, arc_length_mm, float(self.parts))
        found = self.state.predict(places, functional)
        return Normal(found.mean_mm + functional @ _worn_mm(places), found.covariance_mm2)

    @property
    def wear_rate_mm(self) -> tuple[float, float]:
        """Returns the wear a part, and its standard uncertainty."""
        (where,) = (at for key, at in self.state.blocks.items() if key[0] == "wear rate")
        return WEAR_MM + float(self.state.mean[where][0]), float(np.sqrt(self.state.covariance[where, where][0, 0]))


def series_state(profile: Profile, parts: Sequence[ErrorVectors]) -> SeriesState | None:
    """Returns the state after parts in the order in which they were cut, at least two; None where the latest
    contradicts those before it.
    """
    observed = [_unworn(observed_of(profile, one, float(k))[1]) for k, one in enumerate(parts)]
    catalogue = catalogue_of(profile, drifting=True)
    state = State.before(catalogue, fitted_sizes(catalogue, observed[:-1][-FITTED_PARTS:]))
    for one in observed[:-1]:
        state = state.given(one).state.without_parts()
    updated = state.given(observed[-1])
    off = updated.innovation
    squares = float(off.mean_mm @ np.linalg.solve(off.covariance_mm2, off.mean_mm))
    if chdtrc(len(off.mean_mm), squares) < BY_CHANCE:
        return None
    return SeriesState(profile, parts[-1], updated.state.without_parts(), len(parts))


def _worn_mm(places: Places) -> Array:
    """Returns the wear to be expected before any part was measured, (n,)."""
    return WEAR_MM * places.number("age")


def _unworn(observed: Observed) -> Observed:
    return replace(observed, value_mm=observed.value_mm - observed.of(_worn_mm(observed.places)))
