"""Features without a touch: what all touches of the part show of them, against errors drawn by models of their own."""

import math

import numpy as np
import pytest

from tests.support.correction import example_inputs
from tests.support.profiles import polyline
from tests.support.touched import touched
from trueloop.arrays import Array
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile

UM = 1e-3
SHAFT_UM = (14.0, 17.0, 19.0, 22.0, 25.0, 27.0)
"""Errors of six diameters; a cone lies between the third and the fourth."""


def shaft(cone_deg: float = 5.0) -> Profile:
    """Six diameters with faces between them, and in the middle a cone: chuck end left, diameters falling."""
    points, z = [(40.0, -140.0)], -140.0
    for k in range(6):
        z += 20.0
        points.append((points[-1][0], z))
        if k == 2:
            z += 10.0
            points.append((points[-1][0] - 10.0 * math.tan(math.radians(cone_deg)), z))
        elif k < 5:
            points.append((points[-1][0] - 2.0, z))
    names = [f"d{k}" if odd == 0 else f"between{k}" for k in range(6) for odd in (0, 1)][:11]
    return checked_profile(polyline(points, names))


def diameters_touched(profile: Profile) -> ProfileErrorModel:
    index = {feature.name: i for i, feature in enumerate(profile.features)}
    counts = [2 if feature.name.startswith("d") else 0 for feature in profile.features]

    def error_of(points: Array, normals: Array) -> Array:
        names = [f"d{k}" for k in range(6) for _ in range(2)]
        assert [index[name] for name in names] == sorted(index[name] for name in names)
        return np.array([SHAFT_UM[int(name[1])] * UM for name in names])

    return fit_profile(profile, touched(profile, counts, error_of, 0.0004))


def curve_of(model: ProfileErrorModel, name: str) -> "tuple[Array, Array]":
    """Values and standard uncertainties in µm at both ends and in the middle."""
    curve = model.curves[model.profile.names.index(name)]
    s = np.array([0.0, 0.5, 1.0]) * curve.length_mm
    return curve.value_mm(s) / UM, curve.standard_deviation_mm(s) / UM


@pytest.mark.parametrize("error_um", [20.0, -20.0])
def test_one_touched_diameter_shows_a_cone_the_less_the_steeper_it_is(error_um: float) -> None:
    """The setting of the tool along x shows as the cosine of the cone's angle, by the sign of the touched error."""
    shares, us = [], []
    for cone_deg in (1.0, 15.0, 30.0, 45.0):
        t = math.tan(math.radians(cone_deg))
        profile = checked_profile(polyline([(40.0, -60.0), (40.0, -30.0), (30.0, -30.0), (30.0 - 10.0 * t, -20.0)]))
        curve = fit_profile(profile, touched(profile, [1, 0, 0], lambda p, n: np.array([error_um * UM]))).curves[2]
        shares.append(curve.value_mm(0.5 * curve.length_mm)[0] / (error_um * UM))
        us.append(curve.standard_deviation_mm(0.5 * curve.length_mm)[0])
    assert 0.6 < shares[0] < 1.0 and np.all(np.diff(shares) < 0.0) and shares[3] > 0.0
    assert np.all(np.diff(us) > 0.0)


def test_larger_errors_than_expected_make_larger_uncertainties() -> None:
    """The uncertainty of a cone beside a touch of 100 µm and of 10 µm: mostly of the setting, which both share."""
    u = [
        fit_profile(shaft(), touched(shaft(), [2, *[0] * 10], lambda p, n, e=e: np.full(2, e)))  # type: ignore[misc]
        .curves[5]
        .standard_deviation_mm(5.0)[0]
        for e in (0.010, 0.100)
    ]
    assert u[1] > 1.1 * u[0]


def test_a_cone_between_touched_diameters_is_corrected_and_its_corners_stay() -> None:
    """The true error of the cone is like its neighbours', 19 to 22 µm."""
    model = diameters_touched(shaft())
    value, u = curve_of(model, "between2")
    assert np.all(np.abs(value - 20.5) < 4.0)
    assert np.all((u > 3.0) & (u < 25.0))
    for before, after, other_um in (("d2", "between2", 19.0), ("between2", "d3", 22.0)):
        (junction,) = (
            j
            for j in model.junctions
            if j.before is not None
            and j.after is not None
            and (model.profile.names[j.before], model.profile.names[j.after]) == (before, after)
        )
        assert junction.gap_mm < 1e-9
        assert abs(junction.displacement_mm[0] / UM - other_um) < 0.5  # the touched neighbour's own
        assert abs(junction.displacement_mm[1] / UM) < 45.0  # no further than both errors together


@pytest.mark.parametrize("cone_deg", [0.5, 1.0, 2.0, 5.0, 20.0, 45.0])
def test_however_flat_a_corner_it_moves_no_further_than_both_errors(cone_deg: float) -> None:
    model = diameters_touched(shaft(cone_deg))
    untouched = model.profile.names.index("between2")
    for junction in model.junctions:
        if untouched in (junction.before, junction.after):
            assert junction.error_before_mm is not None and junction.error_after_mm is not None
            most = abs(junction.error_before_mm) + abs(junction.error_after_mm)
            assert np.linalg.norm(junction.displacement_mm) < 1.5 * most


def test_faces_stay_as_programmed_where_only_diameters_were_touched() -> None:
    model = diameters_touched(shaft())
    for name in ("between0", "between1", "between3", "between4"):
        value, u = curve_of(model, name)
        np.testing.assert_array_equal(value, 0.0)
        assert np.all(u > 15.0)
        assert model.curves[model.profile.names.index(name)].unsupported
        (note,) = (note for note in model.notes if note.startswith(f"{name}:"))
        assert "left as programmed" in note


def test_a_fillet_to_a_face_leads_from_the_one_error_to_the_other() -> None:
    """Cylinder touched, fillet and face not: the fillet begins with the cylinder's error, the face has little of it."""
    features: list[Feature] = [
        Line("cylinder", (20.0, -40.0), (20.0, -5.0)),
        Arc("fillet", (20.0, -5.0), (15.0, 0.0), (15.0, -5.0), math.pi / 2),
        Line("face", (15.0, 0.0), (0.0, 0.0)),
    ]
    profile = checked_profile(features)
    assert [junction.kind for junction in profile.junctions] == [JunctionKind.TANGENT] * 2
    model = fit_profile(profile, touched(profile, [3, 0, 0], lambda points, normals: np.full(3, 0.02), 0.0004))
    face, (fillet, u) = curve_of(model, "face")[0], curve_of(model, "fillet")
    assert np.all((face >= 0.0) & (face < 4.0))
    assert fillet[0] == pytest.approx(20.0) and fillet[2] == pytest.approx(face[0], abs=1e-9)
    assert 5.0 < fillet[1] < 17.0  # dX·sin 45° is 14, were the error the tool's setting alone
    assert u[1] > 10.0


def test_an_arc_without_a_touch_beside_a_touched_line_begins_at_its_value() -> None:
    """The part's z is taken from a touch, and no probe touched the dome."""
    inputs = example_inputs("modbas2")
    dome = inputs.profile.names.index("dome")
    touches = inputs.touches.chosen(np.flatnonzero(inputs.touches.feature_index != dome))
    assert np.count_nonzero(touches.at_reference) == 1
    curves = fit_profile(inputs.profile, touches).curves
    assert curves[dome].value_mm(0.0)[0] == pytest.approx(curves[dome - 1].value_mm(curves[dome - 1].length_mm)[0])


STEPS = checked_profile(
    polyline([(30.0, -100.0), (30.0, -60.0), (20.0, -60.0), (20.0, 0.0), (0.0, 0.0)], ["wide", "step", "thin", "end"])
)


def test_bands_hold_untouched_features_of_shafts_drawn_cause_by_cause() -> None:
    """Setting and a figure for each feature, scatter; three touches on the wide cylinder and the step: 95 % inside."""
    rng, inside = np.random.default_rng(5), []
    for _ in range(60):
        setting, own = rng.normal(0.0, 15.0, 2), rng.normal(0.0, 5.0, 4)

        def error(points: Array, normals: Array, a: Array = setting, b: Array = own) -> Array:
            of_feature = np.select([points[:, 0] > 29.9, points[:, 1] == -60.0, points[:, 1] < 0.0], b[:3], b[3])
            return np.asarray((normals @ a + of_feature) * UM)

        def seen(points: Array, normals: Array) -> Array:
            return error(points, normals) + rng.normal(0.0, UM, len(points))

        model = fit_profile(STEPS, touched(STEPS, [3, 3, 0, 0], seen, 0.4 * UM))
        for k in (2, 3):
            middle = STEPS.features[k].length_mm / 2.0
            place, normal = STEPS.features[k].point_mm(middle)[None], STEPS.features[k].outward_normal(middle)[None]
            off = error(place, normal)[0] - model.curves[k].value_mm(middle)[0]
            inside.append(abs(off) <= 1.96 * model.curves[k].standard_deviation_mm(middle)[0])
    assert np.mean(inside) >= 0.9
