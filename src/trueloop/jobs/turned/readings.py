"""The inspection files that a job names: the readings of its part, each with its feature.

The files that a job is read from: its record names them by hash, its results must not overwrite them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection, Reading, Touch
from trueloop.domain.option import Limits
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, Severity, in_file
from trueloop.formats.inspections.gauge_csv import FORMAT as GAUGE_CSV
from trueloop.formats.inspections.measured_file import MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.shared.checks import stated_deviations
from trueloop.formats.inspections.shared.text import feature_names
from trueloop.formats.jobs.job import Job
from trueloop.formats.measurements.touches_csv import read_touches
from trueloop.formats.toml_tables import options_from
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.part_on_machine import PartOnMachine
from trueloop.machine.model.term import means
from trueloop.turned.readings.match import features_listed, match_inspection
from trueloop.turned.readings.matches import MatchedReading, feature_named, match_by_name
from trueloop.turned.readings.observed import check_repeats, corrected, nominal_of, other_nominals, repeated
from trueloop.turned.readings.of_this_part import check_matches
from trueloop.turned.readings.vectors import assumed_words, require_places, warm_words, with_readings
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, error_vectors, in_order
from trueloop.units import UM_PER_MM
from trueloop.wording import did_you_mean, first_of, shell_word, wording


@dataclass(frozen=True)
class Sources:
    """Files by the names the job gives them. What is read for a job gets its path here, and so is noted.

    `folder` is where names start from, `prefix` how it is called from the job's own folder.
    """

    folder: Path
    prefix: Path = Path()
    named: dict[str, Path] = field(default_factory=dict)

    def file(self, name: Path | str) -> Path:
        """Returns the path of a file, and notes it by its name with slashes, on Windows too."""
        path = self.folder / name
        self.named[(self.prefix / name).as_posix()] = path
        return path

    def beside(self, name: Path) -> "Sources":
        """Returns sources for the names in another file: they start from its folder, and are noted with these."""
        return replace(self, folder=(self.folder / name).parent, prefix=self.prefix / name.parent)

    @property
    def files(self) -> tuple[Path, ...]:
        """Returns all files that were noted."""
        return tuple(self.named.values())

    @property
    def sha256(self) -> dict[str, str]:
        """Returns their hashes by name."""
        return {name: sha256_of(path.read_bytes()) for name, path in self.named.items()}


@dataclass(frozen=True)
class ReadReadings:
    """The readings of the job's part: as reported, by feature, and notes in words.

    `touches` are points of a measuring machine as errors along the normal; `asked` the files' own characteristics.
    """

    inspections: tuple[Inspection, ...]
    matched: tuple[MatchedReading, ...]
    touches: tuple[Touch, ...]
    asked: tuple[Characteristic, ...]
    names: Mapping[str, str]
    notes: tuple[str, ...]
    gauging: Gauging
    file: str | None

    def joined(self, profile: Profile, touches: ErrorVectors | None) -> tuple[ErrorVectors, tuple[str, ...]]:
        """Touches and readings as error vectors, and all notes. Raises MSR errors."""
        if not self.matched:
            assert touches is not None  # a job has one of both
            return touches, (*self.notes, *_tiny_words(touches))
        with in_file(self.file):
            vectors, notes = with_readings(profile, self.matched, touches, self.gauging)
            require_places(self.matched, vectors)
        return replace(vectors, file=vectors.file or self.file), (*self.notes, *notes)


TINY_MM: Final = 3e-4
"""No touch repeats to less; errors in millimetres that are read as micrometres are smaller."""


def _tiny_words(touches: ErrorVectors) -> tuple[str, ...]:
    """Returns a note where all of several touches have errors below `TINY_MM`."""
    if len(touches.point) < 2 or float(np.max(np.abs(touches.error_mm))) >= TINY_MM:
        return ()
    return (
        wording(
            "All {n} touches have errors below {limit:.1f} µm: were they measured, and is the unit of their column "
            "right?",
            n=len(touches.point),
            limit=TINY_MM * UM_PER_MM,
        ),
    )


def read_readings(job: Job, sources: Sources, profile: Profile) -> ReadReadings:
    """Reads all files of `gauging.readings`. Raises MSR errors with file and line."""
    inspections: list[Inspection] = []
    matched: list[MatchedReading] = []
    touches: list[Touch] = []
    asked: list[Characteristic] = []
    notes: list[str] = []
    gauging = options_from(Gauging, job)
    mapping = None if job.gauging.readings_mapping is None else sources.file(job.gauging.readings_mapping)
    names = feature_names(mapping)
    require_features(mapping, names, profile)
    files = [sources.file(name) for name in job.gauging.readings_files]
    of_files: dict[str, Path] = {}
    for file in files:
        measured = _measured(file, StatedFacts(job.gauging.readings_unit, mapping, "gauging.readings_unit"))
        chosen = [measured.for_part(inspection) for inspection in _of_part(measured, job)]
        _require_another_file(file, [*inspections, *chosen], of_files)
        with in_file(file):
            found, points, unmatched = _matched(profile, chosen, names, strict=measured.format == GAUGE_CSV.name)
            repeated(profile, corrected(found), gauging)
        inspections += chosen
        matched += found
        touches += [_less(point, gauging.allowance_mm) for point in points]
        asked += measured.characteristics
        notes += [f"{file.name}: {remark.text}." for remark in measured.remarks]
        notes += _of_other_name(file.name, measured, job)
        if unmatched:
            notes.append(wording("{file}: {n} values are of no feature of the part.", file=file.name, n=unmatched))
        for nominal in other_nominals(profile, found):
            if nominal.severity is Severity.ERROR:
                raise nominal.in_file(str(file)).as_error()
            notes.append(f"{file.name}: {nominal.message} ({nominal.hint}).")
        notes += [f"{file.name}: {remark.text}." for remark in deviations_of(measured, profile, found)]
    if files and not matched and not touches:
        held = sum(inspection.count for inspection in inspections)
        raise Code.MSR_NONE.refusal(
            wording("{n} files of readings hold {held} values, and 0 readings of the part", n=len(files), held=held),
            hint=f"`trueloop measure read {shell_word(str(files[0]))} --job JOB.toml` shows why each is not used"
            if held
            else "fill in at least one value: a row without one was not measured",
            place=Place(str(files[0])),
        )
    notes += assumed_words(matched, gauging.readings_u_mm)
    notes += warm_words(matched)
    one_file = str(files[0]) if len(files) == 1 else None
    with in_file(one_file):
        notes += check_repeats(profile, matched, gauging, options_from(Limits, job))
    return ReadReadings(
        inspections=tuple(inspections),
        matched=tuple(matched),
        touches=tuple(touches),
        asked=tuple(asked),
        names=names,
        notes=tuple(notes),
        gauging=gauging,
        file=one_file,
    )


def deviations_of(measured: MeasuredFile, profile: Profile, matched: Sequence[MatchedReading]) -> tuple[Remark, ...]:
    """Compares deviations that a file states of readings without a nominal value with those from the profile's."""
    return stated_deviations(
        (replace(reading.reading, nominal=nominal_of(profile, reading)), *deviation)
        for reading in corrected(matched)
        if (deviation := measured.deviation_of(reading.reading)) is not None
    )


def require_features(mapping: Path | None, names: Mapping[str, str], profile: Profile) -> None:
    """Raises MSR-MAPPING for a name of the mapping's list that is not a feature of the part: it would match nothing."""
    for name, listed in names.items():
        for feature in filter(None, features_listed(profile, listed)):
            if feature_named(profile, feature) is None:
                raise Code.MSR_MAPPING.refusal(
                    f"features.{name!r} is {feature!r}, none of the {len(profile.names)} features of the part",
                    hint=f"the part's features are: {', '.join(profile.names)}",
                    place=Place(str(mapping)),
                )


def _less(touch: Touch, allowance_mm: float) -> Touch:
    """A point's error, from which the ball is taken off already, without what the cut was to leave on."""
    assert touch.error_mm is not None  # `match_inspection` takes it from the point
    return replace(touch, error_mm=touch.error_mm - allowance_mm, measured_mm=None)


def _measured(file: Path, stated: StatedFacts) -> MeasuredFile:
    from trueloop.formats.inspections.known import read_measured_file  # slow to import: the readers of all formats

    return read_measured_file(file, stated)


def _of_part(measured: MeasuredFile, job: Job) -> list[Inspection]:
    """Returns the inspections of the job's part; the job fills facts missing in the file. Raises MSR-SERIAL."""
    serials = sorted({inspection.part.serial for inspection in measured.inspections if inspection.part.serial})
    wanted = job.part.serial
    if (wanted and serials and wanted not in serials) or (not wanted and len(serials) > 1):
        why = f"part {wanted!r} is not among them" if wanted else "`part.serial` of the job chooses none"
        raise Code.MSR_SERIAL.refusal(
            wording(
                "the file holds {n} parts by serial number, {shown}: {why}",
                n=len(serials),
                shown=first_of([*map(repr, serials)], 6),
                why=why,
            ),
            hint="say in the job's table [part] which part is to be corrected: serial = …",
            place=Place(str(measured.path)),
            values={"serials": serials},
        )
    chosen = [one for one in measured.inspections if not (wanted and serials) or one.part.serial == wanted]
    _require_one_part(measured, chosen)
    return [_stated(inspection, job) for inspection in chosen]


def _require_another_file(file: Path, inspections: Sequence[Inspection], earlier: dict[str, Path]) -> None:
    """Raises MSR-SERIAL where files are of several parts, MSR-VALUE where one has the content of an earlier one."""
    serials = sorted({inspection.part.serial for inspection in inspections} - {""})
    if len(serials) > 1:
        raise Code.MSR_SERIAL.refusal(
            f"{file.name!r} is not of one part with the files before it: their serial numbers are {serials}",
            hint="name the files of the one part that is to be corrected",
            place=Place(str(file)),
            values={"serials": serials},
        )
    if (other := earlier.setdefault(sha256_of(file.read_bytes()), file)) is not file:
        raise Code.MSR_VALUE.refusal(
            f"{file.name!r} holds what {other.name!r} holds: each value would count twice",
            hint="name the file once in `gauging.readings`",
            place=Place(str(file)),
            values={"file": file.name},
        )


def _require_one_part(measured: MeasuredFile, inspections: Sequence[Inspection]) -> None:
    """Raises MSR-SERIAL where inspections without a common serial number hold one value: not one part's."""
    first: dict[tuple[object, ...], Inspection] = {}
    for inspection in inspections:
        for key in _values_of(inspection):
            other = first.setdefault(key, inspection)
            if other is not inspection and not (other.part.serial and other.part.serial == inspection.part.serial):
                runs = [k for k, one in enumerate(measured.inspections, 1) if one in (other, inspection)]
                command = f"trueloop measure read {shell_word(str(measured.path))} --job JOB.toml --run {runs[-1]}"
                raise Code.MSR_SERIAL.refusal(
                    f"inspections {runs[0]} and {runs[-1]} of the file both hold {key[0]!r}, and no serial number "
                    "tells whether they are of one part",
                    hint=f"write the one that is meant to a file for the job, with `{command} -o one.csv`; or state "
                    "the serial numbers in the file",
                    place=Place(str(measured.path)),
                    values={"serials": [one.part.serial for one in inspections][:20]},
                )


def _values_of(inspection: Inspection) -> list[tuple[object, ...]]:
    """Returns what tells the values of an inspection apart; points without a name are alike."""
    readings = [(one.characteristic, one.feature, one.axis, one.place_mm) for one in inspection.readings]
    points = [point.name for point in inspection.points] + [touch.point for touch in inspection.touches]
    return [*readings, *((name,) for name in points)]


def _of_other_name(file: str, measured: MeasuredFile, job: Job) -> list[str]:
    """A note for each name of a part that is not the job's: measuring machines often have their own."""
    names = dict.fromkeys(inspection.part.part_type.name for inspection in measured.inspections)
    others = [name for name in names if name and name.casefold() not in (job.part.name.casefold(), Path(file).stem)]
    return [f"{file}: its part is {name!r}, that of the job {job.part.name!r}." for name in others]


def _stated(inspection: Inspection, job: Job) -> Inspection:
    given = job.gauging
    return replace(
        inspection,
        part=Part(part_type(job), inspection.part.serial or job.part.serial),
        device=inspection.device or given.device,
        operator=inspection.operator or given.operator,
        measured_at=inspection.measured_at.astimezone() if inspection.measured_at else given.measured_at,
    )


def _matched(
    profile: Profile, inspections: Sequence[Inspection], names: Mapping[str, str], *, strict: bool
) -> tuple[list[MatchedReading], list[Touch], int]:
    """Readings with their features, points as touches, and how many values are of no feature.

    `strict`: a file for this part, of which every name is to be one of its features. Raises MSR-FEATURE for a name
    that is none, and what is wrong about an inspection on this part.
    """
    if strict and not names:
        return [_named(profile, reading) for inspection in inspections for reading in inspection.readings], [], 0
    matched: list[MatchedReading] = []
    touches: list[Touch] = []
    unmatched = 0
    for inspection in inspections:
        found = match_inspection(profile, inspection, names)
        for finding in check_matches(profile, inspection, found, names, None):
            if finding.severity is Severity.ERROR:
                raise finding.as_error()
        matched += found.readings
        touches += [each.touch for each in found.touches]
        unmatched += len(found.unmatched)
    return matched, touches, unmatched


def _named(profile: Profile, reading: Reading) -> MatchedReading:
    found = match_by_name(profile, reading)
    if found is None:
        named = [reading.feature or reading.characteristic, reading.other]
        name = next((one for one in named if one not in profile.names), named[0])
        raise Code.MSR_FEATURE.refusal(
            wording("the part has no feature {name!r}", name=name),
            hint=did_you_mean(name, profile.names) or f"the part's features are: {', '.join(profile.names)}",
            place=Place(line=reading.line),
            values={"feature": name},
        )
    return found


DEVICES: Final = {"machine": "probe of the machine tool", "cmm": "coordinate measuring machine"}
"""By `machine.touched_on` of the job."""


def part_type(job: Job) -> PartType:
    """Returns what the job states of all parts of this kind."""
    given = job.part
    return PartType(given.name, given.revision, given.material, given.drawing)


def read_inspection(file: Path, job: Job, machine: PartOnMachine | None = None) -> Inspection:
    """Reads the touches as reported; device and temperatures as far as the job states them. Raises TCH errors."""
    with in_file(file):
        touches = tuple(read_touches(file))
    gauging = options_from(Gauging, job)
    on_machine = machine is not None and machine.touched_on == "machine"
    return Inspection(
        part=Part(part_type(job), job.part.serial),
        measured="touches",
        sha256=sha256_of(file.read_bytes()),
        count=len(touches),
        values=touches,
        device=job.gauging.device or ("" if machine is None else DEVICES[machine.touched_on]),
        operator=job.gauging.operator,
        measured_at=job.gauging.measured_at,
        ball_radius_mm=gauging.ball_radius_mm,
        z_reference=gauging.z_reference,
        temperatures=means(machine.probing) if machine is not None and on_machine else {},
    )


def part_errors(touches: Sequence[Touch], file: str | None, job: Job, profile: Profile) -> ErrorVectors:
    """Converts the touches of a file to part errors along the profile. Raises TCH errors."""
    with in_file(file):
        return replace(error_vectors(profile, touches, options_from(Gauging, job)), file=file)


def read_part_errors(files: Sequence[Path], job: Job, profile: Profile) -> ErrorVectors:
    """Reads touches from files as error vectors. Raises TCH errors."""
    touches: Sequence[Touch] = [touch for file in files for touch in read_inspection(file, job).touches]
    return part_errors(touches if len(files) == 1 else in_order(profile, touches), str(files[0]), job, profile)
