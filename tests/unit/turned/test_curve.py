"""What a user asks of one curve."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.profiles import modbas2
from tests.support.touched import noise, touched
from trueloop.turned.compensation.shift import of_curve
from trueloop.turned.error_curve.curve import student_t_factor
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.between_cuts import BetweenCuts
from trueloop.turned.fit.options import FitOptions

PROFILE = modbas2()
OPTIONS = FitOptions(knot_every=4, alike_over_mm=0.0)
MODEL = fit_profile(PROFILE, touched(PROFILE, [2, 2, 5, 5, 2, 3, 16], noise(0.01)), OPTIONS)
DOME = MODEL.curves[-1]


@pytest.mark.parametrize("end_mm", [0.0, DOME.length_mm])
def test_beyond_its_ends_it_goes_on_along_its_tangent(end_mm: float) -> None:
    out = np.array([-1.0, -2.0]) if end_mm == 0.0 else np.array([1.0, 2.0])
    values = DOME.value_mm(end_mm + out)
    np.testing.assert_allclose(values, DOME.value_mm(end_mm) + out * DOME.slope(end_mm), atol=1e-15)
    np.testing.assert_allclose(DOME.slope(end_mm + out), np.full(2, DOME.slope(end_mm)[0]), atol=1e-15)


def test_pieces_give_the_same_numbers() -> None:
    begins, coefficients = DOME.pieces
    ends = np.append(begins[1:], DOME.length_mm)
    assert begins[0] == 0.0
    last_touch_mm = DOME.spline.supported_mm[1] if DOME.spline.supported_mm else math.nan
    np.testing.assert_allclose(begins[1:], [*DOME.knots_mm, last_touch_mm])  # from there on along the tangent
    for begin, end, piece in zip(begins, ends, coefficients, strict=True):
        s = np.linspace(begin, end, 7)
        np.testing.assert_allclose(np.polynomial.polynomial.polyval(s - begin, piece), DOME.value_mm(s), atol=1e-14)


def test_slope_is_the_derivative() -> None:
    s = np.linspace(1.0, DOME.length_mm - 1.0, 11)
    step = 1e-4
    differences = (DOME.value_mm(s + step) - DOME.value_mm(s - step)) / (2 * step)
    np.testing.assert_allclose(DOME.slope(s), differences, rtol=1e-6, atol=1e-9)


def test_bend_is_the_derivative_of_the_slope() -> None:
    s = np.linspace(1.0, DOME.length_mm - 1.0, 11)
    step = 1e-4
    differences = (DOME.slope(s + step) - DOME.slope(s - step)) / (2 * step)
    np.testing.assert_allclose(of_curve(DOME).derivative().slope(s), differences, rtol=1e-6, atol=1e-9)


def test_band_and_prediction_are_built_on_the_standard_uncertainty() -> None:
    s = np.linspace(0.0, DOME.length_mm, 5)
    u = DOME.standard_deviation_mm(s)
    np.testing.assert_allclose(DOME.half_band_mm(s, 0.9), student_t_factor(0.9, MODEL.degrees_of_freedom) * u)
    np.testing.assert_allclose(DOME.budget(s).standard_u_mm, np.hypot(u, MODEL.scatter_mm))


def test_a_stated_repeatability_takes_the_place_of_the_scatter() -> None:
    options = FitOptions(knot_every=4, repeatability_mm=0.5)
    curve = fit_profile(PROFILE, MODEL.vectors, options).curves[-1]
    np.testing.assert_allclose(curve.budget(1.0).standard_u_mm, np.hypot(curve.standard_deviation_mm(1.0), 0.5))


def test_what_differs_from_cut_to_cut_comes_in_with_the_cut_that_was_touched_and_with_the_next() -> None:
    options = replace(OPTIONS, between_cuts=BetweenCuts(0.3, 0.4, "stated"))
    curve = fit_profile(PROFILE, MODEL.vectors, options).curves[-1]
    expected = np.sqrt(curve.standard_deviation_mm(1.0) ** 2 + curve.scatter_mm**2 + 2 * (0.3**2 + 0.4**2))
    np.testing.assert_allclose(curve.budget(1.0).standard_u_mm, expected)
