"""Features with few touches or none, junctions of every kind, and what the notes say."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.profiles import modbas2, polyline
from tests.support.touched import chosen, noise, tool_offsets, touched
from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import JunctionKind, Profile, junctions_of
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.nose_fit import fit_nose_model, nose_touches
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.spline import EndConditions

PROFILE = modbas2()
COLLAR, STEP, CONE, CYLINDER, FACE, NECK, DOME = range(7)
PATH = FitOptions(junctions=TangentPolicy.PATH)


def fit(
    counts: list[int], dx_mm: float = 0.01, dz_mm: float = -0.005, options: FitOptions | None = None
) -> ProfileErrorModel:
    return fit_profile(PROFILE, touched(PROFILE, counts, tool_offsets(dx_mm, dz_mm), 0.0004), options)


def note_on(model: ProfileErrorModel, feature: str) -> str:
    (note,) = (note for note in model.notes if note.startswith(f"{feature}:"))
    return note


def test_one_touch_gives_a_constant_with_its_own_uncertainty() -> None:
    model = fit([0, 0, 0, 1, 0, 0, 0])
    cylinder = model.curves[CYLINDER]
    np.testing.assert_allclose(cylinder.value_mm([0.0, 20.0, 70.0]), 0.01)
    np.testing.assert_allclose(cylinder.standard_deviation_mm([0.0, 70.0]), 0.0004)
    assert cylinder.degrees_of_freedom is None
    assert math.isnan(model.leave_one_out_mm[0])
    assert "one touch" in note_on(model, "cylinder")


def test_two_touches_close_together_say_nothing_of_a_taper() -> None:
    vectors = touched(PROFILE, [0, 0, 0, 2, 0, 0, 0], tool_offsets(0.01, 0.0))
    close = replace(vectors, arc_length_mm=np.array([20.0, 21.0]), error_mm=np.array([0.010, 0.012]))
    model = fit_profile(PROFILE, close)
    np.testing.assert_allclose(model.curves[CYLINDER].value_mm([0.0, 60.0]), 0.011)
    assert "span less than a tenth" in note_on(model, "cylinder")


def test_an_untouched_feature_follows_the_same_contact_angle_elsewhere() -> None:
    """The collar is a cylinder like the touched one; the step a face like the touched face. Both stay uncertain."""
    model = fit([0, 0, 0, 4, 3, 0, 0])
    assert model.curves[COLLAR].value_mm(0.0)[0] == pytest.approx(0.01, rel=0.26)
    assert model.curves[STEP].value_mm(0.0)[0] == pytest.approx(-0.005, rel=0.26)
    assert 0.004 < model.curves[COLLAR].standard_deviation_mm(0.0)[0] < 0.016
    assert "no touch" in note_on(model, "collar") and "expected from the other features" in note_on(model, "collar")


def test_an_untouched_cone_follows_the_tool_offsets_between_the_touched_angles() -> None:
    model = fit([0, 0, 0, 4, 3, 0, 0])
    normal = PROFILE.features[CONE].outward_normal(0.0)
    expected = float(normal @ [0.01, -0.005])
    assert 0.5 * expected < model.curves[CONE].value_mm(0.0)[0] < expected


def test_an_untouched_feature_beyond_the_touched_angles_stays_as_programmed() -> None:
    model = fit([0, 0, 0, 4, 0, 0, 0])
    assert model.curves[FACE].value_mm(0.0)[0] == 0.0
    assert 0.015 < model.curves[FACE].standard_deviation_mm(0.0)[0] < 0.04, "the setting of a tool, and more"
    assert model.curves[FACE].unsupported
    assert "left as programmed" in note_on(model, "face")


@pytest.mark.parametrize("policy", list(TangentPolicy))
def test_an_untouched_line_takes_the_value_of_the_arc_it_is_tangent_to(policy: TangentPolicy) -> None:
    model = fit([0, 0, 0, 0, 0, 0, 12], options=FitOptions(junctions=policy))
    neck, dome = model.curves[NECK], model.curves[DOME]
    assert neck.value_mm(neck.length_mm)[0] == pytest.approx(dome.value_mm(0.0)[0], abs=1e-15)
    assert 0.0 < neck.standard_deviation_mm(neck.length_mm)[0] < 0.003


def test_an_untouched_arc_goes_on_from_the_line_it_is_tangent_to_as_the_tool_offset_does() -> None:
    """A diameter says dX·sin φ of a dome, and nothing of its top, where the nose cuts with another side."""
    model = fit([0, 0, 0, 0, 0, 4, 0])
    dome = model.curves[DOME]
    assert dome.value_mm(0.0)[0] == pytest.approx(0.01, abs=1e-15)
    assert abs(dome.value_mm(dome.length_mm)[0]) < 0.002
    u = dome.standard_deviation_mm(np.linspace(0.0, dome.length_mm, 5))
    assert u[0] == pytest.approx(model.curves[NECK].standard_deviation_mm(0.0)[0], abs=1e-6)
    assert np.all(np.diff(u) > 0.0) and u[-1] > 0.015


def test_prescribed_ends_are_met() -> None:
    ends = EndConditions(end_value_mm=-0.02, end_slope=0.001)
    model = fit([0, 0, 4, 4, 1, 1, 16], options=FitOptions(prescribed={"dome": ends}))
    dome = model.curves[DOME]
    assert dome.value_mm(dome.length_mm)[0] == pytest.approx(-0.02, abs=1e-15)
    assert dome.slope(dome.length_mm)[0] == pytest.approx(0.001, abs=1e-15)
    assert dome.conditions.end_slope == 0.001


def test_a_slope_of_the_user_s_own_beside_a_neighbour_s_value_counts_as_exact() -> None:
    """The value at the dome's start is the neck's and as uncertain as that; its slope is said."""
    touches = [0, 0, 4, 4, 3, 4, 16]
    held = fit(touches, options=FitOptions(prescribed={"dome": EndConditions(start_slope=0.0)})).curves[DOME].spline
    assert held.covariance(held.slope_form(0.0), held.slope_form(0.0))[0] == pytest.approx(0.0, abs=1e-20)
    assert held.covariance(held.value_form(0.0), held.value_form(0.0))[0] > 1e-12
    path = FitOptions(junctions=TangentPolicy.PATH)
    neck_s = fit(touches, options=path).curves[DOME].spline
    assert neck_s.covariance(neck_s.slope_form(0.0), neck_s.slope_form(0.0))[0] > 1e-16


def test_a_nose_model_that_cannot_serve_is_told_and_one_gives_way_to_prescribed_ends() -> None:
    full = touched(PROFILE, [0, 0, 4, 4, 1, 1, 16], noise(0.0004))
    nose = fit_nose_model([nose_touches("another part", PROFILE, full)])
    without_arc = fit_profile(PROFILE, touched(PROFILE, [0, 0, 4, 4, 1, 1, 0], noise(0.0004)), nose=nose)
    assert "the nose model of other parts does not serve" in without_arc.notes[0]
    ends = FitOptions(prescribed={"dome": EndConditions(end_value_mm=0.003)})
    assert [bool(fit_profile(PROFILE, full, options, nose).choices) for options in (FitOptions(), ends)] == [
        True,
        False,
    ]


def test_the_ends_of_the_profile_are_displaced_along_their_normals() -> None:
    """[6811 §3.4]: hypothetical straight neighbours, perpendicular, without error."""
    model = fit([2, 2, 4, 4, 2, 2, 16])
    first, last = model.junctions[0], model.junctions[-1]
    assert (first.before, first.after, first.kind) == (None, COLLAR, None)
    np.testing.assert_allclose(first.displacement_mm, (0.01, 0.0), atol=1e-15)
    at_axis = model.curves[DOME].value_mm(PROFILE.features[DOME].length_mm)[0]
    np.testing.assert_allclose(last.displacement_mm, (0.0, at_axis), atol=1e-15)
    assert last.tangential_before_mm == 0.0


def arcs_and_lines() -> Profile:
    """Two cylinders in line, a quarter turn out, a quarter turn back, a neck: tangent all along, then a face."""
    features: list[Feature] = [
        Line("first", (30.0, -50.0), (30.0, -40.0)),
        Line("second", (30.0, -40.0), (30.0, -30.0)),
        Arc("shoulder", (30.0, -30.0), (20.0, -20.0), (20.0, -30.0), math.pi / 2),
        Arc("fillet", (20.0, -20.0), (10.0, -10.0), (20.0, -10.0), -math.pi / 2),
        Line("neck", (10.0, -10.0), (10.0, 0.0)),
        Line("face", (10.0, 0.0), (0.0, 0.0)),
    ]
    return Profile(tuple(features), junctions_of(features))


@pytest.mark.parametrize("policy", list(TangentPolicy))
def test_arcs_joined_tangentially_share_one_spline(policy: TangentPolicy) -> None:
    """Value continuous under both policies, slope under PATH; curvature free to jump where the radius changes sides."""
    profile = arcs_and_lines()
    vectors = touched(profile, [4, 4, 12, 12, 4, 2], noise(0.01))
    model = fit_profile(profile, vectors, FitOptions(junctions=policy, knot_every=4))
    for before, after, junction in zip(model.curves[:4], model.curves[1:5], profile.junctions, strict=False):
        assert junction.kind == JunctionKind.TANGENT
        assert abs(before.value_mm(before.length_mm)[0] - after.value_mm(0.0)[0]) < 1e-15
        kink = abs(before.slope(before.length_mm)[0] - after.slope(0.0)[0])
        assert kink < 1e-15 if policy == TangentPolicy.PATH else kink > 1e-5
    assert model.curves[2].spline is model.curves[3].spline
    assert len(model.tangency) == 4
    for one in model.tangency:
        assert one.predicted_rad == (one.kink if policy == TangentPolicy.PATH else 0.0)
        assert one.standard_u_rad > 0.0


def test_a_corner_too_flat_to_solve_keeps_a_step_and_says_so() -> None:
    """At 0.2° a difference of 40 µm would move the meeting point by 11 mm along features of 20 mm."""
    profile_points = [(30.0, -40.0), (30.0, -20.0), (30.0 - 20.0 * math.tan(math.radians(0.2)), 0.0)]
    features = polyline(profile_points)
    profile = Profile(tuple(features), junctions_of(features))
    assert profile.junctions[0].kind == JunctionKind.CORNER
    vectors = touched(profile, [4, 4], lambda points, normals: np.where(points[:, 1] < -20.0, 0.04, 0.0))
    junction = fit_profile(profile, vectors).junctions[1]
    assert "too flat" in junction.note
    assert junction.gap_mm == pytest.approx(0.02, rel=1e-4)
    assert "40.00 µm" in junction.note
    assert junction.displacement_mm[0] == pytest.approx(0.02, rel=1e-4)


def test_a_touch_where_a_feature_ends_is_kept() -> None:
    """Coordinates are rounded: 10 µm beyond the end still count as the end."""
    vectors = touched(PROFILE, [0, 0, 4, 4, 1, 1, 12], tool_offsets(0.01, 0.0))
    along = vectors.arc_length_mm.copy()
    along[0] = -0.009
    model = fit_profile(PROFILE, replace(vectors, arc_length_mm=along))
    assert np.all(np.isfinite(model.residual_mm))


def test_an_end_far_from_its_touches_is_warned_of() -> None:
    """Touches on the middle of the dome only: both ends are guesses, and the notes say how uncertain."""
    vectors = touched(PROFILE, [0, 0, 5, 5, 0, 0, 40], noise(0.001))
    middle = (vectors.feature_index != DOME) | (np.abs(vectors.arc_length_mm - 29.0) < 12.0)
    model = fit_profile(PROFILE, chosen(vectors, np.flatnonzero(middle)), FitOptions(knot_every=9))
    warnings = [note for note in model.notes if "drawn out" in note]
    assert [("start" in note, "end;" in note) for note in warnings] == [(True, False), (False, True)]
    everywhere = fit_profile(PROFILE, vectors, FitOptions(knot_every=9))
    assert not [note for note in everywhere.notes if "drawn out" in note]
