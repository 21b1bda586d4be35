"""A job file and the files it names, read into the values that the loop works on.

Whatever is refused names the file it stands in: numerics know nothing of files, this module does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from trueloop.domain.limits import Limits
from trueloop.domain.record import check_uncorrected
from trueloop.errors import Code, in_file
from trueloop.formats.input_file import read_input
from trueloop.formats.jobs.job import CompensationTable, FeatureFitTable, Job, read_job
from trueloop.formats.jobs.profile_of_job import junctions_by_design, profile_of_table
from trueloop.formats.option_tables import options_from
from trueloop.geometry.feature import Feature
from trueloop.geometry.offset import CentrePath, nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.inspection import part_errors, read_inspection, read_part_errors
from trueloop.jobs.part_on_machine import read_part_on_machine
from trueloop.jobs.sources import Sources
from trueloop.jobs.user import user_name
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.correction import Inputs
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.understood import require_understood
from trueloop.turned.fit.between_cuts import NONE, PRIOR, BetweenCuts
from trueloop.turned.fit.nose_fit import fit_nose_model, nose_touches
from trueloop.turned.fit.nose_model import NoseModel
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.options import Options
from trueloop.turned.touches.touches import Gauging
from trueloop.units import MM_PER_INCH, UM_PER_MM

PROGRAM_HINT: Final = "the job's table [programs] names it, relative to the job file"


@dataclass(frozen=True)
class ReadJob:
    """A job as values, the files it was read from, and the folder for what comes of it."""

    inputs: Inputs
    files: tuple[Path, ...]
    output_folder: Path


@dataclass(frozen=True)
class ReadPart:
    """A job's nominal profile and tool, and the files they were read from."""

    name: str
    profile: Profile
    nose_radius_mm: float
    files: tuple[Path, ...]

    @property
    def centre_path(self) -> CentrePath:
        """The path of the nose centre along the profile. Raises GEO errors where the nose does not fit."""
        return nose_centre_path(self.profile, self.nose_radius_mm)


def read_part(path: Path) -> ReadPart:
    """The part of a job alone: its touches need not exist yet."""
    sources = Sources(path.parent)
    job = read_job(sources.file(path.name))
    program = _program(sources, path, job, job.programs.finish) if job.part.from_program else None
    profile = _profile(sources, path, job, program)
    return ReadPart(job.part.name, profile, _nose_radius_mm(job), sources.files)


@dataclass(frozen=True)
class ReadFinish:
    """A job's part, its finish program, and how that is run."""

    part: ReadPart
    program: Program
    run: Run


def read_finish(path: Path) -> ReadFinish:
    """The finish program of a job and what it is meant to cut: its touches need not exist yet."""
    sources = Sources(path.parent)
    job = read_job(sources.file(path.name))
    program, given = _program(sources, path, job, job.programs.finish), job.programs
    profile = _profile(sources, path, job, program)
    part = ReadPart(job.part.name, profile, _nose_radius_mm(job), sources.files)
    run = Run(given.parameters, given.execute_deleted_blocks, given.finish_lines)
    return ReadFinish(part, program, run)


def read_inputs(path: Path) -> ReadJob:
    """Everything a job names. Raises JOB, NC, GEO and TCH errors with the file they stand in.

    CMP-TWICE before anything else of the finish program: a profile taken from a corrected one would be no nominal.
    """
    sources = Sources(path.parent)
    job = read_job(sources.file(path.name))
    _require_uncorrected(path, job)
    program = _program(sources, path, job, job.programs.finish)
    profile = _profile(sources, path, job, program)
    touches = sources.file(job.gauging.touches)
    finish_touches = sources.file(job.gauging.finish_touches) if job.gauging.finish_touches else None
    nose = _nose(sources, job)
    machine = None
    if job.machine is not None:
        machine = read_part_on_machine(sources, path, job.machine, options_from(Gauging, job).ball_radius_mm)
    inspection = read_inspection(touches, job, machine)
    inputs = Inputs(
        part=job.part.name,
        profile=profile,
        nose_radius_mm=_nose_radius_mm(job),
        program=program,
        touches=part_errors(inspection, touches, job, profile),
        options=_options(job),
        made_at=datetime.now(UTC),
        made_by=user_name(),
        semifinish=_program(sources, path, job, job.programs.semifinish) if job.programs.semifinish else None,
        allowance_mm=job.programs.semifinish_allowance_mm or 0.0,
        parameters=job.programs.parameters,
        execute_deleted_blocks=job.programs.execute_deleted_blocks,
        lines=job.programs.finish_lines,
        inspection=inspection,
        program_sha256=job.gauging.program_sha256,
        finish_touches=read_part_errors(finish_touches, job, profile) if finish_touches else None,
        nose=nose,
        machine=machine,
        inputs_sha256=sources.sha256,
        file=str(path),
    )
    return ReadJob(
        inputs=inputs,
        files=sources.files,
        output_folder=path.parent / job.output.folder,
    )


def _require_uncorrected(path: Path, job: Job) -> None:
    finish = path.parent / job.programs.finish
    source = read_input(finish, Code.NC_FILE, hint=PROGRAM_HINT)
    with in_file(finish):
        check_uncorrected(source)


def _program(sources: Sources, path: Path, job: Job, name: Path) -> Program:
    file = sources.file(name)
    source = read_input(file, Code.NC_FILE, hint=PROGRAM_HINT)
    with in_file(path):
        program = read_program(source, job.programs.dialect, str(file), job.programs.unit, job.programs.decimals)
        if not job.programs.accept_unknown_words:
            require_understood(program)
        return program


def _profile(sources: Sources, path: Path, job: Job, program: Program | None) -> Profile:
    features = _features(sources, job, program)
    with in_file(path):
        if features is None:
            return profile_of_table(job.part)
        return checked_profile(features, junctions_by_design(job.part.junctions))


def _features(sources: Sources, job: Job, program: Program | None) -> Sequence[Feature] | None:
    """The nominal profile from the file that the job names; None where the job's own table spells it out."""
    part = job.part
    if program is not None and part.from_program:
        run = Run(job.programs.parameters, job.programs.execute_deleted_blocks)
        return run.contour(program, _nose_radius_mm(job)).profile.features
    if part.dxf is not None:
        # ezdxf takes long to import, and most jobs have no drawing.
        from trueloop.formats.cad.dxf import read_dxf

        unit = part.unit if "unit" in part.model_fields_set else None
        drawing = sources.file(part.dxf)
        return read_dxf(drawing, layer=part.dxf_layer, unit=unit, x_is=part.x_is, outline=part.dxf_outline).features
    if part.step is not None:
        from trueloop.formats.cad.step_profile import read_step_profile  # slow to import

        low_mm, high_mm = part.step_from_z_mm, part.step_to_z_mm
        solid = sources.file(part.step)
        return read_step_profile(solid, turned_round=part.step_turned_round, from_z_mm=low_mm, to_z_mm=high_mm).features
    return None


def _nose(sources: Sources, job: Job) -> NoseModel | None:
    """The nose as the jobs of other parts know it that were cut with the same edge."""
    parts = []
    for name in job.compensation.nose_from:
        file, others = sources.file(name), sources.beside(name)
        other = read_job(file)
        if other.part.from_program:
            _require_uncorrected(file, other)
        program = _program(others, file, other, other.programs.finish) if other.part.from_program else None
        profile = _profile(others, file, other, program)
        touches = read_part_errors(others.file(other.gauging.touches), other, profile)
        parts.append(nose_touches(other.part.name, profile, touches))
    return fit_nose_model(parts) if parts else None


def _options(job: Job) -> Options:
    given = job.compensation
    return options_from(
        Options,
        job,
        knot_every_on={name: fit.knot_every for name, fit in given.features.items() if fit.knot_every is not None},
        prescribed={name: ends for name, fit in given.features.items() if (ends := _ends(fit)).count},
        between_cuts=_between_cuts(given),
        limits=options_from(Limits, job),
        offset_is_diameter=None if job.programs.offset_x_is is None else job.programs.offset_x_is == "diameter",
        tool=job.tool.number,
    )


def _between_cuts(given: CompensationTable) -> BetweenCuts:
    """What the job says of how cuts differ; the prior where it says nothing."""
    common_um, along_um = given.cut_to_cut_um, given.cut_to_cut_along_um
    if common_um is None and along_um is None:
        return PRIOR
    source = "stated in the job" if common_um or along_um else NONE.source
    return BetweenCuts((common_um or 0.0) / UM_PER_MM, (along_um or 0.0) / UM_PER_MM, source)


def _ends(fit: FeatureFitTable) -> EndConditions:
    given = (fit.start_um, fit.start_slope_um_per_mm, fit.end_um, fit.end_slope_um_per_mm)
    return EndConditions(*(None if number is None else number / UM_PER_MM for number in given))


def _nose_radius_mm(job: Job) -> float:
    if job.tool.nose_radius_in is not None:
        return job.tool.nose_radius_in * MM_PER_INCH
    assert job.tool.nose_radius_mm is not None
    return job.tool.nose_radius_mm
