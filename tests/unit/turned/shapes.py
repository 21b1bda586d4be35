"""A part with every kind of junction: concave and convex corners, and a dome tangent to a cylinder."""

import math

from trueloop.geometry.feature import Arc, Feature, Line
from trueloop.geometry.profile import Profile, junctions_of

NOSE_RADIUS_MM = 0.79375

FEATURES: tuple[Feature, ...] = (
    Line("cone", (67.564, -155.829), (44.704, -114.554)),
    Line("cylinder", (44.704, -114.554), (44.704, -44.704)),
    Line("face", (44.704, -44.704), (37.084, -44.704)),
    Line("neck", (37.084, -44.704), (37.084, -37.084)),
    Arc("dome", (37.084, -37.084), (0.0, 0.0), (0.0, -37.084), math.pi / 2),
)
PART = Profile(FEATURES, junctions_of(FEATURES))
