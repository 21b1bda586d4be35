"""Files into the store: inspections, records and exports; each file in one transaction, whole or not at all."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from trueloop.domain.inspection import Inspection
from trueloop.domain.labels import PartLabel, ProgramLabel, contradictions, labels_in
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import Correction
from trueloop.errors import Code, Place, Severity, in_file
from trueloop.formats.input_file import readable
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.formats.jobs.job import Job
from trueloop.formats.record_file import read_record
from trueloop.jobs.db.copied import HEAD, is_export, keep_lines, read_export
from trueloop.jobs.db.found import row_name
from trueloop.jobs.measure.measured import PartOfJob, read_measured
from trueloop.jobs.store.of_this_part import require_file_of_part
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.readings import part_type, read_inspection
from trueloop.jobs.user import user_name
from trueloop.storage.store import Store, keep

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
        for found in on_part.findings:
            if found.severity is Severity.ERROR:
                raise found.as_error()
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
