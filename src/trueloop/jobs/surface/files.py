"""What a surface's job writes: surfaces as CAD files, trimmed as the nominal face; the program, pages, maps, record."""

from collections.abc import Sequence
from pathlib import Path

from trueloop.domain.record import MARK
from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.surface_csv import maps_to_csv, pattern_to_json
from trueloop.formats.outputs import Named
from trueloop.geometry.surface import Surface
from trueloop.jobs.surface.job import ReadSurface
from trueloop.loops.surface.correction import RecordedCorrection
from trueloop.loops.surface.surface import SurfaceCorrection, SurfaceModel, maps_of
from trueloop.report.surface.page import maps_picture, surface_page
from trueloop.surface.compensation.pattern import WrittenPattern, pattern_surface


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
    if read.cad_file != "none":
        mark = f"{MARK}: record {done.record.id}"
        files, notes = _trimmed_file(read, correction.surface.surface, f"corrected.{read.cad_file}", mark)
    if correction.program is not None and read.inputs.program is not None:
        files.append((f"corrected{Path(str(read.inputs.program.file)).suffix}", correction.program.source))
    files += _report_files(read.inputs.name, correction.model, correction)
    return [*files, ("record.json", done.record.to_json().encode())], notes


def pattern_files(read: ReadSurface, found: SurfaceModel, magnify: float) -> tuple[list[Named], list[str]]:
    """Returns all files of a pattern; a note where there is no CAD kernel, and so no CAD files."""
    cad, written, notes = _cad_files(read, found, magnify)
    return [*cad, *_report_files(read.inputs.name, found, written=written)], notes


def _cad_files(
    read: ReadSurface, found: SurfaceModel, magnify: float
) -> tuple[list[Named], list[WrittenPattern], list[str]]:
    """Nominal and pattern as STEP and IGES, in true size and magnified, and what they hold."""
    files, written, notes = list[Named](), list[WrittenPattern](), list[str]()
    try:
        for factor, name in ((1.0, "pattern"), (magnify, f"pattern-x{magnify:g}")):
            made = pattern_surface(found.surface, found.pattern.mean, factor, found.options.tolerance_mm)
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
    name: str,
    found: SurfaceModel,
    correction: SurfaceCorrection | None = None,
    written: Sequence[WrittenPattern] = (),
) -> list[Named]:
    """pattern.json, pattern.html, maps.svg, and the maps of every part."""
    return [
        ("pattern.json", pattern_to_json(found.pattern)),
        ("pattern.html", surface_page(name, found, correction, written).encode()),
        ("maps.svg", maps_picture(found).encode()),
        *((f"{maps.name}-maps.csv", maps_to_csv(maps, normal)) for maps, normal in maps_of(found)),
    ]


def _trimmed_file(read: ReadSurface, surface: Surface, name: str, mark: str) -> tuple[list[Named], list[str]]:
    """A surface as the file `name`, STEP or IGES by its ending, and a note where it had to be left whole."""
    from trueloop.formats.cad.step import surface_to_bytes  # slow to import

    ending, loops = name.rpartition(".")[2], read.face.loops if read.face else ()
    try:
        return [(name, surface_to_bytes(surface, ending, mark, loops))], []
    except TrueloopError as error:
        if error.code is not Code.SRF_TRIM:
            raise
        note = f"{name} is the whole patch, not trimmed: {error.message}"
        return [(name, surface_to_bytes(surface, ending, mark))], [note]
