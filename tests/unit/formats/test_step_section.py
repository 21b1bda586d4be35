"""Outside and bore of solids made by turning sections known by hand, with all that is milled and drilled afterwards."""

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Fuse
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt, gp_Vec

from tests.support.refusals import refused
from tests.support.solids import block, drill, revolved, without, written
from trueloop.errors import Code
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step_profile import StepProfile, read_step_profile
from trueloop.geometry.feature import Arc, Point

OUTSIDE: list[Any] = [
    (32.0, -80.0),
    (32.0, -70.0),
    (25.0, -70.0),
    (25.0, -32.0),
    ((25.0 - 2 + math.sqrt(2), -30.0 - 2 + math.sqrt(2)), (23.0, -30.0)),  # an edge rounded by 2 mm
    (20.0, -30.0),
    (20.0, -1.0),
    (19.0, 0.0),
]
"""A bushing's outside from the bore's edge at the chuck on; of a pair, the first is on the arc."""
BORE: list[Any] = [
    (13.0, 0.0),
    (12.0, -1.0),
    (12.0, -25.0),
    (14.0, -25.0),
    (14.0, -28.0),
    (12.0, -28.0),
    (12.0, -38.0),
    ((10.0 + math.sqrt(2), -38.0 - math.sqrt(2)), (10.0, -40.0)),  # a fillet of 2 mm
    (8.0, -40.0),
    (8.0, -80.0),
]
"""Its bore from the free end: chamfer, relief groove, fillet."""


def points(profile: StepProfile) -> list[Point]:
    return [profile.features[0].start_mm, *(feature.end_mm for feature in profile.features)]


def ends(section: Sequence[Any]) -> list[Point]:
    return [step[1] if isinstance(step[0], tuple) else step for step in section]


def runs(profile: StepProfile, section: Sequence[Any]) -> None:
    """Along the section in its order, its arcs with their radius of 2 mm, and everywhere the normal out of it."""
    np.testing.assert_allclose(points(profile), ends(section), atol=1e-7)
    for feature, (_, step) in zip(profile.features, pairwise(section), strict=True):
        assert isinstance(feature, Arc) == isinstance(step[0], tuple)
        if isinstance(feature, Arc):
            assert feature.radius_mm == pytest.approx(2.0, abs=1e-7)
            np.testing.assert_allclose(feature.point_mm(feature.length_mm / 2), step[0], atol=1e-7)


def milled(solid: Any) -> Any:
    """With a cross hole, a keyway in the bore from end to end, one on the outside, flats, a slot across the free end
    and bolt holes in the flange.
    """
    holes = [drill((28 * math.cos(a), 28 * math.sin(a), -90), (0, 0, 1), 2.0, 30.0) for a in (0.1, 1.67, 3.24, 4.81)]
    return without(
        solid,
        drill((0, 0, -50), (1, 0.3, 0), 3.0, 60.0),
        block((-2, 0, -90), (2, 15, 10)),
        block((-3, -26, -60), (3, -22, -45)),
        block((22, -40, -69), (40, 40, -31)),
        block((-40, -40, -69), (-22, 40, -31)),
        block((-40, -1, -3), (40, 1, 5)),
        *holes,
    )


def test_outside_and_bore_are_the_section_whatever_is_milled_and_drilled(tmp_path: Path) -> None:
    path = written(milled(revolved([*OUTSIDE, *BORE])), tmp_path / "bushing.step")
    outside, bore = read_step_profile(path), read_step_profile(path, side="inside")
    runs(outside, [BORE[-1], *OUTSIDE, BORE[0]])
    runs(bore, BORE)
    said = " ".join(outside.notes)
    assert "cross hole or round of radius 3.000 mm" in said and "of radius 2.000 mm along the axis, 28.000" in said
    assert "planes along the axis (flats, keyways)" in said and "planes across the axis or oblique" in said
    assert (
        "Also found: inside, 10 features from x = 13.0000, z = 0.0000 mm to x = 8.0000" in said or "inside, 9" in said
    )


@pytest.mark.parametrize("unit", ["MM", "INCH"])
def test_where_it_lies_makes_no_difference(tmp_path: Path, unit: str) -> None:
    along = np.array([0.36, -0.48, 0.8])
    place = gp_Ax3(gp_Pnt(*(10 * along).tolist()), gp_Dir(*along.tolist()))
    path = written(revolved([*OUTSIDE, *BORE], place), tmp_path / "bushing.step", unit)
    bore = read_step_profile(path, side="inside")
    np.testing.assert_allclose(points(bore), [(x, z + 10) for x, z in ends(BORE)], atol=1e-6)
    back = read_step_profile(path, side="inside", turned_round=True)
    np.testing.assert_allclose(
        points(back), [(x, -z - 10) for x, z in reversed(ends([OUTSIDE[0], *BORE]))][:-1], atol=1e-6
    )


def test_normals_point_out_of_the_material(tmp_path: Path) -> None:
    """The kernel says where the material is: a step along the normal is out of it, a step back in it."""
    solid = revolved([*OUTSIDE, *BORE])
    path, occ = written(solid, tmp_path / "bushing.step"), kernel()
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier

    classifier = BRepClass3d_SolidClassifier(solid)
    for side in ("outside", "inside"):
        for feature in read_step_profile(path, side=side).features:
            middle = feature.length_mm / 2
            for step, state in ((0.01, occ.OUT), (-0.01, occ.IN)):
                x, z = feature.point_mm(middle) + step * feature.outward_normal(middle)
                classifier.Perform(gp_Pnt(float(x) * 0.6, float(x) * 0.8, float(z)), 1e-7)
                assert classifier.State() == state


BLIND: list[Any] = [(0.0, -50.0), (6.0, -50.0), (6.0, -60.0), (20.0, -60.0), (20.0, 0.0), (9.0, 0.0), (9.0, -20.0),
                    (0.0, -20.0 - 9.0 * math.tan(math.radians(31)))]  # fmt: skip
"""A shaft with a blind bore at both ends: one flat, one drilled with a point of 118 degrees."""


def test_two_blind_bores_are_chosen_by_number_or_by_where_they_are(tmp_path: Path) -> None:
    path = written(revolved(BLIND), tmp_path / "shaft.step")
    refusal = refused(lambda: read_step_profile(path, side="inside"))
    assert refusal.code is Code.GEO_STEP and "--outline" in refusal.hint
    assert "2 contours inside: 1: inside, 2 features from x = 0.0000, z = -50.0000 mm" in refusal.message
    np.testing.assert_allclose(points(read_step_profile(path, side="inside", outline=1)), BLIND[:3], atol=1e-7)
    front = read_step_profile(path, side="inside", from_z_mm=-40.0)
    np.testing.assert_allclose(points(front), BLIND[5:], atol=1e-7)
    np.testing.assert_allclose(points(read_step_profile(path)), BLIND[2:6], atol=1e-7)
    assert refused(lambda: read_step_profile(path, side="inside", outline=3)).code is Code.GEO_STEP


def test_a_bore_is_cut_where_its_program_begins_and_ends(tmp_path: Path) -> None:
    path = written(revolved([*OUTSIDE, *BORE]), tmp_path / "bushing.step")
    bore = read_step_profile(path, side="inside", from_z_mm=-30.0, to_z_mm=-0.5)
    expected = [(12.5, -0.5), *BORE[1:6], (12.0, -30.0)]
    np.testing.assert_allclose(points(bore), expected, atol=1e-7)


def test_a_round_lip_is_shared_at_its_top(tmp_path: Path) -> None:
    """A ring whose ends are rounded by half circles of 2 mm: outside and bore meet where it is longest."""
    ring: list[Any] = [
        (14.0, -18.0),
        (14.0, 0.0),
        ((12.0, 2.0), (10.0, 0.0)),
        (10.0, -18.0),
        ((12.0, -20.0), (14.0, -18.0)),
    ]
    path = written(revolved(ring[1:]), tmp_path / "ring.step")
    np.testing.assert_allclose(points(read_step_profile(path)), [(12, -20), (14, -18), (14, 0), (12, 2)], atol=1e-7)
    np.testing.assert_allclose(
        points(read_step_profile(path, side="inside")), [(12, 2), (10, 0), (10, -18), (12, -20)], atol=1e-7
    )


def test_a_face_groove_is_of_the_outside(tmp_path: Path) -> None:
    section: list[Any] = [
        (5.0, -10.0),
        (20.0, -10.0),
        (20.0, 0.0),
        (16.0, 0.0),
        (16.0, -3.0),
        (12.0, -3.0),
        (12.0, 0.0),
        (5.0, 0.0),
    ]
    path = written(revolved(section), tmp_path / "disc.step")
    np.testing.assert_allclose(points(read_step_profile(path)), section, atol=1e-7)
    np.testing.assert_allclose(points(read_step_profile(path, side="inside")), [(5, 0), (5, -10)], atol=1e-7)


def hexagon(across: float, low: float, high: float) -> Any:
    """A prism of a hexagon, so wide across its flats."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon

    polygon = BRepBuilderAPI_MakePolygon()
    for k in range(6):
        corner = across / math.sqrt(3)
        polygon.Add(gp_Pnt(corner * math.cos(k * math.pi / 3), corner * math.sin(k * math.pi / 3), low))
    polygon.Close()
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(polygon.Wire()).Face(), gp_Vec(0, 0, high - low)).Shape()


def test_the_shank_of_a_hexagon_bolt_is_taken_by_its_range(tmp_path: Path) -> None:
    """What is not turned leaves the outside open, and the refusal says where; shank and washer face are whole."""
    shank = [(0.0, -8.0), (5.0, -8.0), (5.0, 29.0), (4.0, 30.0), (0.0, 30.0)]
    head = BRepAlgoAPI_Common(hexagon(16.0, -8.0, 0.0), revolved([(0, -8), (8, -8), (10, -7), (10, 0), (0, 0)])).Shape()
    path = written(BRepAlgoAPI_Fuse(head, revolved(shank)).Shape(), tmp_path / "bolt.step")
    refusal = refused(read_step_profile, path)
    assert refusal.code is Code.GEO_STEP and "open at" in refusal.message
    read = read_step_profile(path, from_z_mm=0.0)
    np.testing.assert_allclose(points(read)[1:], [(5, 0), *shank[2:]], atol=1e-7)
    assert any("planes along the axis" in note for note in read.notes)


def test_a_hub_with_a_lug_is_taken_without_it(tmp_path: Path) -> None:
    """A block stands on the hub: nothing turns to its top, and at most angles it is not there."""
    hub = revolved([(8.0, -30.0), (20.0, -30.0), (20.0, 0.0), (8.0, 0.0)])
    lug = block((9, -6, -20), (26, 6, -10))
    read = read_step_profile(written(BRepAlgoAPI_Fuse(hub, lug).Shape(), tmp_path / "hub.step"))
    np.testing.assert_allclose(points(read), [(8, -30), (20, -30), (20, 0), (8, 0)], atol=1e-7)
    assert any("stands out at less than half" in note for note in read.notes)


def test_what_is_there_at_few_angles_only_is_told(tmp_path: Path) -> None:
    """A collar of which 24 degrees are left was turned: it counts, with a note."""
    hub = revolved([(8.0, -30.0), (20.0, -30.0), (20.0, 0.0), (8.0, 0.0)])
    ring = revolved([(8.0, -20.0), (26.0, -20.0), (26.0, -10.0), (8.0, -10.0)])
    left = BRepAlgoAPI_Common(ring, block((9, -5, -30), (40, 5, 0))).Shape()
    read = read_step_profile(written(BRepAlgoAPI_Fuse(hub, left).Shape(), tmp_path / "hub.step"))
    assert (26.0, -20.0) in [tuple(np.round(point, 6)) for point in points(read)]
    assert any("cylinder-2 stands" in note and "% of the turn only" in note for note in read.notes)


def test_a_bore_that_a_cross_hole_ends_is_open_there(tmp_path: Path) -> None:
    """Drilled 3 mm deep to z = −20, its point bored away by a cross hole of 4 mm radius at z = −20."""
    solid = without(
        revolved([(0, -40), (10, -40), (10, 0), (3, 0), (3, -20), (0, -20 - 3 * math.tan(math.radians(31)))]),
        drill((-20, 0, -20), (1, 0, 0), 4.0, 40.0),
    )
    path = written(solid, tmp_path / "oil.step")
    bore = read_step_profile(path, side="inside")
    assert points(bore)[0] == pytest.approx((3.0, 0.0)) and bore.features[0].end_mm[0] == pytest.approx(3.0)
    np.testing.assert_allclose(points(read_step_profile(path))[1:-1], [(10, -40), (10, 0)], atol=1e-7)


def test_a_closed_cavity_is_no_bore(tmp_path: Path) -> None:
    solid = without(
        revolved([(0, -40), (10, -40), (10, 0), (0, 0)]), revolved([(3, -30), (6, -30), (6, -20), (3, -20)])
    )
    path = written(solid, tmp_path / "hollow.step")
    assert any("1 closed cavities" in note for note in read_step_profile(path).notes)
    assert "0 contours inside" in refused(lambda: read_step_profile(path, side="inside")).message


def test_loose_faces_are_sewn(tmp_path: Path) -> None:
    occ = kernel()
    writer = occ.IgesWriter("MM", 0)
    writer.AddShape(revolved([*OUTSIDE, *BORE]))
    writer.ComputeModel()
    assert writer.Write(str(tmp_path / "bushing.igs"))
    runs(read_step_profile(tmp_path / "bushing.igs", side="inside"), BORE)


def test_two_axes_are_refused(tmp_path: Path) -> None:
    """Two shafts joined by a web: none of the two is the part's axis."""
    other = gp_Ax3(gp_Pnt(60, 0, 0), gp_Dir(0, 0, 1))
    shaft = [(0.0, -50.0), (10.0, -50.0), (10.0, 0.0), (0.0, 0.0)]
    solid = BRepAlgoAPI_Fuse(
        BRepAlgoAPI_Fuse(revolved(shaft), revolved(shaft, other)).Shape(), block((0, -5, -30), (60, 5, -20))
    ).Shape()
    refusal = refused(read_step_profile, written(solid, tmp_path / "two.step"))
    assert refusal.code is Code.GEO_STEP and "2 axes" in refusal.message


def test_a_section_that_crosses_itself_is_refused(tmp_path: Path) -> None:
    bow: list[Any] = [(5.0, -20.0), (15.0, 0.0), (15.0, -20.0), (6.0, 0.0)]
    refusal = refused(read_step_profile, written(revolved(bow), tmp_path / "bow.step"))
    assert refusal.code is Code.GEO_STEP


@pytest.mark.parametrize("name", ["part.step", "part.igs"])
def test_a_file_of_another_kind_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("  0\nSECTION\n  2\nENTITIES\n  0\nENDSEC\n  0\nEOF\n")
    assert refused(read_step_profile, tmp_path / name).code is Code.SRF_CAD


@pytest.mark.corpus
def test_a_countersunk_washer_of_others_gives_outside_and_bore(corpus: Path) -> None:
    """By hand from the file, in inches: radii 0.5321, 0.4509 and 0.2165, a cone of 45 degrees, 7 mm thick."""
    path = corpus / "data/public/cad/conical-surface.step"
    rim, cone, hole = (25.4 * inch for inch in (0.532145256772786, 0.450944881889764, 0.216535433070866))
    z0, z1 = (point[1] for point in (points(read_step_profile(path))[0], points(read_step_profile(path))[-1]))
    assert z1 - z0 == pytest.approx(7.0, abs=1e-9)
    np.testing.assert_allclose(points(read_step_profile(path)), [(cone, z0), (rim, z0), (rim, z1), (hole, z1)])
    bore = points(read_step_profile(path, side="inside"))
    np.testing.assert_allclose(bore, [(hole, z1), (hole, z0 + cone - hole), (cone, z0)])
    lens = corpus / "data/public/cad/nist-mbe-pmi-11.stp"
    assert "0 of 10 faces are turned about an axis" in refused(read_step_profile, lens).message
