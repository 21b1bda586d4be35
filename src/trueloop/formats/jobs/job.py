"""The job file (TOML): one turned part, its tool, its programs, its touches, and how to compensate.

Lengths carry their unit in the key, or, for the profile's coordinates, in `part.unit`. Paths are relative to the job
file. Unknown keys are refused: a mistyped option must not be an option ignored.
"""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from trueloop.domain.limits import Limits
from trueloop.domain.page_options import PageOptions
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.curve_tables import (
    AsphereTable,
    EllipseTable,
    Point,
    PointsTable,
    PolynomialTable,
    SplineTable,
)
from trueloop.formats.option_tables import options_from, with_options
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
    read_located,
)
from trueloop.memory.edge.options import IN_FULL
from trueloop.nc.match.cutting_edge import Corner
from trueloop.nc.program.called import Called
from trueloop.turned.options import Options
from trueloop.turned.touches.touches import Gauging


class FeatureTable(Table):
    """One line, arc or curve, from where the feature before it ended to `to` = [x, z]."""

    name: str
    """Its name, once in a profile: touches refer to it."""
    to: Annotated[Point, In("`unit`")]
    """`[x, z]` where it ends."""
    centre: Annotated[Point | None, In("`unit`")] = None
    """`[x, z]` of an arc's centre."""
    radius: Annotated[Positive | None, In("`unit`")] = None
    """An arc's radius, instead of its centre."""
    turn: Literal["convex", "concave"] = "convex"
    """`"convex"` (dome, edge radius: G02 towards the free end) or `"concave"` (fillet, groove)."""
    more_than_half: bool = False
    """With `radius`: the arc turns through more than 180°."""
    asphere: AsphereTable | None = None
    """An asphere: `[part.feature.asphere]` below. With this or one of the next four keys the feature is a curve."""
    ellipse: EllipseTable | None = None
    """An ellipse: `[part.feature.ellipse]` below."""
    polynomial: PolynomialTable | None = None
    """A polynomial: `[part.feature.polynomial]` below."""
    spline: SplineTable | None = None
    """A B-spline: `[part.feature.spline]` below."""
    points: PointsTable | None = None
    """A list of points with a tolerance: `[part.feature.points]` below."""

    @model_validator(mode="after")
    def _one_form(self) -> "FeatureTable":
        if self.centre is not None and self.radius is not None:
            raise ValueError("an arc has a centre or a radius, not both")
        forms = ("centre", "radius", "asphere", "ellipse", "polynomial", "spline", "points")
        given = [form for form in forms if getattr(self, form) is not None]
        if len(given) > 1:
            raise ValueError(f"a feature has one form, not {' and '.join(given)}")
        return self


class CharacteristicTable(Table):
    """One size that the drawing asks for, to be judged before and after the correction."""

    name: str
    """What it is called, once in a job."""
    quantity: Literal["diameter", "length", "angle", "radius", "form"]
    """`"diameter"` (whatever `part.x_is` is), `"length"` (between two faces, or of one from z = 0), `"angle"` (of a
    cone, to the axis), `"radius"` (of an arc) or `"form"` (straightness; of a curve its profile
    deviation, moved along z as a whole).
    """
    feature: str
    """The feature it is of."""
    other: str = ""
    """The second face of a length; left out, it counts from z = 0."""
    at_z_mm: Finite | None = None
    """Where along the feature a diameter holds; left out, everywhere, which a cylinder alone can have."""
    nominal: Annotated[Finite | None, In("`unit`; degrees")] = None
    """As the drawing says it; left out, what the profile has there."""
    tolerance: str | None = None
    """As the drawing says it: `"h6"`, `"±0.02"`, `"+0.01/-0.02"` (in `unit`; degrees of an angle), `"ISO 2768-m"`."""
    lower_limit: Annotated[Finite | None, In("`unit`; degrees")] = None
    """Instead of `tolerance`: the smallest size."""
    upper_limit: Annotated[Finite | None, In("`unit`; degrees")] = None
    """Instead of `tolerance`: the largest size."""

    @model_validator(mode="after")
    def _one_tolerance(self) -> "CharacteristicTable":
        limits = self.lower_limit is not None or self.upper_limit is not None
        if limits == (self.tolerance is not None):
            raise ValueError("a characteristic has a `tolerance`, or a `lower_limit`, an `upper_limit` or both")
        if self.other and self.quantity != "length":
            raise ValueError(f"`other` is of a length: a {self.quantity} has no second face")
        if self.at_z_mm is not None and self.quantity != "diameter":
            raise ValueError(f"`at_z_mm` is of a diameter: a {self.quantity} is of its whole feature")
        return self


class PartTable(Table):
    """The nominal profile: given here, or read from a DXF drawing or a solid, or taken from the finish program."""

    name: str
    """What the part is called in the report: its name or number."""
    revision: str = ""
    """Revision of the drawing. This key and the next three are for the report and the record."""
    material: str = ""
    """What it is made of."""
    drawing: str = ""
    """Number of its drawing, where that is not its name."""
    serial: str = ""
    """Serial number of the piece that was measured."""
    unit: Literal["mm", "inch"] = "mm"
    """Unit of all coordinates and radii of the profile: `"mm"` or `"inch"` (25.4 mm)."""
    x_is: Literal["radius", "diameter"] = "radius"
    """Whether an x coordinate is a `"radius"` or a `"diameter"`. Arc radii are radii either way."""
    side: Literal["outside", "inside", "around"] = "outside"
    """`"outside"`; `"inside"`: a bore, its features in order from the free end to the chuck end; `"around"`: one
    profile along the outside, over the front face and back through the bore, or a back face alone. The material is
    always on the right of the way along the features, seen with z to the right and x up.
    """
    start: Annotated[Point | None, In("`unit`")] = None
    """`[x, z]` where the first feature begins: of an outside at the chuck end, of a bore at the free end. Start it
    where the finish program's cut has its end there.
    """
    feature: tuple[FeatureTable, ...] = ()
    """The features in order, of an outside from the chuck end to the free end: `[[part.feature]]` below."""
    dxf: Path | None = None
    """A DXF drawing of the part: an open profile, a half section, a section with hatching, a view of both halves, or a
    sheet of them. `side` says whether its outside or its bore is read.
    """
    dxf_layer: str | None = None
    """The layer of the drawing to read, capital letters or not; left out, the whole drawing is."""
    dxf_outline: Count | None = None
    """Which contour, from 1 from the left, where that side has several; the refusal lists them, `trueloop part
    from-dxf --picture` draws them.
    """
    dxf_zero: Literal["drawing", "free-end", "chuck-end"] = "drawing"
    """From where z counts: `"drawing"` (its x = 0; y = 0 of a vertical axis), or the part's `"free-end"` or
    `"chuck-end"` in its view.
    """
    step: Path | None = None
    """A STEP or IGES file of the turned solid: its outside, or its bore by `side`, is the profile, exact, z along its
    axis from the file's origin. What is not turned is left out. Needs the extra `cad`.
    """
    step_outline: Count | None = None
    """Which contour, from 1 from the chuck, where the side has several; the refusal lists them."""
    step_turned_round: bool = False
    """The free end is at the small z of the file: z is counted the other way."""
    step_from_z_mm: Finite | None = None
    """Where the profile begins, as the finish program does; left out, at the solid's end face."""
    step_to_z_mm: Finite | None = None
    """Where it ends; left out, at the other end face."""
    from_program: bool = False
    """Take the profile from the finish program: the path of the nose centre less the nose radius; under G41 or G42 the
    contour that it is.
    """
    general_tolerance: str | None = None
    """`"ISO 2768-m"` (or `f`, `c`, `v`): for every feature without a characteristic, of a cylinder its diameter, of a
    face its length from z = 0, of a cone its angle, of an arc its radius.
    """
    characteristic: tuple[CharacteristicTable, ...] = ()
    """What the drawing asks for: `[[part.characteristic]]` below."""
    junctions: dict[str, Literal["corner", "tangent"]] = Field(default_factory=dict)
    """Junctions by design, `{ "neck/dome" = "tangent" }` or `"corner"`; the others are found from the geometry."""

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
    """Nose radius; 0 is a pointed tool."""
    nose_radius_in: NotNegative | None = None
    """The same in inches."""
    number: Annotated[int, Field(ge=0, le=1_000_000, strict=True)] | None = None
    """Number of its offset at the control; left out, that of the finish pass' T word (12 of `T0312`), or 1 where there
    is none.
    """
    name: str = ""
    """What the tool or its holder is called. This key and the next three are for the report and the record."""
    insert: str = ""
    """The insert: its designation, or the number on it."""
    corner: str = ""
    """Which corner of the insert cuts."""
    set_at: Moment | None = None
    """Date and time when this edge was mounted and measured."""
    table: Path | None = None
    """The control's tool table as it is in force ([offsets.md](offsets.md)): the nose radius comes from it, and a
    correction by offset is written into a copy, `new-NAME`. Needs `number`.
    """
    table_unit: Literal["mm", "inch"] | None = None
    """`"mm"` or `"inch"`: unit of a table that does not say its own: that of the machine."""
    table_name: str = ""
    """The tool's name in the table: a table that has another name under the number is refused."""
    table_edge: Count = 1
    """The tool's edge in the table: D of a Sinumerik, OG of an Okuma."""

    @model_validator(mode="after")
    def _one_nose(self) -> "ToolTable":
        given = (self.nose_radius_mm is not None) + (self.nose_radius_in is not None)
        if given > 1 or (given == 0 and self.table is None):
            raise ValueError("give the nose radius once: `nose_radius_mm` or `nose_radius_in`")
        if self.table is not None and self.number is None:
            raise ValueError("`number` is needed with `table`: it names the tool's row")
        return self


class ToolsTable(ToolTable):
    """One of several edges that cut the part, each with an offset of its own: a table [[tools]] an edge."""

    groove_corner: Corner | None = None
    """Which corner of a plunge or groove insert it is: `"left"` (at the chuck), `"right"`; of a face groover `"outer"`,
    `"inner"`. The two corners are two edges: T0303 and T0313, or T3 D1 and D2, each with its own tables [[tools]].
    """
    finish_lines: tuple[Count, Count] | None = None
    """`[from, to]`, lines of the finish program: which of several passes of this edge is its finish pass."""
    nose_from: tuple[Path, ...] = ()
    """Job files of other parts cut with this edge, as `compensation.nose_from` of a job of one tool."""
    cut_to_cut_um: NotNegative | None = None
    """`compensation.cut_to_cut_um` of this edge; left out, that of the job."""
    cut_to_cut_along_um: NotNegative | None = None
    """The same of `compensation.cut_to_cut_along_um`."""

    @model_validator(mode="after")
    def _numbered(self) -> "ToolsTable":
        if self.number is None:
            raise ValueError("`number` is needed: by the number of its offset the program calls the edge")
        return self

    @property
    def called(self) -> Called:
        """As the program calls it."""
        assert self.number is not None
        return Called(self.number, self.table_edge)


class CutByTable(Table):
    """What is decided of a feature, where the program leaves it open."""

    tool: Annotated[int, Field(ge=0, le=1_000_000, strict=True)] | None = None
    """Number of the tool of [[tools]] that leaves its surface. 0: it is left alone, and nothing that was measured of it
    is used.
    """
    edge: Count = 1
    """That tool's edge: D of a Sinumerik, OG of an Okuma."""
    setup: str | None = None
    """Name of the set-up of [[setups]] that leaves its surface."""

    @property
    def called(self) -> Called | None:
        """As the program calls it; None: the feature is left alone, or its tool is not decided."""
        return Called(self.tool, self.edge) if self.tool else None

    @property
    def left_alone(self) -> bool:
        """Whether nothing is to be corrected there."""
        return self.tool == 0

    @model_validator(mode="after")
    def _decides(self) -> "CutByTable":
        if self.tool is None and self.setup is None:
            raise ValueError("`tool` or `setup` is missing: which of them leaves the surface?")
        return self


@with_options("programs", Options)
class ProgramsTable(Table):
    """The finish program, and the semi-finish program that the measured surface was cut with."""

    dialect: str
    """One of those in [dialects.md](dialects.md): `"ge2000t"`, `"linuxcnc"`, `"fanuc-lathe"`, `"siemens"` …"""
    finish: Path
    """The finish program, to be corrected. It is read, never changed: the corrected one is a new file."""
    finish_lines: tuple[Count, Count] | None = None
    """`[from, to]`, lines of the finish program: which of several passes is the finish pass, where more than one fits
    the profile.
    """
    semifinish: Path | None = None
    """The program that cut the surface that was touched. What it commands off the profile is no error of the process;
    left out, the finish program's own deviation is taken.
    """
    semifinish_allowance_mm: NotNegative | None = None
    """What the semi-finish program leaves on, along the normal."""
    parameters: Annotated[dict[str, Finite], In("program's")] = Field(default_factory=dict)
    """Values of the programs' parameters, `{ P46 = 3.52 }`, in the programs' own unit."""
    unit: Literal["mm", "inch"] | None = None
    """`"mm"` or `"inch"`: the unit in force at the start of programs that do not state their own; see
    [cli.md](cli.md#the-unit-of-a-program).
    """
    decimals: Annotated[int, Field(ge=0, le=9, strict=True)] = 0
    """Decimals of new coordinates, 0 to 9; never fewer than those of the control's resolution and of the program's own
    coordinates.
    """
    offset_x_is: Literal["radius", "diameter"] | None = None
    """How the control reads a tool offset on X: as a `"radius"` or a `"diameter"`; left out, as the program's X words.
    """
    execute_deleted_blocks: bool = False
    """Whether blocks that begin with `/` are run, as with the control's block-delete switch off."""
    machine: str = ""
    """The machine that runs them, as the shop calls it, for report and record; `machine.model` states it too."""
    machine_serial: str = ""
    """The machine's serial number."""
    accept_unknown_words: bool = False
    """Go on although a program holds words or codes that the dialect does not know. They are left alone and taken to
    move nothing.
    """


class SetupTable(Table):
    """One of several set-ups in which the part is turned: a table [[setups]] each, with its program and its tools."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$", max_length=40)]
    """What it is called, in file names too: letters, digits, `-` and `_`."""
    zero_at_z_mm: Annotated[Finite | None, In("mm")] = None
    """z of the part's frame at which this program's Z is 0: its datum. Without it the job is refused."""
    flipped: bool = False
    """The part is turned round: the program's +Z points to the part's −z."""
    mirrored_z: bool = False
    """The control mirrors Z, as at a sub-spindle: the part is not turned round, and yet the program's +Z points to the
    part's −z. Corrected by the contour alone: what the control makes of the sign of a tool offset is not known.
    """
    program_sha256: str | None = None
    """SHA-256 of the finish program that was run before probing: another program is refused."""
    programs: ProgramsTable
    """Its programs: `[setups.programs]`, with the keys of `[programs]`."""
    tools: tuple[ToolsTable, ...]
    """Its tools: a table `[[setups.tools]]` each, with the keys of `[[tools]]`."""

    @model_validator(mode="after")
    def _one_direction(self) -> "SetupTable":
        if self.flipped and self.mirrored_z:
            raise ValueError(
                "`flipped` and `mirrored_z` each point the program's +Z the other way: give the one that does"
            )
        if not self.tools:
            raise ValueError("a set-up has at least one table [[setups.tools]]")
        _require_apart(self.tools)
        return self


def _require_apart(tools: tuple[ToolsTable, ...]) -> None:
    calls = [one.called for one in tools]
    if len(set(calls)) < len(calls):
        raise ValueError("two tables of tools have the same `number` and `table_edge`")


@with_options("gauging", Gauging)
class GaugingTable(Table):
    """What was measured: touches of a probe, readings of gauges or measuring machines, or both.

    Ranges of repeated probing are those of [6811 §4.1]: 1.5 µm on diameters, 0.5 µm on faces.
    """

    touches: Path | None = None
    """CSV of the touches after the semi-finish cut: `point`, `feature`, nominal and measured point or error, the unit
    in each column's name; also `note`, which is not read, and no others. Left out, the job has `readings`.
    """
    readings: tuple[Path, ...] | Path = ()
    """One or several inspection files, in any format of [measurements.md](measurements.md): diameters, radii, lengths
    and angles of features, and points of a measuring machine, which are taken as touches. Of several parts in a file,
    `part.serial` chooses one. Characteristics that a file asks for are judged beside the job's.
    """
    readings_unit: Literal["mm", "inch"] | None = None
    """Unit of lengths in files of readings that do not state it: `"mm"` or `"inch"`."""
    readings_mapping: Path | None = None
    """TOML file that says what the columns, variables and names of files of readings mean
    ([measurements.md](measurements.md#tables-by-mapping)); `trueloop measure map` proposes one.
    """
    after_record: Path | None = None
    """Record (`record.json`) of the last correction of this process: readings from before it are refused."""
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
    """What measured: the probe, gauge or measuring machine, with its number. For the report and the record."""
    operator: str = ""
    """Who measured. For the report and the record."""
    program_sha256: str | None = None
    """SHA-256 of the finish program that the touches belong to: another program is refused."""
    finish_touches: Path | None = None
    """CSV of touches after an earlier corrected cut, to find a correction of reversed sign."""

    @property
    def readings_files(self) -> tuple[Path, ...]:
        """Those of `readings`, one or several."""
        return (self.readings,) if isinstance(self.readings, Path) else self.readings

    @model_validator(mode="after")
    def _something_measured(self) -> "GaugingTable":
        if self.touches is None and not self.readings_files:
            raise ValueError("`touches` or `readings` is missing: at least one of them is to be given")
        return self


class FeatureFitTable(Table):
    """What one feature's error curve is held to: its knots, and error and slope of error at its ends."""

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
    """The same of what varies along the cut, over more than the distance of touches. Where one of the two is given, the
    other is 0 unless given too.
    """


Vector = tuple[Finite, Finite, Finite]
Signals = dict[str, Finite] | Path
"""Values of a model's signals, or the log whose last row is meant."""


class MachineTable(Table):
    """The machine's own errors, to be corrected together with the process's: where the part stands, how warm it is."""

    model: Path
    """The model, as `trueloop machine fit` wrote it."""
    serial: str | None = None
    """Refuse a model of a machine with another serial number."""
    work_zero_mm: Vector
    """Machine coordinates of the program's zero, for a tool of no length, with all that is in force in the finish pass:
    work offset, G52, G92, TRANS.
    """
    tool_mm: Vector
    """The programmed point of the tool from the frame of the last axis, as `--tool`. Semi-finish and finish cut are
    made with this tool.
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
    """`"machine"`: the control reported the touches, which carry its error while probing; `"cmm"`: they are taken as
    they are.
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
    """Its file, from the job's folder, or its URL (`postgresql://…`); left out, `trueloop.db` beside the job where that
    exists. `--db` takes its place; `--db none`: no store.
    """


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

    def require_one_setup(self) -> None:
        """Raises JOB-SETUPS where the job has several set-ups."""
        if self.setups:
            names = [one.name for one in self.setups]
            raise TrueloopError(
                Code.JOB_SETUPS,
                f"the job has {len(names)} set-ups ({', '.join(names)}): this is done for one alone",
                hint="`trueloop compensate`, `trueloop nc features` and `trueloop part show` take set-ups",
                values={"setups": names},
            )

    @model_validator(mode="after")
    def _one_setup_or_several(self) -> "Job":
        if not self.setups:
            if self.programs is None:
                raise ValueError("a job has a table [programs], or a table [[setups]] for each of several set-ups")
            if any(cut.setup is not None for cut in self.feature.values()):
                raise ValueError("`setup` of a table [feature.NAME] is none of [[setups]]: there are none")
            return self
        if self.programs is not None or self.tool is not None or self.tools:
            raise ValueError("with [[setups]] programs and tools are those of each set-up: [setups.programs], "
                             "[[setups.tools]]")  # fmt: skip
        names = [one.name for one in self.setups]
        if len({name.lower() for name in names}) < len(names):
            raise ValueError("two tables [[setups]] have the same `name`")
        for feature, cut in self.feature.items():
            self._require_known(feature, cut)
        if self.gauging.program_sha256 is not None:
            raise ValueError("`gauging.program_sha256` is of one program: give `program_sha256` of a table [[setups]]")
        return self

    def _require_known(self, feature: str, cut: CutByTable) -> None:
        """What is decided of a feature is a set-up, and a tool of it."""
        meant = [one for one in self.setups if cut.setup in (None, one.name)]
        if not meant:
            raise ValueError(f"`feature.{feature}.setup` is none of [[setups]]")
        if cut.called is not None and all(cut.called != tool.called for one in meant for tool in one.tools):
            raise ValueError(f"`feature.{feature}.tool` is none of [[setups.tools]]")

    @model_validator(mode="after")
    def _one_tool_or_several(self) -> "Job":
        several = bool(self.tools or self.setups)
        if (self.tool is None) != several:
            raise ValueError("a job has a table [tool], or a table [[tools]] for each of several edges")
        _require_apart(self.tools)
        calls = [None, *(one.called for one in self.tools)]
        strange = [name for name, cut in self.feature.items() if not self.setups and cut.called not in calls]
        if strange:
            raise ValueError(f"`feature.{strange[0]}.tool` is none of [[tools]]")
        if several and self.compensation.nose_from:
            raise ValueError("`compensation.nose_from` is of one edge: give `nose_from` of a table [[tools]]")
        if several and (self.machine is not None or self.part.from_program):
            raise ValueError("with several tools the profile is drawn or spelt out, and there is no table [machine]")
        return self

    @model_validator(mode="after")
    def _contour_for_the_machine(self) -> "Job":
        if self.machine is not None and options_from(Options, self).by == "offset":
            raise ValueError("no tool offset can carry the machine's error: `compensation.by` is to be another")
        return self

    @model_validator(mode="after")
    def _readings_without_machine(self) -> "Job":
        if self.machine is not None and self.gauging.readings_files:
            raise ValueError("`gauging.readings` cannot be split between machine and process: leave out [machine]")
        return self

    @model_validator(mode="after")
    def _machine_once(self) -> "Job":
        stated = self.programs is not None and (self.programs.machine or self.programs.machine_serial)
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
    """The same with where in the file what stands."""
    return read_located(path, kind, Code.JOB_KEY, hint=hint, missing=Code.JOB_MISSING, syntax=Code.JOB_SYNTAX)
