"""The job file of a milled part (TOML): its features, what cuts them, what was measured, and what may be entered."""

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from trueloop.formats.jobs.job import ProgramTable, read_job_file
from trueloop.formats.toml_tables import Count, In, MeasuringUm, NotNegative, Positive, Table, Vector
from trueloop.milled.feature import Kind, Side


class MilledFeatureTable(Table):
    """A feature as the drawing has it, and what cuts it."""

    name: str
    """Its name; the measurement's, where `[names]` gives no other."""
    kind: Kind
    """`"bore"`, `"boss"`, `"slot"`, `"rib"` (two parallel walls), or `"face"`. A pocket is two slots."""
    at: Annotated[Vector, In("`unit`")]
    """`[x, y, z]` of its centre at its top; of a face any point of it."""
    size: Annotated[NotNegative, In("`unit`")] = 0.0
    """Diameter of a bore or boss, width of a slot or rib."""
    depth: Annotated[NotNegative, In("`unit`")] = 0.0
    """From the top down."""
    direction: Vector = (0.0, 0.0, 1.0)
    """The vector from the middle of a slot or rib to one wall; of a face, its outward normal."""
    tool: Count | None = None
    """Number of the tool that finishes it; with a `[program]` found there, without one required."""
    work_offset: str | None = None
    """The work offset in force there; left out, the program's, which is to cut it, without a `[program]` `"G54"`."""
    side: Side = ""
    """How the finishing pass runs along its wall, found from a `[program]`."""

    @model_validator(mode="after")
    def _as_its_kind_needs(self) -> "MilledFeatureTable":
        length = math.hypot(*self.direction)
        if self.kind == "face":
            if self.size or self.depth:
                raise ValueError(f"a face has no size and no depth, {self.name!r} has {self.size:g} and {self.depth:g}")
        elif not self.size or not self.depth:
            raise ValueError(
                f"a {self.kind} needs `size` and `depth`, {self.name!r} has {self.size:g} and {self.depth:g}"
            )
        if length == 0.0 or (self.kind in ("slot", "rib") and self.direction[2] != 0.0):
            level = "in the plane of x and y, such as [1.0, 0.0, 0.0]" if self.kind != "face" else "other than zero"
            raise ValueError(f"`direction` of {self.name!r} is {list(self.direction)}, it is to be {level}")
        return self


class MilledProgramTable(ProgramTable):
    """The finishing program, from which it is found what cuts each feature."""

    file: Path
    """The program; it is read, never changed."""


class FrameTable(Table):
    """Features that the frame of the measurement was set by; left out: surfaces that these cuts do not make."""

    x: str = ""
    """The feature that x counts from."""
    y: str = ""
    """The feature that y counts from."""
    z: str = ""
    """The face that z counts from."""
    turn: tuple[str, str] | None = None
    """Two features whose line has the drawing's direction."""


class MillToolTable(Table):
    """A tool as the control knows it."""

    number: Count
    """Its number."""
    radius: Literal["control", "program"] | None = None
    """`"control"`: its radius stands at the control (G41, G42 with D) and can be entered there; `"program"`: the paths
    were computed with it, so that no number at the control moves a wall. Found from a `[program]` for what it cuts,
    required for all else.
    """
    cutter_radius: Annotated[Positive | None, In("`unit`")] = None
    """Radius of the cutter: needed where it decides which pass of a `[program]` is the last on a wall, and where the
    contour has inside corners.
    """
    register_is: Literal["radius", "diameter"] | None = None
    """The quantity that the control's register holds; left out, `"diameter"` with a program of LinuxCNC, else
    `"radius"`.
    """


class MeasuredTable(Table):
    """Parts as they were measured, in the order of cutting."""

    file: Path
    """An inspection file, in any format of [measurements.md](measurements.md)."""
    serial: str | None = None
    """Serial number of the part, if the file holds several; left out, all parts in the file's order."""
    unit: Literal["mm", "inch"] | None = None
    """Unit of a file that does not state it."""
    device: str | None = None
    """Name of the measuring device; by default the device that the file names, else the kind of file."""
    mapping: Path | None = None
    """What a table's columns mean, see [measurements.md](measurements.md#tables-by-mapping)."""
    entered: tuple[Path, ...] | None = None
    """The record (`entries.json`) whose numbers were entered last before these parts were cut, with which those before
    it are in force; `[]`: none are. Required of all but the first. Several add up.
    """


class DeviceTable(Table):
    """A device that measured a ring gauge."""

    name: str
    """The device, as `measured.device` or the file names it."""
    ring: Annotated[Positive, In("`unit`")]
    """Calibrated diameter of the ring gauge."""
    ring_measured: Annotated[Positive, In("`unit`")]
    """Diameter that the device read there. Its deviation from the ring is taken out of the device's readings."""


class MilledLimits(Table):
    """What is refused."""

    entry_um: Positive = 100.0
    """Largest change of a radius, a length or an offset."""
    turn_urad: Positive = 1000.0
    """Largest change of a rotation."""
    deviation_um: Positive = 300.0
    """Largest deviation of a size or coordinate."""


class MilledOutput(Table):
    """Where the results go."""

    folder: Path = Path("out")
    """Folder of the results."""


class MilledJobFile(Table):
    """A whole job file of a milled part."""

    name: str
    """The part type."""
    unit: Literal["mm", "inch"]
    """Unit of the features."""
    feature: Annotated[tuple[MilledFeatureTable, ...], Field(min_length=1)]
    frame: FrameTable = FrameTable()
    program: MilledProgramTable | None = None
    tool: tuple[MillToolTable, ...] = ()
    measured: Annotated[tuple[MeasuredTable, ...], Field(min_length=1)]
    device: tuple[DeviceTable, ...] = ()
    names: dict[str, str] = Field(default_factory=dict)
    """Names in the files, and the job's: `{ CIR1 = "B1" }`."""
    rotation: bool = True
    """The program runs under a rotation that can be entered (G68, ROT, a basic rotation); false: none is proposed."""
    measuring_u_um: MeasuringUm = 1.5
    """Standard uncertainty of a measured value whose file states none."""
    limits: MilledLimits = MilledLimits()
    output: MilledOutput = MilledOutput()

    @model_validator(mode="after")
    def _names_that_exist(self) -> "MilledJobFile":
        names = [table.name for table in self.feature]
        tools = {table.number for table in self.tool}
        if len(tools) < len(self.tool):
            raise ValueError(f"{len(self.tool)} [[tool]] tables have {len(tools)} numbers: describe each tool once")
        if twice := next((one for one in names if names.count(one) > 1), None):
            raise ValueError(f"{names.count(twice)} features are named {twice!r}")
        if len({table.name for table in self.device}) < len(self.device):
            raise ValueError(f"{len(self.device)} [[device]] tables have fewer names: state one ring gauge of each")
        for table in self.feature if self.program is None else ():
            if table.tool not in tools:
                by = "what cuts it" if table.tool is None else f"tool {table.tool}, which no [[tool]] describes"
                raise ValueError(f"{table.name!r} is to be cut by {by}: state `tool` and its [[tool]], or a [program]")
        if self.program is None and (without := next((table for table in self.tool if table.radius is None), None)):
            raise ValueError(f"`radius` of tool {without.number} is required, or a [program] to find it from")
        used = (self.frame.x, self.frame.y, self.frame.z, *(self.frame.turn or ()), *self.names.values())
        if unknown := next((one for one in used if one and one not in names), None):
            raise ValueError(f"no feature is named {unknown!r}")
        if self.frame.turn is not None:
            first, second = (next(table for table in self.feature if table.name == name) for name in self.frame.turn)
            if first.at[:2] == second.at[:2] or not {first.kind, second.kind} <= {"bore", "boss"}:
                raise ValueError("`frame.turn` names two bores or bosses at different places of x and y")
        return self


def read_milled_job(path: Path) -> MilledJobFile:
    """Reads a job file of a milled part; raises JOB errors that name the table, the key and the line."""
    return read_job_file(
        path, MilledJobFile, "docs/milled.md lists every key; examples/plate/plate.toml is a ready job"
    )
