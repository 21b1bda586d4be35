"""A job's touches: as an inspection, and as part errors."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from trueloop.domain.inspection import Inspection, Touch
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import in_file
from trueloop.formats.jobs.job import Job
from trueloop.formats.measurements.touches_csv import read_touches
from trueloop.formats.option_tables import options_from
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.part_on_machine import PartOnMachine
from trueloop.machine.model.term import means
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, error_vectors

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


def read_part_errors(file: Path, job: Job, profile: Profile) -> ErrorVectors:
    """Reads touches from a file as error vectors. Raises TCH errors."""
    return part_errors(read_inspection(file, job).touches, str(file), job, profile)
