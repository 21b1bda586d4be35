"""Profiles for tests: the three part families of [6811] by their drawn dimensions, and random chains."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Line, LineOrArc, Point
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.units import MM_PER_INCH

NOSE_RADIUS_MM = 0.03125 * MM_PER_INCH


def inch(x: float, z: float) -> Point:
    return x * MM_PER_INCH, z * MM_PER_INCH


def simple(feature: Feature) -> LineOrArc:
    """The feature, which is no curve."""
    assert not isinstance(feature, Curve)
    return feature


def polyline(points: Sequence[Point], names: Sequence[str] = ()) -> list[Feature]:
    """Lines from point to point, named f0, f1… unless told otherwise."""
    return [Line(names[i] if names else f"f{i}", a, b) for i, (a, b) in enumerate(pairwise(points))]


def modbas2(diameter_in: float = 3.52) -> Profile:
    """Collar, face, cone, cylinder, face, neck and dome of [6811 §5.2, A.3]; `diameter_in` is P46."""
    r, z0 = diameter_in / 2, (3.6 - diameter_in) / 2
    corners = [(r + 1.1, z0 - 6.475), (r + 1.1, z0 - 6.175), (r + 0.9, z0 - 6.175), (r, z0 - 4.55), (r, z0 - 1.8)]
    corners += [(r - 0.3, z0 - 1.8), (r - 0.3, z0 - 1.5)]
    names = ["collar", "collar face", "cone", "cylinder", "face", "neck"]
    lines = polyline([inch(*corner) for corner in corners], names)
    dome = Arc("dome", lines[-1].end_mm, (0.0, 0.0), inch(0.0, z0 - 1.5), math.pi / 2)
    return checked_profile([*lines, dome])


def piecs11() -> Profile:
    """Collar, face, cone and knob of the first PIECS11 part, 5.30 in [6811 §5.3, A.4]: the cone runs into the knob."""
    cone_start, path_corner = np.array(inch(2.41818, -3.71875)), np.array(inch(1.22627, -1.62131))
    along = (path_corner - cone_start) / math.dist(path_corner, cone_start)
    normal = np.array([along[1], -along[0]])
    centre, radius_mm = np.array(inch(0.0, -1.25)), 1.25 * MM_PER_INCH
    on_cone = path_corner - NOSE_RADIUS_MM * normal
    to_corner = math.acos((on_cone - centre) @ normal / radius_mm)
    half_angle = math.atan2(normal[0], normal[1]) + to_corner
    corner = centre + radius_mm * np.array([math.sin(half_angle), math.cos(half_angle)])
    face_z = -3.75 * MM_PER_INCH
    cone_x = on_cone[0] + along[0] / along[1] * (face_z - on_cone[1])
    face = Line("face", (2.65 * MM_PER_INCH, face_z), (float(cone_x), face_z))
    collar = Line("collar", inch(2.65, -4.25), face.start_mm)
    cone = Line("cone", face.end_mm, (float(corner[0]), float(corner[1])))
    knob = Arc("knob", cone.end_mm, (0.0, 0.0), inch(0.0, -1.25), half_angle)
    return checked_profile([collar, face, cone, knob])


def facetst(diameter_in: float = 5.62) -> Profile:
    """Two cylinders and two faces of [6811 §5.1, A.2]; `diameter_in` is P46."""
    r = diameter_in / 2
    corners = [(r, -4.0), (r, -2.0), (r - 1.95, -2.0), (r - 1.95, 0.0), (0.0, 0.0)]
    names = ["large cylinder", "step face", "small cylinder", "end face"]
    return checked_profile(polyline([inch(*corner) for corner in corners], names))


def turned_on(before: Feature | None, name: str, heading_rad: float, size_mm: float, sweep_rad: float) -> Feature:
    """A line (sweep 0) or arc of length `size_mm`, set on in a direction: 0 along +z, positive towards +x."""
    x, z = before.end_mm if before else (150.0, -80.0)
    if sweep_rad == 0:
        return Line(name, (x, z), (x + size_mm * math.sin(heading_rad), z + size_mm * math.cos(heading_rad)))
    signed_radius = size_mm / sweep_rad
    end_heading = heading_rad - sweep_rad
    centre = (x - signed_radius * math.cos(heading_rad), z + signed_radius * math.sin(heading_rad))
    end = (centre[0] + signed_radius * math.cos(end_heading), centre[1] - signed_radius * math.sin(end_heading))
    return Arc(name, (x, z), end, centre, sweep_rad)


@st.composite
def profiles(draw: st.DrawFn) -> Profile:
    """Chains of two to six features that grow in z, with corners up to 115° and exact or nearly exact tangencies."""
    features: list[Feature] = []
    heading = draw(st.floats(-1.0, 1.0))
    for i in range(draw(st.integers(2, 6))):
        if i:
            if draw(st.booleans()):
                heading += draw(st.just(0.0) | st.floats(-2e-4, 2e-4))
            else:
                heading = draw(st.floats(-1.0, 1.0))
        end_heading = draw(st.floats(-1.0, 1.0))
        sweep = heading - end_heading if draw(st.booleans()) and abs(heading - end_heading) > 0.1 else 0.0
        features.append(turned_on(features[-1] if features else None, f"f{i}", heading, draw(st.floats(5, 20)), sweep))
        heading -= sweep
    return checked_profile(features)


@st.composite
def wild_chains(draw: st.DrawFn) -> list[Feature]:
    """Chains with grooves, hooks, undercuts and features smaller than a nose; not all of them are profiles."""
    features: list[Feature] = []
    headings, sizes = st.floats(-2.2, 2.2), st.floats(0.2, 2) | st.floats(2, 20)
    heading = draw(headings)
    for i in range(draw(st.integers(2, 6))):
        heading = heading if draw(st.booleans()) else draw(headings)
        sweep = heading - draw(headings) if draw(st.booleans()) else 0.0
        sweep = sweep if abs(sweep) > 0.1 else 0.0
        features.append(turned_on(features[-1] if features else None, f"f{i}", heading, draw(sizes), sweep))
        heading -= sweep
    return features
