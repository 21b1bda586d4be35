"""Measured values as linear functionals of the error at places."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.estimate.places import Places, joined


@by_content
@dataclass(frozen=True)
class Observed:
    """n values y = H·e(places) + noise, mm, of N places.

    `functional` is H (n, N); None: one value a place. `standard_u_mm` (n,) is that of the instrument, what a cut
    scatters from place to place not included. `correlated_mm2` (n, n) is what the instrument's errors have in common,
    their diagonal included; None: nothing. All values are of one part.
    """

    places: Places
    value_mm: Array
    standard_u_mm: Array
    functional: Array | None = None
    correlated_mm2: Array | None = None

    def __len__(self) -> int:
        return len(self.value_mm)

    @property
    def matrix(self) -> Array:
        """Returns H, (n, N)."""
        return np.eye(len(self.places)) if self.functional is None else self.functional

    def of(self, at_places: Array) -> Array:
        """Returns H times a quantity given at the places, (N, …)."""
        return at_places if self.functional is None else np.asarray(self.functional @ at_places)

    @property
    def instrument_mm2(self) -> Array:
        """Returns the covariance of the instrument's errors, (n, n)."""
        own = np.diag(self.standard_u_mm**2)
        return own if self.correlated_mm2 is None else own + self.correlated_mm2


def together(parts: Sequence[Observed]) -> Observed:
    """Observations whose instruments have nothing in common as one."""
    functional = correlated = None
    if any(one.functional is not None for one in parts):
        functional = _diagonal([one.matrix for one in parts])
    if any(one.correlated_mm2 is not None for one in parts):
        correlated = _diagonal(
            [np.zeros((len(one), len(one))) if one.correlated_mm2 is None else one.correlated_mm2 for one in parts]
        )
    return Observed(
        joined([one.places for one in parts]),
        np.concatenate([one.value_mm for one in parts]),
        np.concatenate([one.standard_u_mm for one in parts]),
        functional,
        correlated,
    )


def _diagonal(blocks: Sequence[Array]) -> Array:
    rows, columns = (np.cumsum([0, *(block.shape[k] for block in blocks)]) for k in (0, 1))
    whole = np.zeros((rows[-1], columns[-1]))
    for k, block in enumerate(blocks):
        whole[rows[k] : rows[k + 1], columns[k] : columns[k + 1]] = block
    return whole
