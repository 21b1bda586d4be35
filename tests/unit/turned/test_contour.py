"""The compensated contour and its centre path, against hand-made cases and a brute-force envelope."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, reject
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from tests.support.profiles import profiles
from trueloop.errors import TrueloopError
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import JunctionKind, Profile, junctions_of
from trueloop.turned.compensation.displaced import (
    CentrePiece,
    ShiftedFeature,
    centre_pieces,
    reaches_mm,
    shifted_contour,
)
from trueloop.turned.compensation.shift import ZERO, Shift, constant, sampled, weighted_sum

from .shapes import FEATURES, NOSE_RADIUS_MM, PART

ends_mm = st.floats(-0.1, 0.1)


def linear(feature: Feature, start_mm: float, end_mm: float) -> Shift:
    return sampled(np.array([0.0, feature.length_mm]), np.array([start_mm, end_mm]))


def pieces_with(shifts: list[Shift]) -> tuple[CentrePiece, ...]:
    return centre_pieces(PART, shifted_contour(PART, shifts, NOSE_RADIUS_MM))


def test_oversize_moves_the_tool_into_the_material() -> None:
    """Δr = +0.04 mm, w = 0.75 cuts 0.03 mm deeper [4773 Fig. 9]: an error of +0.04 shifts the contour by −0.03."""
    error = sampled(np.array([0.0]), np.array([0.04]))
    shift = weighted_sum(((-0.75, error),))
    cylinder = ShiftedFeature(FEATURES[1], shift, NOSE_RADIUS_MM)
    x, z = cylinder.centre_mm(10.0)
    assert x == pytest.approx(44.704 + NOSE_RADIUS_MM - 0.03, abs=1e-12)
    assert z == pytest.approx(-104.554, abs=1e-12)


def test_unshifted_centre_path_meets_where_shop_programs_turn() -> None:
    """Corners of the published MODBAS2 finish program, P46 = 3.52 in, nose radius 0.03125 in [6811 §A.3.3]."""
    corners = [piece.shifted.centre_mm(piece.end_mm) / 25.4 * [2, 1] for piece in pieces_with([ZERO] * 5)]
    published = [(3.5825, -4.50192), (3.5825, -1.72875), (2.9825, -1.72875), (2.9825, -1.46), (0.0, 0.03125)]
    assert np.allclose(corners, published, rtol=0, atol=1e-5)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("radius_mm", "u_mm", "slope"), [(1.0, 0.05, 0.01), (2.0, 0.1, 0.02), (1.0, 0.15, 0.04)])
def test_the_nose_stands_square_to_the_shifted_contour_of_an_arc(
    radius_mm: float, u_mm: float, slope: float, side: float
) -> None:
    """In polar coordinates: the contour is r(φ) = R ± u, which turns its normal by atan(r′ / r) from the radius.

    With the sign of κ u flipped the nose of 0.8 mm is 0.8 µm, 1.6 µm and 9.8 µm beside.
    """
    first = 0.3
    last = first - side * np.pi / 2
    ends = [(5.0 + radius_mm * math.sin(phi), -2.0 + radius_mm * math.cos(phi)) for phi in (first, last)]
    arc = Arc("arc", ends[0], ends[1], (5.0, -2.0), side * np.pi / 2)
    shifted = ShiftedFeature(arc, Shift(np.array([]), np.array([[u_mm, slope]])), 0.8)
    for s in (0.0, 0.4 * radius_mm, 1.2 * radius_mm):
        phi = first - side * s / radius_mm
        r = radius_mm + side * (u_mm + slope * s)
        r_by_phi = -radius_mm * slope
        turned = phi - math.atan2(r_by_phi, r)
        x = 5.0 + r * math.sin(phi) + side * 0.8 * math.sin(turned)
        z = -2.0 + r * math.cos(phi) + side * 0.8 * math.cos(turned)
        assert shifted.centre_mm(s) == pytest.approx((x, z), abs=1e-12)


@given(st.lists(ends_mm, min_size=10, max_size=10))
def test_centre_paths_meet_at_every_junction(ends: list[float]) -> None:
    ends[8] = ends[7]  # the dome begins where the neck ends: a tangent junction closes in value
    shifts = [linear(f, a, b) for f, a, b in zip(FEATURES, ends[::2], ends[1::2], strict=True)]
    pieces = pieces_with(shifts)
    for before, after in itertools.pairwise(pieces):
        gap = before.shifted.centre_mm(before.end_mm) - after.shifted.centre_mm(after.start_mm)
        assert np.linalg.norm(gap) < 1e-9


@given(st.floats(-0.05, 0.05), st.floats(-0.02, 0.02), st.floats(-1e-3, 1e-3))
def test_the_nose_touches_the_compensated_contour(value: float, slope: float, bend: float) -> None:
    """The nose circle about every centre point touches the contour and nowhere enters it (brute force)."""
    dome = FEATURES[4]
    s = np.linspace(0.0, dome.length_mm, 401)
    spline = CubicSpline(s, value + slope * s + bend * np.sin(s))
    rows = spline.c[::-1].T
    shifted = ShiftedFeature(dome, Shift(s[:-1], np.vstack([rows[:1], rows])), NOSE_RADIUS_MM)
    contour = shifted.contour_mm(np.linspace(0, dome.length_mm, 4001))
    for centre in shifted.centre_mm(np.linspace(5, dome.length_mm - 5, 7)):
        nearest = np.linalg.norm(contour - centre, axis=1).min()
        assert nearest == pytest.approx(NOSE_RADIUS_MM, abs=2e-4)
        assert nearest >= NOSE_RADIUS_MM - 1e-9


def test_slope_moves_the_contact_along_the_feature() -> None:
    """With slope u′ the centre stands R u′ back along the feature, which shifting the centre path would leave out."""
    slope = 0.01
    cone = ShiftedFeature(FEATURES[0], linear(FEATURES[0], 0.0, slope * FEATURES[0].length_mm), 1.0)
    offset = cone.centre_mm(20.0) - cone.contour_mm(20.0)
    assert offset @ FEATURES[0].tangent(20.0) == pytest.approx(-math.sin(math.atan(slope)), abs=1e-12)


@given(ends_mm, ends_mm, ends_mm, ends_mm)
def test_corner_is_displaced_as_both_errors_say(a: float, b: float, c: float, d: float) -> None:
    """With a pointed tool the contours cross at d with n₁·d = u₁ and n₂·d = u₂, to the slide's second order."""
    shifts = [ZERO, linear(FEATURES[1], a, b), linear(FEATURES[2], c, d), ZERO, ZERO]
    pieces = centre_pieces(PART, shifted_contour(PART, shifts, 0.0))
    corner = pieces[1].shifted.centre_mm(pieces[1].end_mm)
    assert corner - FEATURES[1].end_mm == pytest.approx([b, c], abs=0.2 * 0.2 / 7)


def test_free_end_is_met_square_to_the_feature() -> None:
    """At the apex the centre path ends on the axis however steep the error is there [6811 §3.4]."""
    dome = ShiftedFeature(FEATURES[4], linear(FEATURES[4], 0.0, 0.3), NOSE_RADIUS_MM)
    s = reaches_mm(dome, 0.0, at_end=True)
    assert dome.centre_mm(s)[0] == pytest.approx(0.0, abs=1e-9)
    assert s != pytest.approx(FEATURES[4].length_mm, abs=1e-4)


def test_kink_at_a_tangent_junction_joins_both_ways() -> None:
    """A part-tangent path turns at the junction, outwards or inwards; the nose path still meets."""
    line, arc = FEATURES[3], FEATURES[4]
    pair = Profile((line, arc), junctions_of((line, arc)))
    for slope in (0.006, -0.006, 1e-9, 0.0):
        contour = shifted_contour(pair, [ZERO, linear(arc, 0.0, slope * arc.length_mm)], NOSE_RADIUS_MM)
        before, after = centre_pieces(pair, contour)
        gap = before.shifted.centre_mm(before.end_mm) - after.shifted.centre_mm(after.start_mm)
        assert np.linalg.norm(gap) < 1e-9
        assert before.end_mm - line.length_mm == pytest.approx(-NOSE_RADIUS_MM * slope / 2, rel=0.02, abs=1e-9)


@pytest.mark.parametrize("apart_mm", [2e-4, -2e-4], ids=["apart", "overlapping"])
def test_tangent_paths_that_rounding_keeps_apart_go_over_where_they_join(apart_mm: float) -> None:
    """A line below the lowest point of a fillet never meets its circle; one above meets it √(2 · 1.1 · 0.0002) beside
    that, 0.02 mm away.
    """
    line = Line("floor", (10.0, -3.0), (10.0, 0.0))
    fillet = Arc("fillet", (10.0, 0.0), (11.5, 1.5), (11.5, 0.0), -math.pi / 2)
    profile = Profile((line, fillet), junctions_of((line, fillet)))
    shifts = [sampled(np.array([0.0]), np.array([-apart_mm])), ZERO]
    before, after = centre_pieces(profile, shifted_contour(profile, shifts, 0.4))
    assert abs(before.end_mm - 3.0) < 0.025 and abs(after.start_mm) < 0.04
    gap = math.dist(before.shifted.centre_mm(before.end_mm), after.shifted.centre_mm(after.start_mm))
    assert gap <= abs(apart_mm) + 1e-9


def test_paths_that_never_meet_go_over_side_by_side() -> None:
    """Along the line nothing lies between their ends, though the fillet's nose leans by 10 mrad: 4 µm, to 2nd order."""
    line = Line("floor", (10.0, -3.0), (10.0, 0.0))
    fillet = Arc("fillet", (10.0, 0.0), (11.5, 1.5), (11.5, 0.0), -math.pi / 2)
    profile = Profile((line, fillet), junctions_of((line, fillet)))
    shifts = [constant(-2e-4), linear(fillet, 0.0, 0.01 * fillet.length_mm)]
    before, after = centre_pieces(profile, shifted_contour(profile, shifts, 0.4))
    gap = after.shifted.centre_mm(after.start_mm) - before.shifted.centre_mm(before.end_mm)
    assert abs(gap[1]) < 2e-5 and abs(gap[0]) > 1e-4
    assert abs(after.start_mm) == pytest.approx(2e-3 / (1.0 - 0.4 / 1.5), rel=0.05)


def test_the_perpendicular_beyond_a_free_end_is_beyond_it_at_both_ends() -> None:
    """Of a line its distance; of an arc of radius 20 cut by a nose of 0.8, by hand: 20.8 sin(s / 20) = 0.5."""
    line = ShiftedFeature(Line("cylinder", (20.0, 0.0), (20.0, 30.0)), ZERO, 0.8)
    assert (reaches_mm(line, 0.5, True), reaches_mm(line, 0.5, False)) == pytest.approx((30.5, -0.5))
    dome = Arc("dome", (20.0, 0.0), (0.0, 20.0), (0.0, 0.0), math.pi / 2)
    beyond_mm = 20.0 * math.asin(0.5 / 20.8)
    found = [reaches_mm(ShiftedFeature(dome, ZERO, 0.8), 0.5, at_end) for at_end in (True, False)]
    assert found == pytest.approx([dome.length_mm + beyond_mm, -beyond_mm])


@given(profiles(), st.floats(0.1, 1.2))
def test_without_shifts_the_path_is_the_offset_of_lines_and_circles(profile: Profile, radius_mm: float) -> None:
    """That path is found by Newton's steps along the features, the other from the crossings of whole lines and circles.

    Where features run along each other, rounding decides how far along them they meet, not where the nose is.
    """
    try:
        path = nose_centre_path(profile, radius_mm)
    except TrueloopError:
        reject()
    pieces = centre_pieces(profile, shifted_contour(profile, [ZERO] * len(profile.features), radius_mm))
    for piece, moved, junction in zip(pieces, path.features, profile.junctions, strict=False):
        end = piece.shifted.centre_mm(piece.end_mm)
        near_mm = 1e-7 if junction.kind is JunctionKind.CORNER else 0.05
        assert math.dist(end, moved.end_mm) < near_mm and abs(float(moved.locate(end)[1])) < 1e-7


@pytest.mark.parametrize(("first_mm", "second_mm", "meets_mm"), [(4.0, 4.0, 0.8), (4.0, 1.2, 0.0), (1.2, 4.0, 0.0)])
def test_tangent_lines_that_cross_beyond_half_of_the_shorter_go_over_where_they_end(
    first_mm: float, second_mm: float, meets_mm: float
) -> None:
    """At 0.9 mrad the first line, 0.72 µm further out, is met 0.72 µm / sin(0.9 mrad) = 0.8 mm beyond its end."""
    turn_rad = 9e-4
    first = Line("first", (10.0, -first_mm), (10.0, 0.0))
    second = Line("second", (10.0, 0.0), (10.0 + second_mm * math.sin(turn_rad), second_mm * math.cos(turn_rad)))
    profile = Profile((first, second), junctions_of((first, second)))
    assert profile.junctions[0].kind is JunctionKind.TANGENT
    out = sampled(np.array([0.0]), np.array([0.72e-3]))
    before, after = centre_pieces(profile, shifted_contour(profile, [out, ZERO], 0.4))
    assert (before.end_mm - first_mm, after.start_mm) == pytest.approx((meets_mm, meets_mm), abs=2e-3)


@pytest.mark.parametrize("beyond_mm", [0.5, -0.7])
def test_paths_that_meet_cross_there_though_rounding_never_lets_the_search_settle(beyond_mm: float) -> None:
    """At 1 µrad and x = 1000 mm: a digit of 1e-13 mm is 1e-7 mm along them, and the search looks for 1e-12 mm."""
    turn_rad, lean_rad = 1e-6, 0.7
    corner = (1000.1, -0.3)
    first, second = (
        Line(
            name,
            (corner[0] + from_mm * math.sin(along_rad), corner[1] + from_mm * math.cos(along_rad)),
            (corner[0] + to_mm * math.sin(along_rad), corner[1] + to_mm * math.cos(along_rad)),
        )
        for name, along_rad, from_mm, to_mm in (
            ("first", lean_rad, -4.3, 0.0),
            ("second", lean_rad + turn_rad, 0.0, 3.7),
        )
    )
    profile = Profile((first, second), junctions_of((first, second)))
    out = sampled(np.array([0.0]), np.array([beyond_mm * turn_rad]))
    before, after = centre_pieces(profile, shifted_contour(profile, [out, ZERO], 0.4))
    assert (before.end_mm - 4.3, after.start_mm) == pytest.approx((beyond_mm, beyond_mm), abs=1e-4)


def test_paths_that_run_on_in_one_direction_are_not_sought_to_cross() -> None:
    first, second = Line("first", (10.0, -4.0), (10.0, 0.0)), Line("second", (10.0, 0.0), (10.0, 5.0))
    profile = Profile((first, second), junctions_of((first, second)))
    out = sampled(np.array([0.0]), np.array([0.01]))
    before, after = centre_pieces(profile, shifted_contour(profile, [out, ZERO], 0.4))
    assert (before.end_mm, after.start_mm) == (4.0, 0.0)


def test_features_that_are_apart_keep_their_ends() -> None:
    first, second = Line("cylinder", (10.0, 0.0), (10.0, 5.0)), Line("face", (8.0, 9.0), (2.0, 9.0))
    profile = Profile((first, second), junctions_of((first, second)))
    pieces = centre_pieces(profile, shifted_contour(profile, [ZERO, ZERO], 0.4))
    assert [(piece.start_mm, piece.end_mm) for piece in pieces] == [(0.0, 5.0), (0.0, 6.0)]
