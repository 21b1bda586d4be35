"""The tables of a job that state what cuts the part: tools, programs, set-ups."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from trueloop.formats.toml_tables import Count, Finite, In, Moment, NotNegative, Table, Vector, with_options
from trueloop.nc.match.cutters import Corner
from trueloop.nc.program.called import CalledOffset
from trueloop.turned.options import Options


class ToolTable(Table):
    """The finishing tool."""

    nose_radius_mm: NotNegative | None = None
    """Nose radius; 0 is a pointed tool."""
    nose_radius_in: NotNegative | None = None
    """The nose radius in inches."""
    number: Annotated[int, Field(ge=0, le=1_000_000, strict=True)] | None = None
    """Number of its offset at the control; left out, that of the finish pass' T word (12 of `T0312`), or 1 where there
    is none.
    """
    tip: Annotated[int, Field(ge=0, le=9, strict=True)] | None = None
    """The control's number of the tip's orientation, where the program moves the imaginary tip without G41 or G42, as
    CAM output that is compensated in the computer may; 0 for the nose's centre. Left out, it is found out from the
    path where the job has one tool; of several it is the centre.
    """
    name: str = ""
    """The name of the tool or its holder. This key and the next three are for the report and the record."""
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
    table_edge: Count | None = None
    """The tool's edge in the table: D of a Sinumerik, OG of an Okuma. Left out, that of the finish pass; with `table`
    and in [[tools]] 1.
    """

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
    """Which corner of a plunge or groove insert it is: `"left"` (at lower Z of the program),
    `"right"`; of a face groover `"outer"`, `"inner"`. The two corners are two edges: T0303 and T0313, or T3 D1 and D2,
    each with its own tables [[tools]].
    """
    finish_lines: tuple[Count, Count] | None = None
    """`[from, to]`, lines of the finish program: which of several passes of this edge is its finish pass."""
    nose_from: tuple[Path, ...] = ()
    """Job files of other parts cut with this edge, as `compensation.nose_from` of a job of one tool."""
    cut_to_cut_um: NotNegative | None = None
    """`compensation.cut_to_cut_um` of this edge; left out, that of the job."""
    cut_to_cut_along_um: NotNegative | None = None
    """`compensation.cut_to_cut_along_um` of this edge; left out, that of the job."""
    tool_mm: Vector | None = None
    """`machine.tool_mm` of this tool: required where the job has a table [machine]."""

    @model_validator(mode="after")
    def _numbered(self) -> "ToolsTable":
        if self.number is None:
            raise ValueError("`number` is needed: by the number of its offset the program calls the edge")
        return self

    @property
    def called(self) -> CalledOffset:
        """As the program calls it."""
        assert self.number is not None
        return CalledOffset(self.number, self.table_edge or 1)


class CutByTable(Table):
    """Tool and set-up of a feature, where the program does not determine them."""

    tool: Annotated[int, Field(ge=0, le=1_000_000, strict=True)] | None = None
    """Number of the tool of [[tools]] that leaves its surface. 0: it is left alone, and nothing that was measured of it
    is used.
    """
    edge: Count = 1
    """That tool's edge: D of a Sinumerik, OG of an Okuma."""
    setup: str | None = None
    """Name of the set-up of [[setups]] that leaves its surface."""

    @property
    def called(self) -> CalledOffset | None:
        """As the program calls it; None: the feature is left alone, or its tool is not decided."""
        return CalledOffset(self.tool, self.edge) if self.tool else None

    @property
    def left_alone(self) -> bool:
        """True if nothing is to be corrected there."""
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
    """The program that cut the surface that was touched. Its commanded deviation from the profile is not an error
    of the process; left out, the finish program's own deviation is taken.
    """
    semifinish_allowance_mm: NotNegative | None = None
    """Allowance that the semi-finish program leaves on, along the normal."""
    cut_with: str = ""
    """How the measured finished part was cut: by `"given"`, the finish program as it is; or by the record of the
    correction that was in force, `"o1/record.json"`, or with a store its id; of several tools or set-ups by
    `"o1/part.json"`. The result is then the whole correction, of which the one in force is a part.
    """
    cut_by: Literal["corrected", "offsets", "wear"] | None = None
    """How that correction was in force: by the `"corrected"` program, by the program with tool `"offsets"`, or as
    `"wear"` entered at the control. To be given where the correction can be carried out in several ways.
    """
    folder: Path | None = None
    """Folder of subprograms in files of their own (`O2000`, `2000.nc`, `CONTOUR.SPF`), of Fanuc, Haas and Siemens.
    Those that the programs call are read, and the corrected program holds them behind itself.
    """
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
    """Run blocks that begin with `/`, as with the control's block-delete switch off."""
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
    """Its name, in file names too: letters, digits, `-` and `_`."""
    zero_at_z_mm: Annotated[Finite | None, In("mm")] = None
    """z of the part's frame at which this program's Z is 0: its datum. Without it the job is refused."""
    flipped: bool = False
    """The part is turned round: the program's +Z points to the part's −z."""
    mirrored_z: bool = False
    """The control mirrors Z, as at a sub-spindle: the part is not turned round, and yet the program's +Z points to the
    part's −z. Corrected by the contour alone: what the control makes of the sign of a tool offset is not known.
    """
    work_zero_mm: Vector | None = None
    """`machine.work_zero_mm` of this set-up: required where the job has a table [machine]. Features are touched in the
    set-up that cuts them, where the machine's probe touches.
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
        require_apart(self.tools)
        return self


def require_apart(tools: tuple[ToolsTable, ...]) -> None:
    """Raises ValueError where two edges would be called the same."""
    calls = [tool.called for tool in tools]
    if len(set(calls)) < len(calls):
        raise ValueError("two tables of tools have the same `number` and `table_edge`")
