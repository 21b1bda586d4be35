"""A surface's job read from its files."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from difflib import get_close_matches
from glob import glob
from pathlib import Path
from typing import TYPE_CHECKING

from trueloop.domain.limits import Limits
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_input
from trueloop.formats.jobs.surface_job import SurfaceJobFile, SurfaceProgramTable, read_surface_job
from trueloop.formats.measurements.points_csv import read_points
from trueloop.geometry.surface import Surface
from trueloop.geometry.surface_fit import fit_grid
from trueloop.jobs.user import user_name
from trueloop.loops.surface.figures import Trim
from trueloop.loops.surface.surface import SurfaceOptions
from trueloop.nc.program.guess import guess_dialect
from trueloop.nc.program.program import Program, read_program
from trueloop.surface.compensation.cutter import Cutter
from trueloop.surface.compensation.samples import SurfaceJob
from trueloop.surface.compensation.side import require_outer_side
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.formats.cad.step import CadFace


@dataclass(frozen=True, eq=False)
class SurfaceInputs:
    """Everything that a surface's `job` names, read: `files` are all of them, `sha256` their hashes by the job's names.

    `face` is the CAD file's, where the surface comes from one.
    """

    job: Path
    name: str
    surface: Surface
    parts: tuple[MeasuredPoints, ...]
    options: SurfaceOptions
    program: Program | None
    cutter: SurfaceJob | None
    cad_file: str
    output_folder: Path
    files: tuple[Path, ...]
    sha256: Mapping[str, str]
    nominal: Path
    face: "CadFace | None" = None
    measured_at: datetime | None = None
    program_sha256: str | None = None
    made_by: str = ""

    @property
    def trim(self) -> Trim | None:
        """Which points of the surface its face's trimming curves cut away."""
        return None if self.face is None else self.face.trimmed_away


def read_surface_inputs(path: Path, *, measured: bool = True) -> SurfaceInputs:
    """Reads a job and what it names; paths are relative to the job file. Raises JOB, SRF and NC errors.

    measured: False leaves the measured parts out, which then need not exist yet.
    """
    job = read_surface_job(path)
    points = _point_files(path, job) if measured else []
    nominal = path.parent / job.surface.file
    program = path.parent / job.program.finish if job.program else None
    surface, face = _nominal(nominal, job.surface.face, flip=job.surface.flip)
    files = (path, nominal, *points, *([program] if program else []))
    finish = None if program is None or job.program is None else _program(program, job.program)
    cutter = _cutter(job)
    if finish is not None and cutter is not None:
        with in_file(path):
            require_outer_side(finish, surface, cutter)
    parts = tuple(_part(file, job.gauging.ball_radius_mm) for file in points)
    hashes = {file: sha256_of(file.read_bytes()) for file in files}
    _require_measured_once(points, hashes)
    return SurfaceInputs(
        job=path,
        name=job.name,
        surface=surface,
        parts=parts,
        options=options_of(job),
        program=finish,
        cutter=cutter,
        cad_file=job.compensation.cad_file,
        output_folder=path.parent / job.output.folder,
        files=files,
        sha256={_named(file, path.parent): digest for file, digest in hashes.items()},
        nominal=nominal,
        face=face,
        measured_at=job.gauging.measured_at,
        program_sha256=job.gauging.program_sha256,
        made_by=user_name(),
    )


def read_nominal(path: Path, face: int | None, *, flip: bool) -> Surface:
    """The nominal surface: a face of a CAD file, or a CSV grid that the surface goes through."""
    return _nominal(path, face, flip=flip)[0]


def _nominal(path: Path, face: int | None, *, flip: bool) -> "tuple[Surface, CadFace | None]":
    if path.suffix.lower() == ".csv":
        grid = read_points(path)
        if grid.shape is None:
            raise TrueloopError(
                Code.SRF_GRID,
                f"the {len(grid.lines)} points of {path.name!r} have no row and column",
                hint="a nominal surface is fitted to a grid: give row and column of each point",
                place=Place(str(path)),
            )
        with in_file(path):
            surface, found = fit_grid(grid.points_mm.reshape(*grid.shape, 3)).surface, None
    else:
        from trueloop.formats.cad.step import read_face  # slow to import

        found = read_face(path, face)
        surface = found.surface
    return (surface.turned_over() if flip else surface), found


def options_of(job: SurfaceJobFile) -> SurfaceOptions:
    """The job's options in mm."""
    model, compensation = job.model, job.compensation
    return SurfaceOptions(
        best_fit=job.gauging.alignment == "best-fit",
        farthest_mm=job.gauging.farthest_mm,
        setup_mm=job.gauging.setup_mm,
        criterion=model.criterion,
        confidence=model.confidence,
        exponent=model.exponent,
        cells=model.cells,
        exclude=model.exclude,
        target_mm=model.target_um / UM_PER_MM,
        weight=compensation.weight,
        least_supported=compensation.min_supported_percent / 100,
        tolerance_mm=compensation.tolerance_um / UM_PER_MM,
        limits=Limits(
            correction_mm=compensation.max_correction_um / UM_PER_MM,
            slope=compensation.max_slope_um_per_mm / UM_PER_MM,
            scatter_mm=compensation.max_scatter_um / UM_PER_MM,
            age_hours=compensation.max_age_hours,
        ),
    )


def _named(file: Path, folder: Path) -> str:
    """As the job names it: relative to its folder, where it lies below it."""
    return file.relative_to(folder).as_posix() if file.is_relative_to(folder) else str(file)


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
    """The files named, patterns like parts/*.csv filled in, in the order of their names.

    Raises SRF-FILE for a pattern that no file is like, SRF-TWICE for two files of one name: parts go by it.
    """
    found: list[Path] = []
    for name in map(str, job.gauging.points):
        # Not `Path.glob`, which takes no absolute pattern.
        matching = sorted(glob(name, root_dir=path.parent, recursive=True)) if "*" in name else [name]  # noqa: PTH207
        if not matching:
            raise TrueloopError(
                Code.SRF_FILE,
                f"no file is like {name!r}",
                hint="gauging.points names the files of the measured parts, relative to the job",
                place=Place(str(path)),
            )
        found += [path.parent / file for file in matching]
    _require_different(found, path)
    _require_parts(job.model.exclude, [file.stem for file in found], path)
    return found


def _require_different(files: Sequence[Path], path: Path) -> None:
    by_name: dict[str, Path] = {}
    for file in files:
        if file.stem in by_name:
            raise TrueloopError(
                Code.SRF_TWICE,
                f"two of {len(files)} parts are called {file.stem!r}: {str(by_name[file.stem])!r} and {str(file)!r}",
                hint="name every part's file once in gauging.points, and no two alike: results go by their names",
                place=Place(str(path)),
            )
        by_name[file.stem] = file


def _require_measured_once(files: Sequence[Path], hashes: Mapping[Path, str]) -> None:
    """Raises SRF-TWICE for a copy under another name: it would count as a further part, and agree to the last digit."""
    by_hash: dict[str, Path] = {}
    for file in files:
        first = by_hash.setdefault(hashes[file], file)
        if first is not file:
            raise TrueloopError(
                Code.SRF_TWICE,
                f"two of {len(files)} parts are one: {first.name!r} and {file.name!r} have the same bytes",
                hint="leave the copy out of gauging.points",
                place=Place(str(file)),
            )


def _require_parts(excluded: Sequence[str], names: Sequence[str], path: Path) -> None:
    """Raises JOB-KEY for a part to leave out that is not there: mistyped, it would be left in."""
    for name in excluded:
        if name not in names:
            near = get_close_matches(name, names, n=1)
            raise TrueloopError(
                Code.JOB_KEY,
                f"'model.exclude' names {name!r}, which is none of the {len(names)} parts",
                hint=f"did you mean {near[0]!r}?" if near else f"the parts are {', '.join(names)}",
                place=Place(str(path)),
            )


def _part(path: Path, ball_radius_mm: float) -> MeasuredPoints:
    read = read_points(path)
    return MeasuredPoints(read.points_mm, ball_radius_mm, read.shape, path.stem, str(path), read.lines)


def _program(path: Path, table: SurfaceProgramTable) -> Program:
    source = read_input(path, Code.NC_FILE, hint="program.finish names the program that cut the parts")
    dialect = table.dialect or guess_dialect(source, str(path), 'program.dialect = "{}"')
    return read_program(source, dialect, str(path), table.unit, table.decimals)
