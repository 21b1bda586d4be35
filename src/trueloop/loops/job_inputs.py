"""A job file and everything it names, read into the values that the loop works on."""

import getpass
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from trueloop.compensation.limits import Limits
from trueloop.compensation.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.job import GaugingTable, Job, PartTable, read_job
from trueloop.formats.profile_of_job import junctions_by_design, profile_of_table
from trueloop.formats.touches_csv import read_touches
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.gauging.touches import Gauging, error_vectors
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.loops.process_intermittent import Inputs, Options
from trueloop.nc.contour import contour_of_program
from trueloop.nc.feed_moves import feed_moves
from trueloop.nc.program import Program, read_program
from trueloop.units import MM_PER_INCH, UM_PER_MM


@dataclass(frozen=True)
class JobInputs:
    """What the loop works on, the files it was read from (never to be overwritten), and where results go."""

    inputs: Inputs
    finish: Path
    output_folder: Path
    files: tuple[Path, ...]


def read_inputs(path: Path) -> JobInputs:
    """Reads a job. Raises the errors of whatever cannot be read, with the file named."""
    job, folder = read_job(path), path.parent
    files = _files(job, path)
    program = _program(folder / job.programs.finish, job)
    nose_radius_mm = _nose_radius_mm(job)
    profile = _profile(job, folder, path, program, nose_radius_mm)
    after = job.gauging.finish_touches
    inputs = Inputs(
        part=job.part.name,
        profile=profile,
        nose_radius_mm=nose_radius_mm,
        program=program,
        touches=_touches(profile, folder / job.gauging.touches, job.gauging),
        options=_options(job),
        semifinish=None if job.programs.semifinish is None else _program(folder / job.programs.semifinish, job),
        allowance_mm=job.programs.semifinish_allowance_mm or 0.0,
        parameters=job.programs.parameters,
        execute_deleted_blocks=job.programs.execute_deleted_blocks,
        measured_at=job.gauging.measured_at,
        program_sha256=job.gauging.program_sha256,
        finish_touches=None if after is None else _touches(profile, folder / after, job.gauging),
        inputs_sha256={name: sha256_of(file.read_bytes()) for name, file in files.items()},
        made_by=_user(),
    )
    return JobInputs(inputs, folder / job.programs.finish, folder / job.output.folder, tuple(files.values()))


def _files(job: Job, path: Path) -> Mapping[str, Path]:
    """Every input by what it is. Raises JOB-MISSING for the first that is not there."""
    named = {
        "finish": job.programs.finish,
        "semifinish": job.programs.semifinish,
        "touches": job.gauging.touches,
        "finish_touches": job.gauging.finish_touches,
        "dxf": job.part.dxf,
        "nose_model": job.compensation.nose_model,
    }
    files = {"job": path} | {what: path.parent / file for what, file in named.items() if file is not None}
    for what, file in files.items():
        if not file.is_file():
            raise TrueloopError(
                Code.JOB_MISSING,
                f"the job names {str(file)!r} as {what!r}, and there is no such file",
                hint="paths are relative to the job file",
                place=Place(str(path)),
            )
    return files


def _program(path: Path, job: Job) -> Program:
    return read_program(path.read_bytes(), job.programs.dialect, str(path))


def _nose_radius_mm(job: Job) -> float:
    if job.tool.nose_radius_mm is not None:
        return job.tool.nose_radius_mm
    assert job.tool.nose_radius_in is not None  # the job was validated: one of the two is there
    return job.tool.nose_radius_in * MM_PER_INCH


def _profile(job: Job, folder: Path, path: Path, program: Program, nose_radius_mm: float) -> Profile:
    try:
        if job.part.dxf is not None:
            return _from_dxf(job.part, folder / job.part.dxf)
        if job.part.from_program:
            moves = feed_moves(program.run(job.programs.parameters))
            found = contour_of_program(moves, nose_radius_mm).profile
            return checked_profile(found.features, junctions_by_design(job.part.junctions))
        return profile_of_table(job.part)
    except TrueloopError as error:
        raise error.in_file(str(path)) from None


def _from_dxf(part: PartTable, path: Path) -> Profile:
    from trueloop.formats.dxf import read_dxf  # ezdxf is slow to import and few jobs need it

    drawing = read_dxf(path, layer=part.dxf_layer, x_is=part.x_is)
    return checked_profile(drawing.features, junctions_by_design(part.junctions))


def _touches(profile: Profile, path: Path, gauging: GaugingTable) -> ErrorVectors:
    how = Gauging(
        ball_radius_mm=gauging.ball_radius_mm,
        allowance_mm=gauging.measured_allowance_mm,
        range_x_mm=gauging.repeatability_diameter_um / UM_PER_MM,
        range_z_mm=gauging.repeatability_face_um / UM_PER_MM,
        z_reference=gauging.z_reference,
    )
    try:
        return error_vectors(profile, read_touches(path), how)
    except TrueloopError as error:
        raise error.in_file(str(path)) from None


def _options(job: Job) -> Options:
    table, programs = job.compensation, job.programs
    return Options(
        weight=table.weight,
        junctions=table.junctions,
        knot_every=table.knot_every,
        chord_tolerance_mm=table.chord_tolerance_um / UM_PER_MM,
        arcs=table.arcs,
        limits=Limits(table.max_correction_um / UM_PER_MM, table.max_slope_um_per_mm / UM_PER_MM, table.max_age_hours),
        resolution_mm=programs.resolution_mm,
        offset_is_diameter=None if programs.offset_x_is is None else programs.offset_x_is == "diameter",
        tool=job.tool.number,
    )


def _user() -> str:
    """Who makes the correction, as the system knows them."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return "unknown"
