"""Points of a measuring machine on a turned profile: axis, distance, sign, ball, and what is not certain."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.profiles import modbas2
from trueloop.domain.inspection import CmmPoint, Inspection, Vector
from trueloop.domain.part import Part, PartType
from trueloop.geometry.feature import Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import Axis, Matches

PROFILE = modbas2()
SHAFT_CORNER = checked_profile(
    [
        Line("a", (10.0, -9.0), (10.0, -5.0)),
        Line("back", (10.0, -5.0), (12.0, -5.0)),
        Line("b", (12.0, -5.0), (12.0, 0.0)),
    ]
)
FACE = PROFILE.names.index("face")
TURNED: dict[Axis, tuple[int, int, int]] = {"z": (0, 1, 2), "x": (1, 2, 0), "y": (2, 0, 1)}
"""Where x (across), y and z (along) of the part go in a frame whose spindle is along that axis."""


def inspection(points: list[CmmPoint], ball_radius_mm: float = 0.0) -> Inspection:
    whole = Inspection(Part(PartType("MODBAS2")), "CMM points", "0" * 64, len(points), tuple(points))
    return replace(whole, ball_radius_mm=ball_radius_mm)


def touched(
    error_mm: float, angle: float, ball_mm: float = 0.0, *, nominal: bool = True, normals: bool = True
) -> list[CmmPoint]:
    """A point in the middle of each feature, at an angle about the axis, that much off along the normal."""
    points = []
    for feature in PROFILE.features:
        s = feature.length_mm / 2
        (x, z), (n_x, n_z) = feature.point_mm(s), feature.outward_normal(s)
        at = np.array([x * math.cos(angle), x * math.sin(angle), z])
        normal = np.array([n_x * math.cos(angle), n_x * math.sin(angle), n_z])
        measured = at + (error_mm + ball_mm) * normal
        points.append(
            CmmPoint(_vector(measured), _vector(at) if nominal else None, _vector(normal) if normals else None, "P")
        )
    return points


def _vector(values: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> Vector:
    x, y, z = (float(one) for one in values)
    return x, y, z


def in_frame(point: CmmPoint, axis: Axis) -> CmmPoint:
    order, sign = TURNED[axis[-1]], -1.0 if axis[0] == "-" else 1.0  # type: ignore[index]

    def turned(place: Vector | None) -> Vector | None:
        if place is None:
            return None
        out = [0.0, 0.0, 0.0]
        for k, value in zip(order, (place[0], place[1], sign * place[2]), strict=True):
            out[k] = value
        return out[0], out[1], out[2]

    measured = turned(point.measured_mm)
    assert measured is not None
    return CmmPoint(measured, turned(point.nominal_mm), turned(point.outward_normal), point.name)


@given(
    st.floats(-0.4, 0.4),
    st.floats(-math.pi, math.pi),
    st.sampled_from([0.0, 1.5]),
    st.sampled_from(["x", "y", "z", "-x", "-y", "-z"]),
)
def test_a_point_has_the_error_that_was_put_into_it(error_mm: float, angle: float, ball: float, axis: Axis) -> None:
    points = [in_frame(one, axis) for one in touched(error_mm, angle, ball)]
    found = match_inspection(PROFILE, inspection(points, ball), axis=axis)
    assert [one.feature_index for one in found.touches] == list(range(len(PROFILE.features)))
    assert [one.touch.error_mm for one in found.touches] == pytest.approx([error_mm] * len(points), abs=1e-9)


@pytest.mark.parametrize("axis", ["x", "y", "z", "-x", "-y", "-z"])
@pytest.mark.parametrize("normals", [True, False])
def test_the_axis_of_the_spindle_is_found_and_z_is_taken_where_it_fits(axis: Axis, normals: bool) -> None:
    points = [in_frame(one, axis) for one in touched(0.01, 0.7, normals=normals)]
    assert match_inspection(PROFILE, inspection(points)).axis == axis


@pytest.mark.parametrize("ball", [0.0, 2.0])
def test_a_point_without_a_nominal_has_the_nearest_place_as_its_own(ball: float) -> None:
    found = match_inspection(PROFILE, inspection(touched(0.02, 0.3, ball, nominal=False, normals=False), ball))
    assert [one.feature_index for one in found.touches] == list(range(len(PROFILE.features)))
    for one, feature in zip(found.touches, PROFILE.features, strict=True):
        assert one.touch.error_mm == pytest.approx(0.02, abs=1e-9)
        assert one.touch.nominal_mm == pytest.approx(feature.point_mm(feature.length_mm / 2).tolist(), abs=1e-9)
        assert one.distance_mm == pytest.approx(0.02, abs=1e-9)


def corner(profile: Profile, index: int) -> Vector:
    x, z = profile.features[index].start_mm
    return x, 0.0, z


def on_corner(normal: Vector | None) -> Matches:
    at = corner(PROFILE, FACE)
    others = touched(0.0, 0.0)
    return match_inspection(PROFILE, inspection([*others, CmmPoint(at, at, normal, "corner")]))


def test_a_nominal_point_on_a_corner_is_of_the_feature_that_its_normal_says_or_of_none() -> None:
    assert PROFILE.names[on_corner((0.0, 0.0, 1.0)).touches[-1].feature_index] == "face"
    assert PROFILE.names[on_corner((1.0, 0.0, 0.0)).touches[-1].feature_index] == "cylinder"
    (left,) = on_corner(None).left
    assert set(left.candidates) == {"cylinder", "face"}


def test_points_off_the_part_or_in_another_frame_are_left_with_their_distance() -> None:
    points = touched(0.0, 0.0)
    x, y, z = points[3].measured_mm
    away = CmmPoint((x + 3.0, y, z), (x + 3.0, y, z), None, "away")
    (left,) = match_inspection(PROFILE, inspection([*points * 2, away])).left
    assert "3.000 mm from 'cylinder'" in left.reason
    device = replace(inspection(points), frame="device")
    found = match_inspection(PROFILE, device)
    assert found.count == 0
    assert all("device's zero" in one.reason for one in found.left)
    nowhere = [CmmPoint((x + 500.0, y, z), None, None, "far") for x, y, z in (one.measured_mm for one in points)]
    assert match_inspection(PROFILE, inspection(nowhere)).axis is None


@pytest.mark.parametrize(
    ("off", "moved_mm", "said"),
    [(2, 0.0, "; along z 80% do: --axis z takes these"), (0, 4.0, "; along z moved by -4 mm they do")],
)
def test_points_that_do_not_lie_on_the_profile_say_what_would_bring_them_there(
    off: int, moved_mm: float, said: str
) -> None:
    """Ten points on a shaft of 4 mm, of which two are 5 mm out, or all are counted from its chuck end."""
    shaft = checked_profile([Line("a", (10.0, -4.0), (10.0, -2.0)), Line("f", (10.0, -2.0), (8.0, -2.0))])
    shaft = checked_profile([*shaft.features, Line("b", (8.0, -2.0), (8.0, 0.0)), Line("e", (8.0, 0.0), (0.0, 0.0))])
    places: list[Vector] = [(8.0 + (5.0 if k < off else 0.0), 0.0, -1.9 + 0.2 * k + moved_mm) for k in range(10)]
    found = match_inspection(shaft, inspection([CmmPoint(place, place) for place in places]))
    assert found.axis is None and all(said in left.reason for left in found.left)


def test_an_error_that_is_not_credible_is_left() -> None:
    found = match_inspection(PROFILE, inspection(touched(1.5, 0.0)))
    assert found.count == 0
    assert all("+1.500 mm" in one.reason for one in found.left)


@pytest.mark.parametrize("axis", ["z", "-z", "x", "-x"])
def test_a_stated_normal_turns_with_its_frame(axis: Axis) -> None:
    at = corner(SHAFT_CORNER, 1)
    point = in_frame(CmmPoint(at, at, (0.0, 0.0, -1.0), "corner"), axis)
    found = match_inspection(SHAFT_CORNER, inspection([point]), axis=axis)
    assert [one.touch.feature for one in found.touches] == ["back"]
