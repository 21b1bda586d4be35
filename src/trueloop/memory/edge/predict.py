"""Predictions of one part from earlier ones: before its touches are used, and after."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.estimate.observed import Observed
from trueloop.estimate.state import Normal, State
from trueloop.memory.edge.state import EDGE, KnownEdge, cut_of, known_edge
from trueloop.memory.made_part import CutErrors, MadePart

REMEMBERED: Final = 40
"""The number of latest parts from which an edge is known: older ones say little."""

OF_TYPE: Final = 10
"""And of so many of the latest of the part's own type, however long ago these were cut."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """A part's t touches and n finish errors E given earlier parts; mm.

    `expected_mm` and `covariance_mm2` are of touches and finish errors together, (t + n,), before a touch is known;
    `mean_mm` (n,) of the finish errors given the touches too. A correction of 1 takes off `gain`, with the standard
    uncertainty `gain_u`. `gross` (t,): probability that a touch is a gross error.
    """

    touched_mm: Array
    expected_mm: Array
    covariance_mm2: Array
    mean_mm: Array
    gain: float
    gain_u: float
    gross: Array
    _known: KnownEdge
    _after: State
    _asked: CutErrors

    @property
    def touches(self) -> int:
        """Returns the number of touches, T."""
        return len(self.touched_mm)

    @property
    def memory_mm(self) -> Array:
        """Returns the prediction of the finish errors (n,) from earlier parts alone."""
        return self.expected_mm[self.touches :]

    def inspected(self, correction_mm: Array) -> Normal:
        """F + C where a correction C (n,) is commanded: E, and what of C does not arrive; of what F is about then."""
        places, functional = self._known.places(self._asked, True, correction_mm)
        return self._after.predict(places, functional)


def predict(history: Sequence[MadePart], part: MadePart, asked: CutErrors) -> Prediction:
    """Predicts the finish errors E = F + C of a part at the places of `asked`, whose values are not used."""
    known = known_edge(history, part, asked)
    places, functional = known.places(asked, True)
    seen = cut_of(part, known.age, part.semifinish, False, None)
    state = known.state.at(seen.places).at(places)
    rows = np.vstack([seen.of(state.design(seen.places)), _of(functional, state.design(places))])
    t, n = len(seen), len(asked)
    covariance = rows @ state.covariance @ rows.T
    covariance[:t, :t] += state.noise_mm2(seen)
    covariance[t:, t:] += state.noise_mm2(Observed(places, np.zeros(n), np.zeros(n), functional))
    updated = state.given(seen) if t else None
    after = state if updated is None else updated.state
    where = after.blocks["gain", EDGE]
    return Prediction(
        part.semifinish.error_mm,
        rows @ state.mean,
        covariance,
        after.predict(places, functional).mean_mm,
        1.0 - float(after.mean[where][0]),
        float(np.sqrt(np.diag(after.covariance)[where][0])),
        np.zeros(t) if updated is None else updated.gross,
        known,
        after,
        asked,
    )


def latest(history: Sequence[MadePart], part_type: str) -> tuple[MadePart, ...]:
    """Returns the parts, in their order, by which a part of this type is predicted."""
    n = len(history)
    of_type = [k for k, part in enumerate(history) if part.part_type == part_type]
    return tuple(history[k] for k in sorted({*range(max(n - REMEMBERED, 0), n), *of_type[-OF_TYPE:]}))


def _of(functional: Array | None, rows: Array) -> Array:
    return rows if functional is None else np.asarray(functional @ rows)
