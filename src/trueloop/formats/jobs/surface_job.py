"""The job file of a surface (TOML): its nominal, its measured parts, how to model, what to correct."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from trueloop.formats.jobs.job import read_job_file
from trueloop.formats.toml_tables import Count, Finite, Moment, NotNegative, Positive, Share, Table
from trueloop.surface.deviations.alignment import SETUP_MM

Cells = Annotated[int, Field(ge=8, le=1000, strict=True)]


class SurfaceTable(Table):
    """The nominal surface: a STEP or IGES file with the number of the face, or a CSV grid of points."""

    file: Path
    face: Count | None = None
    flip: bool = False


class SurfaceGaugingTable(Table):
    """The measured parts, a CSV file each, and how their points are to be understood."""

    points: Annotated[tuple[Path, ...], Field(min_length=1)]
    ball_radius_mm: NotNegative = 0.0
    alignment: Literal["datum", "best-fit"] = "datum"
    farthest_mm: Positive = 1.0
    setup_mm: Positive = SETUP_MM
    measured_at: Moment | None = None
    program_sha256: str | None = None


class ModelTable(Table):
    """How deviations are taken apart. `cells`: average scattered points or scans over a grid of so many cells."""

    criterion: Literal["likelihood", "randomness"] = "likelihood"
    confidence: Annotated[float, Field(gt=0.5, lt=1, strict=True)] = 0.99
    exponent: Positive = 3.0
    cells: tuple[Cells, Cells] | None = None
    exclude: tuple[str, ...] = ()
    target_um: Positive = 1.0


class CutterTable(Table):
    """The cutter of the finishing program; corner radius as the tool's radius for a ball end."""

    radius_mm: Positive
    corner_mm: NotNegative | None = None
    axis: tuple[Finite, Finite, Finite] = (0.0, 0.0, 1.0)
    rotary: Literal["", "A", "B", "CA", "CB", "AB", "BA", "IJK"] = ""


class SurfaceProgramTable(Table):
    """The finishing program that cut the parts."""

    finish: Path
    dialect: str | None = None
    unit: Literal["mm", "inch"] | None = None
    decimals: Annotated[int, Field(ge=0, le=9, strict=True)] = 0


class SurfaceCompensationTable(Table):
    """How much to correct, how exactly, and what is refused."""

    weight: Share = 1.0
    tolerance_um: Positive = 0.1
    chord_um: Positive = 0.5
    gouge_um: Positive = 5.0
    cad_file: Literal["step", "iges", "none"] = "step"
    max_correction_um: Positive = 150.0
    max_slope_um_per_mm: Positive = 40.0
    max_scatter_um: Positive = 10.0
    min_supported_percent: Annotated[float, Field(ge=0, le=100, strict=True)] = 50.0
    max_age_hours: Positive = 24.0 * 7


class SurfaceOutputTable(Table):
    """Where the results go."""

    folder: Path = Path("out")


class SurfaceJobFile(Table):
    """A whole job file of a surface."""

    name: str
    surface: SurfaceTable
    gauging: SurfaceGaugingTable
    model: ModelTable = ModelTable()
    cutter: CutterTable | None = None
    program: SurfaceProgramTable | None = None
    compensation: SurfaceCompensationTable = SurfaceCompensationTable()
    output: SurfaceOutputTable = SurfaceOutputTable()

    @model_validator(mode="after")
    def _program_with_its_cutter(self) -> "SurfaceJobFile":
        if self.program is not None and self.cutter is None:
            raise ValueError("a [program] needs its [cutter]: `cutter.radius_mm`")
        return self


def read_surface_job(path: Path) -> SurfaceJobFile:
    """Reads a job file of a surface; raises JOB errors that name the table, the key and the line."""
    hint = "docs/surface.md lists every key with its default; examples/surface/surface.toml is a ready job"
    return read_job_file(path, SurfaceJobFile, hint)
