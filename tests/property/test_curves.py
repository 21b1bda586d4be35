"""What holds of every curve: arc length, normals, curvature, feet, offsets, both directions, what is stored."""

import math
import pickle

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.support.curves import curves
from trueloop.geometry.curve import Curve, moved_out, part_of
from trueloop.geometry.curve_kinds import b_spline, spline_of
from trueloop.geometry.feature import Line
from trueloop.geometry.intersection import intersections
from trueloop.loops.turned.provenance import CODEC

SHARES = st.floats(0.0, 1.0)


@given(curves())
def test_arc_length_is_the_length_of_the_way(curve: Curve) -> None:
    """Chords of a fine polyline, their sum extrapolated by Richardson: 4/3 of the finer less 1/3 of the coarser."""
    coarse, fine = (
        np.linalg.norm(np.diff(curve.point_mm(np.linspace(0.0, curve.length_mm, n)), axis=0), axis=1).sum()
        for n in (8001, 16001)
    )
    assert abs((4 * fine - coarse) / 3 - curve.length_mm) < 1e-8


@given(curves(), SHARES)
def test_tangent_normal_and_curvature_are_the_derivatives(curve: Curve, share: float) -> None:
    step = 1e-4
    s = step + share * (curve.length_mm - 2 * step)
    assume(np.min(np.abs(curve.breaks_mm - s)) > 2 * step)
    points = curve.point_mm(s + step * np.array([-1.0, 0.0, 1.0]))
    tangent, normal = (points[2] - points[0]) / (2 * step), curve.outward_normal(s)
    assert np.linalg.norm(curve.tangent(s)) - 1 < 1e-12
    assert np.allclose(curve.tangent(s), tangent, rtol=0, atol=1e-7)
    assert np.allclose(normal, [curve.tangent(s)[1], -curve.tangent(s)[0]], rtol=0, atol=1e-15)
    turned = (curve.outward_normal(s + step) - curve.outward_normal(s - step)) / (2 * step)
    assert np.allclose(turned, curve.curvature_per_mm(s) * curve.tangent(s), rtol=0, atol=1e-6)


@given(curves(), SHARES, st.floats(-0.9, 0.9))
def test_the_foot_of_a_normal_is_found(curve: Curve, share: float, away: float) -> None:
    s = share * curve.length_mm
    concave, convex = curve.radius_range_mm()
    distance = away * min(convex if away < 0 else concave, 5.0)
    at, off = curve.locate(curve.point_mm(s) + distance * curve.outward_normal(s))
    nearer = abs(float(off)) < abs(distance) - 1e-9  # another branch is nearer
    assume(not nearer)
    assert abs(float(at) - s) < 1e-8
    assert abs(float(off) - distance) < 1e-11


@given(curves(), st.floats(0.0, 3.0), st.booleans(), st.floats(-0.5, 0.5))
def test_beyond_its_ends_it_goes_on_along_its_circles_of_curvature(
    curve: Curve, beyond: float, at_end: bool, away: float
) -> None:
    s = curve.length_mm + beyond if at_end else -beyond
    end = curve.length_mm if at_end else 0.0
    curvature = float(curve.curvature_per_mm(end))
    assume(abs(curvature) * (beyond + 1) < 1 and abs(curvature) > 1e-6)
    assume(math.dist(curve.start_mm, curve.end_mm) > 8.0)  # else the circle leads back to the other end
    centre = curve.point_mm(end) - curve.outward_normal(end) / curvature
    assert abs(np.linalg.norm(curve.point_mm(s) - centre) - 1 / abs(curvature)) < 1e-9 / abs(curvature)
    at, off = curve.locate(curve.point_mm(s) + away * curve.outward_normal(s))
    assume(abs(float(off)) > abs(away) - 1e-9)
    assert abs(float(at) - s) < 1e-8
    assert abs(float(off) - away) < 1e-9


@given(curves(), SHARES)
def test_reversed_it_runs_back_with_the_material_on_the_other_side(curve: Curve, share: float) -> None:
    s, back = share * curve.length_mm, curve.reversed()
    opposite = curve.length_mm - s
    assert np.allclose(back.point_mm(opposite), curve.point_mm(s), rtol=0, atol=1e-12)
    assert np.allclose(back.outward_normal(opposite), -curve.outward_normal(s), rtol=0, atol=1e-11)
    assert back.reversed() == curve or np.allclose(back.reversed().breaks_mm, curve.breaks_mm, rtol=0, atol=1e-13)


@given(curves(), st.floats(-0.9, 0.9), SHARES)
def test_an_offset_is_everywhere_as_far_away_and_has_the_same_normal(curve: Curve, away: float, share: float) -> None:
    concave, convex = curve.radius_range_mm()
    distance = away * min(concave if away > 0 else convex, 3.0)
    moved = moved_out(curve, distance)
    s = share * curve.length_mm
    point, normal = curve.point_mm(s), curve.outward_normal(s)
    at = moved.locate(point + distance * normal)[0]
    assume(np.linalg.norm(moved.point_mm(at) - point - distance * normal) < 1e-3)
    assert np.allclose(moved.point_mm(at), point + distance * normal, rtol=0, atol=1e-10)
    assert np.allclose(moved.outward_normal(at), normal, rtol=0, atol=1e-8)
    assert abs(moved.length_mm - curve.length_mm - distance * curve.turn_rad) < 1e-8


@given(curves())
def test_it_turns_as_far_as_its_tangent(curve: Curve) -> None:
    """Unrolled angle of the tangent from +z towards +x, which falls on a convex curve."""
    tangent = curve.tangent(np.linspace(0.0, curve.length_mm, 4001))
    angle = np.unwrap(np.arctan2(tangent[:, 0], tangent[:, 1]))
    assert abs(curve.turn_rad - float(angle[0] - angle[-1])) < 1e-12


@given(curves(), SHARES, SHARES, SHARES)
def test_a_part_of_a_curve_is_the_curve(curve: Curve, one: float, other: float, share: float) -> None:
    low, high = sorted((one * curve.length_mm, other * curve.length_mm))
    assume(high - low > 1e-3)
    part = part_of(curve, low, high)
    s = share * (high - low)
    assert np.allclose(part.point_mm(s), curve.point_mm(low + s), rtol=0, atol=1e-11)
    assert abs(float(part.curvature_per_mm(s)) - float(curve.curvature_per_mm(low + s))) < 1e-6


@given(curves())
def test_it_comes_back_from_json_pickle_and_a_spline(curve: Curve) -> None:
    assert CODEC.from_json(CODEC.to_json(curve), Curve) == curve
    assert pickle.loads(pickle.dumps(curve)) == curve
    control, knots, degree = spline_of(curve)
    read = b_spline(curve.name, control, knots, degree)
    s = np.linspace(0.0, curve.length_mm, 40)
    assert np.allclose(read.point_mm(s), curve.point_mm(s), rtol=0, atol=1e-9)


@given(curves(), SHARES, st.floats(-2.0, 2.0))
def test_a_line_through_a_point_of_it_crosses_it_there(curve: Curve, share: float, tilt: float) -> None:
    s = share * curve.length_mm
    point, direction = curve.point_mm(s), curve.outward_normal(s) + tilt * curve.tangent(s)
    start, end = (tuple((point + k * direction).tolist()) for k in (-1.0, 1.0))
    found = intersections(curve, Line("", (start[0], start[1]), (end[0], end[1])))
    assert min(float(np.linalg.norm(point - other)) for other in found) < 1e-8
