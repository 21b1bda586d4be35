"""Turned parts as a draughtsman leaves them: both halves, centre line, shoulders' edges, dimensions, text, layers."""

import math
from pathlib import Path
from typing import Any

import ezdxf.filemanagement
import numpy as np
import pytest
from ezdxf.document import Drawing

from tests.support.refusals import refused
from trueloop.errors import Code
from trueloop.formats.cad.dxf import read_dxf
from trueloop.geometry.feature import Arc, Line

SHAFT = [
    ((0.0, -60.0), (15.0, -60.0)),
    ((15.0, -60.0), (15.0, -40.0)),
    ((15.0, -40.0), (12.0, -40.0)),  # a shoulder, and a fillet of 2 mm into the neck
    ((10.0, -38.0), (10.0, -21.0)),
    ((10.0, -21.0), (9.0, -20.0)),  # a chamfer
    ((9.0, -20.0), (6.0, -20.0)),
    ((6.0, -20.0), (6.0, -6.0)),  # a dome of 6 mm ends it
]
"""Lines of the upper half, (x, z); arcs are drawn by hand below."""


def drawing(mirror: bool = True, y0: float = 0.0) -> Drawing:
    """A view of the shaft: silhouette of both halves, edges of shoulders, chamfer and fillet right across."""
    document = ezdxf.filemanagement.new("R2010", setup=True, units=4)
    document.layers.add("Kontur")
    space = document.modelspace()
    for k, (a, b) in enumerate(SHAFT):
        for side in (1, -1) if mirror else (1,):
            ends = [(z, y0 + side * x) for x, z in ((a, b) if k % 2 else (b, a))]
            space.add_line(ends[0], ends[1], dxfattribs={"layer": "Kontur"})
    for side in (1, -1) if mirror else (1,):
        fillet = ((-38.0, y0 + 12 * side), 2.0, *((180, 270) if side > 0 else (90, 180)))
        space.add_arc(fillet[0], fillet[1], fillet[2], fillet[3], dxfattribs={"layer": "KONTUR"})
    if mirror:
        space.add_arc((-6, y0), 6.0, -90, 90, dxfattribs={"layer": "Kontur"})
        for x, z in ((12.0, -40.0), (10.0, -38.0), (10.0, -21.0), (9.0, -20.0), (6.0, -6.0)):
            space.add_line((z, y0 - x), (z, y0 + x), dxfattribs={"layer": "Kontur"})
    else:
        space.add_arc((-6, y0), 6.0, 0, 90, dxfattribs={"layer": "Kontur"})
    space.add_line((-65, y0), (5, y0), dxfattribs={"linetype": "CENTER", "layer": "Mitte"})
    return document


def dimensioned(document: Drawing, y0: float = 0.0) -> Drawing:
    """Dimensions, once as such and once exploded into lines; text, a hidden bore, a frame, a layer that is off."""
    space = document.modelspace()
    space.add_linear_dim(base=(0, y0 + 30), p1=(-60, y0 + 15), p2=(0, y0)).render()
    for line in (((-60, y0 + 16), (-60, y0 + 41)), ((-20, y0 + 11), (-20, y0 + 41)), ((-60, y0 + 40), (-20, y0 + 40))):
        space.add_line(line[0], line[1], dxfattribs={"layer": "Masse"})
    space.add_line((12, y0 - 6), (12, y0 + 6), dxfattribs={"layer": "Masse"})  # a diameter
    space.add_text("%%c30 h6")
    space.add_line((-60, y0 + 4), (-30, y0 + 4), dxfattribs={"linetype": "DASHED"})
    space.add_lwpolyline([(-100, y0 - 80), (80, y0 - 80), (80, y0 + 80), (-100, y0 + 80)], close=True,
                         dxfattribs={"layer": "Rahmen"})  # fmt: skip
    document.layers.add("Alt").off()
    space.add_line((-60, y0 + 14), (0, y0 + 14), dxfattribs={"layer": "Alt"})
    return document


def is_the_shaft(features: Any) -> None:
    lines = [feature for feature in features if isinstance(feature, Line)]
    arcs = [feature for feature in features if isinstance(feature, Arc)]
    np.testing.assert_allclose([[*f.start_mm, *f.end_mm] for f in lines], [[*a, *b] for a, b in SHAFT], atol=1e-9)
    fillet, dome = arcs
    np.testing.assert_allclose([*fillet.centre_mm, fillet.sweep_rad], [12.0, -38.0, -math.pi / 2], atol=1e-9)
    np.testing.assert_allclose([*dome.end_mm, *dome.centre_mm, dome.sweep_rad], [0, 0, 0, -6, math.pi / 2], atol=1e-9)
    assert [type(f).__name__[0] for f in features] == list("LLLALLLLA")


def saved(document: Drawing, folder: Path) -> Path:
    document.saveas(folder / "part.dxf")
    return folder / "part.dxf"


@pytest.mark.parametrize("mirror", [True, False], ids=["view", "half"])
def test_the_outline_is_found_among_all_that_is_drawn(tmp_path: Path, mirror: bool) -> None:
    read = read_dxf(saved(drawing(mirror), tmp_path))
    is_the_shaft(read.features)
    assert not any("unlike" in note for note in read.notes)
    is_the_shaft(read_dxf(saved(drawing(mirror), tmp_path), layer="kontur").features)


def test_dimensions_text_hidden_edges_and_hidden_layers_are_no_outline(tmp_path: Path) -> None:
    """And the frame, which crosses the axis twice as the part does, but is a rectangle around it."""
    path = saved(dimensioned(drawing()), tmp_path)
    read = read_dxf(path)
    is_the_shaft(read.features)
    assert any("below the axis mirror those above" in note for note in read.notes)
    assert any(note.startswith("3 entities on hidden layers or not drawn in a continuous line") for note in read.notes)
    is_the_shaft(read_dxf(path, layer="KONTUR").features)
    refusal = refused(lambda: read_dxf(path, outline=3))
    assert refusal.code is Code.GEO_DXF_CHOICE and "--outline" in refusal.hint
    assert (
        "number 3 was asked for: 1: 9 features from x = 0.000 mm, z = -60.000 mm on KONTUR, Kontur" in refusal.message
    )


def test_a_part_drawn_above_its_sheet_s_zero_is_read_from_its_centre_line(tmp_path: Path) -> None:
    read = read_dxf(saved(drawing(y0=120.0), tmp_path))
    is_the_shaft(read.features)
    assert "The axis is the centre line at y = 120 mm; z is counted from x = 0 of the drawing." in read.notes


def test_a_centre_line_about_which_nothing_is_drawn_is_no_axis(tmp_path: Path) -> None:
    document = drawing(y0=120.0)
    document.modelspace().add_line((-65, 40), (5, 40), dxfattribs={"linetype": "CENTER"})
    is_the_shaft(read_dxf(saved(document, tmp_path)).features)


def test_a_lower_half_alone_is_turned_up_and_an_unlike_one_is_told(tmp_path: Path) -> None:
    document = ezdxf.filemanagement.new("R2010", units=4)
    document.modelspace().add_lwpolyline([(-40, -10), (-20, -10), (-20, -6), (0, -6)])
    document.modelspace().add_arc((0, 0), 6.0, 270, 360)
    below = read_dxf(saved(document, tmp_path))
    starts = [f.start_mm for f in below.features]
    np.testing.assert_allclose(starts, [(10.0, -40.0), (10.0, -20.0), (6.0, -20.0), (6.0, 0.0)], atol=1e-9)
    dome = below.features[-1]
    assert isinstance(dome, Arc) and dome.sweep_rad == pytest.approx(math.pi / 2)
    np.testing.assert_allclose(dome.end_mm, (0.0, 6.0), atol=1e-9)
    document.modelspace().add_lwpolyline([(-40, 10), (-20, 10), (-20, 8), (0, 8)])
    both = read_dxf(saved(document, tmp_path))
    assert both.features[-1].end_mm == (8.0, 0.0)
    assert "3 lines and arcs below the axis are unlike those above: the upper half counts." in both.notes
