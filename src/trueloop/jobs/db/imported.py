"""Files into the store: inspections, records and exports; each file in one transaction, whole or not at all.

Findings in a store: damage, links to nothing, labels against links, order, clock.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import Any, Final

from sqlalchemy import select

from trueloop.domain.inspection import Inspection
from trueloop.domain.labels import PartLabel, ProgramLabel, contradictions, labels_in
from trueloop.domain.life import Cut, Identity, InspectionLink, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import Correction, Program, Record
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError, in_file
from trueloop.formats.input_file import readable
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.formats.jobs.job import Job
from trueloop.formats.record_file import read_record
from trueloop.jobs.db.copied import HEAD, is_export, keep_lines, read_export
from trueloop.jobs.db.found import row_name, row_of
from trueloop.jobs.measure.measured import PartOfJob, read_measured
from trueloop.jobs.store.history import Dated, cutting_order
from trueloop.jobs.store.of_this_part import require_file_of_part, require_later
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.readings import part_type, read_inspection
from trueloop.jobs.user import user_name
from trueloop.storage.integrity import Damage, damage
from trueloop.storage.keeping import Query, found
from trueloop.storage.kinds import KINDS, Kind
from trueloop.storage.schema import TABLES
from trueloop.storage.store import Store, keep
from trueloop.storage.value_rows import Kept


@dataclass
class Facts:
    """The values to compare, of rows that are not superseded; inspections without their values, which may be many."""

    inspections: dict[Identity, Inspection] = field(default_factory=dict)
    cuts: dict[Identity, Kept[Cut]] = field(default_factory=dict)
    links: list[Kept[InspectionLink]] = field(default_factory=list)
    records: dict[str, tuple[str, Record]] = field(default_factory=dict)
    programs: dict[str, str] = field(default_factory=dict)

    def take(self, kept: Kept[Any]) -> None:
        """Adds a row."""
        value = kept.value
        if isinstance(value, Inspection):
            self.inspections[value.identity] = replace(value, values=())
        elif isinstance(value, Cut):
            self.cuts[value.identity] = kept
        elif isinstance(value, InspectionLink):
            self.links.append(kept)
        elif isinstance(value, Program):
            self.programs[value.sha256] = value.name
        elif isinstance(value, Correction):
            small = replace(value.record, inspections=(), model={}, changes=[])
            self.records[value.record.id] = row_name(Correction, kept.row), small


def odd_links(facts: Facts) -> Iterator[Finding]:
    """Yields STO-LOST: links and cuts that name what is not in the store, or what is superseded."""
    for link in facts.links:
        row = row_name(InspectionLink, link.row)
        if link.value.inspection not in facts.inspections:
            yield _no_such(row, "inspection", link.value.inspection)
        if link.value.cut not in facts.cuts:
            yield _no_such(row, "cut", link.value.cut)
    for cut in facts.cuts.values():
        if cut.value.correction and cut.value.correction not in facts.records:
            yield _no_such(row_name(Cut, cut.row), "correction", (cut.value.correction,))


def odd_labels(facts: Facts) -> Iterator[Finding]:
    """Yields LAB-LINK: labels in the names of programs, and of a record's files, against cuts and inspections."""
    for cut in facts.cuts.values():
        name, part = facts.programs.get(cut.value.program_sha256, ""), cut.value.part
        for label in labels_in(PurePath(name).name):
            place = Place(row_name(Cut, cut.row))
            yield from contradictions(label, part.part_type, part.serial, cut.value.stage, place)
    by_file: dict[str, list[Inspection]] = {}
    for inspection in facts.inspections.values():
        by_file.setdefault(inspection.sha256, []).append(inspection)
    for row, record in facts.records.values():
        for name, sha256 in record.inputs_sha256.items():
            of_file = by_file.get(sha256, []) if labels_in(PurePath(name).name) else []
            yield from _labels_of_file(name, of_file, Place(row))


def odd_order(facts: Facts) -> Iterator[Finding]:
    """Yields STO-ORDER: finish cuts of an edge whose order the facts contradict: inspected before the cut before."""
    shown = {link.value.cut: facts.inspections.get(link.value.inspection) for link in facts.links}
    edges: dict[Identity, list[Kept[Cut]]] = {}
    for cut in facts.cuts.values():
        if cut.value.setting is not None and cut.value.stage is Stage.FINISH:
            edges.setdefault(cut.value.setting.edge.identity, []).append(cut)
    for edge, cuts in edges.items():
        inspected = [shown.get(stored.value.identity) for stored in cuts]
        at = [None if inspection is None else inspection.measured_at for inspection in inspected]
        order = cutting_order([Dated(stored.value, when, stored.row) for stored, when in zip(cuts, at, strict=True)])
        doubted = [cuts[k] for k, doubt in zip(order.places, order.in_doubt, strict=True) if doubt]
        if doubted:
            yield _in_doubt(edge, doubted)


def odd_times(facts: Facts) -> Iterator[Finding]:
    """Yields STO-CLOCK: an inspection before the cut that it shows."""
    for link in facts.links:
        cut, inspection = facts.cuts.get(link.value.cut), facts.inspections.get(link.value.inspection)
        if cut is not None and inspection is not None:
            try:
                what = row_name(InspectionLink, link.row)
                require_later(
                    (f"{row_name(Cut, cut.row)}, which it shows,", cut.value.at),
                    (f"the inspection of {what}", inspection.measured_at),
                )
            except TrueloopError as wrong:
                yield Finding(
                    severity=Severity.WARNING,
                    code=wrong.code,
                    message=wrong.message,
                    hint=wrong.hint,
                    place=wrong.place,
                    values=wrong.values,
                )


def _labels_of_file(name: str, of_file: list[Inspection], place: Place) -> Iterator[Finding]:
    """Yields what contradicts a label of the file; one inspection that agrees suffices: a label names one part."""
    for label in labels_in(PurePath(name).name):
        found = [
            contradictions(label, inspection.part.part_type, inspection.part.serial, place=place)
            for inspection in of_file
        ]
        if found and all(found):
            yield from found[0]


def _in_doubt(edge: Identity, cuts: list[Kept[Cut]]) -> Finding:
    serials = [cut.value.part.serial for cut in cuts]
    return Finding(
        Severity.WARNING,
        Code.STO_ORDER,
        f"the order in which edge {'/'.join(edge)!r} cut its parts is in doubt for {', '.join(map(repr, serials[:10]))}"
        + ("" if len(serials) <= 10 else f" and {len(serials) - 10} more"),
        "state the order or the times of these cuts: trueloop db replace ROW FILE --why …",
        values={"serials": serials[:10]},
    )


def _no_such(row: str, what: str, identity: Identity) -> Finding:
    shown = "/".join(identity)
    return Finding(
        Severity.ERROR,
        Code.STO_LOST,
        f"{row} names the {what} {shown!r}, which is not in the store, or is superseded",
        f"import the {what}, or replace the row that is wrong: trueloop db replace ROW FILE --why …",
        values={"row": row, "named": shown},
    )


@dataclass(frozen=True)
class StoreCheck:
    """The findings of a check, and how many rows it read."""

    rows: int
    findings: tuple[Finding, ...]


@dataclass
class _Pass:
    """One pass over all rows: what is odd so far, and the facts that are compared at the end."""

    rows: int = 0
    findings: list[Finding] = field(default_factory=list)
    facts: Facts = field(default_factory=Facts)


def check_store(store: Store, progress: Callable[[str], None] = lambda _: None) -> StoreCheck:
    """Compares all stored values with their hashes, then rows with the rows that they refer to.

    `progress` is given what is being done. Where pages of a file are damaged, its rows may hold anything: they are not
    read. Raises STO-FILE, STO-BUSY.
    """
    progress(f"checking {store.where}: hashes")
    damaged = damage(store)
    if any(one.row is None for one in damaged):
        return StoreCheck(0, tuple(map(_damaged, damaged)))
    over = _Pass()
    for kind in KINDS:
        progress(f"checking {store.where}: {kind.table}")
        before: Kept[Any] | None = None
        for kept in _readable(store, kind, over.findings):
            over.rows += 1
            over.findings += _clock(before, kept)
            before = replace(kept, value=None)
            if kept.superseded_by is None:
                over.facts.take(kept)
    facts, unreadable = over.facts, {finding.values.get("row") for finding in over.findings}
    more = [finding for finding in map(_damaged, damaged) if finding.values["row"] not in unreadable]
    odd = (*odd_links(facts), *odd_labels(facts), *odd_order(facts), *odd_times(facts))
    return StoreCheck(over.rows, (*over.findings, *more, *odd))


def _damaged(one: Damage) -> Finding:
    name = one.table.replace("_", "-")
    row = f"{name}:{one.row}" if one.row is not None else f"the table {one.table!r}" if one.table else "the file"
    return _finding(row, f"{row} is damaged: {one.why}")


def _readable(store: Store, kind: Kind, findings: list[Finding]) -> Iterator[Kept[Any]]:
    """The rows of a kind that can be read; the others are findings."""
    last = 0
    try:
        with store.reading() as connection:
            for kept in found(connection, store.codec, Query(kind, superseded=True)):
                yield kept
                last = kept.row
    except (TrueloopError, ValueError) as wrong:
        if isinstance(wrong, TrueloopError) and wrong.code is not Code.VAL_FORM:
            raise
        yield from _one_by_one(store, kind, last, findings)


def _one_by_one(store: Store, kind: Kind, after: int, findings: list[Finding]) -> Iterator[Kept[Any]]:
    table = TABLES[kind.table]
    with store.reading() as connection:
        rows = list(connection.scalars(select(table.c.id).where(table.c.id > after).order_by(table.c.id)))
    for row in rows:
        try:
            kept = row_of(store, kind.type, row)
        except (TrueloopError, ValueError) as wrong:
            findings.append(_unreadable(row_name(kind.type, row), wrong))
        else:
            if kept is not None:
                yield kept


def _unreadable(row: str, wrong: Exception) -> Finding:
    why = wrong.message if isinstance(wrong, TrueloopError) else str(wrong)
    return _finding(row, f"{row} cannot be read: {why}")


def _finding(row: str, text: str) -> Finding:
    hint = "restore the store from a backup: trueloop db restore"
    return Finding(Severity.ERROR, Code.STO_DAMAGED, text, hint, values={"row": row})


def _clock(before: Kept[Any] | None, kept: Kept[Any]) -> Iterator[Finding]:
    if before is None or kept.kept_at >= before.kept_at:
        return
    row = row_name(type(kept.value), kept.row)
    earlier, later = kept.kept_at.isoformat(), before.kept_at.isoformat()
    yield Finding(
        Severity.WARNING,
        Code.STO_CLOCK,
        f"{row} was kept at {earlier}, the row before it at {later}: the clock went back",
        "set the computer's clock; rows are in the order of their numbers, whatever the clock said",
        values={"earlier": earlier, "later": later},
    )


NO_TYPE = PartType("")


@dataclass(frozen=True)
class InspectionOptions:
    """Options for inspection files: the job of their part, its serial number, unit and mapping.

    `heed_labels`: a label in a file's name says of which part it is, and must not contradict what else is known.
    """

    job: Path | None = None
    serial: str = ""
    stated: StatedFacts = field(default_factory=StatedFacts)
    heed_labels: bool = True


def read_inspections(path: Path, of: InspectionOptions) -> tuple[Inspection, ...]:
    """Reads the inspections of a file, each with its part. Raises STO-PART, LAB-LINK, and what reading refuses."""
    files = None if of.job is None else JobFiles.of(of.job)
    read = _touches(path, files.job) if files is not None and _is_touches(path) else _measured(path, of, files)
    return tuple(_with_part(path, inspection, of, None if files is None else files.job) for inspection in read)


def _is_touches(path: Path) -> bool:
    """Returns True for a file of touches as a job names them."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    with path.open("rb") as file:
        return any(line.lstrip(b"\xef\xbb\xbf ").startswith(b"point,") and b"nominal_" in line for line in file)


def _touches(path: Path, job: Job) -> Iterator[Inspection]:
    yield read_inspection(path, job)


def _measured(path: Path, of: InspectionOptions, files: JobFiles | None) -> Iterator[Inspection]:
    """Yields the inspections of gauge and measuring machine files. Errors on the job's part are refused."""
    part = None if files is None else PartOfJob(files.job.part.name, files.profile(), files.sources.files)
    for on_part in read_measured(path, of.stated, part).on_part:
        for finding in on_part.findings:
            if finding.severity is Severity.ERROR:
                raise finding.as_error()
        yield on_part.inspection


def _with_part(path: Path, inspection: Inspection, of: InspectionOptions, job: Job | None) -> Inspection:
    """With the type of the job, else of the file or label, and the serial number of the file, user, job or label."""
    label = next((one for one in labels_in(path.name) if isinstance(one, PartLabel)), None) if of.heed_labels else None
    of_label = Part(NO_TYPE) if label is None else Part(PartType(label.number, "", label.material), label.copy)
    given = inspection.part
    kind = part_type(job) if job is not None else given.part_type if given.part_type.name else of_label.part_type
    serial = given.serial or of.serial or (job.part.serial if job is not None else "") or of_label.serial
    if not kind.name or not serial:
        lacks = [name for name, known in (("type", kind.name), ("serial number", serial)) if not known]
        raise Code.STO_PART.refusal(
            f"{path.name!r} does not state its part: its {' and its '.join(lacks)} is not stated",
            hint="give the job of the part by --job, its serial number by --serial",
            place=Place(str(path)),
        )
    if of.serial and of.serial != serial:
        raise Code.STO_PART.refusal(
            f"{path.name!r} is of serial number {serial!r}, not of {of.serial!r}",
            hint="leave --serial out: the file states the serial number",
            place=Place(str(path)),
        )
    if of.heed_labels:
        _check_labels(path, Part(kind, serial))
    return replace(inspection, part=Part(kind, serial))


def _check_labels(path: Path, part: Part) -> None:
    for label in labels_in(path.name):
        if isinstance(label, PartLabel | ProgramLabel):
            for found in contradictions(label, part.part_type, part.serial, place=Place(str(path))):
                error = found.as_error()
                error.override = "--ignore-labels"
                raise error


SHOWN: Final = 20
"""Rows that are listed of one file: nobody reads more."""
HINT: Final = "name an inspection file, a record.json, or what `trueloop db export` wrote"


@dataclass(frozen=True)
class Imported:
    """The outcome of a file: number of values, number of new ones, and rows; of an export the numbers alone."""

    path: Path
    count: int
    new: int
    rows: tuple[tuple[str, bool], ...]

    @property
    def words(self) -> str:
        """Describes the import in a line, and one for each of the first rows."""
        lines = [f"  {name} {'kept' if new else 'is there already, not kept again'}" for name, new in self.rows[:SHOWN]]
        more = len(self.rows) - len(lines)
        return "\n".join(
            [f"{self.path}: {self.new} of {self.count} new", *lines, *([f"  … and {more}"] if more else [])]
        )

    @property
    def as_dict(self) -> dict[str, object]:
        """Returns JSON-ready values."""
        rows = [{"row": name, "new": new} for name, new in self.rows]
        return {"file": str(self.path), "count": self.count, "new": self.new, "rows": rows}


def import_files(
    store: Store, paths: Sequence[Path], of: InspectionOptions, progress: Callable[[str], None] = lambda _: None
) -> Iterator[Imported]:
    """Keeps files one by one as each is yielded; `progress` names it. Raises STO errors, and those of reading."""
    for path in paths:
        progress(f"importing {path}")
        with readable(path, Code.STO_IMPORT, hint=HINT), path.open("rb") as file:
            beginning = file.read(HEAD)
        yield _of_export(store, path, progress) if is_export(beginning) else _of_values(store, path, beginning, of)


def _of_values(store: Store, path: Path, beginning: bytes, of: InspectionOptions) -> Imported:
    if beginning.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        record = read_record(path)
        known = (inspection for inspection in record.inspections if inspection.part.serial)
        values: list[Any] = [*known, Correction(record, {}, None)]
    else:
        values = list(read_inspections(path, of))
        with in_file(path):
            for value in values:
                require_file_of_part(store, value)
    kept = keep(store, values, by=user_name())
    rows = tuple((row_name(type(stored.value), stored.row), stored.new) for stored in kept)
    return Imported(path, len(kept), sum(stored.new for stored in kept), rows)


def _of_export(store: Store, path: Path, progress: Callable[[str], None]) -> Imported:
    copied = keep_lines(store, read_export(path, store.codec), progress, str(path))
    return Imported(path, copied.count, copied.new, ())
