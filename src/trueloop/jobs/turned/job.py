"""A turned part's job and the files it names, read into the values that the loop works on: set-ups, their edges, and
what was measured, each in the frame of its program. A job of one tool has one set-up with one edge.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.domain.option import PageOptions
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, in_file
from trueloop.formats.input_file import FilePath
from trueloop.formats.jobs.job import MachineTable
from trueloop.formats.jobs.profile_of_job import fit_notes
from trueloop.formats.jobs.tool_tables import ToolsTable
from trueloop.formats.measurements.history_csv import read_history
from trueloop.formats.tables.model_file import read_model
from trueloop.formats.tables.tool_tables.tool_table import ToolTable
from trueloop.formats.toml_tables import options_from
from trueloop.geometry.offset import CentrePath, nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.jobs.turned.inputs import Measured, ReadFiles, ReadSetups, inputs_of, read_measured, read_setups
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.readings import Sources, read_part_errors
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.cuts import OfSetup
from trueloop.loops.turned.part import SetupCuts, with_zero
from trueloop.loops.turned.part_on_machine import PartOnMachine
from trueloop.loops.turned.share import characteristics_in, ends_in, vectors_in
from trueloop.machine.model.history import check_lags_given, signals_at_end
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import Signals
from trueloop.machine.model.validity import require_serial
from trueloop.nc.match.cutters import CuttingEdge
from trueloop.turned.readings.vectors import own_seen, shared_words, z_zero
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging
from trueloop.wording import all_of, wording


@dataclass(frozen=True)
class ReadJob:
    """A job as values, the files it was read from, and the folder for what comes of it.

    `tool_table` is the control's, where the job names it; `page` says how the report is shown; `store_db` is the store
    that the job names, "" where it names none.
    """

    inputs: Inputs
    files: tuple[Path, ...]
    output_folder: Path
    tool_table: ToolTable | None = None
    page: PageOptions = field(default_factory=PageOptions)
    store_db: str = ""


@dataclass(frozen=True)
class ReadPart:
    """A job's nominal profile and tool, and their files; `edges` and `setups` of a job that has several."""

    name: str
    profile: Profile
    noses_mm: tuple[float, ...]
    files: tuple[Path, ...]
    edges: tuple[CuttingEdge, ...] = ()
    setups: tuple[SetupFrame, ...] = ()

    @property
    def nose_radius_mm(self) -> float:
        """Returns the radius of the one tool; of several the smallest: the nose that has to fit everywhere."""
        return min(self.noses_mm)

    @property
    def centre_path(self) -> CentrePath:
        """Returns the path of the nose centre along the profile. Raises GEO errors where the nose does not fit."""
        return nose_centre_path(self.profile, self.nose_radius_mm)


def read_part(path: FilePath) -> ReadPart:
    """The part of a job alone: its touches need not exist yet. Raises JOB, NC and GEO errors.

    >>> part = trueloop.read_part(trueloop.example("modbas2/job.toml"))
    >>> [(feature.name, round(feature.length_mm, 3)) for feature in part.profile.features][-2:]
    [('small-cylinder', 7.62), ('dome', 58.251)]
    """
    files = JobFiles.of(Path(path))
    edges = files.edges or tuple(edge for setup in files.job.setups for edge in files.with_setup(setup).edges)
    noses_mm = tuple(edge.nose_radius_mm for edge in edges) or (files.nose_radius_mm,)
    return ReadPart(
        name=files.job.part.name,
        profile=files.profile(),
        noses_mm=noses_mm,
        files=files.sources.files,
        edges=edges,
        setups=files.frames,
    )


def read_job(path: FilePath, *, serial: str | None = None) -> ReadJob:
    """Everything a job names; `serial` takes the place of its part's serial number.

    Raises JOB, NC, GEO, TCH and MSR errors with the file they stand in.

    CMP-TWICE before anything else of the finish program: a profile taken from a corrected one would be no nominal.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> job.inputs.part.name, len(job.inputs.touches.error_mm)
    ('MODBAS2, 3.52 in', 32)
    >>> job.inputs.profile.names[-1], job.inputs.nose_radius_mm
    ('dome', 0.79375)
    """
    files = JobFiles.of(Path(path)).with_serial(serial)
    tool, job = files.tool, files.job
    ((_, inputs),) = read_cuts(files).setups[0].cuts
    table = files.tool_table(tool.table) if tool.table is not None else None
    return ReadJob(
        inputs=inputs,
        files=files.sources.files,
        output_folder=files.output_folder,
        tool_table=table,
        page=files.page_options(),
        store_db=job.store.db,
    )


@dataclass(frozen=True)
class ReadCuts:
    """A part with what was measured of it, whole and by set-up; `notes` on what is of no set-up alone."""

    read: ReadSetups
    measured: Measured
    setups: tuple[SetupCuts, ...]
    notes: tuple[str, ...]


def read_cuts(files: JobFiles, unmeasured: Measured | None = None) -> ReadCuts:
    """Reads a job whole; `unmeasured` stands in for missing touches and readings. Raises what reading raises."""
    for setup in files.of_setups:
        setup.require_uncorrected()
    read, job, sources = read_setups(files), files.job, files.sources
    read.found.require_plain()
    machine = None
    if job.machine is not None:
        ball_mm = options_from(Gauging, job).ball_radius_mm
        machine = read_part_on_machine(sources, files.path, job.machine, ball_mm)
    measured = read_measured(files, read.profile, machine) if unmeasured is None else unmeasured
    after = job.gauging.finish_touches if unmeasured is None else None
    finish = None if after is None else read_part_errors([sources.file(after)], job, read.profile)
    pairs = zip(read.found.setups, read.files, strict=True)
    if not job.setups:
        cuts = [_cuts(of, one, ReadFiles(of.setup.program, of.profile, measured, finish, machine)) for of, one in pairs]
        return ReadCuts(read, measured, with_zero(cuts), ())
    cuts = [_cuts(of, one, _in_setup(of, read.profile, measured, finish, machine)) for of, one in pairs]
    notes = (*fit_notes(job.part, read.profile), *measured.notes, *_of_none(measured, read))
    return ReadCuts(read, measured, with_zero(cuts), notes)


def _in_setup(
    of: OfSetup, profile: Profile, measured: Measured, finish: ErrorVectors | None, machine: PartOnMachine | None
) -> ReadFiles:
    """Inputs for the features of one set-up, in its frame; `profile` is the part's."""
    frame, own = of.setup.frame, {*of.features}
    vectors = vectors_in(frame, _of_features(measured.vectors, profile, own), profile)
    asked = [
        characteristic
        for characteristic in measured.characteristics
        if {characteristic.feature, characteristic.other} - {""} <= own
    ]
    mine = replace(measured, vectors=vectors, characteristics=characteristics_in(frame, asked))
    after = None if finish is None else vectors_in(frame, _of_features(finish, profile, own), profile)
    return ReadFiles(of.setup.program, of.profile, mine, after, machine)


def _cuts(of: OfSetup, files: JobFiles, read: ReadFiles) -> SetupCuts:
    tables = {tool.called: tool for tool in files.job.tools}
    with_tools = [(own, files if own is None else files.with_tool(tables[own.edge.called])) for own in of.contours]
    frame = of.setup.frame
    placed = [(own, one, replace(read, machine=_of_tool(one, read))) for own, one in with_tools]
    cuts = tuple((own, _placed(inputs_of(one, of_tool), frame)) for own, one, of_tool in placed)
    return SetupCuts(cuts, frame, of.features, of.calls if frame.name else frozenset())


def _of_tool(files: JobFiles, read: ReadFiles) -> PartOnMachine | None:
    """The machine with the zero of this set-up and with this tool, where the job states these in their tables."""
    machine, tool = read.machine, files.job.tool
    if machine is None or not isinstance(tool, ToolsTable):
        return machine
    assert tool.tool_mm is not None  # the job is refused without
    return replace(machine, tool_mm=tool.tool_mm, work_zero_mm=files.work_zero_mm or machine.work_zero_mm)


def _placed(inputs: Inputs, frame: SetupFrame) -> Inputs:
    """The inputs of an edge in the frame of its set-up, where the job has set-ups."""
    if not frame.name:
        return inputs
    where = wording(
        "Set-up {name}: positions are those of its program, {formula} of the part.",
        name=frame.name,
        formula=frame.words,
    )
    options = replace(inputs.options, prescribed=ends_in(frame, inputs.options.prescribed))
    return replace(inputs, setup=frame, options=options, notes=(where,))


def _of_features(vectors: ErrorVectors, profile: Profile, features: set[str]) -> ErrorVectors:
    """Those on some features, and what readings state of these alone."""
    rows = np.flatnonzero([profile.names[index] in features for index in vectors.feature_index.tolist()])
    own = [index for index, name in enumerate(profile.names) if name in features]
    return replace(vectors.chosen(rows), seen=own_seen(vectors, own))


def _of_none(measured: Measured, read: ReadSetups) -> list[str]:
    """Where z counts from, readings that are of no set-up alone, touches of what none cuts, in words.

    The part of the next cut stands on a face that another set-up cuts, which a correction of its own error moves.
    """
    owns = [set(setup.features) for setup in read.found.setups]
    touched = {read.profile.names[index] for index in measured.vectors.feature_index.tolist()}
    unused = [name for name in read.found.uncut if name in touched]
    found: list[str] = []
    if len(owns) > 1 and not len(z_zero(measured.vectors)):
        found.append(
            wording(
                "z counts from no face (`gauging.z_reference`): where a correction moves the face by which the part is "
                "set up again, all that is cut there moves with it."
            )
        )
    names = read.profile.names
    indices = [[index for index, name in enumerate(names) if name in own] for own in owns]
    found.extend(shared_words(measured.vectors, indices, names))
    if unused:
        found.append(wording("{features}: touched, which corrects nothing.", features=all_of(unused)))
    return found


NOWHERE: Final = (0.0, 0.0, 0.0)


def read_part_on_machine(sources: Sources, job: Path, machine: MachineTable, ball_radius_mm: float) -> PartOnMachine:
    """Reads the part on its machine. `ball_radius_mm` of the probe, where the table has none. Where several
    tools or set-ups cut it, what places these is stated in their own tables, and takes the place of zeros here.

    Raises MCH-FILE for anything that is not a model, MCH-MACHINE for a model of another machine, MCH-HISTORY and
    MCH-SIGNAL.
    """
    file = sources.file(machine.model)
    model = read_model(file)
    with in_file(file):
        require_serial(model, machine.serial)
    cutting = _signals(sources, job, model, machine.cutting)
    ball = ball_radius_mm if machine.probe_ball_radius_mm is None else machine.probe_ball_radius_mm
    return PartOnMachine(
        model=model,
        sha256=sha256_of(file.read_bytes()),
        work_zero_mm=machine.work_zero_mm or NOWHERE,
        tool_mm=machine.tool_mm or NOWHERE,
        probe_mm=machine.probe_mm or machine.tool_mm or NOWHERE,
        cutting=cutting,
        semifinish=cutting if machine.semifinish is None else _signals(sources, job, model, machine.semifinish),
        probing=cutting if machine.probing is None else _signals(sources, job, model, machine.probing),
        touched_on=machine.touched_on,
        semifinish_cut=machine.semifinish_cut,
        ball_radius_mm=ball,
        extrapolate=machine.extrapolate,
        file=str(job),
    )


def _signals(sources: Sources, job: Path, model: MachineModel, source: dict[str, float] | Path) -> Signals:
    if isinstance(source, Path):
        log = sources.file(source)
        with in_file(log):
            return signals_at_end(read_history(log), model.lags)
    with in_file(job):
        check_lags_given(model.lags, source)
        for name in model.needs():
            if name not in source:
                raise Code.MCH_SIGNAL.refusal(
                    f"the model needs the signal {name!r}; the job gives {len(source)}: {', '.join(source) or 'none'}",
                    hint=f"write it into the table [machine]: cutting = {{ {name} = 21.5 }}, in the unit of the data",
                    values={"signals": [name]},
                )
        return dict(source)
