"""A displaced contour and its path by hand: an arc whose positions are turned, stretched and moved a little."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.geometry.feature import Arc
from trueloop.turned.compensation.displaced import (
    CentrePiece,
    Constant,
    ShiftedFeature,
    Then,
    displaced_pieces,
    magnitude,
)
from trueloop.turned.compensation.shift import Shift, constant

OFFSET_MM, STRETCH = np.array([0.03, -0.02]), np.array([[0.001, 0.002], [-0.0005, 0.0015]])
NOSE_MM, U_MM = 0.8, 0.05


@dataclass(frozen=True)
class Affine:
    def displacement_mm(self, at_mm: Array) -> Array:
        return np.asarray(OFFSET_MM + at_mm @ STRETCH.T)


@pytest.fixture(params=[1.0, -1.0], ids=["convex", "concave"])
def side(request: pytest.FixtureRequest) -> float:
    return float(request.param)


def arc(side: float) -> Arc:
    """Of 20 mm about (5, −2), from 1.2 rad towards −side."""
    ends = [(5.0 + 20.0 * math.sin(phi), -2.0 + 20.0 * math.cos(phi)) for phi in (1.2, 1.2 - side)]
    return Arc("arc", ends[0], ends[1], (5.0, -2.0), side)


def directions(side: float, s: Array) -> tuple[Array, Array]:
    """Normals and tangents: at s the radius stands at 1.2 − side · s / 20 from +z towards +x."""
    phi = 1.2 - side * s / 20.0
    radial = np.stack([np.sin(phi), np.cos(phi)], axis=-1)
    return side * radial, side * np.stack([-radial[..., 1], radial[..., 0]], axis=-1)


@pytest.mark.parametrize("s", [np.array([0.0, 7.0, 20.0]), np.array(11.0)], ids=["several", "one"])
def test_every_position_of_the_tool_goes_to_itself_and_its_displacement(side: float, s: Array) -> None:
    (piece,) = displaced_pieces([CentrePiece(ShiftedFeature(arc(side), constant(U_MM), NOSE_MM), 0.0, 20.0)], Affine())
    normal, tangent = directions(side, s)
    on_arc = np.array([5.0, -2.0]) + 20.0 * side * normal
    centre = on_arc + (U_MM + NOSE_MM) * normal
    moved = OFFSET_MM + centre @ STRETCH.T
    np.testing.assert_allclose(piece.shifted.centre_mm(s), centre + moved, rtol=0, atol=1e-12)
    np.testing.assert_allclose(piece.shifted.contour_mm(s), on_arc + U_MM * normal + moved, rtol=0, atol=1e-12)
    along = tangent + tangent @ STRETCH.T
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    np.testing.assert_allclose(piece.shifted.tangent(s), along, rtol=0, atol=1e-12)
    at_nominal = OFFSET_MM + (on_arc + NOSE_MM * normal) @ STRETCH.T
    off = U_MM + np.sum(at_nominal * normal, axis=-1)
    np.testing.assert_allclose(piece.shifted.off_nominal_mm(s), off, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(piece.shifted.undisplaced.off_nominal_mm(s), np.full(s.shape, U_MM))


def test_its_size_and_change_count_with_a_shift_of_the_feature_s_own(side: float) -> None:
    """Along the arc the centre goes (1 + κ (R + u)) t a millimetre; the own shift adds its slope along the normal."""
    s, own = np.array([1.0, 8.0, 19.0]), Shift(np.array([]), np.array([[0.01, 0.004]]))
    size, change = magnitude(ShiftedFeature(arc(side), constant(U_MM), NOSE_MM), own, Affine(), s)
    normal, tangent = directions(side, s)
    centre = np.array([5.0, -2.0]) + (20.0 * side + U_MM + NOSE_MM) * normal
    vector = OFFSET_MM + centre @ STRETCH.T + (0.01 + 0.004 * s)[:, None] * normal
    by_mm = (1.0 + side * (NOSE_MM + U_MM) / 20.0) * tangent @ STRETCH.T + 0.004 * normal
    np.testing.assert_allclose(size, np.hypot(*vector.T), rtol=1e-12)
    np.testing.assert_allclose(change, np.hypot(*by_mm.T), rtol=1e-6)


def test_the_second_displacement_is_that_where_the_first_has_moved_to() -> None:
    """50 mm in x and −20 mm in z first, so that the stretch between the places counts."""
    at, first = np.array([[10.0, -3.0], [-7.0, 4.0]]), np.array([50.0, -20.0])
    both = Then(Constant((50.0, -20.0)), Affine()).displacement_mm(at)
    np.testing.assert_allclose(both, first + OFFSET_MM + (at + first) @ STRETCH.T, rtol=1e-14)
    turned_round = Then(Affine(), Constant((50.0, -20.0))).displacement_mm(at)
    np.testing.assert_allclose(both - turned_round, np.tile(first @ STRETCH.T, (2, 1)), atol=1e-12)
