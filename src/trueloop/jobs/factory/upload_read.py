"""What a file that was handed over is, and what is in it: shown before anything of it is kept."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Finding, TrueloopError
from trueloop.factory.load import Known, order_of
from trueloop.factory.views import uploads as views
from trueloop.factory.views.uploads import Kind, UploadView
from trueloop.formats.input_file import read_source
from trueloop.formats.inspections.known import HEAD, KNOWN
from trueloop.formats.inspections.measured_file import Stated, Unit
from trueloop.formats.inspections.tables import read as tables
from trueloop.jobs.factory.job_folder import job_folder, programs_of
from trueloop.jobs.factory.uploads import Upload
from trueloop.jobs.measure.measured import PartOfJob, read_measured, read_part_of_job
from trueloop.jobs.measure.table_mapping import map_table
from trueloop.nc.check.check import check
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.unit import recorded_program, unit_of_path
from trueloop.report.measured import FileOnPart, OnPart, ValueRow, rows_of
from trueloop.storage.store import Store

SHOWN: Final = 500
"""Values of one inspection that are listed: nobody reads more before importing."""
DRAWINGS: Final = (".dxf", ".step", ".stp", ".igs", ".iges")
TABLES: Final = (".csv", ".tsv", ".xlsx", ".xlsm")


@dataclass(frozen=True)
class Asked:
    """How a file is to be read, as a person says it; None and "": as the file says.

    `order`: whose job's part the values are matched with. `mapping_toml`: what a table's columns mean.
    """

    kind: Kind | None = None
    dialect: str | None = None
    unit: Unit | None = None
    order: str = ""
    mapping_toml: str = ""


def read_upload(store: Store, upload: Upload, asked: Asked) -> UploadView:
    """The file as it is read; what it is refused for stands in the view. Raises FAC-UNKNOWN for an order."""
    kind = asked.kind or kind_of(upload)
    view = UploadView(upload.name, upload.sha256, len(upload.content), kind)
    try:
        if kind == "program":
            return replace(view, program=program_read(upload, asked))
        if kind == "drawing":
            return replace(view, drawing=_drawing(upload, asked))
        with on_part(store, upload, asked) as found:
            return replace(view, measurement=_measurement(upload, asked, found))
    except TrueloopError as refused:
        if refused.code is Code.FAC_UNKNOWN:
            raise
        proposed = _proposed(upload, asked) if kind == "measurement" else ""
        return replace(view, problem=_problem(refused), mapping_toml=asked.mapping_toml or proposed)


def kind_of(upload: Upload) -> Kind:
    """By the end of its name, else by what its first bytes are known as."""
    ending = Path(upload.name).suffix.lower()
    if ending in DRAWINGS:
        return "drawing"
    if ending in TABLES:
        return "measurement"
    with upload.as_file() as path:
        known = any(one.recognises(path, upload.content[:HEAD]) for one in KNOWN if one is not tables.FORMAT)
    return "measurement" if known else "program"


def program_read(upload: Upload, asked: Asked) -> views.ProgramRead:
    """A program with what is odd about it. Raises NC errors."""
    with upload.as_file() as path:
        source, dialect = read_source(path, asked.dialect)
    program = read_program(source, dialect, upload.name, asked.unit)
    findings = check(program, {})
    return views.ProgramRead(dialect, _unit(program, asked.unit), program.block_count, tuple(map(_found, findings)))


def _unit(program: Program, given: Unit | None) -> Unit | None:
    """The unit in force at the first length; of a program that cannot be run without its parameters, what was said."""
    try:
        told = unit_of_path(given, program.run({}, strict=False))
    except TrueloopError:
        return given
    return recorded_program("", program.dialect.name, "", told).unit


@contextmanager
def on_part(store: Store, upload: Upload, asked: Asked) -> Iterator[FileOnPart]:
    """A measurement's file with the part of an order's job, while it is there. Raises MSR, GEO, JOB and FAC errors."""
    part = _part(store, asked.order)
    with upload.as_file() as path:
        yield read_measured(path, _stated(path.parent, asked), part)


def _part(store: Store, order: str) -> PartOfJob | None:
    if not order:
        return None
    with store.reading() as connection:
        known = Known(connection, store.codec)
        found = order_of(known, order).order
        programs = programs_of(known, found)
    with job_folder(found, programs) as job:
        return read_part_of_job(job)


def _stated(folder: Path, asked: Asked) -> Stated:
    if not asked.mapping_toml:
        return Stated(asked.unit)
    mapping = folder / "mapping.toml"
    mapping.write_text(asked.mapping_toml, encoding="utf-8")
    return Stated(asked.unit, mapping)


def _measurement(upload: Upload, asked: Asked, found: FileOnPart) -> views.MeasurementRead:
    return views.MeasurementRead(
        found.file.format,
        found.file.unit,
        tuple(_inspection(found, one) for one in found.on_part),
        tuple(views.Remarked("note", "", one.text, line=one.line) for one in found.file.remarks),
        asked.mapping_toml or (_proposed(upload, asked) if found.file.format.startswith("table") else ""),
    )


def _inspection(file: FileOnPart, one: OnPart) -> views.InspectionRead:
    rows = list(rows_of(file, one))
    seen = one.inspection
    return views.InspectionRead(
        one.run,
        seen.part.serial,
        "" if seen.measured_at is None else seen.measured_at.isoformat(),
        len(rows),
        tuple(map(_value, rows[:SHOWN])),
        tuple(map(_found, one.findings)),
    )


def _value(row: ValueRow) -> views.ValueRead:
    return views.ValueRead(
        *(row.characteristic, row.quantity, row.feature, row.by, row.nominal, row.actual, row.deviation),
        *(row.within, row.unit, row.reason),
    )


def _proposed(upload: Upload, asked: Asked) -> str:
    """The mapping that a table's headings say; "" where there is none to propose."""
    if Path(upload.name).suffix.lower() not in TABLES:
        return ""
    try:
        with upload.as_file() as path:
            written = map_table(path, path.parent / "mapping.toml", unit=asked.unit).path
            return written.read_text(encoding="utf-8")
    except TrueloopError:
        return ""


def _drawing(upload: Upload, asked: Asked) -> views.DrawingRead:
    from trueloop.formats.jobs.characteristic_toml import characteristics_toml
    from trueloop.formats.jobs.profile_of_job import part_table_toml
    from trueloop.jobs.turned.drawing import read_drawing

    with upload.as_file() as path:
        drawn = read_drawing(path, unit=asked.unit)
    table = part_table_toml(Path(upload.name).stem, drawn.profile, drawn.notes)
    return views.DrawingRead(table + characteristics_toml(drawn.asked))


def _problem(refused: TrueloopError) -> views.Remarked:
    said = f"{refused.place}: {refused.message}" if str(refused.place) else refused.message
    return views.Remarked("error", refused.code.value, said, refused.hint, refused.place.line)


def _found(found: Finding) -> views.Remarked:
    return views.Remarked(found.severity.value, found.code.value, found.message, found.hint, found.place.line)
