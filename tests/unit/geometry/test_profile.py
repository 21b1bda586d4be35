"""Junctions, groups, contact angles and kinds of a profile's features by hand; places on it by dense sampling."""

import math

import numpy as np
import pytest

from tests.support.profiles import modbas2, polyline
from trueloop.geometry.curve_kinds import ellipse
from trueloop.geometry.feature import Arc, Feature, Line, pieces_within
from trueloop.geometry.profile import JunctionKind, Profile, Side, junctions_of, kind_of, named_by_kind

CYLINDER = Line("cylinder", (20.0, -10.0), (20.0, 0.0))
CROWN = Arc("crown", (20.0, 0.0), (20.0 * math.cos(0.5), 20.0 * math.sin(0.5)), (0.0, 0.0), 0.5)
FACE = Line("face", CROWN.end_mm, (CROWN.end_mm[0] - 5.0, CROWN.end_mm[1]))


def of(features: list[Feature], side: Side = Side.OUTSIDE) -> Profile:
    return Profile(tuple(features), junctions_of(features), side)


def test_lengths_and_places_in_tangent_groups() -> None:
    """10 mm of a cylinder and 10 mm of an arc tangent to it are one group, the face of 5 mm another."""
    profile = of([CYLINDER, CROWN, FACE])
    group, share = profile.in_groups(np.array([0, 1, 2, 1]), np.array([4.0, 5.0, 1.0, 10.0]))
    assert group.tolist() == [0, 0, 2, 0] and share == pytest.approx([0.2, 0.75, 0.2, 1.0])
    assert (profile.length_mm, profile.start_of(2)) == pytest.approx((25.0, 20.0))
    assert profile.middle_z_mm == pytest.approx((-10.0 + 20.0 * math.sin(0.5)) / 2.0)


def test_junctions_by_hand() -> None:
    """At the crown's end the direction is 0.5 rad below +z, and the face goes inwards: π/2 − 0.5 to the right."""
    first, second = junctions_of([CYLINDER, CROWN, FACE])
    assert (first.kind, second.kind) == (JunctionKind.TANGENT, JunctionKind.CORNER)
    assert (first.turn_rad, second.turn_rad) == pytest.approx((0.0, math.pi / 2 - 0.5), abs=1e-12)
    (groove,) = junctions_of(polyline([(9.0, 0.0), (5.0, 0.0), (5.0, 4.0)]))
    assert groove.turn_rad == pytest.approx(-math.pi / 2) and not groove.by_design


@pytest.mark.parametrize(
    ("gap_mm", "turn_rad", "kind"),
    [
        (0.0, 9e-4, JunctionKind.TANGENT),
        (0.0, -9e-4, JunctionKind.TANGENT),
        (0.0, 1.1e-3, JunctionKind.CORNER),
        (0.04, 0.0, JunctionKind.TANGENT),
        (0.06, 0.0, JunctionKind.APART),
    ],
)
def test_features_that_nearly_meet(gap_mm: float, turn_rad: float, kind: JunctionKind) -> None:
    start = (10.0 + gap_mm, 5.0)
    after = Line("b", start, (start[0] - 5.0 * math.sin(turn_rad), 5.0 + 5.0 * math.cos(turn_rad)))
    (junction,) = junctions_of([Line("a", (10.0, 0.0), (10.0, 5.0)), after])
    assert junction.kind is kind
    if kind is not JunctionKind.APART:
        assert junction.turn_rad == pytest.approx(turn_rad, abs=1e-12)


def test_contact_angles_go_on_over_back_faces() -> None:
    """π on the back face of an outside, −π on that of a bore, π/2 and −π/2 on their cylinders, 0 on front faces."""
    around = [(5.0, -9.0), (10.0, -9.0), (10.0, 0.0), (4.0, 0.0)]
    outside = of(polyline(around))
    places = np.arange(3), np.full(3, 1.0)
    assert outside.contact_angle_rad(*places) == pytest.approx([math.pi, math.pi / 2, 0.0])
    bore = of(polyline([(4.0, -9.0), (8.0, -9.0), (8.0, -20.0), (0.0, -20.0)]), Side.INSIDE)
    assert bore.contact_angle_rad(*places) == pytest.approx([-math.pi, -math.pi / 2, 0.0])
    assert outside.contact_along_rad(1, [1.0, 2.0]) == pytest.approx([math.pi / 2] * 2)


def test_contact_angles_turn_along_arcs_without_a_jump() -> None:
    """A knob of 200° whose back is undercut: from 110° on the side towards the chuck to −90° beyond its front."""
    ends = [(9.0 + 6.0 * math.sin(a), 6.0 * math.cos(a)) for a in (math.radians(200), 0.0)]
    knob = of([Arc("knob", ends[0], ends[1], (9.0, 0.0), math.radians(200))])
    angles = knob.contact_along_rad(0, np.linspace(0.0, knob.length_mm, 9))
    assert angles == pytest.approx(np.radians(np.linspace(200.0, 0.0, 9)))


def test_contact_angles_are_counted_through_any_number_of_knobs() -> None:
    """Each from 160° to 20°, and 140° to the left into the next."""
    radius, pitch = 6.0, 12.0 * math.cos(math.radians(20))
    knobs: list[Feature] = []
    for k in range(5):
        ends = [(30.0 + radius * math.sin(a), k * pitch + radius * math.cos(a)) for a in np.radians([160.0, 20.0])]
        knobs.append(Arc(str(k), ends[0], ends[1], (30.0, k * pitch), math.radians(140)))
    profile = of(knobs)
    assert [junction.turn_rad for junction in profile.junctions] == pytest.approx([-math.radians(140)] * 4)
    for k, knob in enumerate(knobs):
        angles = profile.contact_along_rad(k, np.linspace(0.0, knob.length_mm, 3))
        assert angles == pytest.approx(np.radians([160.0, 90.0, 20.0]))


def test_places_are_on_the_nearest_feature() -> None:
    """Beside points along all features, 0.1 mm apart: the nearest of them is on the feature found, or as near."""
    profile, rng = modbas2(), np.random.default_rng(9)
    dense = [f.point_mm(np.linspace(0.0, f.length_mm, int(f.length_mm / 0.1) + 2)) for f in profile.features]
    points = np.concatenate([d[rng.integers(len(d), size=40)] for d in dense]) + rng.normal(0.0, 4.0, (280, 2))
    found = profile.locate(points)
    for point, index, s, off in zip(points, found.feature_index, found.arc_length_mm, found.distance_mm, strict=True):
        nearest = [float(np.min(np.hypot(*(d - point).T))) for d in dense]
        feature = profile.features[index]
        assert nearest[index] <= min(nearest) + 0.01
        assert math.dist(feature.point_mm(s) + off * feature.outward_normal(s), point) < 1e-9


@pytest.mark.parametrize("sweep_rad", [2.0, -2.0])
def test_beyond_an_arc_s_ends_its_length_counts_from_the_nearer_one(sweep_rad: float) -> None:
    """An arc of 2 rad leaves 2.14 rad on either side of the place opposite its middle."""
    side = math.copysign(1.0, sweep_rad)
    at = {a: (50.0 + 10.0 * math.sin(a), 10.0 * math.cos(a)) for a in (0.0, -sweep_rad)}
    arc = Arc("arc", at[0.0], at[-sweep_rad], (50.0, 0.0), sweep_rad)
    angles = np.array([-2.1, -1.0, 0.5, 2.0, 3.0, 4.1])
    points = np.stack([50.0 + 11.0 * np.sin(-side * angles), 11.0 * np.cos(angles)], axis=-1)
    s, off = arc.locate(points)
    assert s == pytest.approx(10.0 * angles) and off == pytest.approx([side] * 6)


@pytest.mark.parametrize(
    ("degrees", "kind"), [(0.0, "cylinder"), (0.4, "cylinder"), (0.6, "cone"), (89.4, "cone"), (89.6, "face")]
)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_lines_within_half_a_degree_are_cylinders_and_faces(degrees: float, kind: str, way: float) -> None:
    a, size = math.radians(degrees), 7.0 * way
    assert kind_of(Line("f", (30.0, 0.0), (30.0 - size * math.sin(a), size * math.cos(a)))) == kind


def test_features_are_numbered_by_kind() -> None:
    egg = ellipse("egg", ((24.0, 0.0), (0.0, 30.0)), (0.0, 0.0), (24.0, 30.0))
    named = named_by_kind([CYLINDER, CROWN, FACE, CYLINDER, egg])
    assert [one.name for one in named] == ["cylinder-1", "arc-1", "face-1", "cylinder-2", "curve-1"]


def test_pieces_of_an_arc_whose_chords_stay_within_a_tolerance() -> None:
    """Chords of 0.4 mm on R = 20 mm leave 0.4² / (8 · 20) = 1 µm: 10 mm are 25 of them."""
    assert pieces_within(CROWN, 1.0001e-3) == 25
    assert pieces_within(CROWN, 0.99e-3) == 26
    assert (pieces_within(CYLINDER, 1e-3), pieces_within(CROWN, 100.0)) == (1, 1)
