"""A surface's job read from its files."""

from dataclasses import dataclass
from pathlib import Path

from trueloop.compensation.cutter import Cutter
from trueloop.compensation.limits import Limits
from trueloop.compensation.surface_program import SurfaceJob
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_input
from trueloop.formats.points_csv import read_points
from trueloop.formats.surface_job import SurfaceJobFile, read_surface_job
from trueloop.gauging.surface_deviations import MeasuredPoints
from trueloop.geometry.surface import Surface
from trueloop.geometry.surface_fit import fit_grid
from trueloop.loops.surface import SurfaceOptions
from trueloop.nc.program import Program, read_program
from trueloop.units import UM_PER_MM


@dataclass(frozen=True, eq=False)
class SurfaceInputs:
    """Everything a surface's job names, read: `files` are all of them."""

    name: str
    surface: Surface
    parts: tuple[MeasuredPoints, ...]
    options: SurfaceOptions
    program: Program | None
    cutter: SurfaceJob | None
    cad_file: str
    output_folder: Path
    files: tuple[Path, ...]


def read_surface_inputs(path: Path) -> SurfaceInputs:
    """Reads a job and what it names; paths are relative to the job file. Raises JOB, SRF and NC errors."""
    job = read_surface_job(path)
    points = _point_files(path, job)
    nominal = path.parent / job.surface.file
    program = path.parent / job.program.finish if job.program else None
    return SurfaceInputs(
        name=job.name,
        surface=read_nominal(nominal, job.surface.face, flip=job.surface.flip),
        parts=tuple(_part(file, job.gauging.ball_radius_mm) for file in points),
        options=options_of(job),
        program=None if program is None or job.program is None else _program(program, job.program.dialect),
        cutter=_cutter(job),
        cad_file=job.compensation.cad_file,
        output_folder=path.parent / job.output.folder,
        files=(path, nominal, *points, *([program] if program else [])),
    )


def read_nominal(path: Path, face: int | None, *, flip: bool) -> Surface:
    """The nominal surface: a face of a CAD file, or a CSV grid that the surface goes through."""
    if path.suffix.lower() == ".csv":
        points, shape = read_points(path)
        if shape is None:
            raise TrueloopError(
                Code.SRF_GRID,
                f"the {len(points)} points of {path.name!r} have no row and column",
                hint="a nominal surface is fitted to a grid: give row and column of each point",
                place=Place(str(path)),
            )
        surface = fit_grid(points.reshape(*shape, 3)).surface
    else:
        from trueloop.formats.cad import read_face  # slow to import

        surface = read_face(path, face).surface
    return surface.turned_over() if flip else surface


def options_of(job: SurfaceJobFile) -> SurfaceOptions:
    """The job's options in mm."""
    model, compensation = job.model, job.compensation
    return SurfaceOptions(
        best_fit=job.gauging.alignment == "best-fit",
        farthest_mm=job.gauging.farthest_mm,
        criterion=model.criterion,
        confidence=model.confidence,
        exponent=model.exponent,
        cells=model.cells,
        exclude=model.exclude,
        target_mm=model.target_um / UM_PER_MM,
        weight=compensation.weight,
        tolerance_mm=compensation.tolerance_um / UM_PER_MM,
        limits=Limits(
            correction_mm=compensation.max_correction_um / UM_PER_MM,
            slope=compensation.max_slope_um_per_mm / UM_PER_MM,
        ),
    )


def _cutter(job: SurfaceJobFile) -> SurfaceJob | None:
    if job.cutter is None:
        return None
    corner = job.cutter.radius_mm if job.cutter.corner_mm is None else job.cutter.corner_mm
    return SurfaceJob(
        Cutter(job.cutter.radius_mm, corner),
        job.cutter.axis,
        tolerance_mm=job.compensation.chord_um / UM_PER_MM,
        gouge_mm=job.compensation.gouge_um / UM_PER_MM,
        rotary=job.cutter.rotary,
    )


def _point_files(path: Path, job: SurfaceJobFile) -> list[Path]:
    """The files named, patterns like parts/*.csv filled in, in the order of their names."""
    found: list[Path] = []
    for name in job.gauging.points:
        found += sorted(path.parent.glob(str(name))) if "*" in str(name) else [path.parent / name]
    if not found:
        raise TrueloopError(
            Code.SRF_FILE,
            f"no file is like {', '.join(repr(str(name)) for name in job.gauging.points)}",
            hint="gauging.points names the files of the measured parts, relative to the job",
            place=Place(str(path)),
        )
    return found


def _part(path: Path, ball_radius_mm: float) -> MeasuredPoints:
    points, shape = read_points(path)
    return MeasuredPoints(points, ball_radius_mm, shape, path.stem)


def _program(path: Path, dialect: str) -> Program:
    source = read_input(path, Code.NC_FILE, hint="program.finish names the program that cut the parts")
    return read_program(source, dialect, str(path))
