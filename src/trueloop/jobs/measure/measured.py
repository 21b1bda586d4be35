"""Inspection files read, matched with the features of a job's part, and written as files that a job can name.

A mapping of a table's columns: proposed from its headings, written, and the table read by it.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from trueloop.collector import put_off
from trueloop.domain.inspection import Inspection, Reading
from trueloop.errors import Code, Place, Severity, TrueloopError
from trueloop.formats.input_file import readable
from trueloop.formats.inspections.dmis.results import dmis_results
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts, Unit
from trueloop.formats.inspections.qdas.writer import dfq_of
from trueloop.formats.inspections.qif.writer import qif_of
from trueloop.formats.inspections.shared.text import feature_names
from trueloop.formats.inspections.tables.mapping import HINT, toml_of
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping
from trueloop.formats.inspections.tables.propose import Given, propose
from trueloop.formats.inspections.tables.read import grid_of, read_mapped, settled
from trueloop.formats.measurements.touches_csv import readings_to_csv, touches_to_csv
from trueloop.formats.outputs import Named, write_all
from trueloop.geometry.profile import Profile
from trueloop.report.measured import FileOnPart, OnPart
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import Axis, MatchedReading
from trueloop.turned.readings.observed import other_nominals
from trueloop.turned.readings.of_this_part import check_matches
from trueloop.turned.touches.touches import Gauging, error_vectors, in_order


@dataclass(frozen=True)
class Chosen:
    """Which of a file's inspections are meant: of a serial number, of a run (from 1); None: all."""

    serial: str | None = None
    run: int | None = None


@dataclass(frozen=True)
class PartOfJob:
    """A job's part by name, its profile, and the files that were read for it."""

    name: str
    profile: Profile
    files: tuple[Path, ...]


def read_part_of_job(path: Path) -> PartOfJob:
    """Reads the part of a job, whose touches need not exist yet. Raises JOB, GEO and NC errors."""
    from trueloop.jobs.turned.job_files import JobFiles

    files = JobFiles.of(path)
    return PartOfJob(files.job.part.name, files.profile(), files.sources.files)


@put_off()
def read_measured(
    path: Path,
    stated: StatedFacts,
    part: PartOfJob | None = None,
    chosen: Chosen | None = None,
    axis: Axis | None = None,
) -> FileOnPart:
    """Reads a file, and what of it is on the part. Raises MSR errors; what is odd about it on the part are findings."""
    names = feature_names(stated.mapping)
    file = read_measured_file(path, stated)
    inspections = _chosen(file, chosen or Chosen())
    if part is None:
        return FileOnPart(file, tuple(OnPart(run, inspection) for run, inspection in inspections))
    from trueloop.jobs.turned.readings import deviations_of, require_features

    require_features(stated.mapping, names, part.profile)
    found = tuple(_on_part(part.profile, file, run, inspection, names, axis) for run, inspection in inspections)
    matched = [reading for on_part in found if on_part.matches is not None for reading in on_part.matches.readings]
    remarks = (*file.remarks, *deviations_of(file, part.profile, matched))
    return FileOnPart(replace(file, remarks=remarks), found, part.name, part.profile.names)


def _on_part(
    profile: Profile, file: MeasuredFile, run: int, inspection: Inspection, names: Mapping[str, str], axis: Axis | None
) -> OnPart:
    inspection = file.for_part(inspection)
    matches = match_inspection(profile, inspection, names, axis)
    findings = (*check_matches(profile, inspection, matches, names, axis), *other_nominals(profile, matches.readings))
    return OnPart(run, inspection, matches, tuple(finding.in_file(str(file.path)) for finding in findings))


def _chosen(file: MeasuredFile, chosen: Chosen) -> tuple[tuple[int, Inspection], ...]:
    """Raises MSR-SERIAL for a serial number or a run that the file has not."""
    found = list(enumerate(file.inspections, 1))
    if chosen.serial is not None and (len(found) > 1 or any(inspection.part.serial for _, inspection in found)):
        found = [(k, inspection) for k, inspection in found if inspection.part.serial == chosen.serial]
    if chosen.run is not None:
        found = [(k, inspection) for k, inspection in found if k == chosen.run]
    if not found and (chosen.serial, chosen.run) != (None, None):
        asked = "" if chosen.serial is None else f" of serial number {chosen.serial!r}"
        run = "" if chosen.run is None else f" run {chosen.run}"
        raise serial_error(file, f"has no inspection{asked}{run}")
    return tuple(found)


def serial_error(file: MeasuredFile, why: str) -> TrueloopError:
    """Returns the refusal MSR-SERIAL of a file of which one inspection is to be chosen."""
    serials = [inspection.part.serial for inspection in file.inspections]
    listed = ", ".join(f"{k}: {serial!r}" for k, serial in list(enumerate(serials, 1))[:20])
    more = "" if len(serials) <= 20 else ", …"
    return Code.MSR_SERIAL.refusal(
        f"{file.path.name!r} {why}; its {len(serials)} inspections are {listed}{more}",
        hint="choose one: --serial NUMBER, or --run N where serial numbers are not stated or are the same",
        place=Place(str(file.path)),
        values={"serials": serials[:20]},
    )


def write_measured(files: Sequence[FileOnPart], part: PartOfJob, target: Path, inputs: Collection[Path]) -> list[Path]:
    """Touches and readings as CSV files: `target`, and where there are both `target` with `-readings` for the second.

    All or none, never over an input. Raises MSR-SERIAL for inspections of several parts or runs, MSR-NONE where nothing
    was matched, what the findings are about where one is an error, TCH errors for touches that no job could use.
    """
    serials = {one.inspection.part.serial for file in files for one in file.on_part} - {""}
    for file in files:
        if len(file.on_part) > 1:
            raise serial_error(file.file, "holds several")
        if len(serials) > 1:
            raise serial_error(file.file, f"is not of one part with the others, {len(serials)} serial numbers in all")
        for found in (finding for on_part in file.on_part for finding in on_part.findings):
            if found.severity is Severity.ERROR:
                raise found.as_error()
    on_part = [(one.inspection, one.matches) for file in files for one in file.on_part if one.matches is not None]
    touches = in_order(part.profile, [each.touch for _, matches in on_part for each in matches.touches])
    readings = [(inspection, [_of_part(part.profile, m) for m in matches.readings]) for inspection, matches in on_part]
    if touches:
        error_vectors(part.profile, touches, Gauging())
    contents: list[Named] = [(target.name, touches_to_csv(touches).encode())] if touches else []
    if any(of_it for _, of_it in readings):
        name = target.with_stem(f"{target.stem}-readings").name if touches else target.name
        contents.append((name, readings_to_csv(readings).encode()))
    if not contents:
        raise Code.MSR_NONE.refusal(
            f"0 of {sum(inspection.count for inspection, _ in on_part)} values are errors of the part's profile",
            hint="the table shows what was not matched, and why; a mapping's [features] lists names that differ",
        )
    return write_all(target.parent, contents, inputs)


def _of_part(profile: Profile, match: MatchedReading) -> Reading:
    """A reading with the part's own names of its features."""
    other = "" if match.other_index is None else profile.names[match.other_index]
    return replace(match.reading, feature=profile.names[match.feature_index], other=other)


WRITERS: Final[Mapping[str, Callable[[Sequence[Inspection], str], bytes]]] = {
    ".qif": lambda inspections, _: qif_of(inspections),
    ".dfq": lambda inspections, _: dfq_of(inspections),
    ".dmo": lambda inspections, stem: dmis_results(inspections, stem).encode(),
}
"""By the ending of a file's name; they are given its stem, which DMIS repeats."""


def convert(path: Path, stated: StatedFacts, target: Path) -> MeasuredFile:
    """Reads an inspection file and writes all its inspections to `target`; gives what was read.

    Raises MSR errors for what cannot be read, MSR-FORMAT for a target of no known ending or for touches, OUT errors.
    """
    writer = WRITERS.get(target.suffix.lower())
    if writer is None:
        raise Code.MSR_FORMAT.refusal(
            f"{target.name!r} cannot be written: its ending {target.suffix!r} is not one of {', '.join(WRITERS)}",
            hint="name the output .qif, .dfq or .dmo",
            place=Place(str(target)),
            values={"file": target.name},
        )
    file = read_measured_file(path, stated)
    # Touches are errors of a plane (x, z): no format of measuring machines has words for them
    if touches := sum(len(inspection.touches) for inspection in file.inspections):
        raise Code.MSR_FORMAT.refusal(
            f"{target.name!r} cannot hold {touches} touches of a turned part",
            hint="name the file itself in the job: `gauging.touches`",
            place=Place(str(file.path)),
            values={"file": target.name},
        )
    inputs = [path, *([] if stated.mapping is None else [stated.mapping])]
    write_all(target.parent, [(target.name, lambda: writer(file.inspections, target.stem))], inputs)
    return file


@dataclass(frozen=True)
class Mapped:
    """A mapping with the file it was written to, and the table as it is read by it, or why it is not."""

    path: Path
    mapping: TableMapping
    file: MeasuredFile | TrueloopError


def map_table(
    path: Path, output: Path | None, sheet: str = "", unit: Unit | None = None, given: Given | None = None
) -> Mapped:
    """Proposes, writes and tries a mapping; `given` names columns as `propose` takes them.

    Where the table cannot be read by it, because a unit or a sign is stated nowhere, it is written all the same: there
    it is added. Raises MSR errors where there is no mapping to propose, OUT errors where it cannot be written.
    """
    with readable(path, Code.MSR_FILE, hint=HINT):
        grid = grid_of(path, sheet)
    mapping, stated = propose(grid, given), StatedFacts(unit)
    mapping = mapping.model_copy(update={"unit": unit})
    written = output or path.with_name(f"{path.stem}.map.toml")
    file: MeasuredFile | TrueloopError
    try:
        mapping = settled(grid, mapping, stated)
        file = read_mapped(grid, mapping, stated, written)
    except TrueloopError as error:
        file = error
    text = toml_of(mapping, f"What the columns of {path.name} mean: docs/measurements.md, 'Tables by mapping'")
    write_all(written.parent, [(written.name, text.encode())], [path])
    return Mapped(written, mapping, file)
