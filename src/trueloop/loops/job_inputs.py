"""A job file and the files it names, read into the values that the loop works on.

Whatever is refused names the file it stands in: numerics know nothing of files, this module does.
"""

import getpass
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from trueloop.compensation.limits import Limits
from trueloop.compensation.record import sha256_of
from trueloop.error_curve.nose_fit import fit_nose_model, nose_touches
from trueloop.error_curve.nose_model import NoseModel
from trueloop.errors import Code, TrueloopError
from trueloop.formats.input_file import read_input
from trueloop.formats.job import Job, read_job
from trueloop.formats.profile_of_job import junctions_by_design, profile_of_table
from trueloop.formats.touches_csv import read_touches
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.gauging.touches import Gauging, error_vectors
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.loops.commanded import Run
from trueloop.loops.process_intermittent import Inputs, Options
from trueloop.nc.contour import contour_of_program
from trueloop.nc.feed_moves import feed_moves
from trueloop.nc.program import Program, read_program
from trueloop.nc.understood import require_understood
from trueloop.units import MM_PER_INCH, UM_PER_MM


@dataclass(frozen=True)
class ReadJob:
    """A job as values, and what it was read from: `files` are all inputs, `finish` the program to be corrected."""

    inputs: Inputs
    finish: Path
    files: tuple[Path, ...]
    output_folder: Path
    job: Path
    touches: Path
    finish_touches: Path | None = None

    def file_behind(self, code: Code) -> Path:
        """Where to look for the cause of a refusal that names no file: the touches, unless it is about another."""
        if code is Code.TCH_SIGN and self.finish_touches is not None:
            return self.finish_touches
        if code is Code.CMP_AGE:
            return self.job
        return self.finish if code.startswith("NC-") or code is Code.CMP_READ_BACK else self.touches


@dataclass(frozen=True)
class ReadPart:
    """A job's nominal profile and tool."""

    name: str
    profile: Profile
    nose_radius_mm: float


def read_part(path: Path) -> ReadPart:
    """The part of a job alone: its touches need not exist yet."""
    job = read_job(path)
    program = _program(path, job, job.programs.finish) if job.part.from_program else None
    return ReadPart(job.part.name, _profile(path, job, program), _nose_radius_mm(job))


@dataclass(frozen=True)
class ReadFinish:
    """A job's part, its finish program, and how that is run."""

    part: ReadPart
    program: Program
    run: Run


def read_finish(path: Path) -> ReadFinish:
    """The finish program of a job and what it is meant to cut: its touches need not exist yet."""
    job = read_job(path)
    program, given = _program(path, job, job.programs.finish), job.programs
    part = ReadPart(job.part.name, _profile(path, job, program), _nose_radius_mm(job))
    run = Run(given.parameters, given.execute_deleted_blocks, given.resolution_mm, given.finish_lines)
    return ReadFinish(part, program, run)


def read_inputs(path: Path) -> ReadJob:
    """Everything a job names. Raises JOB, NC, GEO and TCH errors with the file they stand in."""
    job = read_job(path)
    program = _program(path, job, job.programs.finish)
    profile = _profile(path, job, program)
    finish_touches = job.gauging.finish_touches
    files = _files(path, job)
    inputs = Inputs(
        part=job.part.name,
        profile=profile,
        nose_radius_mm=_nose_radius_mm(job),
        program=program,
        touches=_touches(path.parent / job.gauging.touches, job, profile),
        options=_options(job),
        semifinish=_program(path, job, job.programs.semifinish) if job.programs.semifinish else None,
        allowance_mm=job.programs.semifinish_allowance_mm or 0.0,
        parameters=job.programs.parameters,
        execute_deleted_blocks=job.programs.execute_deleted_blocks,
        lines=job.programs.finish_lines,
        # A time without a zone is the clock on the wall here.
        measured_at=job.gauging.measured_at.astimezone() if job.gauging.measured_at else None,
        program_sha256=job.gauging.program_sha256,
        finish_touches=_touches(path.parent / finish_touches, job, profile) if finish_touches else None,
        nose=_nose(path, job),
        inputs_sha256={name: sha256_of(file.read_bytes()) for name, file in files.items()},
        made_by=user_name(),
    )
    return ReadJob(
        inputs=inputs,
        finish=path.parent / job.programs.finish,
        files=tuple(files.values()),
        output_folder=path.parent / job.output.folder,
        job=path,
        touches=path.parent / job.gauging.touches,
        finish_touches=path.parent / finish_touches if finish_touches else None,
    )


@contextmanager
def _named(file: Path) -> Iterator[None]:
    """Puts the file into refusals that do not know it."""
    try:
        yield
    except TrueloopError as error:
        raise error.in_file(str(file)) from error


def _files(path: Path, job: Job) -> dict[str, Path]:
    """Every input by the name the job gives it."""
    named = (
        job.part.dxf,
        job.programs.finish,
        job.programs.semifinish,
        job.gauging.touches,
        job.gauging.finish_touches,
        *job.compensation.nose_from,
    )
    return {path.name: path} | {str(file): path.parent / file for file in named if file is not None}


def _program(path: Path, job: Job, file: Path) -> Program:
    hint = "the job's table [programs] names it, relative to the job file"
    source = read_input(path.parent / file, Code.NC_FILE, hint=hint)
    with _named(path):
        program = read_program(source, job.programs.dialect, str(path.parent / file))
        if not job.programs.accept_unknown_words:
            require_understood(program)
        return program


def _profile(path: Path, job: Job, program: Program | None) -> Profile:
    part, by_design = job.part, junctions_by_design(job.part.junctions)
    if part.from_program:
        assert program is not None
        with _named(path.parent / job.programs.finish):
            tool_path = program.run(job.programs.parameters, skipped_blocks=job.programs.execute_deleted_blocks)
            features = contour_of_program(feed_moves(tool_path), _nose_radius_mm(job)).profile.features
    elif part.dxf is not None:
        # ezdxf takes long to import, and most jobs have no drawing.
        from trueloop.formats.dxf import read_dxf

        unit = part.unit if "unit" in part.model_fields_set else None
        features = read_dxf(path.parent / part.dxf, layer=part.dxf_layer, unit=unit, x_is=part.x_is).features
    else:
        with _named(path):
            return profile_of_table(part)
    with _named(path):
        return checked_profile(features, by_design)


def _touches(file: Path, job: Job, profile: Profile) -> ErrorVectors:
    gauging = Gauging(
        ball_radius_mm=job.gauging.ball_radius_mm,
        allowance_mm=job.gauging.measured_allowance_mm,
        range_x_mm=job.gauging.repeatability_diameter_um / UM_PER_MM,
        range_z_mm=job.gauging.repeatability_face_um / UM_PER_MM,
        z_reference=job.gauging.z_reference,
    )
    with _named(file):
        return error_vectors(profile, read_touches(file), gauging)


def _nose(path: Path, job: Job) -> NoseModel | None:
    """The nose as the jobs of other parts know it that were cut with the same edge."""
    parts = []
    for file in job.compensation.nose_from:
        other = path.parent / file
        told = read_job(other)
        program = _program(other, told, told.programs.finish) if told.part.from_program else None
        profile = _profile(other, told, program)
        parts.append(
            nose_touches(told.part.name, profile, _touches(other.parent / told.gauging.touches, told, profile))
        )
    return fit_nose_model(parts) if parts else None


def _options(job: Job) -> Options:
    given = job.compensation
    return Options(
        weight=given.weight,
        junctions=given.junctions,
        knot_every=given.knot_every,
        cut_to_cut_mm=given.cut_to_cut_um / UM_PER_MM,
        chord_tolerance_mm=given.chord_tolerance_um / UM_PER_MM,
        arcs=given.arcs,
        limits=Limits(
            correction_mm=given.max_correction_um / UM_PER_MM,
            slope=given.max_slope_um_per_mm / UM_PER_MM,
            scatter_mm=given.max_scatter_um / UM_PER_MM,
            age_hours=given.max_age_hours,
        ),
        resolution_mm=job.programs.resolution_mm,
        offset_is_diameter=None if job.programs.offset_x_is is None else job.programs.offset_x_is == "diameter",
        tool=job.tool.number,
    )


def _nose_radius_mm(job: Job) -> float:
    if job.tool.nose_radius_in is not None:
        return job.tool.nose_radius_in * MM_PER_INCH
    assert job.tool.nose_radius_mm is not None
    return job.tool.nose_radius_mm


def user_name() -> str:
    """Who runs this, as far as the system knows."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return "unknown"
