"""Inputs of an edge's correction: those of the job, common to all tools, and those of the edge's tool.

The set-ups of a job with what each cuts: a job without set-ups has one, of one tool one with one edge.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection
from trueloop.domain.option import Limits
from trueloop.domain.tool import Edge, Machine, Tool
from trueloop.errors import Code, Place
from trueloop.formats.jobs.job import CompensationTable, FeatureFitTable, Job
from trueloop.formats.jobs.profile_of_job import fit_notes
from trueloop.formats.jobs.tool_tables import ToolsTable
from trueloop.formats.jobs.tool_tables import ToolTable as TableOfTool
from trueloop.formats.tables.tool_tables.known import held_tool
from trueloop.formats.toml_tables import options_from
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import PART
from trueloop.jobs.turned.characteristics import characteristics_of, joined
from trueloop.jobs.turned.cut_with import with_cut
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.readings import part_errors, part_type, read_inspection, read_part_errors, read_readings
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.cuts import InSetups, Setup, in_setups
from trueloop.loops.turned.part_on_machine import PartOnMachine
from trueloop.loops.turned.share import vectors_in, vectors_of_edge
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.nc.program.called import CalledOffset
from trueloop.nc.program.program import Program
from trueloop.turned.fit.between_cuts import NONE, PRIOR, BetweenCuts
from trueloop.turned.fit.nose_fit import NoseModel, NoseTouches, fit_nose_model, nose_touches
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.options import Options
from trueloop.turned.readings.vectors import nominal_words
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, in_order, no_reference
from trueloop.units import UM_PER_MM
from trueloop.wording import wording


@dataclass(frozen=True)
class ReadFiles:
    """The inputs that a job names, for any of its tools: program, profile, measurements, in the frame of a set-up."""

    program: Program
    profile: Profile
    measured: "Measured"
    finish_touches: ErrorVectors | None
    machine: PartOnMachine | None


@dataclass(frozen=True)
class Measured:
    """Measured values: as reported, as error vectors, and the characteristics that are judged by them; notes."""

    inspections: tuple[Inspection, ...]
    vectors: ErrorVectors
    characteristics: tuple[Characteristic, ...]
    notes: tuple[str, ...]


def inputs_of(files: JobFiles, read: ReadFiles) -> Inputs:
    """Collects the inputs of a job of one tool, or of one tool of a job that has several (`files.with_tool`)."""
    job, sources, tool, measured = files.job, files.sources, files.tool, read.measured
    nose = _nose(files, tool.nose_from if isinstance(tool, ToolsTable) else job.compensation.nose_from)
    table = files.tool_table(tool.table) if tool.table is not None else None
    inputs = Inputs(
        part=part_type(job),
        profile=read.profile,
        nose_radius_mm=files.nose_radius_mm,
        program=read.program,
        touches=measured.vectors,
        options=_options(job, tool),
        made_at=datetime.now(UTC),
        made_by=files.made_by,
        semifinish=files.program(job.own_programs.semifinish) if job.own_programs.semifinish else None,
        allowance_mm=job.own_programs.semifinish_allowance_mm or 0.0,
        parameters=job.own_programs.parameters,
        execute_deleted_blocks=job.own_programs.execute_deleted_blocks,
        lines=files.run.lines,
        inspections=measured.inspections,
        program_sha256=job.gauging.program_sha256,
        finish_touches=read.finish_touches,
        nose=nose,
        machine=read.machine,
        machine_tool=machine_of_job(job),
        edge=edge_of_job(tool),
        edge_set_at=tool.set_at,
        held=held_tool(tool.table_name, tool.table_edge or 0, tool.number, table),
        file=str(files.path),
        characteristics=measured.characteristics,
        measured_allowance_mm=options_from(Gauging, job).allowance_mm,
        notes=(*fit_notes(job.part, read.profile), *measured.notes, *files.called_notes),
        memory=options_from(MemoryOptions, job),
    )
    inputs = with_cut(files, inputs)
    return replace(inputs, inputs_sha256=sources.sha256)


def read_measured(files: JobFiles, profile: Profile, machine: PartOnMachine | None = None) -> Measured:
    """Touches and readings of a job's part. Raises TCH, MSR and TOL errors."""
    job = files.job
    touched = [files.sources.file(name) for name in job.gauging.touches_files]
    inspections = tuple(read_inspection(file, job, machine) for file in touched)
    readings = read_readings(job, files.sources, profile)
    touches = [touch for inspection in inspections for touch in inspection.touches]
    if readings.touches or len(touched) > 1:
        touches = in_order(profile, [*touches, *readings.touches])
    vectors = None
    if touches or touched:
        vectors = part_errors(touches, str(touched[0]) if touched else readings.file, job, profile)
        vectors = replace(vectors, by_cmm=tuple(touch.point for touch in readings.touches))
    elif (reference := options_from(Gauging, job).z_reference) is not None:
        with files.located.at("gauging", "z_reference"):
            raise no_reference(reference, 0)
    joint, notes = readings.joined(profile, vectors)
    notes = (*notes, *nominal_words(joint))
    asked = characteristics_of(files.located, profile)
    characteristics, more = joined(asked, readings.asked, profile, readings.names, readings.matched)
    return Measured((*inspections, *readings.inspections), joint, characteristics, (*notes, *more))


def machine_of_job(job: Job) -> Machine | None:
    """Returns the machine, as far as the job states it."""
    name, serial = job.own_programs.machine, job.own_programs.machine_serial
    return Machine(name, serial) if name or serial else None


def edge_of_job(table: TableOfTool) -> Edge | None:
    """Returns the finishing tool's edge, as far as the job states it."""
    stated = table.name or table.insert or table.corner or table.set_at
    return Edge(Tool(table.number, table.name), table.insert, table.corner) if stated else None


def _nose(files: JobFiles, nose_from: Sequence[Path]) -> NoseModel | None:
    """The nose as the jobs of other parts know it that were cut with the same edge."""
    parts = [touches for other in map(files.other, nose_from) for touches in _of_nose(files.tool, other)]
    return fit_nose_model(parts) if parts else None


def _of_nose(tool: TableOfTool, other: JobFiles) -> Iterator[NoseTouches]:
    """Yields another job's touches of what that edge cut, by set-up. Raises NC-NO-TOOL where it lists others only."""
    job = other.job
    if not job.gauging.touches_files:
        raise Code.TCH_FILE.refusal(
            f"{other.path.name!r} has 0 touches: a nose model needs touches of a probe along an arc",
            hint="leave it out of `compensation.nose_from`",
            place=Place(str(other.path)),
        )
    touched = [other.sources.file(name) for name in job.gauging.touches_files]
    if job.tool is not None:
        if job.part.from_program:
            other.require_uncorrected()
        profile = other.profile()
        yield nose_touches(job.part.name, profile, read_part_errors(touched, job, profile))
        return
    read = read_setups(other)
    read.found.require_plain()
    vectors, found = read_part_errors(touched, job, read.profile), False
    for of, one in zip(read.found.setups, read.files, strict=True):
        calls = [table.called for table in one.job.tools if _same_edge(tool, table)]
        placed = vectors_in(of.setup.frame, vectors, read.profile)
        for own in of.contours:
            if own is not None and own.edge.called in calls:
                found = True
                name = f"{job.part.name} {of.setup.frame.name}".strip()
                yield nose_touches(name, own.profile, vectors_of_edge(placed, own, of.profile))
    if not found:
        raise Code.NC_NO_TOOL.refusal(
            f"none of the edges of {other.path.name!r} is {tool.name or f'T{tool.number}'!r}",
            hint="state the same `name`, `insert` and `corner` in the tables [tool] or [[tools]] of both jobs, or the "
            "same `number`; or leave it out of `compensation.nose_from`",
            place=Place(str(other.path)),
            values={"tool": tool.name or f"T{tool.number}"},
        )


def _same_edge(table: TableOfTool, other: ToolsTable) -> bool:
    """Returns True for two tables of one edge: by the name in both, else by the number of its offset."""
    if table.name and other.name:
        return (table.name, table.insert, table.corner) == (other.name, other.insert, other.corner)
    return (table.number, table.table_edge or 1) == (other.number, other.table_edge or 1)


def _options(job: Job, tool: TableOfTool) -> Options:
    given = job.compensation
    return options_from(
        Options,
        job,
        knot_every_on={name: fit.knot_every for name, fit in given.features.items() if fit.knot_every is not None},
        prescribed={name: ends for name, fit in given.features.items() if (ends := _ends(fit)).count},
        between_cuts=_between_cuts(given),
        limits=options_from(Limits, job),
        offset_is_diameter=None if job.own_programs.offset_x_is is None else job.own_programs.offset_x_is == "diameter",
        tool=tool.number,
        tip=tool.tip,
    )


def _between_cuts(compensation: CompensationTable) -> BetweenCuts:
    """Returns the job's statement of how cuts differ; the prior where the job has none."""
    common_um, along_um = compensation.cut_to_cut_um, compensation.cut_to_cut_along_um
    if common_um is None and along_um is None:
        return PRIOR
    source = wording("stated in the job") if common_um or along_um else NONE.source
    return BetweenCuts((common_um or 0.0) / UM_PER_MM, (along_um or 0.0) / UM_PER_MM, source)


def _ends(fit: FeatureFitTable) -> EndConditions:
    given = (fit.start_um, fit.start_slope_um_per_mm, fit.end_um, fit.end_slope_um_per_mm)
    return EndConditions(*(None if number is None else number / UM_PER_MM for number in given))


def decided_of(files: JobFiles, profile: Profile) -> Mapping[str, CalledOffset | None]:
    """Returns by feature the edge that the job names, None: left alone. Raises JOB-KEY for an unknown feature."""
    for name in files.job.feature:
        if name not in profile.names:
            with files.located.at("feature", name):
                raise Code.JOB_KEY.refusal(
                    f"'feature.{name}' is not one of the {len(profile.names)} features of the part",
                    hint=f"the part's features are: {', '.join(profile.names)}",
                    values={"key": f"feature.{name}"},
                )
    return {name: cut.called for name, cut in files.job.feature.items() if cut.tool is not None}


@dataclass(frozen=True)
class ReadSetups:
    """A part, its `profile`, and what each set-up cuts of it; `files`: the job by set-up as if its only one."""

    profile: Profile
    found: InSetups
    files: tuple[JobFiles, ...]


def read_setups(files: JobFiles) -> ReadSetups:
    """Reads every set-up of a job with what it cuts, without its touches. Raises JOB, GEO, NC and SET errors."""
    frames = files.frames or (PART,)
    of_setups = files.of_setups
    programs = [setup.finish_program() for setup in of_setups]
    profile = files.profile(programs[0])
    decided_of(files, profile)
    setups = [
        Setup(
            frame=frame,
            program=program,
            run=one.run,
            edges=one.edges,
            decided=decided_of(one, profile),
            nose_radius_mm=None if one.edges else one.nose_radius_mm,
        )
        for frame, one, program in zip(frames, of_setups, programs, strict=True)
    ]
    given = files.job.feature
    decided = {
        name: None if cut.left_alone else cut.setup for name, cut in given.items() if cut.setup or cut.left_alone
    }
    return ReadSetups(profile, in_setups(profile, setups, decided), of_setups)
