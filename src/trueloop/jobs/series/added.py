"""Inspection files into the store as parts of series."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Identity
from trueloop.domain.part import Part
from trueloop.domain.proposal import PartCutWith, Proposal, ProposalDecision
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, Stated
from trueloop.loops.post_process.flags import filled_in, known_findings, nominal_findings, unit_findings
from trueloop.loops.post_process.series import sizes_of
from trueloop.storage.store import Kept, Store, find, keep


@dataclass(frozen=True)
class Adding:
    """What is said of the files: part type and serial number where a file does not say them, unit and mapping.

    `cut_with`: the proposals that were in force when the parts were cut, by id; (): none was; None: all that were
    accepted before the part was measured, or before now.
    """

    part_type: str = ""
    serial: str = ""
    stated: Stated = field(default_factory=Stated)
    take_nominal: bool = False
    cut_with: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Added:
    """What came of one file. `parts` are serial numbers: those kept now, and those that were there before."""

    path: Path
    part_type: str
    new: tuple[str, ...]
    known: tuple[str, ...]
    cut_with: tuple[str, ...]
    sizes: int
    findings: tuple[Finding, ...]


def add_files(store: Store, paths: Sequence[Path], adding: Adding) -> list[Added]:
    """Each file in one transaction, whole or not at all, in the order given.

    Raises MSR errors; SER-PART for parts without a name or a serial number, SER-NONE for a file without sizes, SER-UNIT
    for a part in another unit than those before, SER-PROPOSAL for a proposal that was not accepted; STO errors.
    """
    return [_added(store, path, adding) for path in paths]


def _added(store: Store, path: Path, adding: Adding) -> Added:
    file = read_measured_file(path, adding.stated)
    inspections = [_named(path, one, adding, len(file.inspections)) for one in file.inspections]
    _require_sizes(file, inspections)
    part_type = inspections[0].part.part_type.name
    stored = find(store, Inspection, part_type=part_type)
    findings = [one.in_file(str(path)) for one in _findings(stored, inspections, adding)]
    for finding in findings:
        if finding.severity is Severity.ERROR:
            raise finding.as_error()
    values = {one.identity for one in (kept.value for kept in stored)}
    same = {_content(kept.value) for kept in stored if kept.value.identity not in {i.identity for i in inspections}}
    wanted = [one for one in inspections if one.identity in values or _content(one) not in same]
    cut_with = _cut_with(store, part_type, adding, [one for one in wanted if one.identity not in values])
    kept = [one for one in keep(store, [*wanted, *cut_with]) if isinstance(one.value, Inspection)]
    return Added(
        path,
        part_type,
        tuple(one.value.part.serial for one in kept if one.new),
        tuple(one.part.serial for one in inspections if not _is_new(one, kept)),
        tuple(dict.fromkeys(name for one in cut_with for name in one.proposals)),
        sum(1 for one in inspections for _ in sizes_of(one)),
        tuple(findings),
    )


def _is_new(one: Inspection, kept: Sequence[Kept[Inspection]]) -> bool:
    return any(each.new and each.value.identity == one.identity for each in kept)


def _content(inspection: Inspection) -> Identity:
    """Part, time and values: the same measurement in another file is no other one."""
    when = "" if inspection.measured_at is None else inspection.measured_at.isoformat()
    values = (f"{asked.name}={error_mm!r}" for asked, error_mm in sizes_of(inspection))
    return *inspection.part.identity, when, *values


def _named(path: Path, one: Inspection, adding: Adding, of: int) -> Inspection:
    """With part type and serial number as stated where the file does not say them; a stated part type counts."""
    part = one.part
    name = adding.part_type or part.part_type.name
    serial = part.serial or (adding.serial if of == 1 else "")
    if not name or not serial:
        lacks = "part type" if not name else "serial number"
        raise TrueloopError(
            Code.SER_PART,
            f"one of {of} parts has no {lacks} (part {serial or name!r})",
            hint="state it: `--type NAME`, and `--serial NUMBER` for a file of one part",
            place=Place(str(path)),
            values={"part": serial or name},
        )
    return replace(one, part=Part(replace(part.part_type, name=name), serial))


def _require_sizes(file: MeasuredFile, inspections: Sequence[Inspection]) -> None:
    if not any(True for one in inspections for _ in sizes_of(one)):
        readings = sum(len(one.readings) for one in inspections)
        raise TrueloopError(
            Code.SER_NONE,
            f"{file.path.name!r} holds {readings} readings of {len(inspections)} parts, 0 of them sizes with a nominal",
            hint="a series follows diameters, radii, lengths and positions that state their nominal; touches belong to "
            "`trueloop compensate`",
            place=Place(str(file.path)),
        )


def _findings(
    stored: Sequence[Kept[Inspection]], inspections: Sequence[Inspection], adding: Adding
) -> Iterator[Finding]:
    """What is odd about new parts beside those in the store; of parts that are there already nothing is said."""
    there = {_content(kept.value) for kept in stored}
    by_identity = {kept.value.identity for kept in stored}
    known: dict[str, Characteristic] = {}
    for kept in stored:
        known.update({asked.name: asked for asked, _ in sizes_of(kept.value)})
    serials = {kept.value.part.serial: kept.value for kept in stored}
    for one in inspections:
        if one.identity in by_identity and _content(one) in there:
            continue
        yield from unit_findings(known, one)
        yield from nominal_findings(one, used=adding.take_nominal)
        yield from known_findings(known, one)
        yield from _again(serials, one)
        if not filled_in(one) or adding.take_nominal:
            known.update({asked.name: asked for asked, _ in sizes_of(one)})


def _again(serials: dict[str, Inspection], one: Inspection) -> Iterator[Finding]:
    """SER-AGAIN, a part that is in the store by another inspection."""
    before = serials.get(one.part.serial)
    if before is None:
        return
    same = _content(before) == _content(one)
    yield Finding(
        Severity.WARNING,
        Code.SER_AGAIN,
        f"part {one.part.serial!r} is in the store by another file"
        + (", with the same values: not kept again" if same else ", with other values"),
        "the later inspection counts; look whether two parts have one serial number",
        values={"part": one.part.serial},
    )


def _cut_with(store: Store, part_type: str, adding: Adding, inspections: Sequence[Inspection]) -> list[PartCutWith]:
    """What each part was cut with, where any proposal was accepted before: stated, or all accepted before it.

    Raises SER-PROPOSAL for a proposal that was not accepted.
    """
    proposals = {one.value.id for one in find(store, Proposal, part_type=part_type)}
    decided = [one.value for one in find(store, ProposalDecision) if one.value.proposal in proposals]
    accepted = [one for one in decided if one.verdict == "accepted"]
    asked = adding.cut_with
    for one in asked or ():
        if one not in {each.proposal for each in accepted}:
            raise TrueloopError(
                Code.SER_PROPOSAL,
                f"proposal {one!r} is none of the {len(accepted)} accepted ones of {part_type!r}",
                hint="`trueloop series status` lists them; `--cut-with none` where none was in force",
                values={"proposal": one},
            )
    if not accepted:
        return []
    return [
        PartCutWith(one.identity, _accepted_before(one, accepted) if asked is None else asked) for one in inspections
    ]


def _accepted_before(inspection: Inspection, accepted: Sequence[ProposalDecision]) -> tuple[str, ...]:
    at = inspection.measured_at
    if at is None or at.tzinfo is None:
        return tuple(one.proposal for one in accepted)
    return tuple(one.proposal for one in accepted if one.at < at)
