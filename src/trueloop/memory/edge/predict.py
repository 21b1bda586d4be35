"""Predictions of one part from earlier ones, before its touches are used and after, and its differences from them.

Refusals of memory to predict, and its remarks where it predicts from few data.

The expected error of today's finish cut, from earlier parts of the edge and today's touches.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers, by_content
from trueloop.domain.life import Stage
from trueloop.errors import Code, TrueloopError
from trueloop.estimate.catalogue import PRIORS
from trueloop.estimate.places import Observed
from trueloop.estimate.state import Normal, State
from trueloop.memory.edge.learnt import TOOL, KnownEdge, MemoryOptions, cut_of, known_edge, observed
from trueloop.memory.made_part import CutErrors, Expected, MadePart
from trueloop.wording import wording

FEW: Final = 5
"""Fewer touches of an arc show nothing of angles that nobody has seen."""

SMOOTH_RAD: Final = PRIORS["nose_length"].median
"""Over so much contact angle a nose's form is smooth."""

LEAST_GAIN: Final = 1 / 3
FIRST: Final = wording("Nothing to learn from earlier parts of this edge yet: corrected by the fit of its own touches.")
OFF: Final = 'correct by today\'s touches alone: [memory] use = "off"'


def up_to(history: Sequence[MadePart], last_part: str) -> tuple[MadePart, ...]:
    """Returns the history up to a part and with it. Raises MEM-PART where it holds none of that serial number."""
    serials = [part.serial for part in history]
    if last_part not in serials:
        raise Code.MEM_PART.refusal(
            f"memory is frozen after part {last_part!r}, which this edge has not cut; it has cut "
            f"{', '.join(map(repr, serials)) or 'none'}",
            hint="name one of them",
            override=OFF,
            values={"last_part": last_part},
        )
    return tuple(history[: len(serials) - serials[::-1].index(last_part)])


def nearest_rad(history: Sequence[MadePart], today: MadePart, contact_angle_rad: Array) -> Array:
    """Returns the distance of the nearest contact angle measured on today's edge, (n,); inf without any."""
    measured = _measured(of_edge(history, today))
    return _nearest(np.concatenate([today.semifinish.contact_angle_rad, measured]), contact_angle_rad)


def of_edge(history: Sequence[MadePart], today: MadePart) -> tuple[MadePart, ...]:
    """Returns the parts that the edge of today's part has cut; the others are of earlier edges of its tool."""
    return tuple(part for part in history if part.edge == today.edge)


def is_seen(
    history: Sequence[MadePart], today: MadePart, contact_angle_rad: Array, touches: Integers, options: MemoryOptions
) -> Flags:
    """Returns whether contact angles are near enough to those that were measured, (n,).

    `touches` (n,) counts today's on the group of features that each is of. Of many touches further apart, an angle is
    also seen between angles of earlier parts, within the length over which a nose's form is smooth: what is known there
    then is what the fit of today's touches would assume.
    """
    near = nearest_rad(history, today, contact_angle_rad) <= options.unseen_rad
    earlier = _measured(of_edge(history, today))
    between = (contact_angle_rad >= earlier.min(initial=np.inf)) & (contact_angle_rad <= earlier.max(initial=-np.inf))
    smooth = _nearest(earlier, contact_angle_rad) <= SMOOTH_RAD
    return np.asarray(near | ((touches >= FEW) & between & smooth))


def _measured(history: Sequence[MadePart]) -> Array:
    cuts = [cut for part in history for cut in (part.semifinish, part.finish) if cut is not None]
    return np.concatenate([np.empty(0), *(cut.contact_angle_rad for cut in cuts)])


def _nearest(angles: Array, contact_angle_rad: Array) -> Array:
    if not len(angles):
        return np.full(len(contact_angle_rad), np.inf)
    return np.asarray(np.abs(np.subtract.outer(contact_angle_rad, angles)).min(axis=1))


def refuse(history: Sequence[MadePart], today: MadePart, at: CutErrors, options: MemoryOptions) -> None:
    """Raises where nothing may be predicted at places; `history` is not empty."""
    if not len(today.semifinish.error_mm):
        _refuse_untouched(history, today)
    unseen = np.flatnonzero(~_seen(history, today, at, options))
    if len(unseen):
        angles = at.contact_angle_rad[unseen]
        raise _unseen(today, angles, nearest_rad(history, today, angles), options)


def by_itself(history: Sequence[MadePart], today: MadePart, at: CutErrors, options: MemoryOptions) -> bool:
    """Returns whether a part has to be corrected by its own touches alone: the first that a tool cuts, and the first of
    an edge where its touches do not show all contact angles. Earlier edges say nothing of this one's form there.
    """
    if of_edge(history, today):
        return False
    return not history or (len(today.semifinish) > 0 and not np.all(_seen(history, today, at, options)))


def _seen(history: Sequence[MadePart], today: MadePart, at: CutErrors, options: MemoryOptions) -> Flags:
    count = Counter(today.semifinish.groups)
    touches = np.array([count[group] for group in at.groups], dtype=np.intp)
    return is_seen(history, today, at.contact_angle_rad, touches, options)


def refuse_gain(gain: float) -> None:
    """Raises where the machine makes so little of a correction that dividing by it would not be safe."""
    if gain >= LEAST_GAIN:
        return
    raise Code.MEM_GAIN.refusal(
        f"earlier parts of this edge say that the machine makes {gain:.2f} of a correction of 1; at least "
        f"{LEAST_GAIN:.2f} is accepted",
        hint="look whether their corrections were run, and with the right sign; take parts out of what is learned from "
        "whose corrections were not run",
        override=OFF,
        values={"gain": gain},
    )


def flags(history: Sequence[MadePart], today: MadePart, gain: float) -> tuple[str, ...]:
    """Returns the remarks beside a prediction, as sentences."""
    inspected = [part for part in history if part.uncorrected_mm is not None]
    said = []
    if not of_edge(history, today):
        said.append(
            wording(
                "Nothing to learn from earlier parts of this edge yet: corrected by its own touches and what earlier "
                "edges show."
            )
        )
    if not inspected:
        said.append(wording("No earlier part was inspected: what the finish cut does differently is assumed."))
    elif len(inspected) < 3:
        said.append(wording("Fewer than three parts inspected so far ({n}): the band is widened.", n=len(inspected)))
    if any(part.finish is not None and part.correction_mm is None for part in history):
        said.append(wording("Finish inspections whose correction is not known are not learned from."))
    if _differs(today.depth_of_cut_mm, [part.depth_of_cut_mm for part in inspected]):
        said.append(wording("Another depth of cut than earlier parts: what was learned may not hold."))
    if _differs(today.feed_mm, [part.feed_mm for part in inspected]):
        said.append(wording("Another feed than earlier parts: what was learned may not hold."))
    if _order_in_doubt([*history, today]):
        said.append(wording("The order in which the parts were cut is in doubt."))
    if not 0.8 <= gain <= 1.2:
        said.append(
            wording("The machine makes {gain} of a correction of 1: look whether it is run twice.", gain=f"{gain:.2f}")
        )
    return tuple(said)


def _refuse_untouched(history: Sequence[MadePart], today: MadePart) -> None:
    if today.setting not in {part.setting for part in history}:
        raise Code.MEM_SETTING.refusal(
            f"part {today.serial!r}: the tool was set anew ({today.setting}) and no point of the part was touched; "
            "where the tool's tip lies is not known",
            hint="touch the arc at two places far apart",
            override=OFF,
            values={"setting": today.setting},
        )
    if today.part_type not in {part.part_type for part in history}:
        raise Code.MEM_TYPE.refusal(
            f"part {today.serial!r}: this edge has never cut a part of type {today.part_type!r}, and no point of it "
            "was touched",
            hint="touch all points of a new part type; three are enough where all contact angles were seen",
            override=OFF,
            values={"part_type": today.part_type},
        )


def _unseen(today: MadePart, contact_angle_rad: Array, nearest: Array, options: MemoryOptions) -> TrueloopError:
    worst = int(np.argmax(nearest))
    angle, off, most = (math.degrees(a) for a in (contact_angle_rad[worst], nearest[worst], options.unseen_rad))
    return Code.MEM_UNSEEN.refusal(
        f"part {today.serial!r}: contact angle {angle:.1f}° is {off:.1f}° from the nearest that this edge's parts or "
        f"today's touches have seen; at most {most:.1f}° is accepted",
        hint="touch the part there",
        override=f"[memory] unseen_deg = {math.ceil(off)}",
        values={"angle_deg": angle, "nearest_deg": off, "most_deg": most},
    )


def _differs(value: float | None, others: Sequence[float | None]) -> bool:
    """Returns whether a stated value is by more than 10 % off the median of the others that are stated."""
    stated = [other for other in others if other is not None]
    return value is not None and bool(stated) and abs(value / float(np.median(stated)) - 1) > 0.1


def _order_in_doubt(parts: Sequence[MadePart]) -> bool:
    """Returns whether a part's place was doubted, two parts have one place in the order, or the edge's age falls."""
    if any(part.order_in_doubt for part in parts):
        return True
    order = [part.order for part in parts]
    age = [part.minutes_in_cut for part in of_edge(parts, parts[-1]) if part.minutes_in_cut is not None]
    return any(later <= earlier for earlier, later in pairwise(order)) or age != sorted(age)


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
