"""What a part differs by from what was predicted of it: the material of tests for changes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.domain.life import Stage
from trueloop.memory.edge.predict import latest, predict, with_finish_at
from trueloop.memory.made_part import MadePart


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
    """Of a part given those before it: its touches, and its finish inspection where there is one with a known C.

    None for a cut without places. What is learned of the actuator's gain is part of the prediction.
    """
    inspected = part.uncorrected_mm is not None
    found = predict(latest(history, part.part_type), part if inspected else with_finish_at(part, np.empty(0)))
    t, touches, finish = found.touches, part.semifinish, part.finish
    said = []
    if t:
        error, covariance = touches.error_mm - found.before.mean_mm[:t], found.before.covariance_mm2[:t, :t]
        said.append(Innovation(error, covariance, touches.contact_angle_rad, np.zeros(t), Stage.SEMIFINISH))
    if finish is not None and part.correction_mm is not None and len(finish.error_mm):
        error = finish.error_mm + part.correction_mm - found.after.mean_mm
        angle, taken = finish.contact_angle_rad, part.correction_mm
        said.append(Innovation(error, found.after.covariance_mm2, angle, taken, Stage.FINISH))
    return tuple(said)
