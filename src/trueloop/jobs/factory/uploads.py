"""Files that people hand over: kept for a day, read as often as asked, and forgotten. No name of theirs is a path."""

import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Final

from pydantic import Field
from sqlalchemy import delete, insert, select

from trueloop.described import filled_from
from trueloop.domain.factory import WorkOrder
from trueloop.domain.inspection import Inspection
from trueloop.domain.option import Language, LengthUnit
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.factory.known import unknown
from trueloop.factory.load import StoreReader, order_of
from trueloop.factory.views import uploads as views
from trueloop.factory.views.uploads import Kind, UploadView
from trueloop.formats.input_file import read_source
from trueloop.formats.inspections.known import HEAD, KNOWN
from trueloop.formats.inspections.measured_file import StatedFacts, Unit
from trueloop.formats.inspections.tables import read as tables
from trueloop.formats.inspections.tables.grid import SUFFIXES
from trueloop.jobs.factory.hand_job import HandJob, MillJob
from trueloop.jobs.factory.job_folder import job_folder, programs_of, unnamed_folder, without_folder
from trueloop.jobs.measure.measured import map_table, read_measured, read_part_of_job
from trueloop.nc.check.check import check
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.unit import recorded_program, unit_of_path
from trueloop.report.measured import FileOnPart, OnPart, ValueRow, rows_of
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.storage.schema import UPLOAD, stamp
from trueloop.storage.store import Store
from trueloop.wording import wording

SHOWN: Final = 500
"""Values of one inspection that are listed: nobody reads more before importing."""
DRAWINGS: Final = (".dxf", ".step", ".stp", ".igs", ".iges")
TABLES: Final = (".csv", ".tsv", *SUFFIXES)
TEXTS: Final = (".txt",)
"""Programs and tables alike have this ending: a row of known headings decides."""


@dataclass(frozen=True)
class ReadingOptions:
    """Options of reading an upload, for what the file does not state."""

    kind: Kind | None = None
    dialect: str | None = None
    unit: Unit | None = None
    order: str = ""
    """The order of the job whose part the values are matched with."""
    mapping_toml: Annotated[str, Field(max_length=100_000)] = ""
    """The meaning of a table's columns."""


@dataclass(frozen=True)
class HandedFile:
    """A file that was handed over, as it lies at `path` in a folder of its own, under the name that its owner gave it.

    `order`: whose job's part its values are matched with, and the texts of that order's `programs`. `hand` or
    `mill`: the job of a person, whose program it is. What is shown of it is for a reader of this language and unit.
    """

    path: str
    name: str
    sha256: str
    asked: ReadingOptions = field(default_factory=ReadingOptions)
    order: WorkOrder | None = None
    programs: Mapping[str, bytes] = field(default_factory=dict)
    hand: HandJob | None = None
    mill: MillJob | None = None
    language: Language = "en"
    unit: LengthUnit = "mm"

    @property
    def file(self) -> Path:
        """Returns the path of the file."""
        return Path(self.path)

    @property
    def say(self) -> Texts:
        """Returns the texts of the reader."""
        return Texts(self.language, self.unit)


@dataclass(frozen=True)
class UploadedInspection:
    """The inspections of a file, each with its place in the file, from 1."""

    runs: tuple[tuple[int, Inspection], ...]


def upload_view(handed: HandedFile) -> UploadView:
    """Returns the file as it is read; what it is refused for stands in the view."""
    kind = handed.asked.kind or kind_of(handed)
    view = UploadView(handed.name, handed.sha256, handed.file.stat().st_size, kind)
    try:
        if kind == "program":
            return replace(view, program=program_read(handed))
        if kind == "drawing":
            from trueloop.formats.jobs.profile_of_job import characteristics_toml, part_table_toml
            from trueloop.jobs.turned.new import read_drawing

            drawn = read_drawing(handed.file, unit=handed.asked.unit)
            table = part_table_toml(Path(handed.name).stem, drawn.profile, drawn.notes)
            return replace(view, drawing=views.DrawingRead(table + characteristics_toml(drawn.asked)))
        return replace(view, measurement=_measurement(handed, _on_part(handed)))
    except TrueloopError as refused:
        proposed = _proposed(handed) if kind == "measurement" else ""
        problem = remarked(without_folder(refused, handed.file.parent), handed.say)
        return replace(view, problem=problem, mapping_toml=handed.asked.mapping_toml or proposed)


def kind_of(handed: HandedFile) -> Kind:
    """Determines the kind by the end of the file's name, else by its first bytes."""
    ending = Path(handed.name).suffix.lower()
    if ending in DRAWINGS:
        return "drawing"
    if ending in TABLES:
        return "measurement"
    with handed.file.open("rb") as file:
        head = file.read(HEAD)
    formats = (one for one in KNOWN if one is not tables.FORMAT or ending in TEXTS)
    known = any(one.recognises(handed.file, head) for one in formats)
    return "measurement" if known else "program"


def program_read(handed: HandedFile) -> views.ProgramRead:
    """Reads a program with what is odd about it. Raises NC errors."""
    asked = handed.asked
    source, dialect = read_source(handed.file, asked.dialect)
    program = read_program(source, dialect, handed.name, asked.unit)
    findings = check(program, {})
    return views.ProgramRead(
        dialect, _unit(program, asked.unit), program.block_count, tuple(remarked(one, handed.say) for one in findings)
    )


def inspected(handed: HandedFile) -> UploadedInspection:
    """Returns what was measured. Raises MSR, GEO and JOB errors, among them the file's findings on the part."""
    found = _on_part(handed)
    for finding in (one for each in found.on_part for one in each.findings):
        if finding.severity is Severity.ERROR:
            raise finding.as_error()
    return UploadedInspection(tuple((on_part.run, on_part.inspection) for on_part in found.on_part))


def order_read(handed: HandedFile) -> int:
    """Reads an order's job with the file as its touches; how many. Raises JOB, NC, GEO, TCH, PRB, MSR and FAC-PLAN."""
    from trueloop.jobs.turned.job import read_job  # most files that are handed over are not touches

    assert handed.order is not None
    with job_folder(handed.order, handed.programs, handed.file.read_bytes()) as job:
        return len(read_job(job).inputs.touches.error_mm)


def toml_read(handed: HandedFile) -> bool:
    """Returns whether the file is TOML. Raises SRV-FILE for tables in tables without end."""
    try:
        tomllib.loads(handed.file.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError:
        return False
    except RecursionError:
        raise Code.SRV_FILE.refusal(
            f"{handed.name!r} was not read: its lists or tables are nested too deeply",
            hint="write the job as `trueloop new` does, or as in docs/job-file.md",
            values={"file": handed.name},
        ) from None
    return True


def _unit(program: Program, unit: Unit | None) -> Unit | None:
    """The unit in force at the first length; of a program that cannot be run without its parameters, what was said."""
    try:
        told = unit_of_path(unit, program.run({}, strict=False))
    except TrueloopError:
        return unit
    return recorded_program("", program.dialect.name, "", told).unit


def _on_part(handed: HandedFile) -> FileOnPart:
    """A measurement's file with the part of an order's job, where one is given. Raises MSR, GEO, JOB and FAC errors."""
    if handed.order is None:
        return read_measured(handed.file, _stated(handed))
    with job_folder(handed.order, handed.programs) as job:
        part = read_part_of_job(job)
    return read_measured(handed.file, _stated(handed), part)


def _stated(handed: HandedFile) -> StatedFacts:
    if not handed.asked.mapping_toml:
        return StatedFacts(handed.asked.unit)
    mapping = handed.file.with_name("mapping.toml")
    mapping.write_text(handed.asked.mapping_toml, encoding="utf-8")
    return StatedFacts(handed.asked.unit, mapping)


def _measurement(handed: HandedFile, file: FileOnPart) -> views.MeasurementRead:
    return views.MeasurementRead(
        file.file.format,
        file.file.unit,
        tuple(_inspection(file, on_part, handed.say) for on_part in file.on_part),
        tuple(views.Remarked("note", "", remark.text, line=remark.line) for remark in file.file.remarks),
        handed.asked.mapping_toml or (_proposed(handed) if file.file.format.startswith("table") else ""),
    )


def _inspection(file: FileOnPart, inspection: OnPart, say: Texts) -> views.InspectionRead:
    rows = list(rows_of(file, inspection))
    seen = inspection.inspection
    return views.InspectionRead(
        run=inspection.run,
        serial=seen.part.serial,
        measured_at="" if seen.measured_at is None else seen.measured_at.isoformat(),
        count=len(rows),
        values=tuple(map(_value, rows[:SHOWN])),
        remarks=tuple(remarked(one, say) for one in inspection.findings),
    )


def _value(row: ValueRow) -> views.ValueRead:
    return filled_from(views.ValueRead, row)


def _proposed(handed: HandedFile) -> str:
    """The mapping that a table's headings say; "" where there is none to propose."""
    if Path(handed.name).suffix.lower() not in TABLES:
        return ""
    try:
        written = map_table(handed.file, handed.file.with_name("mapping.toml"), unit=handed.asked.unit).path
        return written.read_text(encoding="utf-8")
    except TrueloopError:
        return ""


def remarked(of: TrueloopError | Finding, say: Texts) -> views.Remarked:
    """Returns a finding, or a refusal with its place, for a page."""
    where, severity = ("", of.severity) if isinstance(of, Finding) else (str(of.place), Severity.ERROR)
    text = say.refusal(of.code.meaning, of.message)
    said = f"{where}: {text}" if where else text
    return views.Remarked(severity.value, of.code.value, said, say.note(of.hint), of.place.line)


KEPT: Final = timedelta(days=1)
_UNSAFE: Final = re.compile(r"[^A-Za-z0-9._-]+")
_LONGEST: Final = 100


@dataclass(frozen=True)
class Upload:
    """A file as it was handed over, under the name that its owner gave it."""

    name: str
    sha256: str
    content: bytes


def add_upload(store: Store, name: str, content: bytes, by: str, now: datetime) -> Upload:
    """Keeps a file, and forgets those of more than a day ago."""
    hashed = sha256(content).hexdigest()
    row = {"by": by, "name": name, "sha256": hashed, "created_at": stamp(now), "content": content}
    with store.writing() as connection:
        connection.execute(delete(UPLOAD).where(UPLOAD.c.created_at < stamp(now - KEPT)))
        connection.execute(insert(UPLOAD).values(**row))
    return Upload(name, hashed, content)


def upload_of(store: Store, sha256: str, by: str) -> Upload:
    """Returns this account's upload by its hash: a number might be given to another file later. Raises FAC-UNKNOWN."""
    mine = (UPLOAD.c.sha256 == sha256) & (UPLOAD.c.by == by)
    with store.reading() as connection:
        row = connection.execute(select(UPLOAD).where(mine).order_by(UPLOAD.c.id.desc()).limit(1)).one_or_none()
    if row is None:
        raise unknown(wording("upload"), sha256, wording("hand the file over again: it is kept for a day"))
    return Upload(row.name, row.sha256, bytes(row.content))


def safe_name(name: str) -> str:
    """Returns the name of a file with letters, digits and `._-` alone, and the end of its own."""
    return _UNSAFE.sub("_", name)[-_LONGEST:].lstrip(".") or "file"


@contextmanager
def handed(store: Store, upload: Upload, options: ReadingOptions, say: Texts = ENGLISH) -> Iterator[HandedFile]:
    """Yields the file in a temporary folder of its own, with what the store knows of the order that is requested.

    Its name there has letters, digits and `._-`, and the end of its own. Raises FAC-UNKNOWN.
    """
    order, programs = None, dict[str, bytes]()
    if options.order:
        with store.reading() as connection:
            known = StoreReader(connection, store.codec)
            order = order_of(known, options.order).order
            programs = programs_of(known, order)
    with unnamed_folder() as folder:
        path = folder / safe_name(upload.name)
        path.write_bytes(upload.content)
        yield HandedFile(
            path=str(path),
            name=upload.name,
            sha256=upload.sha256,
            asked=options,
            order=order,
            programs=programs,
            language=say.language,
            unit=say.unit,
        )
