"""Series of parts: files into the store, what the store holds of a series, proposals and decisions."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Identity
from trueloop.domain.part import Part
from trueloop.domain.proposal import PartCutWith, Proposal, ProposalClass, ProposalDecision
from trueloop.domain.record import Correction as StoredCorrection
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.factory.book import Book, only_type, read_book
from trueloop.formats.input_file import FilePath
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.tool_tables.known import new_table, read_tool_table
from trueloop.formats.tables.tool_tables.tool_table import Unit, XIs
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.characteristics import characteristics_of
from trueloop.jobs.turned.inputs import machine_of_job, read_setups
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.user import user_name
from trueloop.loops.post_process.decide import decide, filled_in, known_findings, nominal_findings, unit_findings
from trueloop.loops.post_process.propose import (
    JobTool,
    ProposalContext,
    characteristic_on,
    proposals_of,
    tool_proposals,
)
from trueloop.loops.post_process.series import SeriesOptions, sizes_of
from trueloop.loops.post_process.tracked import replay
from trueloop.loops.turned.commanded import commanded
from trueloop.loops.turned.cuts import OfSetup
from trueloop.loops.turned.part import require_offset
from trueloop.loops.turned.share import characteristics_in, index_in
from trueloop.nc.match.own_contour import OwnContour
from trueloop.report.series.values import SeriesShape, replay_shape, status_shape
from trueloop.storage.store import Kept, Store, find, keep
from trueloop.turned.program.wear_numbers import CONTROLS, Control, WearOffset, counted, offset_program
from trueloop.wording import shell_word


@dataclass(frozen=True)
class Adding:
    """Options for the files: part type and serial number if a file does not state them, unit and mapping.

    Of a file of several part types the stated one is taken.

    `cut_with`: the proposals that were in force when the parts were cut, by id; (): none was; None: all that were
    accepted before the part was measured, or before now.
    """

    part_type: str = ""
    serial: str = ""
    stated: StatedFacts = field(default_factory=StatedFacts)
    take_nominal: bool = False
    cut_with: tuple[str, ...] | None = None


@dataclass(frozen=True)
class AddedFile:
    """The result of one file. `parts` are serial numbers: those kept now, and those that were there before."""

    path: Path
    part_type: str
    new: tuple[str, ...]
    known: tuple[str, ...]
    cut_with: tuple[str, ...]
    sizes: int
    findings: tuple[Finding, ...]


def add_inspections(store: Store, paths: Sequence[FilePath], adding: Adding | None = None) -> list[AddedFile]:
    """Adds the inspections of each file in one transaction, whole or not at all, in the order given.

    Raises MSR errors; SER-PART for parts without a name or a serial number, SER-NONE for a file without sizes, SER-UNIT
    for a part in another unit than those before, SER-PROPOSAL for a proposal that was not accepted; STO errors.

    >>> store = trueloop.make_store("shop.db")
    >>> (added,) = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> added.part_type, added.new, added.sizes
    ('SHAFT', ('101', '102', '103'), 12)
    """
    return [_added(store, Path(path), adding or Adding()) for path in paths]


def stored_inspections(store: Store, part_type: str | None = None) -> list[Inspection]:
    """Returns the inspections of a part type, of all types without one, in the order in which they were kept.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> [one.part.serial for one in trueloop.stored_inspections(store, "SHAFT")]
    ['101', '102', '103']
    """
    kept = [stored.value for stored in find(store, Inspection)]
    return [inspection for inspection in kept if part_type in (None, inspection.part.part_type.name)]


def _added(store: Store, path: Path, adding: Adding) -> AddedFile:
    file = read_measured_file(path, adding.stated)
    of_type = _of_type(path, file.inspections, adding.part_type)
    inspections = [_named(path, inspection, adding, len(of_type)) for inspection in of_type]
    if not any(True for inspection in inspections for _ in sizes_of(inspection)):
        readings = sum(len(inspection.readings) for inspection in inspections)
        raise Code.SER_NONE.refusal(
            f"{file.path.name!r} holds {readings} readings of {len(inspections)} parts, 0 of them sizes with a nominal",
            hint="a series follows diameters, radii, lengths and positions that state their nominal; touches belong to "
            "`trueloop compensate`",
            place=Place(str(file.path)),
        )
    part_type = inspections[0].part.part_type.name
    stored = find(store, Inspection, part_type=part_type)
    findings = [one.in_file(str(path)) for one in _findings(stored, inspections, adding)]
    for finding in findings:
        if finding.severity is Severity.ERROR:
            raise finding.as_error()
    values = {inspection.identity for inspection in (kept.value for kept in stored)}
    same = {_content(kept.value) for kept in stored if kept.value.identity not in {i.identity for i in inspections}}
    wanted = [
        inspection for inspection in inspections if inspection.identity in values or _content(inspection) not in same
    ]
    cut_with = _cut_with(
        store, part_type, adding, [inspection for inspection in wanted if inspection.identity not in values]
    )
    kept = [one for one in keep(store, [*wanted, *cut_with]) if isinstance(one.value, Inspection)]
    return AddedFile(
        path=path,
        part_type=part_type,
        new=tuple(one.value.part.serial for one in kept if one.new),
        known=tuple(inspection.part.serial for inspection in inspections if not _is_new(inspection, kept)),
        cut_with=tuple(dict.fromkeys(name for one in cut_with for name in one.proposals)),
        sizes=sum(1 for inspection in inspections for _ in sizes_of(inspection)),
        findings=tuple(findings),
    )


def _is_new(inspection: Inspection, kept: Sequence[Kept[Inspection]]) -> bool:
    return any(each.new and each.value.identity == inspection.identity for each in kept)


def _content(inspection: Inspection) -> Identity:
    """Part, time and values: the same measurement in another file is not another one."""
    when = "" if inspection.measured_at is None else inspection.measured_at.isoformat()
    values = (f"{asked.name}={error_mm!r}" for asked, error_mm in sizes_of(inspection))
    return *inspection.part.identity, when, *values


def _of_type(path: Path, inspections: Sequence[Inspection], part_type: str) -> Sequence[Inspection]:
    """Returns those of the stated part type where a file states several: serial numbers count within a type."""
    types = list(dict.fromkeys(inspection.part.part_type.name for inspection in inspections))
    if len(types) < 2:
        return inspections
    chosen = [inspection for inspection in inspections if part_type and inspection.part.part_type.name == part_type]
    if not chosen:
        listed = ", ".join(map(repr, types[:8]))
        raise Code.SER_PART.refusal(
            f"{path.name!r} holds parts of {len(types)} part types, {listed}"
            + (f", none of {part_type!r}" if part_type else ""),
            hint=f"add one after the other: `--type {shell_word(next(filter(None, types)))}` takes its parts alone",
            place=Place(str(path)),
            values={"part": types[0]},
        )
    return chosen


def _named(path: Path, inspection: Inspection, adding: Adding, of: int) -> Inspection:
    """With part type and serial number as stated where the file does not say them; a stated part type counts."""
    part = inspection.part
    name = adding.part_type or part.part_type.name
    serial = part.serial or (adding.serial if of == 1 else "")
    if not name or not serial:
        lacks = "part type" if not name else "serial number"
        raise Code.SER_PART.refusal(
            f"a part has no {lacks} (part {serial or name!r}; parts in the file: {of})",
            hint="state it: `--type NAME`, and `--serial NUMBER` for a file of one part",
            place=Place(str(path)),
            values={"part": serial or name},
        )
    return replace(inspection, part=Part(replace(part.part_type, name=name), serial))


def _findings(
    stored: Sequence[Kept[Inspection]], inspections: Sequence[Inspection], adding: Adding
) -> Iterator[Finding]:
    """Returns findings on new parts beside those in the store; parts that are stored already give none."""
    there = {_content(kept.value) for kept in stored}
    by_identity = {kept.value.identity for kept in stored}
    known: dict[str, Characteristic] = {}
    for kept in stored:
        known.update({asked.name: asked for asked, _ in sizes_of(kept.value)})
    serials = {kept.value.part.serial: kept.value for kept in stored}
    for inspection in inspections:
        if inspection.identity in by_identity and _content(inspection) in there:
            continue
        yield from unit_findings(known, inspection)
        yield from nominal_findings(inspection, used=adding.take_nominal)
        yield from known_findings(known, inspection)
        yield from _again(serials, inspection)
        if not filled_in(inspection) or adding.take_nominal:
            known.update({asked.name: asked for asked, _ in sizes_of(inspection)})


def _again(serials: dict[str, Inspection], inspection: Inspection) -> Iterator[Finding]:
    """SER-AGAIN, a part that is in the store by another inspection."""
    before = serials.get(inspection.part.serial)
    if before is None:
        return
    same = _content(before) == _content(inspection)
    yield Finding(
        Severity.WARNING,
        Code.SER_AGAIN,
        f"part {inspection.part.serial!r} is in the store by another file"
        + (", with the same values: not kept again" if same else ", with other values"),
        "the later inspection counts; look whether two parts have one serial number",
        values={"part": inspection.part.serial},
    )


def _cut_with(store: Store, part_type: str, adding: Adding, inspections: Sequence[Inspection]) -> list[PartCutWith]:
    """Returns the proposals in force by part, stated or all accepted before it. Raises SER-PROPOSAL: not accepted."""
    proposals = {stored.value.id for stored in find(store, Proposal, part_type=part_type)}
    decided = [stored.value for stored in find(store, ProposalDecision) if stored.value.proposal in proposals]
    accepted = [decision for decision in decided if decision.verdict == "accepted"]
    asked = adding.cut_with
    for one in asked or ():
        if one not in {each.proposal for each in accepted}:
            raise Code.SER_PROPOSAL.refusal(
                f"proposal {one!r} is not one of the {len(accepted)} accepted ones of {part_type!r}",
                hint="`trueloop series status` lists them; `--cut-with none` where none was in force",
                values={"proposal": one},
            )
    if not accepted:
        return []
    return [
        PartCutWith(inspection.identity, _accepted_before(inspection, accepted) if asked is None else asked)
        for inspection in inspections
    ]


def _accepted_before(inspection: Inspection, accepted: Sequence[ProposalDecision]) -> tuple[str, ...]:
    at = inspection.measured_at
    if at is None or at.tzinfo is None:
        return tuple(decision.proposal for decision in accepted)
    return tuple(decision.proposal for decision in accepted if decision.at < at)


def follow_series(store: Store, part_type: str | None = None) -> SeriesShape:
    """Returns the series of a part type, the only one without a name: each characteristic over the parts, in µm.

    Raises SER-UNKNOWN.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> journal = trueloop.follow_series(store).characteristics[0]
    >>> journal.characteristic, [part.after_um for part in journal.parts]
    ('journal', [26.0, 29.0, 27.0])
    """
    options = SeriesOptions()
    return status_of(read_book(store, part_type or only_type(store), options), options)


def status_of(book: Book, options: SeriesOptions) -> SeriesShape:
    """Returns the series as they are."""
    return status_shape(book.part_type, book.tracked, len(book.parts), book.findings, options)


def replay_of(book: Book) -> SeriesShape:
    """Returns the series as they would have been with memory."""
    replays = [replay(series.series) for series in book.tracked]
    return replay_shape(book.part_type, replays, len(book.parts), book.findings)


def tools_of_job(path: Path, book: Book) -> tuple[JobTool, ...]:
    """Returns each tool of a job with its contour, its moves and the series of sizes of it alone, in the frame of its
    set-up.

    A size between features of two edges is of neither. Raises JOB, GEO, SET and NC errors.
    """
    files = JobFiles.of(path)
    read = read_setups(files)
    read.found.require_plain()
    asked = _asked(files, read.profile, book)
    pairs = zip(read.found.setups, read.files, strict=True)
    return tuple(_job_tool(read.profile, of, one, own, asked) for of, one in pairs for own in of.contours)


def _job_tool(
    part: Profile, of: OfSetup, files: JobFiles, own: OwnContour | None, characteristics: Mapping[str, Characteristic]
) -> JobTool:
    """Returns a tool of a set-up; `own` None: the job's only one. Raises SET-OFFSET where the control mirrors Z."""
    program, frame = of.setup.program, of.setup.frame
    x_is = files.job.own_programs.offset_x_is
    x_is_diameter = None if x_is is None else x_is == "diameter"
    if own is None:
        matched = commanded(program, None, part, files.nose_radius_mm, 0.0, files.run)
        return JobTool(
            profile=part,
            program=program,
            matched=matched,
            asked=characteristics,
            tool=files.tool.number,
            x_is_diameter=x_is_diameter,
            edge=files.tool.table_edge or 0,
        )
    require_offset(own, frame, {}, str(files.path))
    called = own.edge.called
    run = replace(files.run, called=called)
    matched = commanded(program, None, own.profile, own.edge.nose_radius_mm, 0.0, run)
    # Those of an edge's features alone, by their names on its contour and in its frame; `profile` is the part's
    features = len(part.names)
    names = {
        part.names[index_in(frame, i, features)]: own.profile.names[k]
        for k, parts in enumerate(own.parts)
        for i in parts
    }
    mine = {
        name: replace(characteristic, feature=names[characteristic.feature], other=names.get(characteristic.other, ""))
        for name, characteristic in zip(
            characteristics, characteristics_in(frame, list(characteristics.values())), strict=True
        )
        if characteristic.feature in names and (not characteristic.other or characteristic.other in names)
    }
    return JobTool(
        profile=own.profile,
        program=program,
        matched=matched,
        asked=mine,
        tool=called.number,
        x_is_diameter=x_is_diameter,
        edge=called.edge,
        zero_z_mm=frame.z_mm(0.0),
        machine=machine_of_job(files.job),
    )


def _asked(files: JobFiles, profile: Profile, book: Book) -> Mapping[str, Characteristic]:
    """The part's characteristics by name: as the job has them, else as the inspections name features of it."""
    stated = {characteristic.name: characteristic for characteristic in characteristics_of(files.located, profile)}
    series = [one.series.characteristic for one in book.tracked]
    named = {
        characteristic.name: stated.get(characteristic.name) or characteristic_on(profile, characteristic)
        for characteristic in series
    }
    return {name: characteristic for name, characteristic in named.items() if characteristic is not None}


@dataclass(frozen=True)
class SeriesProposals:
    """Proposals that hold now, and decisions; `new`: ids made now; `not_accepted`: why an automatic one waits."""

    book: Book
    proposals: tuple[Proposal, ...]
    new: frozenset[str]
    not_accepted: tuple[str, ...] = ()


def _require_uncorrected(store: Store, book: Book) -> None:
    """Refuses parts cut with a correction of finished parts: no proposal has it, the next correction goes on."""
    of_finished = {
        stored.value.record.id
        for stored in find(store, StoredCorrection, part_type=book.part_type, whole=False)
        if stored.value.record.cut_with is not None
    }
    cuts = find(store, Cut, part_type=book.part_type) if of_finished else []
    corrected = {cut.value.part.serial for cut in cuts if cut.value.correction in of_finished}
    serial = next((serial for of in book.parts if (serial := of.inspection.part.serial) in corrected), None)
    if serial is not None:
        raise Code.SER_CORRECTED.refusal(
            f"part {serial!r} was cut with a correction that `trueloop compensate` made from a finished part: a "
            "proposal would count it as cut without one",
            hint="`trueloop compensate` with the job of the latest part corrects the next one by the whole series",
            values={"part": serial},
        )


def propose(store: Store, book: Book, options: SeriesOptions, job: Path | None = None) -> SeriesProposals:
    """Keeps what the series propose for the next part; classes switched to automatic are accepted at once.

    With a job the offsets are those of its tools. Raises JOB, NC, SER-CORRECTED and SER-TOOL errors.
    """
    _require_uncorrected(store, book)
    made = ProposalContext(user_name(), datetime.now(UTC))
    found = list(proposals_of(book.tracked, options, made))
    if job is not None:
        found = [proposal for proposal in found if proposal.changes is not ProposalClass.TOOL_OFFSET]
        found += tool_proposals(book.tracked, tools_of_job(job, book), options, made)
    known = {proposal.id: proposal for proposal in book.proposals}
    kept = keep(store, [proposal for proposal in found if proposal.id not in known])
    proposals = tuple(known.get(proposal.id, proposal) for proposal in found)
    waiting: list[str] = []
    for proposal in proposals:
        if proposal.changes in options.automatic and book.verdict(proposal) is None:
            try:
                decision = decision_on(book, proposal, "accepted", options, why="its class is automatic")
                keep(store, [replace(decision, automatic=True)])
            except TrueloopError as refused:
                waiting.append(str(refused))
    new = frozenset(stored.value.id for stored in kept if stored.new)
    return SeriesProposals(read_book(store, book.part_type, options), proposals, new, tuple(waiting))


def decision_on(
    book: Book,
    proposal: Proposal,
    verdict: Literal["accepted", "rejected"],
    options: SeriesOptions,
    *,
    who: str = "",
    why: str = "",
    override: Collection[str] = (),
) -> ProposalDecision:
    """Decides on a proposal as the book stands; the first of two counts. Raises SER errors that `override` lacks."""
    now, series = datetime.now(UTC), book.by_identity
    by = who or user_name()
    return decide(proposal, verdict, by, now, series, book.decisions, options, why=why, override=override)


def proposal_named(store: Store, name: str) -> Proposal:
    """Returns the proposal whose id begins so. Raises SER-PROPOSAL where there is none, or several."""
    every = [stored.value for stored in find(store, Proposal)]
    found = [proposal for proposal in every if proposal.id.startswith(name)]
    if len(found) == 1 and name:
        return found[0]
    raise Code.SER_PROPOSAL.refusal(
        f"{name!r} is the beginning of {len(found)} of {len(every)} proposals",
        hint="`trueloop series status` lists those that wait for a decision",
        values={"proposal": name},
    )


def accepted(
    store: Store,
    name: str,
    options: SeriesOptions,
    where: "Written | None",
    *,
    who: str,
    why: str,
    override: Collection[str],
) -> tuple[Proposal, ProposalDecision, Path | None]:
    """Accepts a proposal by its id and writes its tool offset; where that cannot be written nothing is accepted."""
    proposal = proposal_named(store, name)
    book = read_book(store, proposal.part_type.name, options)
    decision = decision_on(book, proposal, "accepted", options, who=who, why=why, override=override)
    file = None if where is None else write_offset(proposal, where)
    keep(store, [decision])
    return proposal, decision, file


def rejected(store: Store, name: str, *, who: str, why: str) -> tuple[Proposal, ProposalDecision]:
    """Rejects a proposal by its id."""
    proposal, options = proposal_named(store, name), SeriesOptions()
    book = read_book(store, proposal.part_type.name, options)
    decision = decision_on(book, proposal, "rejected", options, who=who, why=why)
    keep(store, [decision])
    return proposal, decision


@dataclass(frozen=True)
class Written:
    """Where an accepted offset is to be written: in a control's words, or into a copy of its tool table.

    `control` None: that of the job's program; `x_is` None: as that counts.
    """

    output: Path
    control: Control | None = None
    table: Path | None = None
    unit: Unit | None = None
    x_is: XIs | None = None


def write_offset(proposal: Proposal, where: Written) -> Path:
    """Writes an accepted proposal's tool offset. Raises OFS-NONE where it has none, OFS and OUT errors."""
    if proposal.tool_offset is None:
        names = ", ".join(map(repr, proposal.characteristics))
        raise Code.OFS_NONE.refusal(
            f"proposal {proposal.id} changes {names} and names no tool",
            hint="`trueloop series propose --job JOB.toml` proposes the offset of the job's tool",
        )
    offset = proposal.tool_offset
    if where.table is not None:
        table = read_tool_table(where.table, where.unit)
        content, inputs = new_table(table, offset, proposal.id).content, [where.table]
    else:
        control = where.control or _control_of(proposal)
        counts = (where.x_is or offset.x_is) if control == proposal.control else counted(control, where.x_is)
        content, inputs = offset_program(control, WearOffset.of(offset, counts), proposal.id).encode(), []
    (written,) = write_all(where.output.parent, [(where.output.name, content)], inputs)
    return written


def _control_of(proposal: Proposal) -> Control:
    """That of the job's program; where there is not one of ours, one without words, which says so."""
    return next((one for one in CONTROLS if one == proposal.control), "heidenhain")
