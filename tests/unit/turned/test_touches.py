"""Touches to error vectors: sign, ball, allowance, z reference and uncertainty."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.profiles import modbas2, piecs11
from trueloop.arrays import Array
from trueloop.domain.inspection import Touch
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Point
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, error_vectors, standard_uncertainty_mm

PARTS = {"MODBAS2": modbas2(), "PIECS11": piecs11()}
CYLINDER, FACE, DOME = 3, 4, 6

part_errors_mm = st.floats(-0.2, 0.2)
small_mm = st.floats(-0.01, 0.01)
balls_mm = st.floats(0.0, 4.0)


def _pair(vector: Array) -> Point:
    return float(vector[0]), float(vector[1])


@st.composite
def probed(draw: st.DrawFn) -> tuple[str, Array, list[Touch], Gauging]:
    """A part touched once a feature, in order: the true errors, what the probe reported, and how it probed."""
    name = draw(st.sampled_from(sorted(PARTS)))
    gauging = Gauging(ball_radius_mm=draw(balls_mm), allowance_mm=draw(part_errors_mm))
    errors, touches = [], []
    for feature in PARTS[name].features:
        s = draw(st.floats(0.05, 0.95)) * feature.length_mm
        error, along = draw(part_errors_mm), draw(small_mm)
        nominal, normal, tangent = feature.point_mm(s), feature.outward_normal(s), feature.tangent(s)
        stands_off = error + gauging.ball_radius_mm + gauging.allowance_mm
        ball_centre = nominal + stands_off * normal + along * tangent
        touches.append(Touch(feature.name, _pair(nominal), draw(st.sampled_from([feature.name, None]))))
        touches[-1] = replace(touches[-1], measured_mm=_pair(ball_centre))
        errors.append(error)
    return name, np.array(errors), touches, gauging


@given(probed())
def test_the_error_is_what_the_ball_stood_off_along_the_normal(case: tuple[str, Array, list[Touch], Gauging]) -> None:
    """Ball radius and allowance come off, what the touch missed along the surface does not count."""
    name, errors, touches, gauging = case
    vectors = error_vectors(PARTS[name], touches, gauging)
    assert np.allclose(vectors.error_mm, errors, rtol=0, atol=1e-12)
    assert list(vectors.feature_index) == list(range(len(PARTS[name].features)))


@pytest.mark.parametrize("feature, outwards", [(CYLINDER, (1.0, 0.0)), (FACE, (0.0, 1.0))])
def test_an_oversize_shaft_and_a_proud_face_have_positive_errors(feature: int, outwards: Point) -> None:
    profile = modbas2()
    x, z = _pair(profile.features[feature].point_mm(5.0))
    touch = Touch("1", (x, z), measured_mm=(x + 0.02 * outwards[0], z + 0.02 * outwards[1]))
    assert error_vectors(profile, [touch], Gauging()).error_mm[0] == pytest.approx(0.02, abs=1e-13)


def test_stated_errors_are_part_errors_already() -> None:
    """Neither the ball nor the allowance is taken off a column of errors."""
    touch = Touch("1", _pair(modbas2().features[DOME].point_mm(10.0)), error_mm=-0.0123)
    vectors = error_vectors(modbas2(), [touch], Gauging(ball_radius_mm=2.0, allowance_mm=0.254))
    assert vectors.error_mm[0] == -0.0123


def test_gauging_uncertainty_as_published() -> None:
    """[6811 §5.1]: ranges of 1.5 µm on diameters and 0.5 µm on faces give 0.43 µm and 0.14 µm."""
    cylinder, face = standard_uncertainty_mm(np.array([[1.0, 0.0], [0.0, -1.0]]), Gauging())
    assert f"{cylinder * 1000:.2f} {face * 1000:.2f}" == "0.43 0.14"


def test_uncertainty_is_that_of_uniform_readings_along_the_normal() -> None:
    """Against draws from the two ranges: no formula in common."""
    gauging = Gauging(range_x_mm=0.004, range_z_mm=0.001)
    normal = np.array([math.sin(0.7), math.cos(0.7)])
    readings = np.random.default_rng(7).uniform(-0.5, 0.5, (400_000, 2)) * [0.004, 0.001]
    assert standard_uncertainty_mm(normal, gauging)[0] == pytest.approx(np.std(readings @ normal), rel=5e-3)


def _touched(shift_z_mm: float, z_reference: str | None) -> ErrorVectors:
    """The dome's part errors 0.01 mm, measured in a frame that lies `shift_z_mm` off along z."""
    profile, touches = modbas2(), []
    for k, feature in enumerate(profile.features):
        s = 0.5 * feature.length_mm
        nominal, normal = feature.point_mm(s), feature.outward_normal(s)
        error = 0.0 if k == FACE else 0.01
        measured = nominal + error * normal + [0.0, shift_z_mm]
        touches.append(Touch(feature.name, _pair(nominal), measured_mm=_pair(measured)))
    return error_vectors(profile, touches, Gauging(z_reference=z_reference))


@given(st.floats(-0.3, 0.3))
def test_the_z_reference_takes_out_any_shift_of_the_frame(shift_z_mm: float) -> None:
    vectors = _touched(shift_z_mm, modbas2().names[FACE])
    errors = np.full(7, 0.01)
    errors[FACE] = 0.0
    assert np.allclose(vectors.error_mm, errors, rtol=0, atol=1e-12)
    assert vectors.error_mm[FACE] == 0.0
    assert list(np.flatnonzero(vectors.at_reference)) == [FACE]


def test_without_a_reference_the_shift_shows_by_the_normals_z() -> None:
    """A cylinder does not see it, a face sees all of it."""
    seen = _touched(0.1, None).error_mm - _touched(0.0, None).error_mm
    normals = [f.outward_normal(0.5 * f.length_mm)[1] for f in modbas2().features]
    assert np.allclose(seen, 0.1 * np.array(normals), rtol=0, atol=1e-12)
    assert not np.any(_touched(0.1, None).at_reference)


def test_the_references_own_uncertainty_is_shared_by_what_faces_z() -> None:
    names = modbas2().names
    alone, referred = _touched(0.0, None).standard_u_mm, _touched(0.0, names[FACE]).standard_u_mm
    assert referred[CYLINDER] == alone[CYLINDER]
    assert referred[names.index("collar face")] == pytest.approx(math.sqrt(2) * alone[FACE], rel=1e-12)
    assert np.all(referred >= alone)


def test_what_a_touch_has_of_its_own_is_the_same_with_and_without_a_reference() -> None:
    alone, referred = _touched(0.0, None), _touched(0.0, modbas2().names[FACE])
    assert np.array_equal(alone.own_u_mm, alone.standard_u_mm)
    np.testing.assert_allclose(referred.own_u_mm, alone.standard_u_mm, rtol=1e-12)


@pytest.mark.parametrize("reference, says", [("99", "not one of the 7 touches"), ("cylinder", "faces x")])
def test_a_reference_that_cannot_be_one_is_refused(reference: str, says: str) -> None:
    with pytest.raises(TrueloopError, match=says) as refusal:
        _touched(0.0, reference)
    assert refusal.value.code is Code.TCH_REFERENCE


def test_no_touches_are_refused() -> None:
    with pytest.raises(TrueloopError, match="there are 0 touches"):
        error_vectors(modbas2(), [], Gauging())
