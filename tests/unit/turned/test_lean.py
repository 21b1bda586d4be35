"""What an arc's correction owes to its slope, held against arcs that the virtual machine cuts with a worn nose."""

import numpy as np
import pytest

from tests.support.touched import touched
from trueloop.arrays import Array
from trueloop.geometry.curve_kinds import b_spline, ellipse
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.compensation.shift import (
    MOST_MM,
    ZERO,
    Shift,
    of_curve,
    of_slope,
    to_take_out,
    unasked_u_mm,
    weighted_sum,
)
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.options import FitOptions
from trueloop_lab.loops.turned import path_of_shifts
from trueloop_lab.simulator.machine import Stock, sweep
from trueloop_lab.simulator.nose import Nose

NOSE = Nose(0.8, tuple(np.radians([-20.0, 30.0, 80.0, 130.0])), (-0.003, -0.075, -0.020, 0.005))
DOME = checked_profile([Arc("dome", (20.0, 0.0), (0.0, 20.0), (0.0, 0.0), np.pi / 2)])
FILLET = checked_profile([Arc("fillet", (50.0, 0.0), (30.0, 20.0), (50.0, 20.0), -np.pi / 2)])
EGG = checked_profile([ellipse("egg", ((24.0, 0.0), (0.0, 30.0)), (0.0, 0.0), (24.0, 30.0))])
"""Its radius of curvature falls from 37.5 mm, 30²/24, to 19.2 mm, 24²/30."""
UM = 1e-3


def cut_mm(profile: Profile, shift: Shift, points_mm: Array, normals: Array) -> Array:
    """Errors that the worn nose leaves along these normals when it is driven along the shifted arc."""
    path = path_of_shifts(profile, NOSE.radius_mm, [shift])
    return Stock().cut_by([sweep(path.centre_mm, NOSE)]).height_mm(points_mm, normals)


def curve_of(profile: Profile) -> ErrorCurve:
    """The error curve of an arc cut as programmed, through touches so close that it is the error."""
    vectors = touched(profile, [60], lambda points, normals: cut_mm(profile, ZERO, points, normals))
    return fit_profile(profile, vectors, FitOptions(knot_every=2)).curves[0]


def inside(profile: Profile) -> tuple[Array, Array, Array]:
    """Arc lengths clear of the ends, where a neighbour would cut, with points and normals."""
    arc = profile.features[0]
    s = np.linspace(0.1, 0.9, 33) * arc.length_mm
    return s, arc.point_mm(s), arc.outward_normal(s)


@pytest.mark.parametrize("weight", [1.0, 0.6])
@pytest.mark.parametrize("profile", [DOME, FILLET, EGG], ids=["convex", "concave", "ellipse"])
def test_a_worn_nose_is_taken_out_to_second_order(profile: Profile, weight: float) -> None:
    """Without the term some tenths of a micrometre stay on a convex arc and are missing on a concave one: the contour
    leans and is touched by another place of the nose."""
    curve, (s, points, normals) = curve_of(profile), inside(profile)
    plain = cut_mm(profile, weighted_sum(((-weight, of_curve(curve)),)), points, normals)
    leaned = cut_mm(profile, weighted_sum(((-weight, to_take_out(profile, 0, curve)),)), points, normals)
    wanted = (1.0 - weight) * curve.value_mm(s)
    assert np.max(np.abs(plain - wanted)) > weight * 0.3 * UM
    assert np.max(np.abs(leaned - wanted)) < 0.03 * UM


def test_on_a_curve_the_term_has_the_curvature_at_the_place() -> None:
    """E = 0.1 mm/rad · φ leaves e' = 0.1 κ and asks for 0.01 κ; κ of the ellipse (24 sin t, 30 cos t) by hand.

    A κ that stayed at the curve's start, 1/37.5 mm, would ask for too little at the other end, where it is 1/19.2 mm.
    """
    vectors = touched(EGG, [60], lambda points, normals: 0.1 * np.arctan2(normals[:, 1], normals[:, 0]))
    curve = fit_profile(EGG, vectors, FitOptions(knot_every=2)).curves[0]
    s, points, _ = inside(EGG)
    t = np.arctan2(points[:, 0] / 24.0, points[:, 1] / 30.0)
    curvature = 24.0 * 30.0 / ((24.0 * np.cos(t)) ** 2 + (30.0 * np.sin(t)) ** 2) ** 1.5
    assert curvature[-1] > 1.8 * curvature[0]
    np.testing.assert_allclose(of_slope(EGG, 0, curve).value_mm(s), 0.01 * curvature, atol=0.005 * UM)


def test_where_a_curve_is_straight_nothing_is_asked_for() -> None:
    """A cylinder written as a spline has no curvature, and an S changes its sign: the term goes through zero."""
    straight = [(20.0, 10.0 * k) for k in range(5)]
    bent = [(20.0, 0.0), (20.0, 10.0), (24.0, 20.0), (28.0, 30.0), (28.0, 40.0)]
    for control in (straight, bent):
        profile = checked_profile([b_spline("f", control, [0, 0, 0, 0, 0, 1, 1, 1, 1, 1], 4)])
        barrel = touched(profile, [11], lambda points, normals: 4e-5 * (points[:, 1] - 10.0) ** 2)
        curve = fit_profile(profile, barrel, FitOptions(knot_every=2)).curves[0]
        s = np.linspace(0.0, profile.length_mm, 2001)
        term, curvature = of_slope(profile, 0, curve).value_mm(s), profile.features[0].curvature_per_mm(s)
        assert np.all(np.abs(term) <= np.minimum(MOST_MM, 0.25**2 * np.abs(curvature)) + 0.01 * UM)
        assert np.max(np.abs(np.diff(term))) < 0.1 * UM
        assert (np.max(np.abs(term)) > 0.2 * UM) == (control is bent)


@pytest.mark.parametrize("profile", [DOME, FILLET], ids=["convex", "concave"])
def test_its_slope_is_the_derivative_of_its_value(profile: Profile) -> None:
    out, (s, _, _), step = to_take_out(profile, 0, curve_of(profile)), inside(profile), 1e-4
    differences = (out.value_mm(s + step) - out.value_mm(s - step)) / (2 * step)
    np.testing.assert_allclose(out.slope(s), differences, rtol=1e-4, atol=1e-7)


def test_it_fades_towards_a_tangent_neighbour_and_its_slope_follows() -> None:
    """The line beside has no such term: at the junction both contours are the error curves' own."""
    neck = Line("neck", (20.0, -10.0), (20.0, 0.0))
    profile = checked_profile([neck, *DOME.features])
    steep = touched(profile, [4, 40], lambda points, normals: 0.1 * normals[:, 1])
    curve = fit_profile(profile, steep, FitOptions(knot_every=4)).curves[1]
    out, own, step = to_take_out(profile, 1, curve), of_curve(curve), 1e-5
    assert out.value_mm(0.0) == own.value_mm(0.0) and out.slope(0.0) == own.slope(0.0)
    s = np.linspace(0.01, 0.5, 50)
    differences = (out.value_mm(s + step) - out.value_mm(s - step)) / (2 * step)
    np.testing.assert_allclose(out.slope(s), differences, rtol=1e-4, atol=1e-7)
    assert out.value_mm(3.0) - curve.value_mm(3.0)[0] == pytest.approx(20.0 * curve.slope(3.0)[0] ** 2, rel=1e-9)
    leaning = np.max(np.abs(out.slope(s) - own.slope(s))) / np.max(np.abs(own.slope(s)))
    assert leaning == pytest.approx(1.5 / 4, rel=0.05)  # the steepest of 3u² − 2u³ is 3/2, over 4 times the way e'/κ


@pytest.mark.parametrize("at_end", [True, False])
def test_at_a_free_end_it_does_not_fade_and_goes_on_as_it_is(at_end: bool) -> None:
    """E = 0.1 mm · cos φ, or sin φ, changes fastest there, by 0.1 / 20: 20 mm · 0.005² = 0.5 µm are owed, beyond it
    too.
    """
    steep = touched(DOME, [60], lambda points, normals: 0.1 * normals[:, 0 if at_end else 1])
    curve = fit_profile(DOME, steep, FitOptions(knot_every=4)).curves[0]
    out, own = to_take_out(DOME, 0, curve), of_curve(curve)
    end, inwards = (DOME.length_mm, -1.0) if at_end else (0.0, 1.0)
    near = end + inwards * np.array([0.1, 0.02, -0.02, -1.0])
    owed = out.value_mm(near) - own.value_mm(near)
    np.testing.assert_allclose(owed, 20.0 * own.slope(near) ** 2, rtol=1e-6)
    assert np.all(owed > 0.4 * UM) and owed[3] == pytest.approx(owed[2], rel=1e-9)


def test_beyond_the_ends_of_a_curve_the_term_goes_on_straight() -> None:
    """E = 0.1 mm/rad · φ owes 0.01 κ, whose slope at the vertices of an ellipse is none."""
    vectors = touched(EGG, [60], lambda points, normals: 0.1 * np.arctan2(normals[:, 1], normals[:, 0]))
    term = of_slope(EGG, 0, fit_profile(EGG, vectors, FitOptions(knot_every=2)).curves[0])
    for end, outwards in ((0.0, -1.0), (EGG.length_mm, 1.0)):
        at_end, slope = term.value_mm(end), term.slope(end)
        for beyond_mm in (0.5, 3.0):
            wanted = at_end + slope * outwards * beyond_mm
            assert term.value_mm(end + outwards * beyond_mm) == pytest.approx(wanted, abs=1e-12)
    assert term.value_mm([0.0, EGG.length_mm]) == pytest.approx([0.01 / 37.5, 0.01 / 19.2], rel=0.02)


def test_it_fades_at_an_end_that_joins_tangentially_as_well() -> None:
    profile = checked_profile([*FILLET.features, Line("neck", (30.0, 20.0), (30.0, 40.0))])
    steep = touched(profile, [40, 4], lambda points, normals: 0.1 * normals[:, 1])
    curve = fit_profile(profile, steep, FitOptions(knot_every=4)).curves[0]
    out, own, end = to_take_out(profile, 0, curve), of_curve(curve), FILLET.length_mm
    near = np.array([end - 1e-4, end])
    np.testing.assert_allclose(out.value_mm(near), own.value_mm(near), rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(out.slope(near), own.slope(near), rtol=0.0, atol=2e-6)
    s, step = end - np.linspace(0.01, 0.5, 50), 1e-5
    differences = (out.value_mm(s + step) - out.value_mm(s - step)) / (2 * step)
    np.testing.assert_allclose(out.slope(s), differences, rtol=1e-4, atol=1e-7)
    middle = end - 3.0
    assert out.value_mm(middle) - own.value_mm(middle) == pytest.approx(-20.0 * own.slope(middle) ** 2, rel=1e-6)


@pytest.mark.parametrize("profile", [DOME, EGG], ids=["arc", "ellipse"])
def test_what_is_steeper_than_a_nose_makes_it_asks_for_a_micrometre_at_most(profile: Profile) -> None:
    """40 µm within 4 mm, nearly as steep as towards the spindle axis on the parts of [6811]: the term would be 2 µm."""
    vectors = touched(profile, [60], lambda points, normals: -0.01 * np.maximum(4.0 - points[:, 1], 0.0))
    curve = fit_profile(profile, vectors, FitOptions(knot_every=2)).curves[0]
    s = np.linspace(0.0, profile.length_mm, 200)
    term = to_take_out(profile, 0, curve).value_mm(s) - curve.value_mm(s)
    assert np.max(curve.slope(s) ** 2 * 20.0) > 1.2 * MOST_MM
    assert np.max(term) == pytest.approx(MOST_MM)


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["convex", "concave"])
def test_on_a_large_arc_no_nose_errs_by_more_than_a_quarter_of_a_millimetre_a_radian(sign: float) -> None:
    """e' = 0.002 on R = 200 mm is 0.4 mm/rad: κ (0.25 mm)² = 0.3125 µm is asked for, not e'² R = 0.8 µm."""
    turn = sign * 0.1
    start, end = (220.0, 0.0), (220.0 - sign * 200.0 * (1 - np.cos(turn)), 200.0 * np.sin(abs(turn)))
    profile = checked_profile([Arc("crown", start, end, (220.0 - sign * 200.0, 0.0), turn)])
    vectors = touched(profile, [41], lambda points, normals: 0.4 * np.arctan2(normals[:, 1], normals[:, 0]))
    curve = fit_profile(profile, vectors, FitOptions(knot_every=4)).curves[0]
    term = of_slope(profile, 0, curve).value_mm(np.linspace(2.0, 18.0, 9))
    np.testing.assert_allclose(term, sign * 0.25**2 / 200.0, rtol=1e-6)


def test_a_line_owes_nothing() -> None:
    profile = checked_profile([Line("cone", (20.0, 0.0), (10.0, 20.0))])
    taper = touched(profile, [5], lambda points, normals: 0.005 * points[:, 1])
    curve = fit_profile(profile, taper).curves[0]
    s = np.linspace(0.0, 20.0, 5)
    np.testing.assert_array_equal(to_take_out(profile, 0, curve).value_mm(s), of_curve(curve).value_mm(s))


@pytest.mark.parametrize("profile", [DOME, FILLET], ids=["convex", "concave"])
def test_who_does_not_ask_for_it_has_the_root_mean_square_of_what_may_be_left(profile: Profile) -> None:
    """Of errors whose share of the nose is anything from none to all alike."""
    curve, (s, _, _) = curve_of(profile), inside(profile)
    term = of_slope(profile, 0, curve)
    left = np.linspace(0.0, 1.0, 10_001)[:, None] * term.value_mm(s)
    np.testing.assert_allclose(unasked_u_mm(term, s), np.sqrt(np.mean(left**2, axis=0)), rtol=1e-4)
    assert np.max(unasked_u_mm(term, s)) > 0.1 * UM
