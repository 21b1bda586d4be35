"""Gauging points turned about the part's axis."""

import math

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile, junctions_of
from trueloop.probing.cmm_plan import CmmTouch, cmm_plan, turned
from trueloop.probing.probe_plan import Spacing, equally_spaced

FEATURES = (
    Line("cylinder", (20.0, -50.0), (20.0, -20.0)),
    Line("cone", (20.0, -20.0), (10.0, -10.0)),
    Arc("dome", (10.0, -10.0), (0.0, 0.0), (0.0, -10.0), math.pi / 2),
)
PROFILE = Profile(FEATURES, junctions_of(FEATURES))


def _plan(*angles_deg: float, diameters: bool = False) -> tuple[CmmTouch, ...]:
    points = equally_spaced(PROFILE, {"cylinder": Spacing(1), "cone": Spacing(1)})
    return cmm_plan(PROFILE, points, ["a", "b"], angles_deg, diameters=diameters)


def test_at_angle_zero_a_point_lies_where_the_profile_is_drawn() -> None:
    cylinder, cone = _plan(0.0)
    assert (cylinder.name, cylinder.nominal_mm, cylinder.outward_normal) == ("a", (20.0, 0.0, -35.0), (1.0, 0.0, 0.0))
    assert cone.nominal_mm == pytest.approx((15.0, 0.0, -15.0))
    assert cone.outward_normal == pytest.approx((math.sqrt(0.5), 0.0, math.sqrt(0.5)))


@pytest.mark.parametrize(
    ("angle_deg", "x", "y"), [(90.0, 0.0, 20.0), (180.0, -20.0, 0.0), (270.0, 0.0, -20.0), (-90.0, 0.0, -20.0)]
)
def test_quarter_turns_from_x_to_y_are_exact(angle_deg: float, x: float, y: float) -> None:
    assert turned((20.0, -35.0), angle_deg) == (x, y, -35.0)


def test_another_angle() -> None:
    assert turned((20.0, 5.0), 30.0) == pytest.approx((20.0 * math.sqrt(3) / 2, 10.0, 5.0))


def test_with_diameters_a_cylinder_is_touched_on_both_sides_and_a_cone_is_not() -> None:
    points = _plan(0.0, diameters=True)
    assert [point.name for point in points] == ["a_0", "a_180", "b"]
    assert points[1].nominal_mm == (-20.0, 0.0, -35.0)
    assert points[1].outward_normal == (-1.0, 0.0, 0.0)


def test_opposite_angles_with_diameters_name_each_point_once() -> None:
    assert [point.name for point in _plan(0.0, 180.0, diameters=True)] == ["a_0", "a_180", "b_0", "b_180"]


@pytest.mark.parametrize("angles_deg", [(), (0.0, 0.0), (0.0, 360.0), (math.nan,), (math.inf,)])
def test_angles_that_are_none_are_refused(angles_deg: tuple[float, ...]) -> None:
    with pytest.raises(TrueloopError) as refused:
        _plan(*angles_deg)
    assert refused.value.code is Code.TCH_PLAN
