"""Stored inspections as errors at points, with a job's profile and without one."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

import trueloop
from trueloop.diagnosis.features.errors_of import errors_of
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.domain.part import Part, PartType
from trueloop.loops.diagnosis.points_of import places_of, points_of
from trueloop.turned.touches.touches import Gauging


def inspection(values: Sequence[Touch | Reading | CmmPoint]) -> Inspection:
    kind = {Touch: "touches", Reading: "readings", CmmPoint: "CMM points"}[type(values[0])]
    return Inspection(Part(PartType("SHAFT"), "7"), kind, "0" * 64, len(values), tuple(values))  # type: ignore[arg-type]


def errors(one: Inspection, u: float | None = None) -> dict[tuple[str, ErrorKind], FeatureError]:
    places = places_of([one])
    return {(e.feature, e.kind): e for e in errors_of(points_of(one, places, standard_u_mm=u), places)}


def diameter(name: str, actual: float, z: float | None, **more: object) -> Reading:
    place = () if z is None else (z,)
    return Reading(name, Quantity.DIAMETER, actual, 40.0, feature="journal", place_mm=place, **more)  # type: ignore[arg-type]


def length(feature: str, other: str, nominal: float, error: float) -> Reading:
    return Reading(feature, Quantity.LENGTH, nominal + error, nominal, feature=feature, other=other, standard_u=0.001)


def test_diameters_are_halved_and_their_repeats_are_kept() -> None:
    one = inspection(
        [diameter("near", 40.010, 10.0), diameter("free", 40.030, 90.0), diameter("near", 40.014, 10.0, repeat=2)]
    )
    seen = points_of(one, places_of([one]))
    assert seen.error_mm.tolist() == pytest.approx([0.005, 0.015, 0.007])
    assert seen.repeat.tolist() == [1, 1, 2]
    assert seen.standard_u_mm == pytest.approx([0.001] * 3)  # half of what is assumed of a reading
    found = errors(one)
    assert found["journal", ErrorKind.RADIUS].value_mm == pytest.approx(0.006)
    assert found["journal", ErrorKind.SHAFT_TAPER].value_mm == pytest.approx(0.009)


def test_an_oversize_bore_lacks_material() -> None:
    bore = Reading("bore", Quantity.DIAMETER, 10.02, 10.0, side="inner")
    assert errors(inspection([bore]))["bore", ErrorKind.RADIUS].value_mm == pytest.approx(-0.010)


@pytest.mark.parametrize("z", [None, -10.0, 10.0])
def test_lengths_that_count_from_each_other_are_each_their_own_error(z: float | None) -> None:
    """Each from the face nearer to the chuck: z counts into the part, unless diameters were read on its other side."""
    readings = [length("b", "a", 50.0, 0.010), length("c", "b", 30.0, -0.004), diameter("j", 40.0, z)]
    found = errors(inspection(readings))
    names = (("b", "a"), ("c", "b")) if z == 10.0 else (("a", "b"), ("b", "c"))
    first, second = (found[feature, ErrorKind.LENGTH] for feature, _ in names)
    assert (first.other, second.other) == tuple(other for _, other in names)
    assert first.value_mm == pytest.approx(0.010)
    assert first.standard_u_mm == pytest.approx(0.001)
    assert second.value_mm == pytest.approx(-0.004)


@pytest.mark.parametrize("with_profile", [True, False])
def test_touches_are_those_of_a_correction(with_profile: bool) -> None:
    profile = trueloop.read_part(trueloop.example("modbas2/job.toml")).profile
    touches = trueloop.read_touches(trueloop.example("modbas2/touches.csv"))
    one = inspection(touches)
    seen = points_of(one, places_of([one], profile if with_profile else None))
    vectors = trueloop.error_vectors(profile, touches, Gauging())
    expected = {
        tuple(at): (error, u)
        for at, error, u in zip(
            vectors.nominal_mm.round(6).tolist(), vectors.error_mm, vectors.standard_u_mm, strict=True
        )
    }
    assert len(seen.feature) == len(touches) if with_profile else len(seen.feature) > 5
    for at, error, u in zip(seen.nominal_mm.round(6).tolist(), seen.error_mm, seen.standard_u_mm, strict=True):
        assert (error, u) == pytest.approx(expected[tuple(at)], rel=0.01)


def cmm(angle: float, z: float, error: float, radius: float = 20.0, out: float = 1.0) -> CmmPoint:
    x, y = math.cos(angle), math.sin(angle)
    measured = radius + out * error
    return CmmPoint((measured * x, measured * y, z), (radius * x, radius * y, z), (out * x, out * y, 0.0), f"P{z}")


def test_points_of_a_measuring_machine_have_angles() -> None:
    angles = np.arange(8) * math.pi / 4
    values = [cmm(a, z, 0.004 + 0.02 * math.cos(a - 0.5)) for z in (5.0, 45.0) for a in angles]
    found = errors(inspection(values), u=1e-5)
    (name,) = {feature for feature, _ in found}
    ecc = found[name, ErrorKind.ECCENTRICITY]
    assert ecc.value_mm == pytest.approx(0.02, rel=1e-4)
    assert ecc.more["highest_rad"] == pytest.approx(0.5, abs=1e-4)
    assert found[name, ErrorKind.RADIUS].value_mm == pytest.approx(0.004, abs=1e-6)


def test_points_of_one_place_are_repeats_in_their_order() -> None:
    one = inspection([cmm(0.0, 5.0, e) for e in (0.001, 0.002, 0.003)] + [cmm(0.0, 45.0, 0.0)])
    seen = points_of(one, places_of([one]), standard_u_mm=0.0007)
    assert seen.repeat.tolist() == [1, 2, 3, 1]
    assert seen.standard_u_mm.tolist() == [0.0007] * 4


def test_unnamed_points_make_features_by_place_and_normal() -> None:
    values = [
        *(cmm(0.0, z, 0.003) for z in (5.0, 45.0)),
        *(cmm(0.0, z, 0.002, 8.0, -1.0) for z in (20.0, 48.0)),
        *(CmmPoint((x, 0.0, 50.006), (x, 0.0, 50.0), (0.0, 0.0, 1.0), f"F{x}") for x in (9.0, 19.0)),
    ]
    found = errors(inspection(values), u=0.001)
    sizes = {kind: error.value_mm for (feature, kind), error in found.items() if not feature.startswith("bore")}
    assert sizes[ErrorKind.RADIUS] == pytest.approx(0.003)
    assert sizes[ErrorKind.FACE_TAPER] == pytest.approx(0.0, abs=1e-9)
    bore = next(e for (feature, kind), e in found.items() if feature.startswith("bore") and kind is ErrorKind.RADIUS)
    assert bore.value_mm == pytest.approx(0.002)


def test_what_a_cut_was_to_leave_on_is_no_error() -> None:
    touch = [Touch(f"p{z}", (20.0, z), "journal", error_mm=0.3 + 0.004) for z in (5.0, 45.0)]
    one = inspection(touch)
    seen = points_of(one, places_of([one]), Gauging(allowance_mm=0.3))
    assert seen.error_mm == pytest.approx([0.004, 0.004])


def test_values_of_no_feature_are_left_out() -> None:
    one = inspection([Reading("round", Quantity.FORM, 0.002, 0.0, feature="journal")])
    assert places_of([one]) == {}
    assert points_of(one, {}).feature == ()
    journal = inspection([diameter("near", 40.01, 10.0)])
    assert points_of(one, places_of([journal])).feature == ()
