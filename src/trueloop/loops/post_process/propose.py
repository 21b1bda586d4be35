"""The proposals of a series for the next part: a change of size, memory begun anew after an alarm, another weight.

A proposal acts only when it is accepted. What is measured enters memory at once, for that changes no cut.

One tool's offset (dX, dZ) for all characteristics of the features that it cuts.

A tool offset d moves every surface with the outward normal n by n·d, and so changes a characteristic by g·d, where
g = Σ gains · n over those of its places that the tool cuts (`turned.characteristics.measurand`): a diameter by 2 dX, a
length by dZ where its other face is cut by another tool or in another set-up. Both faces of one tool's move alike: no
offset changes the length between them. A length from the part's zero counts from the face that stands there, where the
part has one. Wanted are the changes c of all characteristics of the tool: least squares of (g·d − c)/u, u the standard
deviation of one part. It is minimal where the characteristics leave an axis open: that one stays as it is.
"""

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.part import PartType
from trueloop.domain.proposal import Effect, ExpandedU, HeldTool, Proposal, ProposalClass, ToolOffset
from trueloop.domain.tool import Machine
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.loops.post_process.tracked import TrackedSeries
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.programs import contour_tools, edge_of_pass, no_number, require_in_force
from trueloop.memory.level.kalman import LEAST, REDUCED, monitor
from trueloop.nc.program.called import CalledOffset
from trueloop.nc.program.program import Program
from trueloop.statistics import NORMAL_95
from trueloop.tolerances.conformance import probability_between
from trueloop.turned.characteristics.measurand import measurand
from trueloop.turned.program.wear_numbers import WearOffset, wear_offset
from trueloop.wording import Um


@dataclass(frozen=True)
class ProposalContext:
    """By whom and when proposals are made."""

    by: str
    at: datetime


def proposals_of(
    series: Sequence[TrackedSeries], options: SeriesOptions, made: ProposalContext
) -> tuple[Proposal, ...]:
    """Returns the proposals of each series that is the latest of its characteristic; () where it is best left alone."""
    found: list[Proposal] = []
    for one in series:
        if one.series.latest:
            found += offset_of(one, options, made)
            found += restart_of(one, made)
            found += weight_of(one, made)
    return tuple(found)


def offset_of(one: TrackedSeries, options: SeriesOptions, made: ProposalContext) -> list[Proposal]:
    """Returns the next part's change of size, where it is worth it: −1 times what the correction is to take off."""
    change_mm = -one.change_mm
    if abs(change_mm) <= options.least_mm:
        return []
    effect, step = effect_of(one, change_mm), one.last.step
    why = (
        f"{len(one.parts)} parts; the level is {Um(step.level_mm or 0.0, '+.1f')} had nothing been corrected; weight "
        f"{effect.weight:.2f}: {step.weight.reason}"
    )
    return [_proposal(ProposalClass.TOOL_OFFSET, [one], [effect], made, why)]


def effect_of(series: TrackedSeries, size_change_mm: float) -> Effect:
    """Predicts the effect of a change of size; the share of it that arrives is estimated from the parts."""
    step, asked = series.last.step, series.series.characteristic
    before_mm = series.next_mm
    after_mm = before_mm + series.gain * size_change_mm
    u_mm = step.predicted_u_mm or 0.0

    def inside(error_mm: float) -> float | None:
        if asked.lower_limit is None and asked.upper_limit is None:
            return None
        return probability_between(asked.nominal + error_mm, u_mm, None, asked.lower_limit, asked.upper_limit)

    return Effect(
        characteristic=series.series.name,
        series=series.series.identity,
        parts=len(series.parts),
        size_change_mm=size_change_mm,
        error_before_mm=before_mm,
        error_after_mm=after_mm,
        standard_u_mm=u_mm,
        probability_in_before=inside(before_mm),
        probability_in_after=inside(after_mm),
        weight=step.weight.value * series.factor,
        in_force_mm=series.in_force_mm,
    )


def restart_of(series: TrackedSeries, made: ProposalContext) -> list[Proposal]:
    """Proposes after an alarm to learn from the alarming part on, because earlier parts may hold no more."""
    alarm = series.open_alarm
    if alarm is None:
        return []
    expected, band = Um(alarm.expected_mm or 0.0, "+.1f"), Um(NORMAL_95 * (alarm.expected_u_mm or 0.0))
    why = (
        f"part {alarm.made.serial} was expected at {expected} ± {band} and found at {Um(alarm.made.error_mm, '+.1f')}: "
        "another edge, another offset, or a wrong value"
    )
    return [
        _proposal(ProposalClass.MEMORY, [series], [effect_of(series, 0.0)], made, why, from_serial=alarm.made.serial)
    ]


def weight_of(series: TrackedSeries, made: ProposalContext) -> list[Proposal]:
    """Proposes a weight where the remaining errors are not white, by the standard percentage [4773 §3.5]."""
    seen = monitor(np.array([part.step.innovation_mm or 0.0 for part in series.parts[1:]]))
    if not seen.says:
        return []
    rises = seen.agreeing > seen.pairs / 2
    factor = float(np.clip(series.factor / REDUCED if rises else series.factor * REDUCED, LEAST, 1.0))
    if factor == series.factor:
        return []
    why = f"{seen.says} ({seen.agreeing} of {seen.pairs} neighbours have one sign, p = {seen.probability:.2g})"
    return [_proposal(ProposalClass.WEIGHT, [series], [effect_of(series, 0.0)], made, why, weight=factor)]


def of_tool(
    series: Sequence[TrackedSeries],
    effects: Sequence[Effect],
    offset: ToolOffset,
    control: str,
    made: ProposalContext,
    why: str,
) -> Proposal:
    """Proposes one tool's offset for several characteristics, in the words of a control."""
    found = _proposal(ProposalClass.TOOL_OFFSET, series, effects, made, why, tool_offset=offset)
    return replace(found, control=control)


def _proposal(
    changes: ProposalClass,
    series: Sequence[TrackedSeries],
    effects: Sequence[Effect],
    made: ProposalContext,
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
    sizes = [[effect.series, effect.parts, round(effect.size_change_mm, 7)] for effect in effects]
    tool = None if offset is None else [offset.tool, round(offset.x_radius_mm, 7), round(offset.z_mm, 7)]
    text = json.dumps([changes, part_type.identity, sizes, last, tool, *more])
    return hashlib.sha256(text.encode()).hexdigest()[:12]


OPEN: Final = 1e-6
"""Share of the largest singular value below which characteristics say nothing of a direction."""
LEAST_U_MM: Final = 1e-4
NO_GAIN: Final = 1e-9
"""A size that changes by less per mm of offset is not changed by it."""


@dataclass(frozen=True)
class JobTool:
    """Part and tool of a job, or one of its tools with the features that it cuts. `asked`: the requested
    characteristics of its features, by name.

    `tool` is the number of the offset that the job names, `edge` its edge, 0: not stated; `x_is_diameter` how the
    control counts offsets on X. `zero_z_mm` is z of the part's zero in the frame of the program, from which lengths
    count. Two set-ups on one `machine` that call one number run with one offset.
    """

    profile: Profile
    program: Program
    matched: Commanded
    asked: Mapping[str, Characteristic]
    tool: int | None = None
    x_is_diameter: bool | None = None
    edge: int = 0
    zero_z_mm: float = 0.0
    machine: Machine | None = None


def moved_by_offset(
    profile: Profile, characteristic: Characteristic, zero_z_mm: float = 0.0, of_tool: Collection[int] | None = None
) -> Array:
    """Returns the g of a characteristic, (2,): the change of its size per mm of tool offset on X (a radius) and on Z.

    `of_tool` are the features, by index, that the tool cuts; None: all. Raises TOL-FEATURE and TOL-PLACE for what the
    part does not have.
    """
    counted = _from_face(profile, characteristic, zero_z_mm)
    sizes = measurand(profile, counted, np.zeros(len(profile.features), dtype=np.intp), zero_z_mm)
    places = zip(sizes.feature_index.tolist(), sizes.arc_length_mm.tolist(), strict=True)
    moved = [(index, s, of_tool is None or index in of_tool) for index, s in places]
    normals = np.array([profile.features[index].outward_normal(s) * by_tool for index, s, by_tool in moved])
    gain = np.asarray((sizes.gains @ normals).mean(axis=0))
    return np.where(np.abs(gain) < NO_GAIN, 0.0, gain)


def _from_face(profile: Profile, characteristic: Characteristic, zero_z_mm: float) -> Characteristic:
    """Returns a length from the part's zero as one from the face that stands there, where there is another one."""
    if characteristic.quantity is not Quantity.LENGTH or characteristic.other:
        return characteristic
    there = [profile.names[k] for k in profile.faces_at(zero_z_mm) if profile.names[k] != characteristic.feature]
    return replace(characteristic, other=there[0] if there else "")


def fitted_offset(gains: Array, wanted_mm: Array, standard_u_mm: Array) -> tuple[tuple[float, float], ExpandedU]:
    """Returns the closest offset (x as a radius, z) mm and its expanded uncertainty (95 %), by gains (m, 2)."""
    u = np.maximum(standard_u_mm, LEAST_U_MM)
    terms = gains / u[:, None]
    inverse = np.linalg.pinv(terms, rcond=OPEN)
    x, z = inverse @ (wanted_mm / u)
    known = np.diag(inverse @ terms) > 1.0 - OPEN
    expanded = NORMAL_95 * np.linalg.norm(inverse, axis=1)
    x_u, z_u = (float(one) if determined else None for one, determined in zip(expanded, known, strict=True))
    return (float(x), float(z)), (x_u, z_u)


def tool_proposals(
    series: Sequence[TrackedSeries], jobs: Sequence[JobTool], options: SeriesOptions, made: ProposalContext
) -> tuple[Proposal, ...]:
    """Returns a proposal for each tool offset of the finish passes that is to change, in its control's step: from the
    sizes of all that is cut with it, in every set-up.

    Raises SER-TOOL where no characteristic of the series is a size of the job's part.
    """
    by_tool = dict[tuple[Machine | None, CalledOffset], tuple[JobTool, list[tuple[TrackedSeries, Array]]]]()
    for job in jobs:
        for call, of_it in sorted(_by_tool(series, job).items()):
            by_tool.setdefault((job.machine, call), (job, []))[1].extend(of_it)
    if not by_tool:
        raise Code.SER_TOOL.refusal(
            f"none of {len(series)} series ({_names(series)}) is a size of the job's features",
            hint="name them in `[[part.characteristic]]` of the job as the inspections do, each with its feature",
        )
    every = [one for _, of_it in by_tool.values() for one in of_it]
    if not any(gain.any() for _, gain in every):
        raise Code.SER_TOOL.refusal(
            f"no tool offset changes {_names([one for one, _ in every])}: angles, radii of arcs, form, and lengths "
            "between two faces of one tool's cut",
            hint="correct the contour: `trueloop compensate` with the sizes in `gauging.readings` of the job",
        )
    found = [_of_one(job, call, of_it, options, made) for (_, call), (job, of_it) in by_tool.items()]
    return tuple(proposal for proposal in found if proposal is not None)


def _by_tool(series: Sequence[TrackedSeries], job: JobTool) -> dict[CalledOffset, list[tuple[TrackedSeries, Array]]]:
    """Groups the series by the offset that cuts their feature, each with its g."""
    found: dict[CalledOffset, list[tuple[TrackedSeries, Array]]] = {}
    cut_by = contour_tools(job.program, job.matched, alone=True).cut_by
    for one in series:
        asked = job.asked.get(one.series.name)
        if one.series.latest and asked is not None:
            index = job.profile.names.index(asked.feature)
            own = [k for k, tool in enumerate(cut_by) if tool == cut_by[index]]
            gain = moved_by_offset(job.profile, asked, job.zero_z_mm, own)
            found.setdefault(_called(job, cut_by[index], index), []).append((one, gain))
    return found


def _called(job: JobTool, cut_by: int | None, index: int) -> CalledOffset:
    """Returns the offset that cuts a feature. Raises OFS-TOOL: none, another edge each, or cut without it."""
    number, move = cut_by or job.tool, job.matched.match.features[index].moves[0].move
    if not number:
        raise no_number(job.program, move.line)
    require_in_force(job.program, job.matched.path, move.index)
    return CalledOffset(number, edge_of_pass(job.program, job.matched.path, move.index, job.edge))


def _of_one(
    job: JobTool,
    call: CalledOffset,
    of_it: Sequence[tuple[TrackedSeries, Array]],
    options: SeriesOptions,
    made: ProposalContext,
) -> Proposal | None:
    series, gains = [one for one, gain in of_it if gain.any()], np.array([gain for _, gain in of_it if gain.any()])
    if not series:
        return None
    wanted = np.array([-one.change_mm for one in series])
    u_mm = np.array([one.last.step.predicted_u_mm or 0.0 for one in series])
    offset_mm, known_mm = fitted_offset(gains, wanted, u_mm)
    cut = job.matched.match.features[0].moves[0].move.index
    wear = wear_offset(
        *(job.program, job.matched.path, cut, offset_mm, call.number, job.x_is_diameter, call.edge),
        expanded_u_mm=known_mm,
    )
    kept = wear.as_offset(True, "", HeldTool())
    moved = gains @ np.array([kept.x_radius_mm, kept.z_mm])
    if np.all(np.abs(moved) <= options.least_mm):
        return None
    effects = [effect_of(one, float(size_mm)) for one, size_mm in zip(series, moved, strict=True)]
    why = _why(wear, len(series), wanted - moved)
    if unmoved := [one for one, gain in of_it if not gain.any()]:
        why += f"; it does not change {_names(unmoved)}: the tool moves all of their surfaces alike"
    return of_tool(series, effects, kept, job.program.dialect.wear_words, made, why)


def _names(series: Sequence[TrackedSeries]) -> str:
    return ", ".join(sorted(repr(one.series.name) for one in series)[:6])


def _why(wear: WearOffset, count: int, left_mm: Array) -> str:
    left = Um(float(np.max(np.abs(left_mm))))
    return f"{wear.words}: the offset closest to what {count} characteristics ask for; it leaves up to {left} of that"


def characteristic_on(profile: Profile, characteristic: Characteristic) -> Characteristic | None:
    """Returns a characteristic that names its feature as the part does and that an offset changes; else None."""
    if characteristic.feature not in profile.names or characteristic.quantity not in (
        Quantity.DIAMETER,
        Quantity.LENGTH,
    ):
        return None
    try:
        moved_by_offset(profile, characteristic)
    except TrueloopError:
        return None
    return characteristic
