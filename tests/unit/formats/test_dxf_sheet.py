"""Whole drawings by hand: sections with hatching, several views, border and title block, axes of either direction.

The bush: 60 mm long, outside 40 with a flange of 60, a bore of 20 with a chamfer of 2 x 45 degrees and a recess of 26.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import ezdxf.filemanagement
import numpy as np
import pytest
from ezdxf.document import Drawing

from tests.support.refusals import refused
from trueloop.errors import Code
from trueloop.formats.cad.dxf import DxfProfile, read_dxf
from trueloop.geometry.curve import Curve

XZ = tuple[float, float]
OUTSIDE: list[XZ] = [(10, -60), (30, -60), (30, -50), (20, -50), (20, 0), (12, 0)]
BORE: list[XZ] = [(12, 0), (10, -2), (10, -20), (13, -20), (13, -35), (10, -35), (10, -60)]
SHAFT: list[XZ] = [(0, -60), (15, -60), (15, -20), (9, -20), (9, 0), (0, 0)]


class Sheet:
    """A drawing, and a place and direction on it for every view."""

    def __init__(self, at: XZ = (0.0, 0.0), *, vertical: bool = False) -> None:
        self.document: Drawing = ezdxf.filemanagement.new("R2010", setup=True, units=4)
        self.space: Any = self.document.modelspace()
        self.at, self.vertical = at, vertical

    def place(self, x: float, z: float) -> XZ:
        """Of (x, z) counted from the view's axis; a vertical axis runs up."""
        return (self.at[0] - x, self.at[1] + z) if self.vertical else (self.at[0] + z, self.at[1] + x)

    def way(self, points: Sequence[XZ], **attributes: Any) -> "Sheet":
        for a, b in pairwise(points):
            self.space.add_line(self.place(*a), self.place(*b), dxfattribs=attributes)
        return self

    def both(self, points: Sequence[XZ], **attributes: Any) -> "Sheet":
        return self.way(points, **attributes).way([(-x, z) for x, z in points], **attributes)

    def hatch(self, points: Sequence[XZ], sides: Sequence[int] = (1, -1)) -> "Sheet":
        for side in sides:
            hatch = self.space.add_hatch(dxfattribs={"layer": "Schraffur"})
            hatch.set_pattern_fill("ANSI31", scale=0.5)
            hatch.paths.add_polyline_path([self.place(side * x, z) for x, z in points], is_closed=True)
        return self

    def axis(self, low: float = -65.0, high: float = 5.0) -> "Sheet":
        return self.way([(0.0, low), (0.0, high)], linetype="CENTER")

    def bush(self, *, hatched: bool = True, across: bool = True) -> "Sheet":
        """The section, with the edges of the bore seen behind the plane of it."""
        self.both([*OUTSIDE, *BORE]).axis()
        if hatched:
            self.hatch([*OUTSIDE, *BORE])
        for x, z in ((12, 0), (10, -2), (13, -20), (13, -35), (10, -60)) if across else ():
            self.way([(x, z), (-x, z)])
        return self

    def shaft(self) -> "Sheet":
        return self.both(SHAFT).way([(9, -20), (-9, -20)]).axis()

    def border(self) -> "Sheet":
        """A frame, and a title block with text."""
        self.space.add_lwpolyline([(-150, -100), (150, -100), (150, 110), (-150, 110)], close=True)
        for y in (-100, -90, -80):
            self.space.add_line((60, y), (150, y))
        self.space.add_line((60, -100), (60, -80))
        self.space.add_line((100, -100), (100, -80))
        self.space.add_text("Buchse 1:1").set_placement((62, -97))
        return self

    def saved(self, folder: Path) -> Path:
        self.document.saveas(folder / "part.dxf")
        return folder / "part.dxf"


def along(read: DxfProfile) -> list[XZ]:
    return [read.features[0].start_mm, *(feature.end_mm for feature in read.features)]


def is_the_bush(path: Path, at_z: float = 0.0, **options: Any) -> None:
    for side, way in (("outside", OUTSIDE), ("inside", BORE)):
        read = read_dxf(path, side=side, **options)  # type: ignore[arg-type]
        np.testing.assert_allclose(along(read), [(x, z + at_z) for x, z in way], atol=1e-9)


@pytest.mark.parametrize("across", [True, False], ids=["edges behind", "no edges behind"])
def test_a_hatched_section_gives_outside_and_bore(tmp_path: Path, across: bool) -> None:
    is_the_bush(Sheet().bush(across=across).saved(tmp_path))


def test_a_vertical_axis_points_up(tmp_path: Path) -> None:
    path = Sheet((70.0, 20.0), vertical=True).bush().saved(tmp_path)
    is_the_bush(path, at_z=20.0)
    assert "The axis is the centre line at x = 70 mm; z is counted upwards" in " ".join(read_dxf(path).notes)


def test_a_whole_sheet_with_border_dimensions_and_an_end_view(tmp_path: Path) -> None:
    """Frame, title block, dimensions, bolt holes with their own centre lines, a view along the axis."""
    sheet = Sheet((-20.0, 40.0)).bush().border()
    for x in (25.0, -25.0):
        sheet.way([(x + 2, -60), (x + 2, -50)]).way([(x - 2, -60), (x - 2, -50)])
        sheet.way([(x, -63), (x, -47)], linetype="CENTER")
    sheet.space.add_linear_dim(base=(-20, 85), p1=(-80, 70), p2=(-20, 60)).render()
    for x0, x1 in (((100.0 - 35), 100.0 + 35),):
        sheet.space.add_line((x0, 40), (x1, 40), dxfattribs={"linetype": "CENTER"})
        sheet.space.add_line((100, 5), (100, 75), dxfattribs={"linetype": "CENTER"})
    for radius in (30, 20, 12):
        sheet.space.add_circle((100, 40), radius)
    path = sheet.saved(tmp_path)
    is_the_bush(path, at_z=-20.0)
    notes = " ".join(read_dxf(path).notes)
    assert "The axis is the centre line at y = 40 mm" in notes and "a hole's" in notes


def test_two_views_of_one_part_are_one_contour(tmp_path: Path) -> None:
    """A section, and beside it the part from outside: the same outside, once; its bore from the section."""
    sheet = Sheet((-20.0, 40.0)).bush()
    sheet.at = (-20.0, -60.0)
    sheet.both([(0, -60), *OUTSIDE[1:5], (0, 0)]).axis()
    sheet.way([(20, -50), (-20, -50)])
    path = sheet.saved(tmp_path)
    is_the_bush(path, at_z=-20.0)
    assert "1 contours are drawn again in another view." in read_dxf(path).notes


@pytest.mark.parametrize(("zero", "at_z"), [("free-end", 0.0), ("chuck-end", 60.0), ("drawing", -20.0)])
def test_z_counts_from_an_end_of_the_part_or_from_the_sheet(tmp_path: Path, zero: str, at_z: float) -> None:
    is_the_bush(Sheet((-20.0, 40.0)).bush().border().saved(tmp_path), at_z=at_z, zero=zero)


def test_the_lower_half_may_be_the_section(tmp_path: Path) -> None:
    """From outside above, in section below: the outside of both, the bore of the lower one."""
    sheet = Sheet().both([(0, -60), *OUTSIDE[1:5], (0, 0)]).axis().hatch([*OUTSIDE, *BORE], sides=(-1,))
    sheet.way([(20, -50), (0, -50)]).way([(-x, z) for x, z in BORE])
    for x, z in BORE[1:5]:
        sheet.way([(0, z), (-x, z)])
    path = sheet.saved(tmp_path)
    np.testing.assert_allclose(along(read_dxf(path)), [(0, -60), *OUTSIDE[1:5], (0, 0)], atol=1e-9)
    np.testing.assert_allclose(along(read_dxf(path, side="inside")), BORE, atol=1e-9)


def test_a_hatch_without_an_outline_is_passed_over(tmp_path: Path) -> None:
    sheet = Sheet().bush()
    sheet.space.add_hatch().paths.add_edge_path()
    is_the_bush(sheet.saved(tmp_path))


def test_a_section_without_hatching_is_told_by_its_lines(tmp_path: Path) -> None:
    """The end faces then begin at the axis, as in a view from outside, where the same lines are a thread's."""
    path = Sheet().bush(hatched=False).saved(tmp_path)
    bore = read_dxf(path, side="inside")
    np.testing.assert_allclose(along(bore), BORE, atol=1e-9)
    assert any(note.startswith("Nothing is hatched") for note in bore.notes)
    assert along(read_dxf(path))[0] == (0.0, -60.0)


def test_hidden_edges_are_a_bore_where_no_other_is_drawn(tmp_path: Path) -> None:
    """A blind bore of 8 mm, 25 deep, drawn dashed in a view from outside."""
    blind: list[XZ] = [(4, 0), (4, -25), (0, -25 - 4 * math.tan(math.radians(31)))]
    path = Sheet().shaft().both(blind, linetype="HIDDEN").saved(tmp_path)
    bore = read_dxf(path, side="inside")
    np.testing.assert_allclose(along(bore), blind, atol=1e-9)
    assert any(note.startswith("Hidden (dashed) edges were read") for note in bore.notes)
    np.testing.assert_allclose(along(read_dxf(path)), SHAFT, atol=1e-9)


def test_without_a_centre_line_both_halves_show_the_axis(tmp_path: Path) -> None:
    sheet = Sheet((0.0, 50.0)).both(SHAFT).way([(9, -20), (-9, -20)])
    read = read_dxf(sheet.saved(tmp_path))
    np.testing.assert_allclose(along(read), SHAFT, atol=1e-9)
    assert any("The axis is the mirror line of both halves at y = 50 mm" in note for note in read.notes)


def test_a_rectangle_off_the_axis_is_a_bar_or_a_ring_and_is_asked_for(tmp_path: Path) -> None:
    sheet = Sheet()
    sheet.space.add_lwpolyline([(-40, 10), (0, 10), (0, 15), (-40, 15)], close=True)
    path = sheet.saved(tmp_path)
    refusal = refused(read_dxf, path)
    assert refusal.code is Code.GEO_DXF_CHOICE and "2 separate chains" in refusal.message
    found = {tuple(map(tuple, np.round(along(read_dxf(path, outline=k)), 6).tolist())) for k in (1, 2)}
    assert found == {((0, -40), (2.5, -40), (2.5, 0), (0, 0)), ((10, -40), (15, -40), (15, 0), (10, 0))}


def test_two_parts_on_one_sheet_are_asked_for_in_their_order(tmp_path: Path) -> None:
    sheet = Sheet((-20.0, 40.0)).bush()
    sheet.at = (80.0, 40.0)
    path = sheet.shaft().saved(tmp_path)
    refusal = refused(read_dxf, path)
    assert refusal.code is Code.GEO_DXF_CHOICE and refusal.message.count(" features from x = ") == 2
    np.testing.assert_allclose(along(read_dxf(path, outline=1)), [(x, z - 20) for x, z in OUTSIDE], atol=1e-9)
    np.testing.assert_allclose(along(read_dxf(path, outline=2)), [(x, z + 80) for x, z in SHAFT], atol=1e-9)
    assert any("Another contour is there, number 2" in note for note in read_dxf(path, outline=1).notes)


def test_a_view_in_a_block_is_read_in_its_place(tmp_path: Path) -> None:
    sheet = Sheet()
    block, space = sheet.document.blocks.new("view"), sheet.space
    sheet.space = block
    sheet.bush()
    sheet.space = space
    space.add_blockref("view", (15, 0), dxfattribs={"layer": "Ansicht"})
    is_the_bush(sheet.saved(tmp_path), at_z=15.0)


@pytest.mark.parametrize("kind", ["ellipse", "spline"])
def test_an_elliptic_end_is_a_curve(tmp_path: Path, kind: str) -> None:
    """Semi-axes 8 along z and 15 across: x²/15² + (z + 8)²/8² = 1, drawn as an ellipse or as its rational spline."""
    from ezdxf.math import BSpline, ConstructionEllipse

    sheet = Sheet().way([(0, -60), (15, -60), (15, -8)]).axis()
    ellipse = ConstructionEllipse((-8, 0), (0, 15), ratio=8 / 15, start_param=-math.pi / 2, end_param=0)
    if kind == "ellipse":
        sheet.space.add_ellipse((-8, 0), (0, 15), 8 / 15, -math.pi / 2, 0)
    else:
        sheet.space.add_spline().apply_construction_tool(BSpline.from_ellipse(ellipse))
    read = read_dxf(sheet.saved(tmp_path))
    curve = read.features[-1]
    assert isinstance(curve, Curve) and curve.name == "curve-1"
    x, z = curve.point_mm(np.linspace(0, curve.length_mm, 101)).T
    np.testing.assert_allclose((x / 15) ** 2 + ((z + 8) / 8) ** 2, 1.0, atol=1e-9)
    np.testing.assert_allclose([curve.start_mm, curve.end_mm], [(15, -8), (0, 0)], atol=1e-9)


def test_a_ring_s_half_section_gives_both_sides(tmp_path: Path) -> None:
    sheet = Sheet()
    sheet.space.add_lwpolyline([(0, 5), (-40, 5), (-40, 10), (-20, 12)], close=True)
    path = sheet.saved(tmp_path)
    np.testing.assert_allclose(along(read_dxf(path)), [(5, -40), (10, -40), (12, -20), (5, 0)], atol=1e-9)
    np.testing.assert_allclose(along(read_dxf(path, side="inside")), [(5, 0), (5, -40)], atol=1e-9)


def test_a_bore_drawn_alone_runs_from_the_free_end(tmp_path: Path) -> None:
    path = Sheet().way(BORE[::-1]).saved(tmp_path)
    np.testing.assert_allclose(along(read_dxf(path, side="inside")), BORE, atol=1e-9)
    np.testing.assert_allclose(along(read_dxf(path)), BORE[::-1], atol=1e-9)


def test_a_solid_part_has_no_bore(tmp_path: Path) -> None:
    refusal = refused(lambda: read_dxf(Sheet().shaft().saved(tmp_path), side="inside"))
    assert refusal.code is Code.GEO_DXF_CHOICE and "none of that side" in refusal.message
