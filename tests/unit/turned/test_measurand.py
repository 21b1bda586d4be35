"""Sizes as functions of the part error: signs and factors, against shapes displaced by hand."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.support.curves import LENS
from tests.support.profiles import simple
from tests.unit.turned.shapes import PART
from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.profile import Profile
from trueloop.turned.characteristics.measurand import Measurand, measurand

TOUCHES = np.array([4, 5, 3, 2, 20])
DIAMETER = Characteristic("D", Quantity.DIAMETER, "cylinder", 0.0)
LENGTH = Characteristic("L", Quantity.LENGTH, "face", 0.0)


def sizes(asked: Characteristic) -> Measurand:
    return measurand(PART, asked, TOUCHES)


def of_constant(asked: Characteristic, error_mm: float) -> list[float]:
    found = sizes(asked)
    return [float(size) for size in found.nominal + found.gains @ np.full(len(found.arc_length_mm), error_mm)]


def test_material_left_on_makes_a_diameter_larger_by_twice_the_error() -> None:
    assert of_constant(DIAMETER, 0.010) == pytest.approx([89.408 + 0.020] * len(sizes(DIAMETER).nominal))


def test_a_cone_with_material_left_on_is_larger_at_a_fixed_z() -> None:
    """The cone displaced along its normal crosses z where its radius is larger by e/n_x."""
    cone, z = PART.features[0], -130.0
    (found,) = of_constant(replace(DIAMETER, feature="cone", at_z_mm=z), 0.010)
    ends = np.array([cone.point_mm(s) + 0.010 * cone.outward_normal(s) for s in (0.0, cone.length_mm)])
    radius = np.interp(z, ends[:, 1], ends[:, 0])

    assert found == pytest.approx(2.0 * radius, abs=1e-9)


def test_a_place_on_an_arc_is_found_by_its_z() -> None:
    found = sizes(replace(DIAMETER, feature="dome", at_z_mm=-30.0))

    assert found.nominal[0] == pytest.approx(2.0 * np.sqrt(37.084**2 - 7.084**2))


def test_material_left_on_a_face_makes_the_length_to_the_chuck_end_longer() -> None:
    """The face looks to +z at z −44.704: its distance from the part's zero, at the free end, gets smaller."""
    assert of_constant(LENGTH, 0.010) == pytest.approx([44.704 - 0.010])


def test_what_moves_both_faces_changes_no_length_between_them() -> None:
    stepped = replace(PART, features=(*PART.features[:3], replace(PART.features[2], name="second")))
    shorter = replace(stepped, features=(*stepped.features[:3], _moved(stepped.features[3], -10.0)))
    found = measurand(shorter, replace(LENGTH, other="second"), np.array([4, 5, 3, 2]))
    of_first = np.where(found.feature_index == 2, 0.010, 0.0)

    assert found.nominal == pytest.approx([10.0])
    assert found.gains @ np.ones(len(found.arc_length_mm)) == pytest.approx([0.0])
    assert found.gains @ of_first == pytest.approx([0.010])  # the one nearer to the free end stands proud


def displaced(index: int, error_of: Callable[[Array], Array], s: Array) -> Array:
    """Points of a feature moved along its normal."""
    feature = PART.features[index]
    return feature.point_mm(s) + error_of(s)[:, None] * feature.outward_normal(s)


def test_material_left_on_towards_the_wide_end_makes_a_cone_steeper() -> None:
    """The cone narrows towards the free end; the angle of the line through its displaced points, by their slope."""
    cone = PART.features[0]
    found = sizes(Characteristic("A", Quantity.ANGLE, "cone", 0.0))
    points = displaced(0, lambda s: 0.010 * (1.0 - s / cone.length_mm), np.array([0.0, cone.length_mm]))
    (dx, dz) = points[1] - points[0]
    error = 0.010 * (1.0 - found.arc_length_mm / cone.length_mm)

    assert found.nominal[0] == pytest.approx(np.degrees(np.arctan2(22.86, 41.275)))
    assert (found.nominal + found.gains @ error)[0] == pytest.approx(np.degrees(np.arctan2(-dx, dz)), abs=1e-7)
    assert np.degrees(np.arctan2(-dx, dz)) > found.nominal[0]


def test_a_radius_is_that_of_the_circle_through_the_displaced_arc() -> None:
    """A convex arc with 10 µm left on is larger by 10 µm; moved as a whole it is not."""
    asked = Characteristic("R", Quantity.RADIUS, "dome", 0.0)
    found = sizes(asked)
    normals = PART.features[4].outward_normal(found.arc_length_mm)

    assert of_constant(asked, 0.010) == pytest.approx([37.094])
    assert found.gains @ (normals @ np.array([0.02, -0.01])) == pytest.approx([0.0], abs=1e-12)


def test_a_concave_radius_with_material_left_on_is_smaller() -> None:
    fillet = Arc("fillet", (20.0, -30.0), (15.0, -25.0), (20.0, -25.0), -math.pi / 2)
    part = Profile((fillet,), ())
    found = measurand(part, Characteristic("R", Quantity.RADIUS, "fillet", 0.0), np.array([9]))

    assert found.nominal + found.gains @ np.full(len(found.arc_length_mm), 0.010) == pytest.approx([4.990])


def test_form_is_what_a_line_leaves() -> None:
    found = sizes(Characteristic("F", Quantity.FORM, "cylinder", 0.0))
    s = found.arc_length_mm

    assert found.gains @ (0.003 + 0.001 * s) == pytest.approx(np.zeros(len(s)), abs=1e-12)
    assert np.ptp(found.gains @ (1e-5 * (s - s.mean()) ** 2)) == pytest.approx(1e-5 * np.max((s - s.mean()) ** 2))


def test_form_of_a_curve_is_its_profile_deviation() -> None:
    """Moved along z it keeps its form; moved away from the axis, or larger all around, it does not."""
    curve = LENS.curve()
    found = measurand(Profile((curve,), ()), Characteristic("F", Quantity.FORM, "lens", 0.0), np.array([15]))
    normal = curve.outward_normal(found.arc_length_mm)

    assert found.gains @ (0.01 * normal[:, 1]) == pytest.approx(np.zeros(len(normal)), abs=1e-15)
    assert np.ptp(found.gains @ (0.01 * normal[:, 0])) > 0.004
    sphere = 0.01 * np.ones(len(normal)) - 0.01 * normal[:, 1] * np.sum(normal[:, 1]) / np.sum(normal[:, 1] ** 2)
    assert found.gains @ np.full(len(normal), 0.01) == pytest.approx(sphere, abs=1e-15)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (replace(DIAMETER, feature="face"), "give at_z_mm"),
        (replace(DIAMETER, feature="cone"), "give at_z_mm"),
        (replace(DIAMETER, at_z_mm=-10.0), "is not on it"),
        (replace(DIAMETER, feature="dome", at_z_mm=-0.1), "faces along z"),
        (replace(LENGTH, feature="cylinder"), "is none"),
        (replace(LENGTH, other="cone"), "is none"),
        (replace(LENGTH, other="face"), "second face"),
        (Characteristic("A", Quantity.ANGLE, "cylinder", 0.0), "no cone"),
        (Characteristic("R", Quantity.RADIUS, "cone", 0.0), "no arc"),
        (Characteristic("P", Quantity.POSITION, "cone", 0.0), "not judged"),
        (Characteristic("N", Quantity.DIAMETER, "bore", 0.0), "does not have"),
    ],
)
def test_what_a_feature_cannot_have_is_refused(asked: Characteristic, words: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        sizes(asked)
    assert refused.value.code in (Code.TOL_PLACE, Code.TOL_FEATURE)
    assert words in str(refused.value)


def _moved(feature: Feature, by_z_mm: float) -> Feature:
    (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
    return replace(simple(feature), start_mm=(x0, z0 + by_z_mm), end_mm=(x1, z1 + by_z_mm))
