"""The difference of a part from its prediction: the input of tests for changes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.domain.life import Stage
from trueloop.memory.edge.predict import latest, predict
from trueloop.memory.edge.state import cut_of
from trueloop.memory.made_part import CutErrors, MadePart


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
    touches = part.semifinish
    finish = CutErrors.none() if part.finish is None or part.correction_mm is None else part.finish
    found = predict(latest(history, part.part_type), part, finish)
    t, said = found.touches, list[Innovation]()
    if t:
        error, covariance = touches.error_mm - found.expected_mm[:t], found.covariance_mm2[:t, :t]
        said.append(Innovation(error, covariance, touches.contact_angle_rad, np.zeros(t), Stage.SEMIFINISH))
    if part.correction_mm is not None and len(finish):
        taken = part.correction_mm
        expected, seen = found.inspected(taken), cut_of(part, 0.0, finish, True, taken)
        error = finish.error_mm + taken - expected.mean_mm
        said.append(
            Innovation(
                error, expected.covariance_mm2 + seen.instrument_mm2, finish.contact_angle_rad, taken, Stage.FINISH
            )
        )
    return tuple(said)
