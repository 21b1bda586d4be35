"""Surfaces that the commands write as CAD files, trimmed as the nominal face."""

from typing import TYPE_CHECKING

from trueloop.errors import Code, TrueloopError

if TYPE_CHECKING:
    from trueloop.formats.outputs import Named
    from trueloop.geometry.surface import Surface
    from trueloop.loops.surface.inputs import SurfaceInputs
    from trueloop.loops.surface.surface import SurfaceModel
    from trueloop.surface.compensation.pattern import WrittenPattern


def trimmed_file(inputs: "SurfaceInputs", surface: "Surface", name: str, mark: str) -> "tuple[Named, list[str]]":
    """A surface as the file `name`, STEP or IGES by its ending, and a note where it had to be left whole."""
    from trueloop.formats.cad.step import surface_to_bytes

    ending, loops = name.rpartition(".")[2], inputs.face.loops if inputs.face else ()
    try:
        return (name, surface_to_bytes(surface, ending, mark, loops)), []
    except TrueloopError as error:
        if error.code is not Code.SRF_TRIM:
            raise
        note = f"{name} is the whole patch, not trimmed: {error.message}"
        return (name, surface_to_bytes(surface, ending, mark)), [note]


def pattern_files(
    inputs: "SurfaceInputs", found: "SurfaceModel", magnify: float
) -> "tuple[list[Named], list[WrittenPattern], list[str]]":
    """Nominal and pattern as STEP and IGES, in true size and magnified, and what they hold; a note instead where there
    is no CAD kernel.
    """
    from trueloop.surface.compensation.pattern import WrittenPattern, pattern_surface

    files, written, notes = list["Named"](), list[WrittenPattern](), list[str]()
    try:
        for factor, name in ((1.0, "pattern"), (magnify, f"pattern-x{magnify:g}")):
            made = pattern_surface(found.surface, found.pattern.mean, factor, found.options.tolerance_mm)
            mark = f"trueloop: nominal + {factor:g} x machining pattern, not to be cut"
            written.append(WrittenPattern((f"{name}.step", f"{name}.iges"), factor, made))
            for file_name in written[-1].files:
                file, note = trimmed_file(inputs, made.surface, file_name, mark)
                files.append(file)
                notes += note
    except TrueloopError as error:
        if error.code is not Code.SRF_CAD_KERNEL:
            raise
        return [], [], [f"the pattern was not written as STEP and IGES: {error.message}; {error.hint}"]
    return files, written, notes
