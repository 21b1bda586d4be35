"""Crossings of lines, arcs and splines in columns, beside each two features intersected by themselves."""

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trueloop.arrays import Array
from trueloop.formats.cad.dxf_edges import Edges, all_crossings
from trueloop.geometry.curve_kinds import b_spline
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.intersection import intersections

KNOTS = [0.0] * 4 + [1.0] * 4


def _xz(point: Array) -> Point:
    return float(point[0]), float(point[1])


def _chain(random: np.random.Generator) -> list[Feature]:
    """Head to tail, with corners and without, back over itself or straight on, drawn from either end; and apart."""
    chain: list[Feature] = []
    at, heading = np.zeros(2), 0.0
    for _ in range(8):
        heading += random.choice([0.0, random.uniform(-3, 3)])
        way = np.array([math.sin(heading), math.cos(heading)])
        kind, reach = random.integers(3), random.uniform(0.5, 3)
        end, turned = at + reach * way, heading
        feature: Feature = Line("", _xz(at), _xz(end))
        if kind == 1:
            side, sweep = random.choice([-1.0, 1.0]), random.uniform(0.2, 5)
            centre = at - side * reach * np.array([way[1], -way[0]])
            angle = math.atan2(*(at - centre)) - side * sweep
            end, turned = centre + reach * np.array([math.sin(angle), math.cos(angle)]), heading - side * sweep
            feature = Arc("", _xz(at), _xz(end), _xz(centre), side * sweep)
        elif kind == 2:
            turned = heading + random.uniform(-3, 3)
            last = np.array([math.sin(turned), math.cos(turned)])
            end = at + random.uniform(0.5, 2) * way + random.uniform(0.2, 1) * last
            inner = at + random.uniform(0.2, 2) * way, end - random.uniform(0.2, 2) * last
            feature = b_spline("", np.array([at, *inner, end]), KNOTS, 3)
        chain.append(feature.reversed() if random.integers(2) else feature)
        at, heading = end, turned
    return chain


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32))
def test_crossings_are_those_of_each_two(seed: int) -> None:
    features = _chain(np.random.default_rng(seed))
    edges = Edges.of(features, ["0"] * len(features))
    ends = np.concatenate([edges.start_mm, edges.end_mm])

    def away(points: list[Point]) -> Array:
        """Those that are no end of a feature, where rounding decides."""
        found = np.array(points).reshape(-1, 2)
        apart: Array = np.linalg.norm(found[:, None] - ends, axis=2).min(axis=1, initial=np.inf)
        return found[apart > 1e-4]

    expected = away(
        [
            point
            for one, other in combinations(features, 2)
            for point in intersections(one, other)
            if all(0 < float(each.locate(point)[0]) < each.length_mm for each in (one, other))
        ]
    )
    found = away([(x, z) for x, z in all_crossings(edges, *edges.boxes()).tolist()])
    assert len(found) == len(expected)
    for some, others in ((found, expected), (expected, found)):
        distance = np.linalg.norm(some[:, None] - others, axis=2).min(axis=1, initial=np.inf) if len(some) else some
        assert np.all(distance < 1e-7)


@pytest.mark.parametrize("reach_mm", [100.0, 200.0, 800.0])
def test_a_short_hook_of_a_long_spline_is_crossed(reach_mm: float) -> None:
    """The line leaves with the spline from its first point and crosses its hook, which is shorter than a 16th of it."""
    poles = [(0, 0), (-0.1, 0.1), (-0.1, 0.25), (0, 0.3), (0.4, 0.2), (1, 0), (3, 0), (10, 0), (30, 0), (60, 0)]
    last = np.array([*poles, (reach_mm / 2, 0.0), (reach_mm, 0.0)])
    spans = len(last) - 3
    spline = b_spline("", last, [0.0] * 3 + list(map(float, range(spans + 1))) + [float(spans)] * 3, 3)
    line = Line("", (0.0, 0.0), (-0.05, 1.0))
    edges = Edges.of([spline, line], ["0", "0"])
    found = all_crossings(edges, *edges.boxes())
    expected = [at for at in intersections(spline, line) if math.hypot(*at) > 1e-6]
    assert len(found) == len(expected) == 1
    assert found[0] == pytest.approx(expected[0], abs=1e-7)
