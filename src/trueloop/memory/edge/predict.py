"""Predictions of one part from earlier ones, before its touches are used and after, and its differences from them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.domain.life import Stage
from trueloop.estimate.observed import Observed
from trueloop.estimate.state import Normal, State
from trueloop.memory.edge.state import TOOL, KnownEdge, cut_of, known_edge, observed
from trueloop.memory.made_part import CutErrors, MadePart

REMEMBERED: Final = 40
"""The number of latest parts from which an edge is known: older ones say little."""

OF_TYPE: Final = 10
"""And of so many of the latest of the part's own type, however long ago these were cut."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """The n finish errors E of a part given earlier parts and its t touches; mm.

    `mean_mm` (n,) is expected, `memory_mm` (n,) without the touches; `covariance_mm2` (t + n, t + n) is that of touches
    and finish errors together before a touch is known. A correction of 1 takes off `gain`, with the standard
    uncertainty `gain_u`.
    """

    touches: int
    memory_mm: Array
    covariance_mm2: Array
    mean_mm: Array
    gain: float
    gain_u: float
    _known: KnownEdge
    _after: State
    _asked: CutErrors

    def inspected(self, correction_mm: Array) -> Normal:
        """F + C where a correction C (n,) is commanded: E, and what of C does not arrive; of what F is about then."""
        places, functional = self._known.places(self._asked, True, correction_mm)
        return self._after.predict(places, functional)


def predict(history: Sequence[MadePart], part: MadePart, asked: CutErrors) -> Prediction:
    """Predicts the finish errors E = F + C of a part at the places of `asked`, whose values are not used."""
    known = known_edge(history, part, asked)
    places, functional = known.places(asked, True)
    seen = cut_of(part, known.age, part.semifinish, False, None)
    state = known.state.at(seen.places).expecting(places)
    rows = np.vstack([seen.of(state.design(seen.places)), _of(functional, state.design(places))])
    t, n = len(seen), len(asked)
    covariance = rows @ state.covariance @ rows.T
    covariance[:t, :t] += state.noise_mm2(seen)
    covariance[t:, t:] += state.noise_mm2(Observed(places, np.zeros(n), np.zeros(n), functional))
    # what only the asked places are of is added after the touches: no value has scaled its tails
    after = (known.state.given(seen).state if t else known.state).expecting(places)
    where = after.blocks["gain", TOOL]
    return Prediction(
        t,
        rows[t:] @ state.mean,
        covariance,
        after.predict(places, functional).mean_mm,
        1.0 - float(after.mean[where][0]),
        float(np.sqrt(np.diag(after.covariance)[where][0])),
        known,
        after,
        asked,
    )


@by_content
@dataclass(frozen=True)
class Innovation:
    """Measured less predicted, at n places of one cut of one part, mm.

    `covariance_mm2` (n, n) is that of `error_mm` (n,) were nothing changed, scatter of the cut and of the measurement
    included. `stage` SEMIFINISH: touches, given earlier parts; `correction_mm` (n,) is zero. FINISH: E = F + C of the
    inspection, given earlier parts and own touches; `correction_mm` is C, commanded: an innovation of −1 times it says
    that it was run twice, +1 times it that it was not run.
    """

    error_mm: Array
    covariance_mm2: Array
    contact_angle_rad: Array
    correction_mm: Array
    stage: Stage


def innovations(history: Sequence[MadePart], part: MadePart) -> tuple[Innovation, ...]:
    """Returns the innovations of a part given those before it: its touches, and its finish inspection where there is
    one with a known C.

    None for a cut without places. What is learned of the actuator's gain is part of the prediction.
    """
    known, found = known_edge(latest(history, part.part_type), part), list[Innovation]()
    state = known.state
    for cut in observed(part, known.age):
        updated, rows = state.given(cut), slice(len(cut))
        angle, taken, finish = (
            cut.places.number(name)[rows] for name in ("contact_angle_rad", "taken_off_mm", "finish")
        )
        shown, stage = updated.innovation, Stage.FINISH if finish[0] else Stage.SEMIFINISH
        found.append(Innovation(shown.mean_mm, shown.covariance_mm2, angle, taken, stage))
        state = updated.state
    return tuple(found)


def latest(history: Sequence[MadePart], part_type: str) -> tuple[MadePart, ...]:
    """Returns the parts, in their order, by which a part of this type is predicted."""
    n = len(history)
    of_type = [k for k, part in enumerate(history) if part.part_type == part_type]
    return tuple(history[k] for k in sorted({*range(max(n - REMEMBERED, 0), n), *of_type[-OF_TYPE:]}))


def _of(functional: Array | None, rows: Array) -> Array:
    return rows if functional is None else np.asarray(functional @ rows)
