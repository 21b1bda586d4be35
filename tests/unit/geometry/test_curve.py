"""Curves by their definitions, against the equations evaluated without the package."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ellipeinc

from tests.support.curves import LENS, arc_as_curve
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.curve import part_of
from trueloop.geometry.curve_kinds import asphere, b_spline, curve_through, ellipse, off_points_mm, power_series
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.intersection import intersections
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import JunctionKind
from trueloop.geometry.validate import checked_profile

NOSE_MM = 0.8
H = np.linspace(20.0, 0.0, 101)


def test_asphere_is_its_equation() -> None:
    curve = LENS.curve()
    s = LENS.arc_length_mm(H)
    assert_allclose(curve.point_mm(s), LENS.point_mm(H), rtol=0, atol=1e-12)
    assert_allclose(curve.outward_normal(s), LENS.normal(H), rtol=0, atol=1e-13)
    bent = LENS.bend_per_mm(H) / (1 + LENS.slope(H) ** 2) ** 1.5
    assert_allclose(curve.curvature_per_mm(s), bent, rtol=0, atol=1e-12)
    assert curve.length_mm == pytest.approx(float(LENS.arc_length_mm(np.array(0.0))), abs=1e-12)


def test_sag_to_the_free_end_and_odd_powers() -> None:
    """A hollow at the free end: the sag of a positive radius goes outwards; h² + |h|³ on both sides of a vertex."""
    hollow = asphere("hollow", ((8.0, 4.0), (0.0, 0.0)), (0.0, 0.0), 10.0, 0.0, {}, True)
    assert float(hollow.curvature_per_mm(1.0)) == pytest.approx(-0.1)
    across = asphere("across", ((11.0, -0.501), (9.0, -0.501)), (10.0, 0.0), 1e9, 0.0, {2: 0.5, 3: 0.001})
    assert float(across.locate((10.5, -0.125 - 0.000125))[1]) == pytest.approx(0.0, abs=1e-9)


def test_length_of_an_ellipse() -> None:
    """Semi-axes 10 along x and 20 along z from 30° to 75° of the parameter: 20·(E(75°) − E(30°)), m = 1 − (10/20)²."""
    a, b = np.radians([15.0, 60.0])  # the parameter counted from the x axis
    ends = [(30 + 10 * math.cos(t), 20 * math.sin(t)) for t in (a, b)]
    curve = ellipse("bowl", (ends[0], ends[1]), (30.0, 0.0), (10.0, 20.0))
    assert curve.length_mm == pytest.approx(20 * (ellipeinc(b, 0.75) - ellipeinc(a, 0.75)), abs=1e-12)
    whole = ellipse("round", ((30.0 + 1e-9, -20.0), (30.0, -20.0)), (30.0, 0.0), (10.0, 20.0))
    assert whole.length_mm == pytest.approx(80 * ellipeinc(math.pi / 2, 0.75), abs=1e-8)


def test_turned_ellipse_runs_the_side_it_is_asked_to() -> None:
    """A quarter of an ellipse turned by 90°: the axes change places; concave runs the other three quarters."""
    ends = ((30.0, -10.0), (50.0, 0.0))
    convex = ellipse("e", ends, (30.0, 0.0), (10.0, 20.0), math.pi / 2)
    concave = ellipse("e", ends, (30.0, 0.0), (10.0, 20.0), math.pi / 2, convex=False)
    assert convex.length_mm + concave.length_mm == pytest.approx(80 * ellipeinc(math.pi / 2, 0.75), abs=1e-9)
    assert convex.radius_range_mm()[0] == math.inf
    assert convex.radius_range_mm()[1] == pytest.approx(100 / 20, rel=1e-6)
    assert concave.radius_range_mm()[1] == math.inf
    assert concave.radius_range_mm()[0] == pytest.approx(100 / 20, rel=1e-6)


def test_polynomial_is_found_from_either_end() -> None:
    up = power_series("p", ((1.0, 0.0), (5.0, 2.0)), (1.0, 0.0, 1.0))
    down = power_series("p", ((5.0, 2.0), (1.0, 0.0)), (1.0, 0.0, 1.0))
    length = math.sqrt(17) + math.asinh(4) / 4  # of a parabola, ∫₀² √(1 + 4z²) dz
    assert up.length_mm == pytest.approx(length, abs=1e-12)
    assert down.start_mm == pytest.approx((5.0, 2.0), abs=1e-12)
    across = power_series("p", ((3.0, 5.0), (1.0, 1.0)), (1.0, 0.0, 1.0), 1.0, of_x=True)
    assert across.length_mm == pytest.approx(length, abs=1e-12)


def test_rational_spline_is_a_circle() -> None:
    """Weights 1, √½, 1 on a square corner are a quarter of a circle."""
    curve = b_spline("q", [(10.0, 0.0), (10.0, 10.0), (0.0, 10.0)], [0, 0, 0, 1, 1, 1], 2, [1, math.sqrt(0.5), 1])
    assert curve.length_mm == pytest.approx(5 * math.pi, abs=1e-12)
    assert_allclose(curve.curvature_per_mm(np.linspace(0, curve.length_mm, 9)), 0.1, rtol=0, atol=1e-13)


@pytest.mark.parametrize(("cut_mm", "kept_mm"), [(0.0, 400.0), (3.0, 330.0), (-0.25, 250.0)])
def test_every_piece_of_a_long_ellipse_is_where_its_equation_is(cut_mm: float, kept_mm: float) -> None:
    """Semi-axes 10 and 200 mm, in many pieces; before its start, its vertex, a circle of 10²/200 = 0.5 mm: half a
    radian of it is 0.25 mm.
    """
    curve = ellipse("e", ((30.0, -200.0), (30.0, 200.0)), (30.0, 0.0), (10.0, 200.0), convex=False)
    assert len(curve.breaks_mm) > 5
    part = part_of(curve, cut_mm, cut_mm + kept_mm)
    assert part.length_mm == pytest.approx(kept_mm, abs=1e-9)
    s = np.linspace(max(0.0, -cut_mm), kept_mm, 301)
    x, z = part.point_mm(s).T
    assert_allclose(((x - 30.0) / 10.0) ** 2 + (z / 200.0) ** 2, 1.0, rtol=0, atol=1e-11)
    assert_allclose(part.point_mm(s), curve.point_mm(s + cut_mm), rtol=0, atol=1e-10)
    if cut_mm < 0.0:
        before = (30.0 + 0.5 * math.sin(0.5), -200.0 + 0.5 * (1 - math.cos(0.5)))
        assert part.start_mm == pytest.approx(before, abs=1e-9)


ARC = Arc("dome", (24.0, -24.0), (0.0, 0.0), (0.0, -24.0), math.pi / 2)


def test_arc_as_a_curve_is_the_arc() -> None:
    curve, s = arc_as_curve(ARC), np.linspace(-2.0, ARC.length_mm + 2.0, 60)
    assert curve.length_mm == pytest.approx(ARC.length_mm, abs=1e-12)
    for of in ("point_mm", "tangent", "outward_normal", "curvature_per_mm"):
        assert_allclose(getattr(curve, of)(s), getattr(ARC, of)(s), rtol=0, atol=1e-11)
    points = np.random.default_rng(1).uniform([1, -20], [40, 20], (200, 2))
    assert_allclose(curve.locate(points)[0], ARC.locate(points)[0], rtol=0, atol=1e-9)
    assert_allclose(curve.locate(points)[1], ARC.locate(points)[1], rtol=0, atol=1e-11)
    line = Line("l", (10.0, -30.0), (10.0, 10.0))
    on_curve = min(intersections(curve, line), key=lambda point: -point[1])
    assert on_curve == pytest.approx(max(intersections(ARC, line), key=lambda point: point[1]), abs=1e-10)


@pytest.mark.parametrize("corner_mm", [24.0, 22.0, 26.0])
def test_nose_path_along_an_arc_as_a_curve_is_that_along_the_arc(corner_mm: float) -> None:
    """A cylinder tangent to it, in a concave corner with it, in a convex one after a face."""
    z = -24.0 + math.sqrt(576.0 - min(corner_mm, 24.0) ** 2)
    before: list[Feature] = [Line("neck", (corner_mm, -40.0), (corner_mm, z))]
    if corner_mm > 24.0:
        before.append(Line("face", (corner_mm, z), (24.0, z)))
    begin = before[-1].end_mm
    sweep = math.pi / 2 - math.atan2(z + 24.0, begin[0])
    arc = Arc("dome", begin, (0.0, 0.0), (0.0, -24.0), sweep)
    by_arc, by_curve = (nose_centre_path(checked_profile([*before, one]), NOSE_MM) for one in (arc, arc_as_curve(arc)))
    assert_allclose(by_curve.reachable_mm, by_arc.reachable_mm, rtol=0, atol=1e-8)
    for one, other in zip(by_curve.features, by_arc.features, strict=True):
        assert_allclose([one.start_mm, one.end_mm], [other.start_mm, other.end_mm], rtol=0, atol=1e-8)


def test_nose_path_along_an_asphere_is_its_equation_moved_out() -> None:
    lens = LENS.curve()
    rim = Line("rim", (20.0, -30.0), lens.start_mm)
    profile = checked_profile([rim, lens])
    assert profile.junctions[0].kind is JunctionKind.CORNER
    path = nose_centre_path(profile, NOSE_MM).features[1]
    wanted = LENS.point_mm(H) + NOSE_MM * LENS.normal(H)
    s, off = path.locate(wanted)
    assert np.max(np.abs(off)) < 1e-9
    assert s[0] > 0.0  # on to the corner's own crossing
    assert path.end_mm == pytest.approx((0.0, NOSE_MM), abs=1e-10)


def test_curve_tighter_than_the_nose() -> None:
    """z = x²/2 in a hollow has a radius of 1 mm at its bottom: a nose of 0.99 fits, one of 1.01 does not."""
    ends = ((3.0, 4.5), (0.0, 0.0))
    hollow: list[Feature] = [Line("rim", (9.0, -9.0), (9.0, 4.5)), Line("face", (9.0, 4.5), ends[0])]
    hollow += [power_series("hollow", ends, (0.0, 0.0, 0.5), of_x=True)]
    assert nose_centre_path(checked_profile(hollow), 0.99).features[2].length_mm > 3
    with pytest.raises(TrueloopError) as refusal:
        nose_centre_path(checked_profile(hollow), 1.01)
    assert refusal.value.code is Code.GEO_NOSE
    assert "least radius of curvature of 1.0000 mm" in refusal.value.message


def test_points_of_an_asphere_give_it_back() -> None:
    """Rounded to a micrometre, 101 points: the curve passes all within 1 µm, in few pieces, and is the lens to 1 µm."""
    points = np.round(LENS.point_mm(H), 3)
    curve = curve_through("lens", points, 1e-3)
    assert np.max(off_points_mm(curve, points)) <= 1e-3
    assert len(curve.breaks_mm) < 10
    between = LENS.point_mm(np.linspace(20.0, 0.0, 999))
    assert np.max(np.abs(curve.locate(between)[1])) < 1e-3


def test_curve_that_crosses_itself_is_refused() -> None:
    loop = b_spline("loop", [(20, 0), (60, 30), (60, -20), (20, 12)], [0, 0, 0, 0, 1, 1, 1, 1], 3)
    with pytest.raises(TrueloopError) as refusal:
        checked_profile([loop])
    assert refusal.value.code is Code.GEO_CROSSING
    assert "'loop' crosses itself" in refusal.value.message


def test_curve_that_a_line_crosses_is_refused() -> None:
    dip = power_series("dip", ((20.0, 0.0), (20.0, 10.0)), (20.0, 1.0, -0.1))
    over = [Line("up", (20.0, 10.0), (25.0, 10.0)), Line("back", (25.0, 10.0), (21.0, 1.0 + 1e-9))]
    with pytest.raises(TrueloopError) as refusal:
        checked_profile([dip, *over, Line("out", over[-1].end_mm, (60.0, 11.0))])
    assert refusal.value.code is Code.GEO_CROSSING


@pytest.mark.parametrize(
    ("make", "code", "words"),
    [
        (lambda: asphere("a", ((20.0, -9.0), (0.0, 0.0)), (0.0, 0.0), 15.0), Code.GEO_CURVE, "no slope at 20.0000 mm"),
        (lambda: b_spline("s", [(0, 0), (1, 1), (2, 0)], [0, 0, 1, 2, 2], 1), Code.GEO_CURVE, "turns by 90.0000°"),
        (lambda: b_spline("s", [(0, 0), (1, 1)], [0, 0, 1, 1], 3), Code.GEO_CURVE, "2 control points for degree 3"),
        (lambda: b_spline("s", [(0, 0), (1, 1)], [0, 0, 1], 1), Code.GEO_CURVE, "3 knots"),
        (lambda: power_series("p", ((0.0, 0.0), (1.0, 2.0)), (0.0, 0.0, 0.2)), Code.GEO_CURVE_END, "0.2"),
        (lambda: power_series("p", ((1.0, 2.0), (1.0, 2.0)), (1.0,)), Code.GEO_LENGTH, "ends where it starts"),
        (lambda: curve_through("c", [(0, 0), (1, 1)], 0.1), Code.GEO_CURVE, "2 points"),
    ],
)
def test_refused(make: Callable[[], object], code: Code, words: str) -> None:
    with pytest.raises(TrueloopError) as refusal:
        make()
    assert refusal.value.code is code
    assert words in refusal.value.message


def test_a_point_off_the_rest_is_named() -> None:
    points = np.round(LENS.point_mm(H), 3)
    points[40, 1] += 0.02
    with pytest.raises(TrueloopError) as refusal:
        curve_through("lens", points, 1e-3)
    assert refusal.value.code is Code.GEO_CURVE_FIT
    assert "from point 41 at" in refusal.value.message


def test_the_stated_end_must_be_on_the_asphere() -> None:
    """Equation and diameter disagree: the rim said to be at 20.5 where the equation has 20 for that z."""
    x, z = (float(value) for value in LENS.point_mm(np.array(20.0)))
    with pytest.raises(TrueloopError) as refusal:
        asphere("lens", ((x + 0.5, z), (0.0, 0.0)), (0.0, 0.0), 40.0, -0.8, dict(LENS.powers))
    assert refusal.value.code is Code.GEO_CURVE_END
