"""Predictions of one part from earlier ones, before its touches are used and after, and its differences from them.

The expected error of today's finish cut, from earlier parts of the edge and today's touches.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.domain.life import Stage
from trueloop.estimate.places import Observed
from trueloop.estimate.state import Normal, State
from trueloop.memory.edge.refuse import FIRST, by_itself, flags, nearest_rad, refuse, refuse_gain, up_to
from trueloop.memory.edge.state import TOOL, KnownEdge, MemoryOptions, cut_of, known_edge, observed
from trueloop.memory.made_part import CutErrors, Expected, MadePart

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
        contact_angle_rad=angle,
        mean_mm=command_mm,
        covariance_mm2=found.inspected(command_mm).covariance_mm2 * (WIDENED if parts < FEW_PARTS else 1.0),
        memory_mm=found.memory_mm / found.gain,
        weight=np.full(len(angle), 1.0 if _confirmed(learned, command_mm) else options.first_weight),
        nearest_rad=nearest_rad(learned, today, angle),
        parts=parts,
        enough_touches=enough_touches(found.covariance_mm2, found.touches),
        notes=(FIRST,) if alone else flags(learned, today, found.gain),
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


def predict(history: Sequence[MadePart], part: MadePart, errors: CutErrors) -> Prediction:
    """Predicts the finish errors E = F + C of a part at the places of `errors`, whose values are not used."""
    known = known_edge(history, part, errors)
    places, functional = known.places(errors, True)
    seen = cut_of(part, known.age, part.semifinish, False, None)
    state = known.state.at(seen.places).expecting(places)
    rows = np.vstack([seen.of(state.design(seen.places)), _of(functional, state.design(places))])
    t, n = len(seen), len(errors)
    covariance = state.covariance_of(rows)
    covariance[:t, :t] += state.noise_mm2(seen)
    covariance[t:, t:] += state.noise_mm2(Observed(places, np.zeros(n), np.zeros(n), functional))
    # what only the asked places are of is added after the touches: no value has scaled its tails
    after = (known.state.given(seen).state if t else known.state).expecting(places)
    where = after.blocks["gain", TOOL]
    return Prediction(
        touches=t,
        memory_mm=rows[t:] @ state.mean,
        covariance_mm2=covariance,
        mean_mm=after.predict(places, functional).mean_mm,
        gain=1.0 - float(after.mean[where][0]),
        gain_u=float(np.sqrt(np.diag(after.covariance)[where][0])),
        _known=known,
        _after=after,
        _asked=errors,
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
    return tuple(history[k] for k in latest_of([part.part_type for part in history], part_type))


def latest_of(part_types: Sequence[str], part_type: str) -> list[int]:
    """Returns which parts of a history these are, by their part types."""
    n = len(part_types)
    of_type = [k for k, one in enumerate(part_types) if one == part_type]
    return sorted({*range(max(n - REMEMBERED, 0), n), *of_type[-OF_TYPE:]})


def _of(functional: Array | None, rows: Array) -> Array:
    return rows if functional is None else np.asarray(functional @ rows)
