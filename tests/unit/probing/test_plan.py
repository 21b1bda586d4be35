"""Gauging points: the published coordinates of [6517 Table 1], the angles on the knob of PIECS11, and refusals."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from tests.support.profiles import NOSE_RADIUS_MM, modbas2, piecs11, polyline
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import contact_angle_rad
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.validate import checked_profile
from trueloop.probing.probe_plan import GaugingPoints, Spacing, equally_spaced

INCH = 25.4
MODBAS2_SPACINGS = {
    "cone": Spacing(5, 0.3 * INCH, 0.45 * INCH),
    "cylinder": Spacing(5, 0.3 * INCH, 0.1 * INCH),
    "face": Spacing(1, at_mm=0.05 * INCH),
    "neck": Spacing(1, at_mm=0.25 * INCH),
    "dome": Spacing(20, 0.1 * INCH, 0.1 * INCH),
}


def modbas2_points() -> GaugingPoints:
    return equally_spaced(modbas2(3.52), MODBAS2_SPACINGS)


@pytest.mark.parametrize(
    ("point", "x_mm", "z_mm"),
    [
        (1, 63.87211, -149.1631), (3, 57.05696, -136.858), (5, 50.24184, -124.5529),
        (6, 44.704, -106.934), (8, 44.704, -77.089), (10, 44.704, -47.244), (11, 43.434, -44.704),
        (12, 37.084, -38.354), (13, 36.99706, -34.54598), (14, 36.70041, -31.76392), (22, 27.19286, -11.8695),
        (31, 5.320081, -0.383591), (32, 2.538019, -0.086944),
    ],
)  # fmt: skip
def test_modbas2_points_of_table_1(point: int, x_mm: float, z_mm: float) -> None:
    """[6517 Table 1], part 2511 (P46 = 3.52 in): coordinates printed to seven digits."""
    np.testing.assert_allclose(modbas2_points().nominal_mm[point - 1], (x_mm, z_mm), atol=4e-5)


@pytest.mark.corpus
def test_all_modbas2_points_of_table_1(corpus: Path) -> None:
    with (corpus / "data" / "nist" / "nistir-6517-table1.csv").open() as table:
        published = [(float(row["nominal_x_mm"]), float(row["nominal_z_mm"])) for row in csv.DictReader(table)]
    np.testing.assert_allclose(modbas2_points().nominal_mm, published, atol=4e-5)


def test_piecs11_knob_from_102_3_to_4_6_degrees() -> None:
    """[6811 §5.3]: twenty points on the knob that the nose reaches from 106.85°, 0.1 in of arc from either end."""
    profile = piecs11()
    reachable = nose_centre_path(profile, NOSE_RADIUS_MM).reachable_mm
    points = equally_spaced(profile, {"cone": Spacing(4), "knob": Spacing(20)}, reachable)
    angles = np.degrees(contact_angle_rad(points.outward_normal[4:]))
    assert angles[[0, -1]] == pytest.approx([102.3, 4.6], abs=0.05)
    np.testing.assert_allclose(np.diff(angles), (angles[-1] - angles[0]) / 19, atol=1e-9)
    assert list(points.feature_index) == [2] * 4 + [3] * 20


def test_one_point_lies_in_the_middle_of_what_the_nose_reaches() -> None:
    profile = modbas2()
    path = nose_centre_path(profile, NOSE_RADIUS_MM)
    on_feature = equally_spaced(profile, {"face": Spacing(1)})
    in_reach = equally_spaced(profile, {"face": Spacing(1)}, path.reachable_mm)
    assert on_feature.nominal_mm[0, 0] == pytest.approx(1.61 * INCH)
    assert in_reach.nominal_mm[0, 0] == pytest.approx((1.61 + 0.03125 / 2) * INCH)


def test_points_come_in_the_profiles_order() -> None:
    points = equally_spaced(modbas2(), {"dome": Spacing(2), "cone": Spacing(2)})
    assert list(points.feature_index) == [2, 2, 6, 6]
    assert math.isclose(points.arc_length_mm[0], 2.54)


@pytest.mark.parametrize(
    ("name", "spacing"),
    [
        ("rim", Spacing(3)), ("f0", Spacing(0)), ("f0", Spacing(2)), ("f0", Spacing(1, at_mm=5)),
        ("f0", Spacing(2, -1, 0)),
    ],
)  # fmt: skip
def test_points_that_cannot_be_placed(name: str, spacing: Spacing) -> None:
    profile = checked_profile(polyline([(10.0, 0.0), (10.0, 4.0), (2.0, 4.0)]))
    with pytest.raises(TrueloopError) as refusal:
        equally_spaced(profile, {name: spacing})
    assert refusal.value.code is Code.TCH_PLAN
