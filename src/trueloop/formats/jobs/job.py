"""The job file (TOML): one turned part, its tool, its programs, its touches, and how to compensate.

Lengths carry their unit in the key, or, for the profile's coordinates, in `part.unit`. Paths are relative to the job
file. Unknown keys are refused: a mistyped option must not be an option ignored.
"""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from trueloop.errors import Code
from trueloop.formats.toml_tables import Count, Finite, Moment, NotNegative, Positive, Share, T, Table, read_tables

Point = tuple[Finite, Finite]


class FeatureTable(Table):
    """One line or arc, from where the feature before it ended to `to` = [x, z]."""

    name: str
    to: Point
    centre: Point | None = None
    radius: Positive | None = None
    turn: Literal["convex", "concave"] = "convex"
    more_than_half: bool = False

    @model_validator(mode="after")
    def _one_arc_form(self) -> "FeatureTable":
        if self.centre is not None and self.radius is not None:
            raise ValueError("an arc has a centre or a radius, not both")
        return self


class PartTable(Table):
    """The nominal profile: given here, or read from a DXF drawing or a solid, or taken from the finish program."""

    name: str
    unit: Literal["mm", "inch"] = "mm"
    x_is: Literal["radius", "diameter"] = "radius"
    start: Point | None = None
    feature: tuple[FeatureTable, ...] = ()
    dxf: Path | None = None
    dxf_layer: str | None = None
    dxf_outline: Count | None = None
    step: Path | None = None
    step_turned_round: bool = False
    step_from_z_mm: Finite | None = None
    step_to_z_mm: Finite | None = None
    from_program: bool = False
    junctions: dict[str, Literal["corner", "tangent"]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _one_source(self) -> "PartTable":
        sources = [bool(self.feature), self.dxf is not None, self.step is not None, self.from_program]
        if sum(sources) != 1:
            raise ValueError("the profile comes from exactly one of `feature`, `dxf`, `step` and `from_program`")
        if self.feature and self.start is None:
            raise ValueError("`start` = [x, z] of the first feature is missing")
        return self


class ToolTable(Table):
    """The finishing tool."""

    nose_radius_mm: NotNegative | None = None
    nose_radius_in: NotNegative | None = None
    number: Annotated[int, Field(ge=0, le=1_000_000, strict=True)] | None = None

    @model_validator(mode="after")
    def _one_unit(self) -> "ToolTable":
        if (self.nose_radius_mm is None) == (self.nose_radius_in is None):
            raise ValueError("give the nose radius once: `nose_radius_mm` or `nose_radius_in`")
        return self


class ProgramsTable(Table):
    """The finish program, and the semi-finish program that the measured surface was cut with."""

    dialect: str
    finish: Path
    finish_lines: tuple[Count, Count] | None = None
    semifinish: Path | None = None
    semifinish_allowance_mm: NotNegative | None = None
    parameters: dict[str, Finite] = Field(default_factory=dict)
    unit: Literal["mm", "inch"] | None = None
    decimals: Annotated[int, Field(ge=0, le=9, strict=True)] = 0
    offset_x_is: Literal["radius", "diameter"] | None = None
    execute_deleted_blocks: bool = False
    accept_unknown_words: bool = False


class GaugingTable(Table):
    """The touches and how well the probe repeats ([6811 §4.1]: ranges of 1.5 µm on diameters, 0.5 µm on faces)."""

    touches: Path
    probe: Path | None = None
    points: dict[str, Count] = Field(default_factory=dict)
    spacing_mm: Positive | None = None
    ball_radius_mm: NotNegative = 0.0
    repeatability_diameter_um: NotNegative = 1.5
    repeatability_face_um: NotNegative = 0.5
    z_reference: str | None = None
    measured_allowance_mm: Finite = 0.0
    measured_at: Moment | None = None
    program_sha256: str | None = None
    finish_touches: Path | None = None


class FeatureFitTable(Table):
    """What one feature's error curve is held to: its knots, and error and slope of error at its ends."""

    knot_every: Count | None = None
    start_um: Finite | None = None
    start_slope_um_per_mm: Finite | None = None
    end_um: Finite | None = None
    end_slope_um_per_mm: Finite | None = None


class CompensationTable(Table):
    """How much of the error to take out, how, and what to refuse."""

    weight: Share = 1.0
    by: Literal["auto", "contour", "offset"] = "auto"
    junctions: Literal["part", "path"] = "part"
    knot_every: Count | None = None
    features: dict[str, FeatureFitTable] = Field(default_factory=dict)
    nose_from: tuple[Path, ...] = ()
    bad_touches: Literal["leave-out", "keep"] = "leave-out"
    chord_tolerance_um: Positive = 0.5
    arcs: Literal["auto", "lines", "arcs"] = "auto"
    errors_follow: Literal["place", "nose"] = "place"
    max_correction_um: Positive = 150.0
    max_slope_um_per_mm: Positive = 40.0
    max_scatter_um: Positive = 10.0
    max_age_hours: Positive = 24.0
    cut_to_cut_um: NotNegative | None = None
    cut_to_cut_along_um: NotNegative | None = None
    repeatability_um: NotNegative | None = None


Vector = tuple[Finite, Finite, Finite]
Signals = dict[str, Finite] | Path
"""Values of a model's signals, or the log whose last row is meant."""


class MachineTable(Table):
    """The machine's own errors, to be corrected together with the process's: where the part stands, how warm it is."""

    model: Path
    serial: str | None = None
    work_zero_mm: Vector
    tool_mm: Vector
    cutting: Signals = Field(default_factory=dict)
    semifinish_cut: Literal["uncompensated", "compensated"]
    semifinish: Signals | None = None
    touched_on: Literal["machine", "cmm"]
    probing: Signals | None = None
    probe_mm: Vector | None = None
    probe_ball_radius_mm: NotNegative | None = None
    extrapolate: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _probe_given(self) -> "MachineTable":
        if self.touched_on == "machine" and (self.probing is None or self.probe_mm is None):
            raise ValueError("touches taken on the machine need `probing` (temperatures) and `probe_mm`")
        return self


class OutputTable(Table):
    """Where the results go."""

    folder: Path = Path("out")


class Job(Table):
    """A whole job file."""

    part: PartTable
    tool: ToolTable
    programs: ProgramsTable
    gauging: GaugingTable
    compensation: CompensationTable = CompensationTable()
    machine: MachineTable | None = None
    output: OutputTable = OutputTable()

    @model_validator(mode="after")
    def _contour_for_the_machine(self) -> "Job":
        if self.machine is not None and self.compensation.by == "offset":
            raise ValueError("no tool offset can carry the machine's error: `compensation.by` is to be another")
        return self


def read_job(path: Path) -> Job:
    """Reads a job file; raises JOB errors that name the table, the key and the line."""
    hint = "docs/job-file.md lists every table and key with its unit and default; `trueloop demo` runs a ready job"
    return read_job_file(path, Job, hint)


def read_job_file(path: Path, kind: type[T], hint: str) -> T:
    """Reads a job file of some kind; `hint` says what such a file holds."""
    return read_tables(path, kind, Code.JOB_KEY, hint=hint, missing=Code.JOB_MISSING, syntax=Code.JOB_SYNTAX)
