"""What is written of a machining pattern, beside CAD files: its figures, a page, maps."""

from collections.abc import Sequence

from trueloop.formats.measurements.surface_csv import maps_to_csv, pattern_to_json
from trueloop.formats.outputs import Named
from trueloop.loops.surface.surface import SurfaceCorrection, SurfaceModel, maps_of
from trueloop.report.surface.page import maps_picture, surface_page
from trueloop.surface.compensation.pattern import WrittenPattern


def report_files(
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
