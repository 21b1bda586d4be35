"""One part given earlier ones: before its touches are looked at, and after."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.memory.edge.fit import fitted
from trueloop.memory.edge.hyperparameters import BEFOREHAND, Hyperparameters
from trueloop.memory.edge.observations import observations
from trueloop.memory.edge.posterior import Posterior, condition, joint
from trueloop.memory.made_part import ArcErrors, MadePart

REMEMBERED: Final = 40
"""Of so many of the latest parts an edge is known: what it was long ago says little, and matrices grow with parts."""

OF_TYPE: Final = 10
"""And of so many of the latest of the part's own type, however long ago these were cut."""


@by_content
@dataclass(frozen=True)
class Prediction:
    """A part's t touches and n finish errors given earlier parts.

    `touched` are its touches (t,), mm; `before` predicts touches and finish errors together (t + n,), `after` the
    finish errors (n,) given the touches too.
    """

    touched_mm: Array
    before: Posterior
    after: Posterior

    @property
    def touches(self) -> int:
        """T."""
        return len(self.touched_mm)

    @property
    def memory_mm(self) -> Array:
        """What earlier parts alone predict of the finish errors (n,)."""
        return self.before.mean_mm[self.touches :]


def predict(history: Sequence[MadePart], part: MadePart) -> Prediction:
    """The finish errors E = F + C at the places of `part.finish`, whose values are not looked at."""
    everything = observations([*history, part])
    of_history = int(np.sum(everything.cuts.part[everything.cut] < len(history)))
    of_touches = len(part.semifinish.error_mm)
    prior = joint(everything, sizes(history))
    before = condition(prior, everything.error_mm[:of_history])
    return Prediction(part.semifinish.error_mm, before, condition(before, part.semifinish.error_mm[:of_touches]))


def latest(history: Sequence[MadePart], part_type: str) -> tuple[MadePart, ...]:
    """The parts, in their order, by which a part of this type is predicted."""
    n = len(history)
    of_type = [k for k, part in enumerate(history) if part.part_type == part_type]
    return tuple(history[k] for k in sorted({*range(max(n - REMEMBERED, 0), n), *of_type[-OF_TYPE:]}))


def sizes(history: Sequence[MadePart]) -> Hyperparameters:
    """Hyperparameters as earlier parts show them; without any, as believed beforehand."""
    return fitted(observations(history)) if history else BEFOREHAND


def with_finish_at(part: MadePart, contact_angle_rad: Array) -> MadePart:
    """The part with places, but no values, of a finish inspection: exact, and of an uncorrected cut."""
    n = len(contact_angle_rad)
    asked = ArcErrors(("",) * n, ("",) * n, contact_angle_rad, np.zeros(n), np.zeros(n))
    return replace(part, finish=asked, correction_mm=np.zeros(n))
