"""Profiles from drawings: polylines with bulges, loose entities, units, orientation, and drawings that are refused."""

import math
import random
from pathlib import Path
from typing import Any

import ezdxf.filemanagement
import numpy as np
import pytest
from ezdxf.document import Drawing
from hypothesis import given

from tests.support.profiles import facetst, modbas2, piecs11, profiles
from trueloop.errors import Code, TrueloopError
from trueloop.formats.cad.dxf import DxfProfile, read_dxf
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile

MM, INCH, NO_UNIT = 4, 1, 0


def drawing(units: int = MM) -> Drawing:
    return ezdxf.filemanagement.new("R2010", units=units)


def bulges(features: tuple[Feature, ...], scale: float = 1.0) -> list[tuple[float, float, float]]:
    """Vertices (x, y, bulge) of a polyline: the bulge is tan(sweep/4), positive counter-clockwise."""
    vertices = []
    for feature in features:
        x, z = feature.start_mm
        bulge = -math.tan(feature.sweep_rad / 4) if isinstance(feature, Arc) else 0.0
        vertices.append((z * scale, x * scale, bulge))
    x, z = features[-1].end_mm
    return [*vertices, (z * scale, x * scale, 0.0)]


def add_loose(space: Any, features: tuple[Feature, ...], layers: dict[str, str] | None = None) -> None:
    """Lines and arcs in random order and direction, as a draughtsman leaves them."""
    shuffled = list(features)
    random.Random(7).shuffle(shuffled)
    for i, feature in enumerate(shuffled):
        attributes = {"layer": (layers or {}).get(feature.name, "0")}
        ends = [(z, x) for x, z in (feature.start_mm, feature.end_mm)]
        if isinstance(feature, Line):
            space.add_line(*(ends if i % 2 else reversed(ends)), dxfattribs=attributes)
            continue
        assert isinstance(feature, Arc)
        (cx, cz), clockwise = feature.centre_mm, feature.sweep_rad > 0
        first, last = reversed(ends) if clockwise else ends
        angles = [math.degrees(math.atan2(y - cx, x - cz)) for x, y in (first, last)]
        space.add_arc((cz, cx), feature.radius_mm, *angles, dxfattribs=attributes)


def saved(document: Drawing, folder: Path) -> Path:
    path = folder / "part.dxf"
    document.saveas(path)
    return path


def same(read: DxfProfile, profile: Profile, atol_mm: float = 1e-8) -> None:
    back = checked_profile(read.features)
    assert len(back.features) == len(profile.features)
    for found, nominal in zip(back.features, profile.features, strict=True):
        assert type(found) is type(nominal)
        share = np.linspace(0, 1, 9)
        points, expected = found.point_mm(share * found.length_mm), nominal.point_mm(share * nominal.length_mm)
        np.testing.assert_allclose(points, expected, atol=atol_mm)


@pytest.mark.parametrize("profile", [facetst(), modbas2(), piecs11()], ids=["facetst", "modbas2", "piecs11"])
def test_polyline_with_bulges(profile: Profile, tmp_path: Path) -> None:
    document = drawing()
    document.modelspace().add_lwpolyline(bulges(profile.features), format="xyb")
    same(read_dxf(saved(document, tmp_path)), profile)


def test_old_style_polyline_drawn_from_the_free_end(tmp_path: Path) -> None:
    profile = piecs11()
    backwards = tuple(feature.reversed() for feature in reversed(profile.features))
    document = drawing()
    document.modelspace().add_polyline2d(bulges(backwards), format="xyb")
    same(read_dxf(saved(document, tmp_path)), profile)


@given(profiles())
def test_loose_lines_and_arcs_in_any_order(tmp_path_factory: pytest.TempPathFactory, profile: Profile) -> None:
    document = drawing()
    add_loose(document.modelspace(), profile.features)
    same(read_dxf(saved(document, tmp_path_factory.mktemp("dxf"))), profile)


def test_inches_by_header_and_by_hand(tmp_path: Path) -> None:
    profile = modbas2()
    for units, unit in ((INCH, None), (NO_UNIT, "inch"), (MM, "inch")):
        document = drawing(units)
        document.modelspace().add_lwpolyline(bulges(profile.features, 1 / 25.4), format="xyb")
        read = read_dxf(saved(document, tmp_path), unit=unit)  # type: ignore[arg-type]
        same(read, profile)
        assert "25.4 mm" in read.notes[0] and f"$INSUNITS = {units}" in read.notes[0]


def test_diameters_halve_x(tmp_path: Path) -> None:
    profile, document = facetst(), drawing()
    document.modelspace().add_lwpolyline(
        [(z, 2 * x) for x, z, _ in [(x, z, b) for z, x, b in bulges(profile.features)]]
    )
    same(read_dxf(saved(document, tmp_path), x_is="diameter"), profile)


def test_closed_half_section_opens_at_the_axis(tmp_path: Path) -> None:
    document = drawing()
    document.modelspace().add_lwpolyline([(0, 0), (-40, 0), (-40, 10), (0, 10)], close=True)
    read = read_dxf(saved(document, tmp_path))
    assert [f.start_mm for f in read.features] == [(0.0, -40.0), (10.0, -40.0), (10.0, 0.0)]
    assert "1 lines on the axis were left out." in read.notes


def test_polyline_seen_from_behind(tmp_path: Path) -> None:
    """Extrusion (0, 0, −1) mirrors a polyline's own coordinates: x changes sign and arcs turn the other way."""
    profile, document = modbas2(), drawing()
    mirrored = [(-x, y, -bulge) for x, y, bulge in bulges(profile.features)]
    document.modelspace().add_lwpolyline(mirrored, format="xyb", dxfattribs={"extrusion": (0, 0, -1)})
    same(read_dxf(saved(document, tmp_path)), profile)


def test_layer_choice_and_names(tmp_path: Path) -> None:
    profile, document = modbas2(), drawing()
    space = document.modelspace()
    add_loose(space, profile.features)
    space.add_lwpolyline([(200, 50), (200, -50), (-200, -50)], dxfattribs={"layer": "frame"})
    space.add_text("MODBAS2")
    path = saved(document, tmp_path)
    read = read_dxf(path, layer="0")
    assert [f.name for f in read.features] == [
        "cylinder-1",
        "face-1",
        "cone-1",
        "cylinder-2",
        "face-2",
        "cylinder-3",
        "arc-1",
    ]
    assert "1 TEXT entities were not read." in read.notes
    with pytest.raises(TrueloopError, match="2 separate chains") as refusal:
        read_dxf(path)
    assert refusal.value.code is Code.GEO_DXF_CHOICE and refusal.value.place.file == str(path)


def _two_lines(gap: float) -> Drawing:
    document = drawing()
    document.modelspace().add_line((-40, 10), (0, 10))
    document.modelspace().add_line((0, 10 - gap), (0, 2))
    return document


def test_ends_that_nearly_meet_are_a_gap(tmp_path: Path) -> None:
    assert len(read_dxf(saved(_two_lines(0.0009), tmp_path)).features) == 2
    with pytest.raises(TrueloopError, match=r"two ends lie 0\.0500 mm apart") as refusal:
        read_dxf(saved(_two_lines(0.05), tmp_path))
    assert refusal.value.code is Code.GEO_GAP


def _branch(document: Drawing) -> None:
    document.modelspace().add_line((0, 10), (20, 10))
    document.modelspace().add_line((-40, 10), (0, 10))
    document.modelspace().add_line((0, 10), (0, 2))


def _arc_only(document: Drawing) -> None:
    document.modelspace().add_arc((0, 0), 10, 0, 90)


@pytest.mark.parametrize(
    ("draw", "units", "x_is", "code"),
    [
        (_branch, MM, "radius", Code.GEO_DXF_CHOICE),
        (_arc_only, MM, "diameter", Code.GEO_DXF),
        (_arc_only, NO_UNIT, "radius", Code.GEO_DXF_UNIT),
        (_arc_only, 18, "radius", Code.GEO_DXF_UNIT),
    ],
)
def test_drawings_that_are_refused(draw: Any, units: int, x_is: Any, code: Code, tmp_path: Path) -> None:
    document = drawing(units)
    draw(document)
    with pytest.raises(TrueloopError) as refusal:
        read_dxf(saved(document, tmp_path), x_is=x_is)
    assert refusal.value.code is code and refusal.value.hint and refusal.value.place.file


@pytest.mark.parametrize("content", [b"", b"  0\nSECTION\n  2\nENTIT", b"\xff\xfe\x00GIF89a", b"%PDF-1.4\n"])
def test_files_that_are_no_drawing(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "part.dxf"
    path.write_bytes(content)
    with pytest.raises(TrueloopError) as refusal:
        read_dxf(path)
    assert refusal.value.code is Code.GEO_DXF


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError, match="cannot be read"):
        read_dxf(tmp_path / "none.dxf")


def test_an_arc_without_extent_is_left_out_as_is_a_line_without(tmp_path: Path) -> None:
    document = drawing()
    space = document.modelspace()
    add_loose(space, facetst().features)
    expected = read_dxf(saved(document, tmp_path)).features
    space.add_arc((-20.0, 10.0), 0.0, 0.0, 90.0)
    space.add_line((-20.0, 10.0), (-20.0, 10.0))
    assert read_dxf(saved(document, tmp_path)).features == expected
