"""The job file (TOML): one turned part, its tool, its programs, its touches, and how to compensate.

The tables of a job that state what was measured, and how its error is taken out.

Lengths carry their unit in the key, or, for the profile's coordinates, in `part.unit`. Paths are relative to the job
file. Unknown keys are refused: a mistyped option must not be an option ignored.
"""

from operator import attrgetter
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from trueloop.domain.option import Limits, PageOptions
from trueloop.errors import Code
from trueloop.formats.jobs.part_tables import PartTable
from trueloop.formats.jobs.tool_tables import (
    CutByTable,
    ProgramsTable,
    SetupTable,
    ToolsTable,
    ToolTable,
    require_apart,
)
from trueloop.formats.toml_tables import (
    Count,
    Finite,
    In,
    Located,
    Moment,
    NotNegative,
    Positive,
    T,
    Table,
    Vector,
    options_from,
    read_located,
    with_options,
)
from trueloop.memory.edge.learnt import IN_FULL
from trueloop.turned.options import Options
from trueloop.turned.touches.touches import Gauging


@with_options("gauging", Gauging)
class GaugingTable(Table):
    """The measurements: touches of a probe, readings of gauges or measuring machines, or both.

    Ranges of repeated probing are those of [6811 §4.1]: 1.5 µm on diameters, 0.5 µm on faces.
    """

    touches: tuple[Path, ...] | Path | None = None
    """CSV of the touches after the semi-finish cut: `point`, `feature`, nominal and measured point or error, the unit
    in each column's name; also `note`, which is not read, and no others. Several files, as of a part that is probed in
    each of its set-ups, count as one. Left out, the job has `readings`.
    """
    readings: tuple[Path, ...] | Path = ()
    """One or several inspection files, in any format of [measurements.md](measurements.md): diameters, radii, lengths
    and angles of features, and points of a measuring machine, which are taken as touches. Of several parts in a file,
    `part.serial` chooses one. Characteristics that a file asks for are judged beside the job's.
    """
    readings_unit: Literal["mm", "inch"] | None = None
    """Unit of lengths in files of readings that do not state it: `"mm"` or `"inch"`."""
    readings_mapping: Path | None = None
    """TOML file that states what the columns, variables and names of files of readings mean
    ([measurements.md](measurements.md#tables-by-mapping)); `trueloop measure map` proposes one.
    """
    after_record: Path | None = None
    """Record (`record.json`) of the last correction of this process: measurements from before it are refused. A
    finished part is taken as cut with it, unless `programs.cut_with` states otherwise.
    """
    probe: Path | None = None
    """The probe's file (`docs/probing.md`): needed to plan touches, to write probing programs and to read their logs.
    """
    points: dict[str, Count] = Field(default_factory=dict)
    """How many points a feature gets when touches are planned, `{ dome = 20, "main-face" = 1 }`; left out with
    `spacing_mm`, the points of `touches` are taken.
    """
    spacing_mm: Positive | None = None
    """Every feature not named in `points` gets points at most this far apart."""
    measured_at: Moment | None = None
    """Date and time of the touches; from it their age is judged."""
    device: str = ""
    """The device that measured: probe, gauge or measuring machine, with its number. For the report and the record."""
    operator: str = ""
    """Who measured. For the report and the record."""
    program_sha256: str | None = None
    """SHA-256 of the finish program that the touches belong to: another program is refused."""
    finish_touches: Path | None = None
    """CSV of touches after an earlier corrected cut, to find a correction of reversed sign."""

    @property
    def touches_files(self) -> tuple[Path, ...]:
        """Those of `touches`, one or several."""
        return (self.touches,) if isinstance(self.touches, Path) else self.touches or ()

    @property
    def readings_files(self) -> tuple[Path, ...]:
        """Those of `readings`, one or several."""
        return (self.readings,) if isinstance(self.readings, Path) else self.readings

    @model_validator(mode="after")
    def _something_measured(self) -> "GaugingTable":
        if not self.touches_files and not self.readings_files:
            raise ValueError("`touches` or `readings` is missing: at least one of them is to be given")
        return self


class FeatureFitTable(Table):
    """Conditions on one feature's error curve: its knots, and error and slope of error at its ends."""

    knot_every: Annotated[Count | None, In("points")] = None
    """`knot_every` on this arc alone."""
    start_um: Finite | None = None
    """The error at the feature's start."""
    start_slope_um_per_mm: Finite | None = None
    """The slope of the error there, along the profile."""
    end_um: Finite | None = None
    """The error at the feature's end."""
    end_slope_um_per_mm: Finite | None = None
    """The slope of the error there."""


@with_options("compensation", Options, Limits)
class CompensationTable(Table):
    """How much of the error to take out, how, and what to refuse."""

    features: dict[str, FeatureFitTable] = Field(default_factory=dict)
    """Tables `[compensation.features.NAME]`, one a feature: see below."""
    nose_from: tuple[Path, ...] = ()
    """Job files of other parts cut with the same edge: their touches give the nose model, which serves an arc where
    leave-one-out prefers it.
    """
    cut_to_cut_um: NotNegative | None = None
    """Standard deviation of what moves a whole cut, along x and z each, but not from place to place of it (heat, the
    turret indexed for the probe, the edge): one part's touches cannot show it. The semi-finish and the finish cut both
    bring it. Left out together with the next key: 2 µm and 1.5 µm, a prior for turning in general that
    `src/trueloop/turned/fit/between_cuts.py` derives. `0` switches it off. Widens the predicted ±U (√2 times it, root
    of squares) and changes no correction.
    """
    cut_to_cut_along_um: NotNegative | None = None
    """As `cut_to_cut_um`, for the variation along the cut, over more than the distance of touches. Where one of the two
    is given, the other is 0 unless given too.
    """


Signals = dict[str, Finite] | Path
"""Values of a model's signals, or the log whose last row is meant."""


class MachineTable(Table):
    """The machine's own errors, to be corrected together with the process's: where the part stands, how warm it is."""

    model: Path
    """The model, as `trueloop machine fit` wrote it."""
    serial: str | None = None
    """Refuse a model of a machine with another serial number."""
    work_zero_mm: Vector | None = None
    """Machine coordinates of the program's zero, for a tool of no length, with all that is in force in the finish pass:
    work offset, G52, G92, TRANS. With set-ups it is stated in each of them.
    """
    tool_mm: Vector | None = None
    """The programmed point of the tool from the frame of the last axis, as `--tool`. Semi-finish and finish cut are
    made with this tool. With several tools it is stated in the table of each.
    """
    cutting: Signals = Field(default_factory=dict)
    """Signals of the model during the finish cut, `{ T1 = 24.0 }`, or the CSV log whose last row is meant."""
    semifinish_cut: Literal["uncompensated", "compensated"]
    """`"uncompensated"`: the touched surface carries the machine's error (its program is `programs.semifinish`, or as
    the finish program); `"compensated"`: the control took the error out, or a program that the job does not name. A
    `programs.semifinish` with trueloop's mark is followed word by word either way.
    """
    semifinish: Signals | None = None
    """Signals during the semi-finish cut; left out, those of `cutting`."""
    touched_on: Literal["machine", "cmm"]
    """`"machine"`: the control reported `gauging.touches`, which carry its error while probing; `"cmm"`: they are taken
    as they are, as `gauging.readings` are in any case.
    """
    probing: Signals | None = None
    """Signals while probing; required with touches taken on the machine."""
    probe_mm: Vector | None = None
    """The ball's centre from the frame of the last axis; required with touches taken on the machine."""
    probe_ball_radius_mm: NotNegative | None = None
    """Radius of the ball: where its centre was in the machine; left out, `gauging.ball_radius_mm`."""
    extrapolate: tuple[str, ...] = ()
    """Axes and signals that may leave the range of the model's data, `["T1"]`."""

    @model_validator(mode="after")
    def _probe_given(self) -> "MachineTable":
        if self.touched_on == "machine" and (self.probing is None or self.probe_mm is None):
            raise ValueError("touches taken on the machine need `probing` (temperatures) and `probe_mm`")
        return self


class OutputTable(Table):
    """Where the results go."""

    folder: Path = Path("out")
    """Where the results go."""


@with_options("report", PageOptions)
class ReportTable(Table):
    """How the page of the results is shown."""


class StoreTable(Table):
    """The store that keeps parts, inspections and corrections."""

    db: str = ""
    """Its file, from the job's folder, or its URL (`postgresql://…`); left out, `trueloop.db` beside the job, which is
    made. `--db` takes its place; `--no-store`: no store.
    """


class ProgramTable(Table):
    """How the program that a job names is read."""

    dialect: str | None = None
    """One of those in [dialects.md](dialects.md); left out, it is found from the program."""
    unit: Literal["mm", "inch"] | None = None
    """`"mm"` or `"inch"`: the unit in force at the program's start, where it does not state it; see
    [cli.md](cli.md#the-unit-of-a-program).
    """
    parameters: Annotated[dict[str, Finite], In("program's")] = Field(default_factory=dict)
    """Values of the program's parameters and of the machine's that it depends on, `{ "3402#0" = 0 }`."""
    accept_unknown_words: bool = False
    """Go on although the program holds words or codes that the dialect does not know: taken to move nothing."""


@with_options("memory", IN_FULL)
class MemoryTable(Table):
    """How earlier parts of the finishing tool's edge take part, where there is a store and the edge is stated."""


class Job(Table):
    """A whole job file."""

    part: PartTable
    tool: ToolTable | None = None
    tools: tuple[ToolsTable, ...] = ()
    feature: dict[str, CutByTable] = Field(default_factory=dict)
    programs: ProgramsTable | None = None
    setups: tuple[SetupTable, ...] = ()
    gauging: GaugingTable
    compensation: CompensationTable = CompensationTable()
    machine: MachineTable | None = None
    output: OutputTable = OutputTable()
    report: ReportTable = ReportTable()
    store: StoreTable = StoreTable()
    memory: MemoryTable = MemoryTable()

    @property
    def own_programs(self) -> ProgramsTable:
        """The table [programs]. Raises JOB-SETUPS where every set-up has its own."""
        self.require_one_setup()
        assert self.programs is not None
        return self.programs

    @property
    def every_programs(self) -> tuple[ProgramsTable, ...]:
        """The tables of programs, one a set-up."""
        return tuple(setup.programs for setup in self.setups) if self.programs is None else (self.programs,)

    def require_one_setup(self) -> None:
        """Raises JOB-SETUPS where the job has several set-ups."""
        if self.setups:
            names = [setup.name for setup in self.setups]
            raise Code.JOB_SETUPS.refusal(
                f"the job has {len(names)} set-ups ({', '.join(names)}): this is done for one alone",
                hint="`trueloop compensate` (in Python `compensate_part`), `measure read`, `series propose`, "
                "`probe program`, `probe read`, `nc features` and `part show` take set-ups",
                values={"setups": names},
            )

    @model_validator(mode="after")
    def _one_setup_or_several(self) -> "Job":
        if not self.setups:
            if self.programs is None:
                raise ValueError("a job has a table [programs], or a table [[setups]] for each of several set-ups")
            if any(cut.setup is not None for cut in self.feature.values()):
                raise ValueError("`setup` of a table [feature.NAME] is not one of [[setups]]: there are none")
            return self
        if self.programs is not None or self.tool is not None or self.tools:
            raise ValueError("with [[setups]] programs and tools are those of each set-up: [setups.programs], "
                             "[[setups.tools]]")  # fmt: skip
        names = [setup.name for setup in self.setups]
        if len({name.lower() for name in names}) < len(names):
            raise ValueError("two tables [[setups]] have the same `name`")
        for feature, cut in self.feature.items():
            self._require_known(feature, cut)
        if self.gauging.program_sha256 is not None:
            raise ValueError("`gauging.program_sha256` is of one program: give `program_sha256` of a table [[setups]]")
        return self

    def _require_known(self, feature: str, cut: CutByTable) -> None:
        """Checks that the decision for a feature is a set-up, and a tool of it."""
        meant = [setup for setup in self.setups if cut.setup in (None, setup.name)]
        if not meant:
            raise ValueError(f"`feature.{feature}.setup` is not one of [[setups]]")
        if cut.called is not None and all(cut.called != tool.called for table in meant for tool in table.tools):
            raise ValueError(f"`feature.{feature}.tool` is not one of [[setups.tools]]")

    @model_validator(mode="after")
    def _one_tool_or_several(self) -> "Job":
        several = bool(self.tools or self.setups)
        if (self.tool is None) != several:
            raise ValueError("a job has a table [tool], or a table [[tools]] for each of several edges")
        require_apart(self.tools)
        calls = [None, *(tool.called for tool in self.tools)]
        strange = [name for name, cut in self.feature.items() if not self.setups and cut.called not in calls]
        if strange:
            raise ValueError(f"`feature.{strange[0]}.tool` is not one of [[tools]]")
        if several and self.compensation.nose_from:
            raise ValueError("`compensation.nose_from` is of one edge: give `nose_from` of a table [[tools]]")
        if several and self.part.from_program:
            raise ValueError("with several tools the profile is drawn or spelt out")
        return self

    @model_validator(mode="after")
    def _placed_in_the_machine(self) -> "Job":
        """Every tool and every program's zero is placed in the machine once."""
        given = self.machine
        if given is None:
            return self
        tools = [*self.tools, *(tool for setup in self.setups for tool in setup.tools)]
        stated = [given.tool_mm] if self.tool is not None else [tool.tool_mm for tool in tools]
        zeros = [setup.work_zero_mm for setup in self.setups] or [given.work_zero_mm]
        if None in stated or (tools and given.tool_mm is not None):
            where = "each table of tools" if tools else "the table [machine]"
            raise ValueError(f"with [machine] `tool_mm` is stated in {where}, and nowhere else")
        if None in zeros or (self.setups and given.work_zero_mm is not None):
            where = "each table [[setups]]" if self.setups else "the table [machine]"
            raise ValueError(f"with [machine] `work_zero_mm` is stated in {where}, and nowhere else")
        if any(setup.mirrored_z for setup in self.setups):
            raise ValueError("with [machine] no set-up has `mirrored_z`: which way the machine's Z runs is not known")
        probed = given.touched_on == "machine"
        if self.setups and probed and options_from(Gauging, self).z_reference is not None:
            raise ValueError(
                "touches that the machine's probe took in several set-ups count from the zero of each: leave out "
                "`gauging.z_reference`"
            )
        return self

    @model_validator(mode="after")
    def _contour_for_the_machine(self) -> "Job":
        if self.machine is not None and attrgetter("by")(self.compensation) == "offset":
            raise ValueError("no tool offset can carry the machine's error: `compensation.by` is to be another")
        return self

    @model_validator(mode="after")
    def _touched_on_the_machine(self) -> "Job":
        if self.machine is not None and self.machine.touched_on == "machine" and not self.gauging.touches_files:
            raise ValueError(
                '`machine.touched_on = "machine"` is of `gauging.touches`, and there are none: readings are taken off '
                'the machine, "cmm"'
            )
        return self

    @model_validator(mode="after")
    def _machine_once(self) -> "Job":
        stated = any(program.machine or program.machine_serial for program in self.every_programs)
        if self.machine is not None and stated:
            raise ValueError("leave `programs.machine` and `programs.machine_serial` out: `machine.model` states them")
        return self


def read_turned_job(path: Path) -> Job:
    """The job alone of `locate_turned_job`."""
    return locate_turned_job(path).model


def locate_turned_job(path: Path) -> Located[Job]:
    """Reads a job file; raises JOB errors that name the table, the key and the line."""
    hint = "docs/job-file.md lists every table and key with its unit and default; `trueloop demo` runs a ready job"
    return locate_job_file(path, Job, hint)


def read_job_file(path: Path, kind: type[T], hint: str) -> T:
    """Reads a job file of some kind; `hint` says what such a file holds."""
    return locate_job_file(path, kind, hint).model


def locate_job_file(path: Path, kind: type[T], hint: str) -> Located[T]:
    """Reads a job file with the line of each key."""
    return read_located(path, kind, Code.JOB_KEY, hint=hint, missing=Code.JOB_MISSING, syntax=Code.JOB_SYNTAX)
