"""The proposals of a series for the next part: a change of size, memory begun anew after an alarm, another weight.

A proposal acts only when it is accepted. What is measured enters memory at once, for that changes no cut.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from trueloop.domain.part import PartType
from trueloop.domain.proposal import Effect, Proposal, ProposalClass
from trueloop.domain.tool_offset import ToolOffset
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.loops.post_process.tracked import Tracked
from trueloop.memory.level.whitening import LEAST, REDUCED, monitor
from trueloop.statistics import NORMAL_95
from trueloop.tolerances.conformance import probability_between
from trueloop.wording import Um


@dataclass(frozen=True)
class Made:
    """By whom and when proposals are made."""

    by: str
    at: datetime


def proposals_of(series: Sequence[Tracked], options: SeriesOptions, made: Made) -> tuple[Proposal, ...]:
    """Returns the proposals of each series that is the latest of its characteristic; () where it is best left alone."""
    found: list[Proposal] = []
    for one in series:
        if one.series.latest:
            found += offset_of(one, options, made)
            found += restart_of(one, made)
            found += weight_of(one, made)
    return tuple(found)


def offset_of(one: Tracked, options: SeriesOptions, made: Made) -> list[Proposal]:
    """Returns the next part's change of size, where it is worth one: −1 times what the correction is to take off
    more.
    """
    change_mm = -one.change_mm
    if abs(change_mm) <= options.least_mm:
        return []
    effect, step = effect_of(one, change_mm), one.last.step
    why = (
        f"{len(one.parts)} parts; the level is {Um(step.level_mm or 0.0, '+.1f')} had nothing been corrected; weight "
        f"{effect.weight:.2f}: {step.weight.reason}"
    )
    return [_proposal(ProposalClass.TOOL_OFFSET, [one], [effect], made, why)]


def effect_of(one: Tracked, size_change_mm: float) -> Effect:
    """Predicts the effect of a change of size; the share of it that arrives is estimated from the parts."""
    step, asked = one.last.step, one.series.characteristic
    gain = 1.0 if step.gain is None else step.gain
    # The step predicts with its own correction; what is taken off less than that stays on.
    after_mm = step.predicted_mm + gain * (step.correction_mm - one.in_force_mm + size_change_mm)
    before_mm = after_mm - gain * size_change_mm
    u_mm = step.predicted_u_mm or 0.0

    def inside(error_mm: float) -> float | None:
        if asked.lower_limit is None and asked.upper_limit is None:
            return None
        return probability_between(asked.nominal + error_mm, u_mm, None, asked.lower_limit, asked.upper_limit)

    return Effect(
        *(one.series.name, one.series.identity, len(one.parts)),
        *(size_change_mm, before_mm, after_mm, u_mm),
        *(inside(before_mm), inside(after_mm)),
        step.weight.value * one.factor,
        one.in_force_mm,
    )


def restart_of(one: Tracked, made: Made) -> list[Proposal]:
    """Proposes after an alarm to learn from the alarming part on, because earlier parts may hold no more."""
    alarm = one.open_alarm
    if alarm is None:
        return []
    expected, band = Um(alarm.expected_mm or 0.0, "+.1f"), Um(NORMAL_95 * (alarm.expected_u_mm or 0.0))
    why = (
        f"part {alarm.made.serial} was expected at {expected} ± {band} and found at {Um(alarm.made.error_mm, '+.1f')}: "
        "another edge, another offset, or a wrong value"
    )
    return [_proposal(ProposalClass.MEMORY, [one], [effect_of(one, 0.0)], made, why, from_serial=alarm.made.serial)]


def weight_of(one: Tracked, made: Made) -> list[Proposal]:
    """Proposes a weight where the remaining errors are not white: the factor of the changes, by the standard percentage
    [4773 §3.5].
    """
    seen = monitor(np.array([part.step.innovation_mm or 0.0 for part in one.parts[1:]]))
    if not seen.says:
        return []
    rises = seen.agreeing > seen.pairs / 2
    factor = float(np.clip(one.factor / REDUCED if rises else one.factor * REDUCED, LEAST, 1.0))
    if factor == one.factor:
        return []
    why = f"{seen.says} ({seen.agreeing} of {seen.pairs} neighbours have one sign, p = {seen.probability:.2g})"
    return [_proposal(ProposalClass.WEIGHT, [one], [effect_of(one, 0.0)], made, why, weight=factor)]


def of_tool(
    series: Sequence[Tracked], effects: Sequence[Effect], offset: ToolOffset, control: str, made: Made, why: str
) -> Proposal:
    """Proposes one tool's offset for several characteristics, in the words of a control."""
    found = _proposal(ProposalClass.TOOL_OFFSET, series, effects, made, why, tool_offset=offset)
    return replace(found, control=control)


def _proposal(
    changes: ProposalClass,
    series: Sequence[Tracked],
    effects: Sequence[Effect],
    made: Made,
    why: str,
    tool_offset: ToolOffset | None = None,
    weight: float | None = None,
    from_serial: str = "",
) -> Proposal:
    last, part_type = series[0].last.made.serial, series[0].series.part_type
    alarms = tuple(f"{one.series.name}: {a.made.serial}" for one in series if (a := one.open_alarm) is not None)
    return Proposal(
        id=_id(changes, part_type, effects, last, tool_offset, weight, from_serial),
        changes=changes,
        part_type=part_type,
        effects=tuple(effects),
        last_serial=last,
        made_at=made.at,
        made_by=made.by,
        tool_offset=tool_offset,
        weight=weight,
        from_serial=from_serial,
        alarms=alarms,
        why=why,
    )


def _id(
    changes: ProposalClass,
    part_type: PartType,
    effects: Sequence[Effect],
    last: str,
    offset: ToolOffset | None,
    *more: object,
) -> str:
    """Returns twelve hex digits of its inputs: the same parts give the same id on any day."""
    sizes = [[one.series, one.parts, round(one.size_change_mm, 7)] for one in effects]
    tool = None if offset is None else [offset.tool, round(offset.x_radius_mm, 7), round(offset.z_mm, 7)]
    text = json.dumps([changes, part_type.identity, sizes, last, tool, *more])
    return hashlib.sha256(text.encode()).hexdigest()[:12]
