"""Keeps measurements of a part in the store and links them with the cut that they show."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

import numpy as np

from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.domain.life import Cut, Identity, InspectionLink, Stage
from trueloop.domain.part import Part
from trueloop.domain.record import sha256_of
from trueloop.domain.tool import Setting
from trueloop.errors import Code, Finding, Severity
from trueloop.formats.jobs.job import Job
from trueloop.formats.jobs.tool_tables import ToolsTable
from trueloop.formats.toml_tables import options_from
from trueloop.jobs.measure.measured import serial_error
from trueloop.jobs.store.history import LivedPart, errors_of, finish_inspection, order_in_doubt, touched_at
from trueloop.jobs.store.keep_facts import (
    CutStatement,
    KeptFacts,
    correction_of,
    finish_cut,
    is_changed,
    judged_parts,
    keep_facts,
    said_of_each,
    texts_of,
)
from trueloop.jobs.store.of_this_part import (
    as_known,
    cuts_of,
    link_of,
    other_points,
    require_file_of_part,
    require_later,
    require_serial,
    require_size,
)
from trueloop.jobs.store.opened import Beside, Keeping, accepting, store_of
from trueloop.jobs.tools import apart
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.inputs import edge_of_job, machine_of_job
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.readings import DEVICES, part_type
from trueloop.jobs.turned.shares import inspection_of_edge, shares_of
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.tool_path import PER_REVOLUTION
from trueloop.report.measured import FileOnPart
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find
from trueloop.turned.touches.touches import Gauging
from trueloop.wording import wording

After: TypeAlias = Literal["semifinish", "finish", "released"]
"""The stage after which a part was inspected; released: it had left the machine."""


@dataclass(frozen=True)
class StatedCut:
    """The cut that an inspection shows, as stated: stage, data of a finish cut; `measured_at` if it states none."""

    after: After
    cut: CutStatement = field(default_factory=CutStatement)
    measured_at: datetime | None = None


@dataclass(frozen=True)
class _KeepingContext:
    """Context while the inspections of a job are kept; refusals that are accepted go to `findings`.

    `finished` has the parts with a finish cut, by the identity of that cut, each with the inspection that memory takes.
    """

    store: Store
    files: JobFiles
    shown: StatedCut
    keeping: Keeping
    findings: list[Finding]
    finished: dict[Identity, LivedPart] = field(default_factory=dict)


def keep_measured(
    files: Sequence[FileOnPart], job: Path, shown: StatedCut, keeping: Keeping, names: Mapping[str, str] | None = None
) -> KeptFacts | None:
    """Keeps the inspections of files, and which cut they show; None: no store knows the correction.

    `names`: the profile's names of features, by those in the files. Raises MSR-SERIAL, STO-PART, STO-OTHER-PART,
    STO-LINK, STO-STAGE, STO-CLOCK, STO-UNIT, STO-PROGRAM, and what keeping refuses.
    """
    for file in files:
        serials = [on_part.inspection.part.serial for on_part in file.on_part]
        if len(serials) > 1 and "" in serials:
            raise serial_error(file.file, f"holds {serials.count('')} inspections of an unknown part")
    inspections = [(file.file.path.name, on_part.inspection) for file in files for on_part in file.on_part]
    beside: Beside = "made" if shown.after == "semifinish" else "used"
    return _keep(inspections, JobFiles.of(job), shown, keeping, beside, names or {})


def keep_inspections(
    inspections: Sequence[tuple[str, Inspection]], job: Path, shown: StatedCut, keeping: Keeping
) -> KeptFacts | None:
    """Keeps inspections with the names of their files; None: no store is named, and the part has no serial number."""
    files = JobFiles.of(job)
    known = keeping.serial or files.job.part.serial or all(inspection.part.serial for _, inspection in inspections)
    return _keep(inspections, files, shown, keeping, "made" if known else "unused", {})


def _keep(
    inspections: Sequence[tuple[str, Inspection]],
    files: JobFiles,
    shown: StatedCut,
    keeping: Keeping,
    beside: Beside,
    names: Mapping[str, str],
) -> KeptFacts | None:
    files = files.with_serial(keeping.serial)
    store = store_of(files.path.parent, keeping.db, files.job.store.db, beside)
    return None if store is None else keep_in(store, inspections, files, shown, keeping, names)


def keep_in(
    store: Store,
    inspections: Sequence[tuple[str, Inspection]],
    files: JobFiles,
    shown: StatedCut,
    keeping: Keeping,
    names: Mapping[str, str] = MappingProxyType({}),
) -> KeptFacts:
    """Keeps inspections in a store that is open."""
    several = files.job.tools or files.job.setups
    shares = _shares(files, inspections, names) if several else [_Share(files, inspections, names)]
    said = said_of_each(store, [one.files.job.part.name for one in shares], shown.cut) if several else [shown.cut]
    values, findings, finished = list[Any](), list[Finding](), list[LivedPart]()
    for share, cut in zip(shares, said, strict=True):
        given = _KeepingContext(store, share.files, replace(shown, cut=cut), keeping, findings)
        for file, inspection in share.inspections:
            values += _facts(given, _of_part(inspection, share.files.job, shown, share.names, file))
        finished += given.finished.values()
    obtained, alarms, quarantines = judged_parts(store, finished, keeping.accept)
    kept = keep_facts(store, [*values, *quarantines], [*findings, *alarms], supersede=keeping.supersede)
    return replace(kept, obtained=tuple(obtained))


@dataclass(frozen=True)
class _Share:
    """A part that is kept on its own: its job, and its measurements by the names of files."""

    files: JobFiles
    inspections: Sequence[tuple[str, Inspection]]
    names: Mapping[str, str]


def _shares(files: JobFiles, inspections: Sequence[tuple[str, Inspection]], names: Mapping[str, str]) -> list[_Share]:
    """Returns a part's measurements by edge, each as a job of its own with the features that the edge cuts."""
    profile, found = files.profile(), list[_Share]()
    inspections = [(file, _from_reference(inspection, files.job)) for file, inspection in inspections]
    drawn = characteristics_of(files.located, profile)
    for share in shares_of(files):
        mine = [
            (file, inspection_of_edge(inspection, profile, share.own, names, share.setup, drawn=drawn))
            for file, inspection in inspections
        ]
        found.append(_Share(share.files, [(file, inspection) for file, inspection in mine if inspection.values], {}))
    return found


def _facts(context: _KeepingContext, one: Inspection) -> Iterator[Any]:
    """An inspection, its part, the cut that it shows, and the link."""
    one = as_known(context.store, one)
    require_file_of_part(context.store, one)
    semifinish = context.shown.after == "semifinish"
    cut = _semifinish_cut(context, one.part) if semifinish else _finish_cut(context, one)
    require_stage(context.store, one, cut)
    if not semifinish and context.shown.cut.program is not None:
        yield from texts_of([context.shown.cut.program])
    yield from (one.part, cut, one, InspectionLink(one.identity, cut.identity, context.shown.after == "released"))


def _of_part(inspection: Inspection, job: Job, shown: StatedCut, names: Mapping[str, str], file: str) -> Inspection:
    """The inspection as of the job's part, with the profile's names of features. Raises STO-PART."""
    part = Part(part_type(job), inspection.part.serial or job.part.serial)
    require_serial(part, file)
    by_probe = job.machine is not None and job.machine.touched_on == "machine" and inspection.measured == "touches"
    of_job = (job.gauging.device or DEVICES["machine"]) if by_probe and shown.after != "released" else ""
    return replace(
        _from_reference(inspection, job),
        part=part,
        device=inspection.device or of_job,
        values=tuple(_renamed(value, names) for value in inspection.values) if names else inspection.values,
        measured_at=inspection.measured_at or shown.measured_at,
    )


def _from_reference(inspection: Inspection, job: Job) -> Inspection:
    """Returns the inspection with the point from which its z is taken, where it has the job's."""
    reference = options_from(Gauging, job).z_reference
    of_reference = any(touch.point == reference for touch in inspection.touches)
    return replace(inspection, z_reference=inspection.z_reference or (reference if of_reference else None))


def _renamed(value: Touch | Reading | CmmPoint, names: Mapping[str, str]) -> Touch | Reading | CmmPoint:
    if isinstance(value, Touch):
        return replace(value, feature=names.get(value.feature or "", value.feature))
    if isinstance(value, Reading):
        feature = names.get(value.characteristic) or names.get(value.feature, value.feature)
        return replace(value, feature=feature, other=names.get(value.other, value.other))
    return value


def _semifinish_cut(context: _KeepingContext, part: Part) -> Cut:
    """The one that is stored, else as the job says it."""
    known = cuts_of(context.store, part, Stage.SEMIFINISH)
    if known:
        return known[-1]
    job, files = context.files.job, context.files
    program = None if job.own_programs.semifinish is None else files.program(job.own_programs.semifinish)
    tool, edge = files.tool, edge_of_job(files.tool)
    corner = tool.groove_corner if isinstance(tool, ToolsTable) else None
    setting = None if edge is None else Setting(apart(edge, corner), tool.set_at)
    sha256 = "" if program is None else sha256_of(program.source)
    return Cut(part, Stage.SEMIFINISH, setting, machine_of_job(job), sha256)


def _finish_cut(context: _KeepingContext, inspection: Inspection) -> Cut:
    """The finish cut, after what contradicts the correction is refused or noted."""
    store, findings, said = context.store, context.findings, context.shown.cut
    correction = correction_of(store, inspection.part, said)
    with accepting(context.keeping.accept, findings):
        before = ("the inspection before the finish cut", touched_at(correction))
        require_later(before, ("the inspection after it", inspection.measured_at))
    after = errors_of(correction.payload.profile, inspection)
    if after is None:
        findings.append(_no_points(inspection))
    else:
        findings += other_points(inspection.part, correction.payload, after)
        with accepting(context.keeping.accept, findings):
            require_size(correction.payload, after)
    findings += is_changed(correction, inspection.part, said)
    cut = _under_conditions(context, finish_cut(store, inspection.part, correction, said))
    doubts = list(order_in_doubt(store, cut, inspection.measured_at))
    findings += doubts
    if cut.setting is None:
        findings.append(no_edge(inspection.part))
    lived = LivedPart(cut, correction, inspection, bool(doubts))
    if lived.by_own_probe:
        findings.append(_own_probe(inspection))
    _take_finished(context, lived, inspection)
    return cut


def _take_finished(context: _KeepingContext, lived: LivedPart, inspection: Inspection) -> None:
    """The part as memory will take it: by the latest inspection, and not by one off the machine beside one on it."""
    links = find(context.store, InspectionLink, cut=joined(lived.cut.identity))
    if context.shown.after == "released" and any(not link.value.released for link in links):
        return
    counts = finish_inspection(context.store, lived.cut)
    is_known = any(link.value.inspection == inspection.identity for link in links)
    if is_known and counts is not None and counts.identity != inspection.identity:
        lived = replace(lived, finish=counts)
    context.finished[lived.cut.identity] = lived


def _under_conditions(context: _KeepingContext, cut: Cut) -> Cut:
    """With depth of cut and material by the job, feed by its finish program; a stored cut stays as it is."""
    if cuts_of(context.store, cut.part, Stage.FINISH):
        return cut
    job, files = context.files.job, context.files
    known = cut.conditions
    allowance_mm = job.own_programs.semifinish_allowance_mm
    depth_mm = allowance_mm if known.depth_of_cut_mm is None else known.depth_of_cut_mm
    feed_mm = _feed_mm(files) if known.feed_mm_per_rev is None else known.feed_mm_per_rev
    material = known.material or job.part.material
    conditions = replace(known, depth_of_cut_mm=depth_mm, feed_mm_per_rev=feed_mm, material=material)
    return replace(cut, conditions=conditions)


def _feed_mm(files: JobFiles) -> float | None:
    """The usual feed of the finish program, mm a revolution; None where it is not by the revolution."""
    path = files.run.of(files.finish_program())
    moves = [move.index for move in feed_moves(path)]
    feeds = path.feed[moves][path.feed_mode[moves] == PER_REVOLUTION]
    feeds = feeds[np.isfinite(feeds)]
    return float(np.median(feeds)) if len(feeds) else None


def require_stage(store: Store, one: Inspection, cut: Cut) -> None:
    """Raises STO-STAGE for what was kept before as the inspection of another cut of the part."""
    known = link_of(store, one)
    if known is not None and known.cut != cut.identity:
        stage = known.cut[len(one.part.identity)]
        raise Code.STO_STAGE.refusal(
            wording(
                "this inspection of part {serial!r} is kept as that of its {stage} cut, not its {kept} cut",
                serial=one.part.serial,
                stage=stage,
                kept=cut.stage,
            ),
            hint=wording("name the file of this stage"),
            values={"serial": one.part.serial},
        )


def _own_probe(one: Inspection) -> Finding:
    return Finding(
        Severity.WARNING,
        Code.STO_PATTERN,
        f"the machine's own probe inspected part {one.part.serial!r}: {one.count} touches carry the machine's error "
        "at temperatures that are not stated; they are kept, and teach nothing of an edge",
        hint="inspect finished parts by a gauge or a measuring machine; `trueloop machine decompose` keeps both",
        values={"serial": one.part.serial, "points": float(one.count)},
    )


def _no_points(one: Inspection) -> Finding:
    return Finding(
        Severity.WARNING,
        Code.STO_PATTERN,
        f"0 of {one.count} values of part {one.part.serial!r} are errors at places of its profile: they are kept, and "
        "teach nothing of an edge",
        hint="hand in touches or points; sizes are followed by `trueloop series add`",
        values={"serial": one.part.serial, "points": 0.0},
    )


def no_edge(part: Part) -> Finding:
    """Makes the warning that a finish cut teaches nothing of an edge."""
    return Finding(
        Severity.WARNING,
        Code.STO_EDGE,
        f"the edge that cut part {part.serial!r} is not stated: the part is kept, and teaches nothing of an edge",
        hint="name it in the job's table [tool] before the correction is made: `name`, `insert`, `corner`",
        values={"serial": part.serial},
    )
