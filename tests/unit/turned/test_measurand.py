"""Sizes as functions of the part error: signs and factors, against shapes displaced by hand."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.turned.shapes import PART
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.geometry.feature import Feature
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


def _moved(feature: Feature, by_z_mm: float) -> Feature:
    (x0, z0), (x1, z1) = feature.start_mm, feature.end_mm
    return replace(feature, start_mm=(x0, z0 + by_z_mm), end_mm=(x1, z1 + by_z_mm))
