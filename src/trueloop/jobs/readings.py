"""The inspection files that a job names: the readings of its part, each with its feature."""

import difflib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part
from trueloop.errors import Code, Place, Severity, TrueloopError, in_file
from trueloop.formats.inspections.gauge_csv import FORMAT as GAUGE_CSV
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, Stated
from trueloop.formats.jobs.job import Job
from trueloop.formats.option_tables import options_from
from trueloop.formats.record_file import read_record
from trueloop.geometry.profile import Profile
from trueloop.jobs.inspection import part_type
from trueloop.jobs.sources import Sources
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matched import MatchedReading, match_by_name
from trueloop.turned.readings.observed import corrected, repeated
from trueloop.turned.readings.of_this_part import check_matches
from trueloop.turned.readings.vectors import assumed_words, with_readings
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging


@dataclass(frozen=True)
class ReadReadings:
    """What the job's files of readings hold of its part: as reported, by feature, and notes in words."""

    inspections: tuple[Inspection, ...]
    matched: tuple[MatchedReading, ...]
    notes: tuple[str, ...]
    gauging: Gauging
    file: str | None

    def joined(self, profile: Profile, touches: ErrorVectors | None) -> tuple[ErrorVectors, tuple[str, ...]]:
        """Touches and readings as error vectors, and all notes. Raises MSR errors."""
        if not self.inspections:
            assert touches is not None  # a job has one of both
            return touches, ()
        with in_file(self.file):
            vectors, notes = with_readings(profile, self.matched, touches, self.gauging)
        return replace(vectors, file=vectors.file or self.file), (*self.notes, *notes)


def read_readings(job: Job, sources: Sources, profile: Profile) -> ReadReadings:
    """All files of `gauging.readings`. Raises MSR errors with file and line."""
    inspections: list[Inspection] = []
    matched: list[MatchedReading] = []
    notes: list[str] = []
    gauging = options_from(Gauging, job)
    files = [sources.file(name) for name in job.gauging.readings_files]
    for file in files:
        measured = read_measured_file(file, Stated(job.gauging.readings_unit))
        chosen = _of_part(measured, job)
        with in_file(file):
            found, unmatched = _matched(profile, chosen, strict=measured.format == GAUGE_CSV.name)
            repeated(profile, corrected(found), gauging)
        inspections += chosen
        matched += found
        notes += [f"{file.name}: {remark.text}." for remark in measured.remarks]
        notes += [f"{file.name}: {len(unmatched)} readings are of no feature of the part."] if unmatched else []
    if files and not any(one.readings for one in inspections):
        raise TrueloopError(
            Code.MSR_NONE,
            f"{len(files)} files of readings hold 0 readings of the part",
            hint="fill in at least one value: a row without one was not measured",
            place=Place(str(files[0])),
        )
    if files and job.gauging.after_record is not None:
        _refuse_before(sources.file(job.gauging.after_record), files[0], inspections)
    notes += assumed_words(matched, gauging.readings_u_mm)
    one_file = str(files[0]) if len(files) == 1 else None
    return ReadReadings(tuple(inspections), tuple(matched), tuple(notes), gauging, one_file)


def _of_part(measured: MeasuredFile, job: Job) -> list[Inspection]:
    """The inspections of the job's part, with what the job says of it where the file does not."""
    serials = sorted({one.part.serial for one in measured.inspections if one.part.serial})
    wanted = job.part.serial
    if (wanted and serials and wanted not in serials) or (not wanted and len(serials) > 1):
        shown = ", ".join(map(repr, serials[:6])) + (", …" if len(serials) > 6 else "")
        why = f"part {wanted!r} is none of them" if wanted else "`part.serial` of the job chooses none"
        raise TrueloopError(
            Code.MSR_SERIAL,
            f"the file holds {len(serials)} parts by serial number, {shown}: {why}",
            hint="say in the job's table [part] which part is to be corrected: serial = …",
            place=Place(str(measured.path)),
            values={"serials": serials},
        )
    chosen = [one for one in measured.inspections if not wanted or one.part.serial in (wanted, "")]
    return [_stated(one, job) for one in chosen]


def _stated(one: Inspection, job: Job) -> Inspection:
    given = job.gauging
    return replace(
        one,
        part=Part(part_type(job), one.part.serial or job.part.serial),
        device=one.device or given.device,
        operator=one.operator or given.operator,
        measured_at=one.measured_at or given.measured_at,
    )


def _matched(
    profile: Profile, inspections: Sequence[Inspection], *, strict: bool
) -> tuple[list[MatchedReading], list[Reading]]:
    """Readings with their features, and those of none. `strict`: a file for this part, every name is to be one of its.

    Raises MSR-FEATURE for a name that is none, and what is wrong about an inspection on this part.
    """
    if strict:
        return [_named(profile, reading) for one in inspections for reading in one.readings], []
    matched: list[MatchedReading] = []
    unmatched: list[Reading] = []
    for one in inspections:
        found = match_inspection(profile, one)
        for finding in check_matches(profile, one, found, {}, None):
            if finding.severity is Severity.ERROR:
                raise finding.as_error()
        matched += found.readings
        unmatched += [left.value for left in found.unmatched if isinstance(left.value, Reading)]
    return matched, unmatched


def _named(profile: Profile, reading: Reading) -> MatchedReading:
    found = match_by_name(profile, reading)
    if found is None:
        raise _no_feature(profile, [reading.feature or reading.characteristic, reading.other], reading.line)
    return found


def _no_feature(profile: Profile, named: Sequence[str], line: int | None) -> TrueloopError:
    name = next((one for one in named if one not in profile.names), named[0])
    near = difflib.get_close_matches(name, profile.names, n=1)
    return TrueloopError(
        Code.MSR_FEATURE,
        f"the part has no feature {name!r}",
        hint=f"did you mean {near[0]!r}?" if near else f"the part's features are: {', '.join(profile.names)}",
        place=Place(line=line),
        values={"feature": name},
    )


def _refuse_before(record: Path, file: Path, inspections: Sequence[Inspection]) -> None:
    """Refuses readings from before the correction of a record, or of no known time."""
    corrected_at = datetime.fromisoformat(read_record(record).made_at).astimezone(UTC)
    for measured_at in (one.measured_at and one.measured_at.astimezone(UTC) for one in inspections):
        if measured_at is None or measured_at < corrected_at:
            when = "" if measured_at is None else measured_at.isoformat(timespec="minutes")
            raise TrueloopError(
                Code.MSR_OLD,
                f"readings were taken at {when or 'a time that is not stated'}, the last correction was made at "
                f"{corrected_at.isoformat(timespec='minutes')}",
                hint="measure a part that was cut with the corrected program; `measured_at` says when",
                place=Place(str(file)),
                override="leave out gauging.after_record in the job",
                values={"measured_at": when, "corrected_at": corrected_at.isoformat()},
            )
