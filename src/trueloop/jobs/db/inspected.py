"""Inspection files as the store keeps them: of which part each inspection is, by job, file, label or the user."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from trueloop.domain.inspection import Inspection
from trueloop.domain.labelled import contradictions
from trueloop.domain.labels import PartLabel, ProgramLabel, labels_in
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, Place, Severity, TrueloopError
from trueloop.formats.inspections.measured_file import Stated
from trueloop.formats.jobs.job import Job
from trueloop.jobs.measure.measured import PartOfJob, read_measured
from trueloop.jobs.turned.inspection import part_type, read_inspection
from trueloop.jobs.turned.job_files import JobFiles

NO_TYPE = PartType("")


@dataclass(frozen=True)
class Inspected:
    """What is said of inspection files besides: the job of their part, its serial number, unit and mapping.

    `heed_labels`: a label in a file's name says of which part it is, and must not contradict what else is known.
    """

    job: Path | None = None
    serial: str = ""
    stated: Stated = field(default_factory=Stated)
    heed_labels: bool = True


def read_inspections(path: Path, of: Inspected) -> tuple[Inspection, ...]:
    """The inspections of a file, each with its part. Raises STO-PART, LAB-LINK, and what reading refuses."""
    files = None if of.job is None else JobFiles.of(of.job)
    read = _touches(path, files.job) if files is not None and _is_touches(path) else _measured(path, of, files)
    return tuple(_with_part(path, one, of, None if files is None else files.job) for one in read)


def _is_touches(path: Path) -> bool:
    """Whether a file holds touches as a job names them."""
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    with path.open("rb") as file:
        return any(line.lstrip(b"\xef\xbb\xbf ").startswith(b"point,") and b"nominal_" in line for line in file)


def _touches(path: Path, job: Job) -> Iterator[Inspection]:
    yield read_inspection(path, job)


def _measured(path: Path, of: Inspected, files: JobFiles | None) -> Iterator[Inspection]:
    """What the readers of gauges' and measuring machines' files give. What is an error on the job's part is refused."""
    part = None if files is None else PartOfJob(files.job.part.name, files.profile(), files.sources.files)
    for one in read_measured(path, of.stated, part).on_part:
        for found in one.findings:
            if found.severity is Severity.ERROR:
                raise found.as_error()
        yield one.inspection


def _with_part(path: Path, inspection: Inspection, of: Inspected, job: Job | None) -> Inspection:
    """With the type of the job, else of the file or label, and the serial number of the file, user, job or label."""
    label = next((one for one in labels_in(path.name) if isinstance(one, PartLabel)), None) if of.heed_labels else None
    of_label = Part(NO_TYPE) if label is None else Part(PartType(label.number, "", label.material), label.copy)
    given = inspection.part
    kind = part_type(job) if job is not None else given.part_type if given.part_type.name else of_label.part_type
    serial = given.serial or of.serial or (job.part.serial if job is not None else "") or of_label.serial
    if not kind.name or not serial:
        raise _not_identified(path, kind, serial)
    if of.serial and of.serial != serial:
        raise _other_serial(path, of.serial, serial)
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


def _not_identified(path: Path, kind: PartType, serial: str) -> TrueloopError:
    lacks = [name for name, known in (("type", kind.name), ("serial number", serial)) if not known]
    return TrueloopError(
        Code.STO_PART,
        f"{path.name!r} does not say of which part it is: its {' and its '.join(lacks)} is not stated",
        hint="give the job of the part by --job, its serial number by --serial",
        place=Place(str(path)),
        values={"file": path.name},
    )


def _other_serial(path: Path, asked: str, found: str) -> TrueloopError:
    return TrueloopError(
        Code.STO_PART,
        f"{path.name!r} is of serial number {found!r}, not of {asked!r}",
        hint="leave --serial out: the file says of which part it is",
        place=Place(str(path)),
        values={"file": path.name},
    )
