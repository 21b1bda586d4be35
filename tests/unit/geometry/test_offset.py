"""The nose-centre path: published programs, figures by hand, and the corners that cannot be offset."""

import math

import numpy as np
import pytest

from tests.support.profiles import NOSE_RADIUS_MM, inch, modbas2, piecs11, polyline
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.offset import contour_from_centre_path, nose_centre_path
from trueloop.geometry.profile import Profile, junctions_of
from trueloop.geometry.validate import checked_profile


def test_modbas2_centre_path_is_the_published_finish_program() -> None:
    """[6811 §A.3.3], P46 = 3.52: X/2 and Z of blocks N0350–N0420, printed to 1e-5 in."""
    program = [(2.89125, -6.40375 - 0.03125), (2.89125, -6.10375), (2.67842, -6.10375), (1.79125, -4.50192)]
    program += [(1.79125, -1.72875), (1.49125, -1.72875), (1.49125, -1.46), (0.0, 0.03125)]
    path = nose_centre_path(modbas2(), NOSE_RADIUS_MM)
    points = [path.features[0].start_mm, *(feature.end_mm for feature in path.features)]
    np.testing.assert_allclose(points, [inch(*p) for p in program], atol=0.6e-5 * 25.4)


def test_piecs11_knob_is_reached_from_106_85_degrees() -> None:
    """[6811 §A.4.2.4]: N0310 ends at X2.45254 Z-1.62131, whose direction from the knob's centre is 106.85° from +z."""
    profile = piecs11()
    path = nose_centre_path(profile, NOSE_RADIUS_MM)
    np.testing.assert_allclose(path.features[3].start_mm, inch(1.22627, -1.62131), atol=0.6e-5 * 25.4)
    start = float(path.reachable_mm[3, 0])
    normal = profile.features[3].outward_normal(start)
    assert math.degrees(math.atan2(normal[0], normal[1])) == pytest.approx(106.846, abs=1e-3)
    assert start > 0.3
    assert path.reachable_mm[3, 1] == pytest.approx(profile.features[3].length_mm, abs=1e-12)
    assert path.features[3].length_mm == pytest.approx(1.28125 * 25.4 * math.radians(106.846), abs=1e-3)


def test_corners_by_hand() -> None:
    """A groove with square corners, nose 0.5 mm: out by 0.5 mm at the edge, short by 0.5 mm in the corner."""
    corners = [(10.0, 0.0), (10.0, 5.0), (8.0, 5.0), (8.0, 9.0), (12.0, 9.0)]
    profile = checked_profile(polyline(corners))
    path = nose_centre_path(profile, 0.5)
    ends = [feature.end_mm for feature in path.features]
    np.testing.assert_allclose(ends, [(10.5, 5.5), (8.5, 5.5), (8.5, 8.5), (12.0, 8.5)], atol=1e-13)
    np.testing.assert_allclose(path.reachable_mm, [(0, 5), (0, 1.5), (0.5, 3.5), (0.5, 4)], atol=1e-13)


def test_concave_arc_shrinks_and_convex_grows() -> None:
    fillet = Arc("fillet", (10.0, 0.0), (10.0, 6.0), (14.0, 3.0), -2 * math.asin(0.6))
    dome = Arc("dome", (10.0, 6.0), (10.0, 12.0), (6.0, 9.0), 2 * math.asin(0.6))
    path = nose_centre_path(checked_profile([fillet, dome]), 1.0)
    radii = [feature.radius_mm for feature in path.features if isinstance(feature, Arc)]
    assert radii == pytest.approx([4.0, 6.0], abs=1e-12)


def test_pointed_tool_follows_the_profile() -> None:
    profile = modbas2()
    path = nose_centre_path(profile, 0.0)
    for nominal, feature in zip(profile.features, path.features, strict=True):
        np.testing.assert_allclose([feature.start_mm, feature.end_mm], [nominal.start_mm, nominal.end_mm], atol=1e-12)


def test_edge_rounded_by_the_path_is_a_sharp_edge() -> None:
    """A path that turns about an edge by an arc of the nose radius leaves the edge and no feature of its own."""
    along = Line("cylinder", (10.5, 0.0), (10.5, 5.0))
    about = Arc("edge", (10.5, 5.0), (10.0, 5.5), (10.0, 5.0), math.pi / 2)
    inwards = Line("face", (10.0, 5.5), (2.0, 5.5))
    cylinder, face = contour_from_centre_path([along, about, inwards], 0.5)
    np.testing.assert_allclose([cylinder.end_mm, face.start_mm, face.end_mm], [(10, 5), (10, 5), (2, 5)], atol=1e-12)


def test_misfit_of_a_rounded_tangency_does_not_move_the_joint() -> None:
    """A line 0.1 µm above its tangent circle misses it; the path is joined where they touch, not where they cross."""
    neck = Line("neck", (20.0001, -10.0), (20.0001, 0.0))
    dome = Arc("dome", (20.0, 0.0), (0.0, 20.0), (0.0, 0.0), math.pi / 2)
    path = nose_centre_path(checked_profile([neck, dome]), 0.8)
    assert math.dist(path.features[0].end_mm, (20.80005, 0.0)) < 1e-9
    assert path.features[0].end_mm == path.features[1].start_mm


def _vee(included_deg: float, convex: bool) -> list[Feature]:
    rise = 10 / math.tan(math.radians(included_deg) / 2) * (1 if convex else -1)
    return polyline([(200.0, 0.0), (200.0 + rise, 10.0), (200.0, 20.0)])


@pytest.mark.parametrize("included_deg", [15.0, 60.0, 90.0, 170.0, 179.99])
def test_corner_lies_on_the_bisector(included_deg: float) -> None:
    half = math.radians(included_deg) / 2
    for convex in (True, False):
        profile = checked_profile(_vee(included_deg, convex))
        path = nose_centre_path(profile, 0.4)
        out = 0.4 / math.sin(half)
        assert math.dist(path.features[0].end_mm, (profile.features[0].end_mm[0] + out, 10.0)) < 1e-9


@pytest.mark.parametrize(
    ("features", "radius_mm", "code"),
    [
        (_vee(8.0, convex=True), 0.4, Code.GEO_SHARP),
        (_vee(8.0, convex=False), 0.4, Code.GEO_NARROW),
        (polyline([(9.0, 0.0), (5.0, 0.0), (5.0, 1.0), (9.0, 1.0)]), 0.6, Code.GEO_NARROW),
        ([Arc("fillet", (10.0, 0.0), (10.0, 6.0), (10.0, 3.0), -math.pi)], 3.0, Code.GEO_NOSE),
        ([Line("a", (9.0, 0.0), (9.0, 5.0))], -0.4, Code.GEO_NOSE),
        ([Line("a", (9.0, 0.0), (9.0, 5.0))], math.nan, Code.GEO_NOSE),
    ],
)  # fmt: skip
def test_refusals(features: list[Feature], radius_mm: float, code: Code) -> None:
    profile = checked_profile(features)
    with pytest.raises(TrueloopError) as refusal:
        nose_centre_path(profile, radius_mm)
    assert refusal.value.code is code


def test_features_that_are_apart_keep_the_ends_of_their_offsets() -> None:
    """Another edge cuts between them: the nose does not go on to where their paths would cross."""
    first, second = Line("cylinder", (10.0, 0.0), (10.0, 5.0)), Line("face", (9.0, 6.0), (2.0, 6.0))
    path = nose_centre_path(Profile((first, second), junctions_of((first, second))), 0.4)
    assert path.features[0].end_mm == pytest.approx((10.4, 5.0))
    assert path.features[1].start_mm == pytest.approx((9.0, 6.4))
    np.testing.assert_allclose(path.reachable_mm, [(0, 5), (0, 7)])


def test_a_groove_that_is_too_narrow_is_named_with_its_place() -> None:
    """1 mm wide, nose 0.6 mm: at its bottom the nose's centre would be at x = 5 + 0.6, 0.6 from one side."""
    groove = checked_profile(polyline([(9.0, 0.0), (5.0, 0.0), (5.0, 1.0), (9.0, 1.0)]))
    with pytest.raises(TrueloopError) as refusal:
        nose_centre_path(groove, 0.6)
    assert refusal.value.values["features"] == ["f1"]
    place = refusal.value.values["x_mm"], refusal.value.values["z_mm"]
    assert place == pytest.approx((5.6, 0.6))


def test_groove_narrower_than_the_nose_by_way_of_arcs() -> None:
    """The neck between two domes 1 mm apart: no single feature vanishes, but the nose cannot reach the line between."""
    left = Arc("left", (10.0, 0.0), (4.0, 6.0), (4.0, 0.0), math.pi / 2)
    neck = Line("neck", (4.0, 6.0), (4.0, 7.0))
    right = Arc("right", (4.0, 7.0), (10.0, 13.0), (4.0, 13.0), math.pi / 2)
    profile = checked_profile([left, neck, right])
    nose_centre_path(profile, 0.45)
    with pytest.raises(TrueloopError, match="'neck'"):
        nose_centre_path(profile, 0.55)
