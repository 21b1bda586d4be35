"""Profiles of a line, a curve and a line: a refusal has its reason, and a path of the nose keeps its distance."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from tests.support.curves import curves
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Feature, Line, Point
from trueloop.geometry.intersection import sign_changes
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile

NOSE_MM = 0.8


@st.composite
def chains(draw: st.DrawFn) -> list[Feature]:
    """A curve between two lines that end exactly in its ends, turned by up to 60° from its tangents."""
    curve = draw(curves())
    turns, lengths = st.just(0.0) | st.floats(-1.0, 1.0), st.floats(2.0, 20.0)
    before = _from(curve.start_mm, -_turned(curve.tangent(0.0), draw(turns)), draw(lengths))
    after = _from(curve.end_mm, _turned(curve.tangent(curve.length_mm), draw(turns)), draw(lengths))
    return [Line("before", before, curve.start_mm), curve, Line("after", curve.end_mm, after)]


def _turned(tangent: Array, by_rad: float) -> Array:
    cos, sin = math.cos(by_rad), math.sin(by_rad)
    return np.array([cos * tangent[0] - sin * tangent[1], sin * tangent[0] + cos * tangent[1]])


def _from(point: Point, direction: Array, length_mm: float) -> Point:
    return point[0] + length_mm * float(direction[0]), point[1] + length_mm * float(direction[1])


@settings(max_examples=300, deadline=None)
@given(chains())
def test_such_a_profile_is_taken_or_refused_with_a_reason(chain: list[Feature]) -> None:
    try:
        profile = checked_profile(chain)
        path = nose_centre_path(profile, NOSE_MM)
    except TrueloopError as refused:
        if refused.code is Code.GEO_CROSSING:
            assert _nearest_mm(chain, refused) < 1e-6
        return
    if _runs_forward(profile):
        centre = np.concatenate([_sampled(feature) for feature in path.features])
        assert _distance_mm(centre, profile) > NOSE_MM - 2e-3


def _runs_forward(profile: Profile) -> bool:
    """Whether the profile nowhere turns back against its chord: it then has one side, however long it goes on."""
    chord = np.array(profile.features[-1].end_mm) - profile.features[0].start_mm
    tangents = np.concatenate([f.tangent(np.linspace(0.0, f.length_mm, 50)) for f in profile.features])
    return bool(np.all(tangents @ chord > 0.0))


def _nearest_mm(chain: list[Feature], refused: TrueloopError) -> float:
    """Returns how far the place of a crossing is from the farther of the two features that cross there."""
    place = np.array([[refused.values["x_mm"], refused.values["z_mm"]]], dtype=np.float64)
    names = refused.values["features"]
    assert isinstance(names, list)
    if names[0] == names[1]:
        return 0.0
    return max(abs(float(feature.locate(place)[1][0])) for feature in chain if feature.name in names)


def _sampled(feature: Feature) -> Array:
    return feature.point_mm(np.linspace(0.0, feature.length_mm, 200))


def _distance_mm(points: Array, profile: Profile) -> float:
    """Returns the least distance of points (n, 2) from 2,001 places along the profile."""
    places = np.concatenate([f.point_mm(np.linspace(0.0, f.length_mm, 667)) for f in profile.features])
    return float(np.min(KDTree(places).query(points)[0]))


@given(curves(), st.booleans())
def test_a_curve_crosses_what_goes_through_its_end_there(curve: Curve, at_end: bool) -> None:
    """At any angle, and the crossing is listed once."""
    s = curve.length_mm if at_end else 0.0
    point, normal = curve.point_mm(s), curve.outward_normal(s)
    for tilt in np.linspace(-0.9, 0.9, 7):
        along = normal + tilt * curve.tangent(s)
        across = np.array([along[1], -along[0]]) / np.hypot(*along)
        found = sign_changes(curve, lambda points, across=across: (points - point) @ across)  # type: ignore[misc]
        assert np.sum(np.abs(found - s) < 1e-9) == 1
