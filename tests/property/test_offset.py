"""Properties of the nose-centre path on random profiles, against a dense sampling of the profile."""

import math
from itertools import pairwise

import numpy as np
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

from tests.support.profiles import profiles, wild_chains
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Feature
from trueloop.geometry.offset import CentrePath, contour_from_centre_path, nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile


def sampled(profile: Profile, per_feature: int = 401) -> Array:
    return np.concatenate([f.point_mm(np.linspace(0, f.length_mm, per_feature)) for f in profile.features])


def path_of(profile: Profile, radius_mm: float) -> CentrePath:
    """The nose-centre path; a convex corner behind a hollow arc is no example: with a large nose the two paths need not
    meet at all.
    """
    try:
        return nose_centre_path(profile, radius_mm)
    except TrueloopError as refusal:
        assert refusal.code is Code.GEO_SHARP
        reject()


@given(profiles(), st.floats(0.1, 1.2))
def test_nose_on_its_path_touches_its_feature_and_cuts_no_other(profile: Profile, radius_mm: float) -> None:
    path = path_of(profile, radius_mm)
    surface = sampled(profile)
    for nominal, moved, (low, high) in zip(profile.features, path.features, path.reachable_mm, strict=True):
        s = np.linspace(low, high, 25)
        centres = nominal.point_mm(s) + radius_mm * nominal.outward_normal(s)
        feet, off = moved.locate(centres)
        assert np.abs(off).max() < 1e-9, "the path is the normal offset of its feature"
        assert feet.min() > -1e-6 and feet.max() < moved.length_mm + 1e-6, "the path covers what is reachable"
        clearance = np.hypot(*(surface[None] - centres[:, None]).transpose(2, 0, 1)).min(axis=1)
        assert clearance.min() > radius_mm - 1e-6, "the nose cuts into no part of the profile"


@settings(max_examples=200, suppress_health_check=[HealthCheck.filter_too_much])
@given(wild_chains(), st.floats(0.1, 2.0))
def test_a_path_that_is_given_out_cuts_into_nothing(chain: list[Feature], radius_mm: float) -> None:
    try:
        profile = checked_profile(chain)
        path = nose_centre_path(profile, radius_mm)
    except TrueloopError:
        reject()
    surface = sampled(profile)
    for nominal, (low, high) in zip(profile.features, path.reachable_mm, strict=True):
        s = np.linspace(low, high, 25)
        centres = nominal.point_mm(s) + radius_mm * nominal.outward_normal(s)
        clearance = np.hypot(*(surface[None] - centres[:, None]).transpose(2, 0, 1)).min(axis=1)
        assert clearance.min() > radius_mm - 1e-5


@given(profiles(), st.floats(0.1, 1.2))
def test_path_is_one_chain_with_the_profiles_names(profile: Profile, radius_mm: float) -> None:
    path = path_of(profile, radius_mm)
    assert tuple(f.name for f in path.features) == profile.names
    for before, after in pairwise(path.features):
        assert before.end_mm == after.start_mm
        assert math.dist(after.point_mm(0.0), before.point_mm(before.length_mm)) < 1e-7


@given(profiles(), st.floats(0.1, 1.2))
def test_contour_of_the_path_is_the_profile(profile: Profile, radius_mm: float) -> None:
    contour = contour_from_centre_path(path_of(profile, radius_mm).features, radius_mm)
    for nominal, back in zip(profile.features, contour, strict=True):
        _, off = nominal.locate(back.point_mm(np.linspace(0, back.length_mm, 11)))
        assert np.abs(off).max() < 1e-9
        assert math.dist(nominal.start_mm, back.start_mm) < 1e-6
        assert math.dist(nominal.end_mm, back.end_mm) < 1e-6


@given(profiles(), st.floats(-0.3, 0.3), st.floats(0.02, 0.98))
def test_locate_is_the_inverse_of_point_and_normal(profile: Profile, distance_mm: float, share: float) -> None:
    for feature in profile.features:
        s = share * feature.length_mm
        point = feature.point_mm(s) + distance_mm * feature.outward_normal(s)
        arc_length, distance = feature.locate(point)
        assert abs(arc_length - s) < 1e-9
        assert abs(distance - distance_mm) < 1e-9
