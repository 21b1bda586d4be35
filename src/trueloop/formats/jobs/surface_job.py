"""The job file of a surface (TOML): its nominal, its measured parts, how to model, what to correct."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from trueloop.domain.option import OF_SURFACES
from trueloop.formats.jobs.job import ProgramTable, StoreTable, read_job_file
from trueloop.formats.toml_tables import Count, Finite, Moment, NotNegative, Positive, Table, with_options
from trueloop.surface.compensation.shift import SurfaceJob
from trueloop.surface.options import SurfaceOptions


class SurfaceTable(Table):
    """The nominal surface."""

    file: Path
    """STEP, IGES, or a CSV grid (`row,column,x_mm,y_mm,z_mm`) that a surface is put through."""
    face: Count | Annotated[tuple[Count, ...], Field(min_length=1)] | None = None
    """Which face of the CAD file, from 1, when it has several: one, or all that the program cuts, `[10, 13]`. The other
    faces are not converted.
    """
    flip: bool = False
    """Turn the normals over: they must point out of the material. A program whose tool runs on their inner side is
    refused (SRF-SIGN).
    """


@with_options("gauging", SurfaceOptions)
class SurfaceGaugingTable(Table):
    """The measured parts, and how their points are to be understood."""

    points: Annotated[tuple[Path, ...], Field(min_length=1)]
    """The measured parts, a file each: a CSV (`x_mm,y_mm,z_mm`, and `row,column` for a grid), or a scan, see Scans; `*`
    is filled in. Parts go by the files' names: no two alike.
    """
    unit: Literal["mm", "inch"] | None = None
    """Unit of scans that do not state it; required for those."""
    columns: Annotated[tuple[Count, Count, Count] | None, Field()] = None
    """Which columns of a scan in text are x, y and z, from 1; left out, its headings say so, or they are the first."""
    ball_radius_mm: NotNegative = 0.0
    """Above 0: points are ball centres, not compensated."""
    alignment: Literal["datum", "best-fit"] = "datum"
    """`"datum"`: location and orientation are errors. `"best-fit"`: what the set-up may have done is taken out, form
    alone is left.
    """
    measured_at: Moment | None = None
    """When the parts were measured (TOML date and time); left out, their age is not checked."""
    program_sha256: str | None = None
    """SHA-256 of the program that cut them: another one is refused; left out, it is not checked."""
    cut_with: str = ""
    """The correction that was in force when the parts were cut, by the path to its `record.json`: it is taken over, and
    the new correction added to it. `"given"`: nominal surface and program as they are.
    """


@with_options("model", SurfaceOptions)
class ModelTable(Table):
    """How deviations are taken apart."""


class CutterTable(Table):
    """The cutter of the finishing program, required with `[program]`."""

    tool: Annotated[int, Field(ge=0, strict=True)] | None = None
    """Its T number: moves of other tools stay. Required for each, `[[cutter]]`, where several tools cut the surface."""
    radius_mm: Positive
    """Radius of the tool."""
    corner_mm: NotNegative | None = None
    """Corner radius: left out for a ball end, 0 for a flat end."""
    axis: tuple[Finite, Finite, Finite] = (0.0, 0.0, 1.0)
    """Tool axis out of the material, fixed: straight up, or a tilt."""
    rotary: Literal["", "A", "B", "CA", "CB", "AB", "BA", "IJK"] = ""
    """Words that turn the tool as it cuts: `"CA"`, `"CB"`, `"AB"`, `"BA"`, `"A"`, `"B"`, or vectors `"IJK"`; see
    Turning tools.
    """


class SurfaceProgramTable(ProgramTable):
    """The finishing program that cut the parts."""

    finish: Path
    """The program; it is read, never changed."""
    decimals: Annotated[int, Field(ge=0, le=9, strict=True)] = 0
    """Decimals of new coordinates; never fewer than the control's and the program's."""
    zero_mm: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)
    """Where the zero of the work offset lies in the coordinates of `surface.file`; the axes are parallel."""
    work_offsets: tuple[str, ...] = ()
    """Work offsets with that zero, `["G54"]`; required if the program cuts in several. Moves in others stay."""


@with_options("compensation", SurfaceOptions, SurfaceJob, OF_SURFACES)
class SurfaceCompensationTable(Table):
    """How much to correct, how exactly, and what is refused."""

    cad_file: Literal["step", "iges", "none"] = "step"
    """The corrected surface's file: `"step"` (AP242), `"iges"` or `"none"`."""


class SurfaceOutputTable(Table):
    """Where the results go."""

    folder: Path = Path("out")
    """Folder of the results."""


class SurfaceJobFile(Table):
    """A whole job file of a surface."""

    name: str
    """The surface's name."""
    surface: SurfaceTable
    gauging: SurfaceGaugingTable
    model: ModelTable = ModelTable()
    cutter: CutterTable | tuple[CutterTable, ...] | None = None
    program: SurfaceProgramTable | None = None
    compensation: SurfaceCompensationTable = SurfaceCompensationTable()
    output: SurfaceOutputTable = SurfaceOutputTable()
    store: StoreTable = StoreTable()

    @model_validator(mode="after")
    def _program_with_its_cutter(self) -> "SurfaceJobFile":
        if self.program is not None and not self.cutter:
            raise ValueError("a [program] needs its [cutter]: `cutter.radius_mm`")
        numbers = [cutter.tool for cutter in self.cutters]
        if len(numbers) > 1 and (None in numbers or len(set(numbers)) < len(numbers)):
            raise ValueError("several [[cutter]] tables each need a `tool`, no two the same")
        if len({cutter.rotary for cutter in self.cutters}) > 1:
            raise ValueError("all [[cutter]] tables need the same `rotary`")
        return self

    @property
    def cutters(self) -> tuple[CutterTable, ...]:
        """Returns the cutters of all tools that are stated."""
        return self.cutter if isinstance(self.cutter, tuple) else () if self.cutter is None else (self.cutter,)


def read_surface_job(path: Path) -> SurfaceJobFile:
    """Reads a job file of a surface; raises JOB errors that name the table, the key and the line."""
    hint = "docs/surface.md lists every key with its default; examples/surface/surface.toml is a ready job"
    return read_job_file(path, SurfaceJobFile, hint)
