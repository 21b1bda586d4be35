"""Arcs by what earlier parts tell: the curve, its junctions, and bands that hold nothing twice."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.correction import example_inputs
from trueloop.arrays import Array
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.fit.between_cuts import PRIOR
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.prior.remembered_fit import Remembered, angles_along
from trueloop.turned.fit.spline import EndConditions
from trueloop.turned.touches.error_vectors import ErrorVectors

MODBAS2 = example_inputs("modbas2")
DOME = MODBAS2.profile.names.index("dome")
CYLINDER = DOME - 1
OPTIONS = FitOptions(between_cuts=PRIOR)


def form_mm(angle_rad: Array) -> Array:
    """A nose's error that no touch of the example shows: 40 µm and a wave of 10 µm."""
    return 0.040 + 0.010 * np.sin(3.0 * angle_rad)


def remembered(corrects: bool = True, gain: float = 1.0, scatter_mm: float = 0.0) -> Remembered:
    """4 µm alike over 30°, and what every place has of its own; a gain g is met by 1/g of the correction."""
    s, grid = angles_along(MODBAS2.profile, DOME)
    alike = np.exp(-0.5 * (np.subtract.outer(grid, grid) / math.radians(30.0)) ** 2)
    covariance = 0.004**2 * alike + scatter_mm**2 * np.eye(len(grid))
    return Remembered(np.full(len(s), DOME), s, form_mm(grid), covariance, form_mm(grid) / gain, gain, corrects)


def few_touches() -> ErrorVectors:
    """All touches of lines, three of the dome."""
    dome = MODBAS2.touches.of_feature(DOME)
    return MODBAS2.touches.chosen(np.setdiff1d(np.arange(len(MODBAS2.touches.point)), np.delete(dome, [2, 9, 16])))


def fitted(known: Remembered | None, options: FitOptions = OPTIONS) -> ProfileErrorModel:
    return fit_profile(MODBAS2.profile, few_touches(), options, remembered=known)


def test_the_dome_is_what_is_remembered_and_all_else_as_without() -> None:
    model, own = fitted(remembered()), fitted(None)
    s, angle = angles_along(MODBAS2.profile, DOME)
    beyond = angle < angle[0] - math.radians(4.0)
    np.testing.assert_allclose(model.curves[DOME].value_mm(s)[beyond], form_mm(angle)[beyond], atol=2e-5)
    assert model.curves[:DOME] == own.curves[:DOME]
    assert model.scatter_mm == own.scatter_mm
    assert model.degrees_of_freedom == own.degrees_of_freedom


@pytest.mark.parametrize("junctions", TangentPolicy)
def test_the_contour_does_not_step_where_the_dome_begins(junctions: TangentPolicy) -> None:
    model = fitted(remembered(), replace(OPTIONS, junctions=junctions))
    before, dome = model.curves[CYLINDER], model.curves[DOME]
    end_mm = before.length_mm
    assert dome.value_mm(0.0)[0] == pytest.approx(before.value_mm(end_mm)[0], abs=1e-12)
    if junctions == TangentPolicy.PATH:
        assert dome.slope(0.0)[0] == pytest.approx(before.slope(end_mm)[0], abs=1e-9)


def test_the_band_is_what_is_remembered_and_nothing_twice() -> None:
    """4 µm and 3 µm of scatter are 5 µm: no scatter of touches, no prior between cuts on top."""
    model = fitted(remembered(scatter_mm=0.003))
    budget = model.curves[DOME].budget(np.array([20.0, 40.0]))
    np.testing.assert_allclose(budget.standard_u_mm, 0.005, rtol=1e-3)
    np.testing.assert_allclose(budget.expanded_u_mm, 1.96 * 0.005, rtol=1e-3)
    own = fitted(None).curves[CYLINDER].budget(1.0)
    assert model.curves[CYLINDER].budget(1.0) == own
    assert own.between_cuts_mm > 0.0


def test_bands_alone_leave_the_curve_to_the_touches() -> None:
    model, own = fitted(remembered(corrects=False)), fitted(None)
    s = np.linspace(0.0, model.curves[DOME].length_mm, 40)
    np.testing.assert_array_equal(model.curves[DOME].value_mm(s), own.curves[DOME].value_mm(s))
    np.testing.assert_array_equal(model.residual_mm, own.residual_mm)
    angle = angles_along(MODBAS2.profile, DOME)
    expected = np.interp(s, angle[0], form_mm(angle[1]))
    np.testing.assert_allclose(model.curves[DOME].expected_mm(s)[5:], expected[5:], atol=2e-5)
    np.testing.assert_allclose(model.curves[DOME].budget(s[5:]).standard_u_mm, 0.004, rtol=1e-3)


def test_where_the_dome_goes_over_to_the_cylinder_the_difference_is_uncertain() -> None:
    model = fitted(remembered())
    at_end = model.curves[CYLINDER].value_mm(model.curves[CYLINDER].length_mm)[0]
    off = float(at_end - form_mm(np.array(math.radians(90.0))))
    expected = math.hypot(0.004, off / math.sqrt(3.0))
    assert model.curves[DOME].budget(0.0).standard_u_mm[0] == pytest.approx(expected, rel=1e-3)


def test_a_machine_that_takes_off_twice_as_much_is_asked_for_half() -> None:
    curve = fitted(remembered(gain=2.0)).curves[DOME]
    s, angle = angles_along(MODBAS2.profile, DOME)
    np.testing.assert_allclose(curve.value_mm(s)[8:], 0.5 * form_mm(angle)[8:], atol=2e-5)
    np.testing.assert_allclose(curve.expected_mm(s)[8:] - curve.gain * curve.value_mm(s)[8:], 0.0, atol=4e-5)


def test_an_arc_without_a_touch_is_told_as_well() -> None:
    touches = MODBAS2.touches.chosen(np.flatnonzero(MODBAS2.touches.feature_index != DOME))
    model = fit_profile(MODBAS2.profile, touches, OPTIONS, remembered=remembered())
    s, angle = angles_along(MODBAS2.profile, DOME)
    np.testing.assert_allclose(model.curves[DOME].value_mm(s)[8:], form_mm(angle)[8:], atol=2e-5)


def test_prescribed_ends_stand_above_memory() -> None:
    options = replace(OPTIONS, prescribed={"dome": EndConditions(end_slope=0.0)})
    with_memory, own = (
        fit_profile(MODBAS2.profile, few_touches(), options, remembered=k) for k in (remembered(), None)
    )
    assert with_memory.curves == own.curves


def straight(bend_mm: float) -> ProfileErrorModel:
    """A cylinder of which a parabola with this rise is remembered, each place uncertain by 1 µm."""
    s, _ = angles_along(MODBAS2.profile, CYLINDER)
    rise = 0.010 + bend_mm * (1.0 - (2.0 * s / s[-1] - 1.0) ** 2)
    return fitted(Remembered(np.full(len(s), CYLINDER), s, rise, 0.001**2 * np.eye(len(s)), rise))


def test_a_straight_feature_is_bent_where_that_shows() -> None:
    """15 µm of bow are followed to a tenth of a micrometre; what one standard uncertainty hides is not."""
    bent, flat = (straight(bend_mm).curves[CYLINDER] for bend_mm in (0.015, 0.001))
    s = np.linspace(0.0, bent.length_mm, 21)
    expected = 0.010 + 0.015 * (1.0 - (2.0 * s / bent.length_mm - 1.0) ** 2)
    assert bent.value_mm(s) == pytest.approx(expected, abs=1e-4)
    assert np.ptp(flat.slope(s)) == pytest.approx(0.0, abs=1e-9)
