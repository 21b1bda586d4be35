"""The expected error of today's finish cut, from earlier parts of the edge and today's touches."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.memory.edge.options import MemoryOptions
from trueloop.memory.edge.predict import latest, predict
from trueloop.memory.edge.refuse import FIRST, by_itself, flags, nearest_rad, refuse, refuse_gain, up_to
from trueloop.memory.expected import Expected
from trueloop.memory.made_part import CutErrors, MadePart

FEW_PARTS: Final = 3
"""With fewer inspected parts the sizes of the terms are known so badly that bands are widened."""

WIDENED: Final = 1.3
"""The factor by which the variance then grows: simulated with two parts of history, 1.2 to 1.3 is missing."""

CONFIRMS: Final = 1 / 3
"""An inspected correction confirms the actuator for corrections up to three times as large."""

NEARLY: Final = 1.1
"""Standard uncertainties that are at most so many times those of all touches count as good as these."""


def expect(history: Sequence[MadePart], today: MadePart, at: CutErrors, options: MemoryOptions) -> Expected:
    """Predicts the finish error of today's part, had nothing been corrected, at n places, whose values are not used.

    `history` holds the earlier parts of the tool in cutting order, those of the edge last; `today` is the part in hand,
    without its finish inspection; of neither is anything used that comes later. Command `weight` × `mean_mm` as the
    correction: positive where material is to be taken off. Where `own_fit` is set, correct by the fit of today's
    touches as without memory: it is the first part of the tool, or of an edge at angles that its touches do not show,
    or the options say so; the rest then is what the state says of today's touches.

    Raises MEM-UNSEEN where a contact angle is too far from all that were seen, MEM-SETTING without a touch after a new
    setting, MEM-TYPE without a touch of a part type that the edge has never cut, MEM-GAIN where corrections hardly
    acted, or the wrong way, MEM-PART for an unknown `last_part`.
    """
    learned = latest(remembered(history, options), today.part_type)
    angle = at.contact_angle_rad
    alone = by_itself(learned, today, at, options)
    if not alone:
        refuse(learned, today, at, options)
    found = predict(learned, today, at)
    parts = sum(part.uncorrected_mm is not None for part in learned)
    refuse_gain(found.gain)
    command_mm = found.mean_mm / found.gain
    return Expected(
        angle,
        command_mm,
        found.inspected(command_mm).covariance_mm2 * (WIDENED if parts < FEW_PARTS else 1.0),
        found.memory_mm / found.gain,
        np.full(len(angle), 1.0 if _confirmed(learned, command_mm) else options.first_weight),
        nearest_rad(learned, today, angle),
        parts,
        enough_touches(found.covariance_mm2, found.touches),
        (FIRST,) if alone else flags(learned, today, found.gain),
        gain=found.gain,
        gain_u=found.gain_u,
        own_fit=alone or options.memory == "bands",
    )


def remembered(history: Sequence[MadePart], options: MemoryOptions) -> tuple[MadePart, ...]:
    """Returns the parts from which the edge is learned."""
    if options.memory == "off":
        return ()
    if options.memory != "frozen":
        return tuple(history)
    return up_to(history, options.last_part)


def _confirmed(learned: Sequence[MadePart], command_mm: Array) -> bool:
    """Returns whether an inspected part has shown the effect of a correction of about this size."""
    shown = [part.correction_mm for part in learned if part.uncorrected_mm is not None]
    largest = max((_largest(taken) for taken in shown if taken is not None), default=0.0)
    return largest > 0 and largest >= CONFIRMS * _largest(command_mm)


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values), initial=0.0))


def enough_touches(covariance_mm2: Array, touches: int) -> int:
    """Returns the least number of touches, placed one by one where they help most, that would have been enough.

    `covariance_mm2` is that of the touches, first, and of the finish errors, before a touch is known. The touch is
    taken next that leaves the least sum of variances; enough are those whose root of it is within 10 % of that of all.
    """
    rest, left = covariance_mm2, list(range(touches))
    variance = [float(np.trace(rest[touches:, touches:]))]
    while left:
        best = max(left, key=lambda k: _helps(rest, k, touches))
        left.remove(best)
        rest = _after(rest, best)
        variance.append(float(np.trace(rest[touches:, touches:])))
    return next(count for count, value in enumerate(variance) if value <= NEARLY**2 * variance[-1])


def _helps(covariance: Array, k: int, touches: int) -> float:
    """Returns by how much touch k, once known, lowers the sum of variances of the finish errors."""
    return float(np.sum(covariance[touches:, k] ** 2) / covariance[k, k])


def _after(covariance: Array, k: int) -> Array:
    """Returns the covariance once value k is known."""
    return np.asarray(covariance - np.outer(covariance[:, k], covariance[k]) / covariance[k, k])
