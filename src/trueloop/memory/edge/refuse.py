"""Refusals of memory to predict, and its remarks where it predicts from few data."""

import math
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, TrueloopError
from trueloop.estimate.catalogue import PRIORS
from trueloop.memory.edge.state import MemoryOptions
from trueloop.memory.made_part import CutErrors, MadePart
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
