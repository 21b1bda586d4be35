"""Features without a touch: what the touched ones say of them, judged by arithmetic and draws of its own."""

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
from trueloop.turned.fit.prior.untouched import expect

# The stated prior, again: setting, form of the nose, between features, noise of a touch (µm); 20° of contact angle.
SETTING, NOSE, BETWEEN, NOISE, ALIKE_DEG = 20.0, 20.0, 16.0, 1.5, 20.0
UM = 1e-3

SHAFT_UM = (14.0, 17.0, 19.0, 22.0, 25.0, 27.0)
"""Errors of six diameters; a cone of 5° lies between the third and the fourth."""


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


def alike(apart_deg: float) -> float:
    d = math.sqrt(3.0) * apart_deg / ALIKE_DEG
    return (1.0 + d) * math.exp(-d)


@pytest.mark.parametrize("cone_deg", [1.0, 5.0, 15.0, 30.0])
@pytest.mark.parametrize("error_um", [20.0, -20.0])
def test_one_touched_diameter_tells_a_cone_by_hand(cone_deg: float, error_um: float) -> None:
    """Mean and uncertainty of two jointly normal numbers; the sign is that of the touched error."""
    t = math.tan(math.radians(cone_deg))
    profile = checked_profile(polyline([(30.0, -60.0), (30.0, -30.0), (20.0, -30.0), (20.0 - 10.0 * t, -20.0)]))
    vectors = touched(profile, [1, 0, 0], lambda points, normals: np.array([error_um * UM]))
    angle = np.array([math.radians(90.0 - cone_deg)])
    found = expect(profile, vectors, angle, 2)
    seen = SETTING**2 + NOSE**2 + BETWEEN**2 + NOISE**2
    shared = SETTING**2 * math.cos(math.radians(cone_deg)) + NOSE**2 * alike(cone_deg)
    assert found.mean_mm[0] / UM == pytest.approx(shared / seen * error_um, rel=1e-9)
    variance = SETTING**2 + NOSE**2 + BETWEEN**2 - shared**2 / seen
    assert math.sqrt(found.covariance_mm2[0, 0]) / UM == pytest.approx(math.sqrt(variance), rel=1e-9)


def test_a_cone_between_touched_diameters_is_corrected_and_its_corners_stay() -> None:
    """True error of the cone like its neighbours', 19 to 22 µm: it was left 22 µm wrong, its corners 0.2 mm off."""
    model = diameters_touched(shaft())
    value, u = curve_of(model, "between2")
    assert np.all(np.abs(value - 20.5) < 4.0)
    assert np.all((u > 15.0) & (u < 25.0))
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
        np.testing.assert_allclose(u, math.sqrt(SETTING**2 + NOSE**2 + BETWEEN**2), rtol=1e-3)
        assert model.curves[model.profile.names.index(name)].unsupported
        (note,) = (note for note in model.notes if note.startswith(f"{name}:"))
        assert "left as programmed; standard uncertainty 32 µm" in note


def test_the_uncertainty_grows_with_the_distance_from_the_touched_angles() -> None:
    profile, angles = shaft(), np.radians(90.0 - np.arange(0.0, 91.0, 5.0))
    touches = touched(profile, [2, *[0] * 10], lambda points, normals: np.array([0.02, 0.02]))
    u = np.sqrt(np.diag(expect(profile, touches, angles, 5).covariance_mm2))
    assert np.all(np.diff(u) > 0.0)
    assert u[0] < 0.7 * u[-1]


def test_larger_errors_than_the_prior_thinks_make_larger_uncertainties() -> None:
    """Touches of 100 µm are no reason to be sure of 33 µm elsewhere; those of 10 µm change nothing."""
    profile, angle = shaft(), np.array([math.radians(60.0)])
    means, us = [], []
    for error_mm in (0.010, 0.020, 0.100):
        touches = touched(profile, [2, *[0] * 10], lambda points, normals, e=error_mm: np.full(2, e))  # type: ignore[misc]
        found = expect(profile, touches, angle, 5)
        means.append(found.mean_mm[0] / error_mm)
        us.append(math.sqrt(found.covariance_mm2[0, 0]))
    assert means == pytest.approx([means[0]] * 3)
    assert us[0] == us[1] and us[2] > 2.5 * us[0]


def test_a_fillet_to_a_face_leads_from_the_one_error_to_the_other() -> None:
    """Cylinder touched, fillet and face not: the fillet begins with the cylinder's error, the face has none of it."""
    features: list[Feature] = [
        Line("cylinder", (20.0, -40.0), (20.0, -5.0)),
        Arc("fillet", (20.0, -5.0), (15.0, 0.0), (15.0, -5.0), math.pi / 2),
        Line("face", (15.0, 0.0), (0.0, 0.0)),
    ]
    profile = checked_profile(features)
    assert [junction.kind for junction in profile.junctions] == [JunctionKind.TANGENT] * 2
    model = fit_profile(profile, touched(profile, [3, 0, 0], lambda points, normals: np.full(3, 0.02), 0.0004))
    assert curve_of(model, "face")[0] == pytest.approx([0.0] * 3, abs=1e-9)
    fillet, u = curve_of(model, "fillet")
    assert fillet[0] == pytest.approx(20.0) and fillet[2] == pytest.approx(0.0, abs=1e-9)
    assert 5.0 < fillet[1] < 16.0  # dX·sin 45° is 14, were the error the tool's setting alone
    assert u[1] > 10.0


def test_ninety_five_per_cent_of_errors_drawn_from_the_prior_lie_inside() -> None:
    """Drawn apart: dX, dZ, a nose by Cholesky's root of its own correlations, a figure for each feature, noise."""
    profile, rng = shaft(20.0), np.random.default_rng(5)
    normals = [feature.outward_normal(0.0) for feature in profile.features]
    angles = np.array([math.atan2(n[0], n[1]) for n in normals])
    apart = np.degrees(np.abs(angles[:, None] - angles))
    root = np.linalg.cholesky(np.vectorize(alike)(apart) + 1e-9 * np.eye(len(angles)))
    inside = []
    for _ in range(400):
        dx, dz = SETTING * rng.standard_normal(2)
        error = dx * np.sin(angles) + dz * np.cos(angles) + NOSE * root @ rng.standard_normal(len(angles))
        error += BETWEEN * rng.standard_normal(len(angles))
        counts = [1, 1, 1, *[0] * 8]
        seen = error[:3] + NOISE * rng.standard_normal(3)
        vectors = touched(profile, counts, lambda points, normals, e=seen: e * UM)  # type: ignore[misc]
        for feature in (4, 5):
            found = expect(profile, vectors, angles[[feature]], feature)
            u = math.sqrt(found.covariance_mm2[0, 0]) / UM
            inside.append(abs(error[feature] - found.mean_mm[0] / UM) < 1.96 * u)
    assert 0.93 < np.mean(inside) < 0.985


def test_a_scanned_arc_says_what_its_means_say() -> None:
    """5000 points on a quarter of a circle: a dX of 20 µm, told to the face of the same angle and to no other."""
    features: list[Feature] = [
        Arc("ball", (20.0, -20.0), (0.0, 0.0), (0.0, -20.0), math.pi / 2),
    ]
    neck: list[Feature] = [Line("collar", (30.0, -60.0), (30.0, -40.0)), Line("step", (30.0, -40.0), (20.0, -40.0))]
    profile = checked_profile([*neck, Line("neck", (20.0, -40.0), (20.0, -20.0)), *features])
    vectors = touched(profile, [0, 0, 0, 5000], lambda points, normals: 0.02 * normals[:, 0])
    for feature, angle_deg, low, high in ((0, 90.0, 12.0, 20.0), (1, 0.0, -3.0, 3.0)):
        found = expect(profile, vectors, np.array([math.radians(angle_deg)]), feature)
        assert low < found.mean_mm[0] / UM < high
        assert BETWEEN < math.sqrt(found.covariance_mm2[0, 0]) / UM < 25.0


def test_an_arc_without_a_touch_beside_a_touched_line_follows_its_reference() -> None:
    """The part's z is taken from a touch, and the dome, which no probe touched, begins at the cylinder's value."""
    inputs = example_inputs("modbas2")
    dome = inputs.profile.names.index("dome")
    touches = inputs.touches.chosen(np.flatnonzero(inputs.touches.feature_index != dome))
    assert np.count_nonzero(touches.at_reference) == 1
    curves = fit_profile(inputs.profile, touches).curves
    assert curves[dome].value_mm(0.0)[0] == pytest.approx(curves[dome - 1].value_mm(curves[dome - 1].length_mm)[0])
