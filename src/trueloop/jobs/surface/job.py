"""A surface's job: read with the files it names, worked off, its record signed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

from trueloop.domain.option import Limits
from trueloop.domain.record import MARK, check_uncorrected, sha256_of
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import FilePath, read_input
from trueloop.formats.jobs.surface_job import SurfaceJobFile, SurfaceProgramTable, read_surface_job
from trueloop.formats.measurements.surface_csv import maps_to_csv, pattern_to_json, read_points
from trueloop.formats.outputs import Named
from trueloop.formats.record_file import read_record
from trueloop.formats.toml_tables import options_from
from trueloop.geometry.surface import Surface, fit_grid
from trueloop.jobs.surface.cut_with import named_in, require_stated, with_cut
from trueloop.jobs.surface.points import inspection_of, point_files, read_measured, require_measured_once
from trueloop.jobs.turned.cut_with import GIVEN
from trueloop.jobs.user import user_name
from trueloop.loops.surface.compare import Comparison, group_of, require_comparable
from trueloop.loops.surface.correction import RecordedCorrection, SurfaceInputs, correct_parts, pattern_of_inputs
from trueloop.loops.surface.surface import HERE, Part, SurfaceCorrection, SurfaceModel, Work, maps_of
from trueloop.nc.program.guess import guess_dialect
from trueloop.nc.program.program import Program, read_program
from trueloop.report.surface.page import maps_picture, surface_page
from trueloop.surface.compensation.cutter import Cutter
from trueloop.surface.compensation.placed import require_outer_side
from trueloop.surface.compensation.shift import SurfaceJob, WrittenPattern, pattern_surface
from trueloop.surface.options import SurfaceOptions

if TYPE_CHECKING:
    from trueloop.formats.cad.step import CadFace


@dataclass(frozen=True, eq=False)
class ReadSurface:
    """A surface's job as values, and what it was read from: `files` are all inputs.

    `faces` are the CAD file's, where the surface comes from one; `store_db` is the store that the job names;
    `cut_stated`: the job states what cut the parts.
    """

    inputs: SurfaceInputs
    job: Path
    nominal: Path
    files: tuple[Path, ...]
    output_folder: Path
    cad_file: str
    faces: "tuple[CadFace, ...]" = ()
    store_db: str = ""
    cut_stated: bool = False


def read_surface(path: FilePath, *, measured: bool = True) -> ReadSurface:
    """Reads a job and what it names; paths are relative to the job file. Raises JOB, SRF and NC errors.

    measured: False leaves the measured parts out, which then need not exist yet.

    >>> job = trueloop.read_surface(trueloop.example("surface/surface.toml"))
    >>> job.inputs.name, len(job.inputs.parts), len(job.inputs.parts[0].points_mm)
    ('Wave, 50 × 50 mm', 10, 625)
    """
    path = Path(path)
    job = read_surface_job(path)
    points = point_files(path, job) if measured else []
    nominal = path.parent / job.surface.file
    program = path.parent / job.program.finish if job.program else None
    nominals = _nominals(nominal, job.surface.face, flip=job.surface.flip)
    stated = job.gauging.cut_with if measured else ""
    record = [path.parent / stated] if stated not in ("", GIVEN) else []
    for file in record:
        read_record(file)
    files = (path, nominal, *points, *([program] if program else []), *record)
    finish = None if program is None or job.program is None else _program(program, job.program)
    cutter = _cutter(job)
    if finish is not None and cutter is not None:
        with in_file(path):
            for (surface, _), of_tool in product(nominals, cutter.by_tool):
                require_outer_side(finish, surface, of_tool)
    faces = [
        SurfaceInputs(
            name=job.name,
            surface=surface,
            parts=(),
            options=options_of(job),
            program=finish,
            cutter=cutter,
            sha256={},
            trim=None if cad is None else cad.trimmed_away,
            beside=() if cad is None else cad.others,
            program_sha256=job.gauging.program_sha256,
            face=None if cad is None or len(nominals) == 1 else cad.number,
            group=0 if cad is None else cad.group,
        )
        for surface, cad in nominals
    ]
    measured_on = [read_measured(file, job, faces) for file in points]
    hashes = {file: sha256_of(file.read_bytes()) for file in files}
    require_measured_once(points, hashes)
    for file in points:
        if hashes[file] == hashes[nominal]:
            raise Code.SRF_FILE.refusal(
                f"{file.name!r} is the nominal surface {nominal.name!r} itself, no measured part",
                hint="leave it out of gauging.points",
                place=Place(str(path)),
            )
    sha256 = {named_in(path.parent, file): digest for file, digest in hashes.items()}
    first, *further = (
        replace(face, parts=tuple(of_faces[k] for of_faces in measured_on), sha256=sha256)
        for k, face in enumerate(faces)
    )
    inspections = tuple(
        inspection_of(job, of_faces, hashes[file]) for file, of_faces in zip(points, measured_on, strict=True)
    )
    inputs = replace(first, inspections=inspections, further=tuple(further))
    folder, cad_file = path.parent / job.output.folder, job.compensation.cad_file
    given = bool(stated) or (finish is not None and job.gauging.program_sha256 is not None)
    inputs = with_cut(inputs, path, stated, nominal)
    return ReadSurface(
        inputs=inputs,
        job=path,
        nominal=nominal,
        files=files,
        output_folder=folder,
        cad_file=cad_file,
        faces=tuple(cad for _, cad in nominals if cad is not None),
        store_db=job.store.db,
        cut_stated=given,
    )


def correct_surface(read: ReadSurface, *, work: Work = HERE) -> RecordedCorrection:
    """The correction of a job, and its record. Raises SRF, NC and CMP errors for what cannot or must not be corrected,
    CMP-TWICE for a nominal surface that is a corrected one.

    >>> job = trueloop.read_surface(trueloop.example("surface/surface.toml"))
    >>> given = replace(job.inputs, parts=job.inputs.parts[:3])
    >>> done = trueloop.correct_surface(replace(job, inputs=given))
    >>> print(f"moved by up to {1e3 * done.correction.surface.largest_shift_mm:.1f} µm")
    moved by up to 15.0 µm
    >>> done.correction.program.cutting_moves, len(done.notes)
    (2925, 1)
    """
    with in_file(read.nominal):
        check_uncorrected(read.nominal.read_bytes(), "surface")
    require_cut_stated(read)
    with in_file(read.job):
        done = correct_parts(read.inputs, datetime.now(UTC), work=work)
    return replace(done, record=replace(done.record, made_by=user_name()))


def require_cut_stated(read: ReadSurface) -> None:
    """Raises CMP-CUT-WITH where a correction beside the job may have cut its parts, and the job states nothing."""
    if not read.cut_stated:
        require_stated(read.inputs, read.job, read.output_folder, read.nominal)


def pattern_of_parts(read: ReadSurface, parts: Sequence[Part]) -> SurfaceModel:
    """The machining pattern of a job's parts, corrected by nothing yet. Raises SRF-PARTS for too few.

    >>> job = trueloop.read_surface(trueloop.example("surface/surface.toml"))
    >>> given = replace(job.inputs, parts=job.inputs.parts[:3])
    >>> found = trueloop.pattern_of_parts(job, trueloop.model_of(given.surface, given.parts, given.options))
    >>> print(f"pattern up to {1e3 * found.figures.largest_mm:.1f} µm, ± {1e3 * found.figures.uncertainty_mm:.1f} µm")
    pattern up to 15.0 µm, ± 1.9 µm
    """
    with in_file(read.job):
        return pattern_of_inputs(read.inputs, parts)


def compare_jobs(before: ReadSurface, after: ReadSurface, work: Work = HERE) -> Comparison:
    """Takes both jobs' parts apart. Raises SRF-COMPARE: other surface or alignment, SRF-PARTS: none."""
    with in_file(after.job):
        require_comparable(require_one_face(before).inputs, require_one_face(after).inputs)
    groups = []
    for read in (before, after):
        with in_file(read.job):
            groups.append(group_of(read.inputs, work))
    return Comparison(before.inputs.surface, *groups)


def read_nominal(path: Path, face: int | None, *, flip: bool) -> Surface:
    """Reads the nominal surface: a face of a CAD file, or a CSV grid that the surface goes through."""
    return _nominals(path, face, flip=flip)[0][0]


def require_one_face(read: ReadSurface) -> ReadSurface:
    """Returns a job that names one face. Raises SRF-CAD-CHOICE for several: `compensate` alone takes them."""
    if read.inputs.further:
        numbers = [face.face for face in read.inputs.faces]
        raise Code.SRF_CAD_CHOICE.refusal(
            f"surface.face names {len(numbers)} faces, {numbers}: here one is looked at",
            hint="name one of them; `trueloop surface compensate` takes several, with --no-store",
            place=Place(str(read.job)),
            values={"file": read.nominal.name, "faces": len(numbers)},
        )
    return read


def _nominals(
    path: Path, face: int | tuple[int, ...] | None, *, flip: bool
) -> "Sequence[tuple[Surface, CadFace | None]]":
    """Returns the surface of every face that the job names, with the face where a CAD file has it."""
    numbers = face if isinstance(face, tuple) else (face,)
    if len(set(numbers)) < len(numbers):
        raise Code.JOB_KEY.refusal(
            f"'surface.face' names a face twice: {list(numbers)}",
            hint="name every face once",
            values={"key": "surface.face"},
        )
    if path.suffix.lower() != ".csv":
        from trueloop.formats.cad.step import named_faces  # slow to import

        return [(cad.surface.turned_over() if flip else cad.surface, cad) for cad in named_faces(path, numbers)]
    if len(numbers) > 1:
        raise Code.SRF_CAD_CHOICE.refusal(
            f"{path.name!r} is a grid of points, 1 surface, and surface.face names {len(numbers)} faces",
            hint="leave surface.face out, or name the part's STEP or IGES in surface.file",
            place=Place(str(path)),
            values={"file": path.name, "faces": 1},
        )
    grid = read_points(path)
    if grid.shape is None:
        raise Code.SRF_GRID.refusal(
            f"the {len(grid.lines)} points of {path.name!r} have no row and column",
            hint="a nominal surface is fitted to a grid: give row and column of each point",
            place=Place(str(path)),
        )
    with in_file(path):
        surface = fit_grid(grid.points_mm.reshape(*grid.shape, 3)).surface
    return [(surface.turned_over() if flip else surface, None)]


def options_of(job: SurfaceJobFile) -> SurfaceOptions:
    """Returns the job's options in mm."""
    best_fit = job.gauging.alignment == "best-fit"
    return options_from(SurfaceOptions, job, best_fit=best_fit, limits=options_from(Limits, job))


def _cutter(job: SurfaceJobFile) -> SurfaceJob | None:
    keys = {"parameters", "accept_unknown_words", "zero_mm", "work_offsets"}
    of_program = job.program.model_dump(include=keys) if job.program else {}
    by_tool = [
        options_from(
            SurfaceJob,
            job,
            cutter=Cutter(table.radius_mm, table.radius_mm if table.corner_mm is None else table.corner_mm),
            axis=table.axis,
            rotary=table.rotary,
            tool=table.tool,
            **of_program,
        )
        for table in job.cutters
    ]
    return replace(by_tool[0], further=tuple(by_tool[1:])) if by_tool else None


def _program(path: Path, table: SurfaceProgramTable) -> Program:
    source = read_input(path, Code.NC_FILE, hint="program.finish names the program that cut the parts")
    dialect = table.dialect or guess_dialect(source, str(path), 'program.dialect = "{}"')
    return read_program(source, dialect, str(path), table.unit, table.decimals)


def corrected_files(read: ReadSurface, done: RecordedCorrection) -> tuple[list[Named], list[str]]:
    """All files of a correction, the record last: then its set is complete. A note where the corrected surface had to
    be left whole.

    >>> job = trueloop.read_surface(trueloop.example("surface/surface.toml"))
    >>> given = replace(job.inputs, parts=job.inputs.parts[:3], program=None)
    >>> files, notes = trueloop.corrected_files(job, trueloop.correct_surface(replace(job, inputs=given)))
    >>> [name for name, _ in files][:3]
    ['corrected.step', 'pattern.json', 'pattern.html']
    >>> trueloop.write_all("surface", files, inputs=job.files)[-1].name  # as the command writes them, all or none
    'record.json'
    """
    files, notes, correction = list[Named](), list[str](), done.correction
    for k, face in enumerate(correction.faces if read.cad_file != "none" else ()):
        mark, name = f"{MARK}: record {done.record.id}", f"corrected{_of(face.model)}.{read.cad_file}"
        written, note = _trimmed_file(read, face.surface.surface, name, mark, k)
        files += written
        notes += note
    if correction.program is not None and read.inputs.program is not None:
        files.append((f"corrected{Path(str(read.inputs.program.file)).suffix}", correction.program.source))
    for face in correction.faces:
        files += _report_files(read.inputs.name, face.model, replace(face, program=correction.program))
    return [*files, ("record.json", done.record.to_json().encode())], notes


def pattern_files(read: ReadSurface, model: SurfaceModel, magnify: float) -> tuple[list[Named], list[str]]:
    """Returns all files of a pattern; a note where there is no CAD kernel, and so no CAD files."""
    cad, written, notes = _cad_files(read, model, magnify)
    return [*cad, *_report_files(read.inputs.name, model, written=written)], notes


def _cad_files(
    read: ReadSurface, model: SurfaceModel, magnify: float
) -> tuple[list[Named], list[WrittenPattern], list[str]]:
    """Nominal and pattern as STEP and IGES, in true size and magnified, and what they hold."""
    files, written, notes = list[Named](), list[WrittenPattern](), list[str]()
    try:
        for factor, name in ((1.0, "pattern"), (magnify, f"pattern-x{magnify:g}")):
            made = pattern_surface(model.surface, model.pattern.mean, factor, model.options.tolerance_mm)
            mark = f"trueloop: nominal + {factor:g} x machining pattern, not to be cut"
            written.append(WrittenPattern((f"{name}.step", f"{name}.iges"), factor, made))
            for file_name in written[-1].files:
                file, note = _trimmed_file(read, made.surface, file_name, mark)
                files += file
                notes += note
    except TrueloopError as error:
        if error.code is not Code.SRF_CAD_KERNEL:
            raise
        return [], [], [f"the pattern was not written as STEP and IGES: {error.message}; {error.hint}"]
    return files, written, notes


def _report_files(
    name: str, model: SurfaceModel, correction: SurfaceCorrection | None = None, written: Sequence[WrittenPattern] = ()
) -> list[Named]:
    """pattern.json, pattern.html, maps.svg, and the maps of every part."""
    of_face, title = _of(model), name if model.face is None else f"{name}, face {model.face}"
    return [
        (f"pattern{of_face}.json", pattern_to_json(model.pattern)),
        (f"pattern{of_face}.html", surface_page(title, model, correction, written).encode()),
        (f"maps{of_face}.svg", maps_picture(model).encode()),
        *((f"{maps.name}-maps{of_face}.csv", maps_to_csv(maps, normal)) for maps, normal in maps_of(model)),
    ]


def _of(model: SurfaceModel) -> str:
    """Returns what the names of a face's files have in them, where the job names several."""
    return "" if model.face is None else f"-face-{model.face}"


def _trimmed_file(
    read: ReadSurface, surface: Surface, name: str, mark: str, face: int = 0
) -> tuple[list[Named], list[str]]:
    """A surface as the file `name`, STEP or IGES by its ending, and a note where it had to be left whole."""
    from trueloop.formats.cad.step import surface_to_bytes  # slow to import

    ending, loops = name.rpartition(".")[2], read.faces[face].loops if read.faces else ()
    try:
        return [(name, surface_to_bytes(surface, ending, mark, loops))], []
    except TrueloopError as error:
        if error.code is not Code.SRF_TRIM:
            raise
        note = f"{name} is the whole patch, not trimmed: {error.message}"
        return [(name, surface_to_bytes(surface, ending, mark))], [note]
