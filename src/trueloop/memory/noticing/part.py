"""Changes of a whole part, known by an edge's memory or by one number."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtr

from trueloop.arrays import Integers
from trueloop.domain.life import Stage
from trueloop.memory.edge.innovation import innovations
from trueloop.memory.level.step import PartReading, Step
from trueloop.memory.made_part import CutErrors, MadePart
from trueloop.memory.noticing.alarm import Alarm, Noticed, What
from trueloop.memory.noticing.notice import BY_CHANCE, notice, wider
from trueloop.memory.noticing.sentences import NEAR, is_slip, of_gain, of_number


def notice_part(history: Sequence[MadePart], part: MadePart) -> dict[Stage, Noticed]:
    """Returns by cut how a part differs from the prediction of earlier parts of the edge, in cutting order.

    Its touches are judged by earlier parts, its finish inspection by these and by its own touches. A cut without places
    is absent, and so are all of a part before which none was inspected: what is believed beforehand is no reason to
    call a part changed.
    """
    parts = sum(earlier.uncorrected_mm is not None for earlier in history)
    if not parts:
        return {}
    found = {}
    for one in innovations(history, part):
        finish = part.finish if one.stage is Stage.FINISH else None
        found[one.stage] = notice(
            one.error_mm,
            one.covariance_mm2,
            one.contact_angle_rad,
            parts,
            None if finish is None else one.correction_mm,
            None if finish is None else part.from_memory_mm,
            (part.semifinish if finish is None else finish).point,
        )
    return found


def notice_step(step: Step, reading: PartReading, parts: int) -> Noticed:
    """Tests a series of one number: `step` is the one that `memory.level.kalman.steps` made of the reading, `parts` the
    number of parts behind it.

    One number does not tell a moved level from a correction that was not run. Where the share of the correction that
    would have arrived is that of a slip in the shop, this is reported, and the record goes into quarantine; else it is
    said that the part differs. Raises ValueError for a step of a rule without a model, which predicts nothing.
    """
    if step.innovation_mm is None or step.innovation_sd_mm is None:
        raise ValueError("a step without an innovation")
    beyond, deviation = step.innovation_mm, step.innovation_sd_mm * np.sqrt(wider(parts))
    chance = float(2 * ndtr(-abs(beyond) / deviation))
    if chance >= BY_CHANCE:
        return Noticed()
    taken = reading.correction_mm
    arrived, u = (1 - beyond / taken, abs(deviation / taken)) if taken else (1.0, float("inf"))
    if u < NEAR and is_slip(arrived):
        return Noticed((Alarm(What.GAIN, chance, of_gain(arrived)),), gain=arrived, gain_u=u, quarantine=True)
    return Noticed((Alarm(What.LEVEL, chance, of_number(beyond)),))


def cleaned(part: MadePart, found: Mapping[Stage, Noticed]) -> MadePart:
    """Returns the part as it may be learned from: without the touches that were left out, and without its finish
    inspection where that is in quarantine. Not learning from a gross touch keeps later predictions right.
    """
    before, after = (found.get(stage, Noticed()) for stage in (Stage.SEMIFINISH, Stage.FINISH))
    touches = _without(part.semifinish, before)
    if part.finish is None or after.quarantine:
        return replace(part, semifinish=touches, finish=None, correction_mm=None, from_memory_mm=None)
    stays = _stays(len(part.finish.error_mm), after)
    taken, added = part.correction_mm, part.from_memory_mm
    return replace(
        part,
        semifinish=touches,
        finish=_without(part.finish, after),
        correction_mm=None if taken is None else taken[stays],
        from_memory_mm=None if added is None else added[stays],
    )


def _stays(places: int, found: Noticed) -> Integers:
    return np.delete(np.arange(places), [touch.index for touch in found.left_out])


def _without(errors: CutErrors, found: Noticed) -> CutErrors:
    return errors.chosen(_stays(len(errors), found))
