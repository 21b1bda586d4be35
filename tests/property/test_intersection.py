"""Where lines and circles meet, and where chains cross, against dense polygons."""

import math
from itertools import pairwise

import numpy as np
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from tests.support.profiles import turned_on, wild_chains
from trueloop.arrays import Array
from trueloop.geometry.feature import Arc, Feature, Line, least_radius_mm
from trueloop.geometry.intersection import crossings, intersections

ROUNDING_MM2 = 1e-10
"""Of edges of some millimetres at some hundred millimetres from zero."""
FEATURES = st.builds(
    turned_on,
    st.builds(lambda x, z: Line("", (0.0, 0.0), (x, z)), st.floats(20, 60), st.floats(-30, 30)),
    st.just("f"),
    st.floats(-3, 3),
    st.floats(1, 40),
    st.just(0.0) | st.floats(0.2, 4) | st.floats(-4, -0.2),
)


@given(FEATURES, FEATURES)
def test_common_points_lie_on_both_and_none_is_missed(first: Feature, second: Feature) -> None:
    points = intersections(first, second)
    for point in points:
        assert abs(float(first.locate(point)[1])) < 1e-6
        assert abs(float(second.locate(point)[1])) < 1e-6
    assert intersections(second, first) == points or len(intersections(second, first)) == len(points)
    around = 200.0 if isinstance(first, Line) else math.pi * least_radius_mm(first)
    s = first.length_mm / 2 + np.linspace(-around, around, 4001)
    off = second.locate(first.point_mm(s))[1]
    assume(np.abs(off).max() > 1e-3)
    side = off > 0
    changes = int(np.count_nonzero(side[1:] != side[:-1]))
    if isinstance(second, Line) or isinstance(first, Arc):
        assert changes <= len(points)


def polygon(feature: Feature, edges: int = 120) -> Array:
    return feature.point_mm(np.linspace(0, feature.length_mm, edges + 1))


def polygons_cross(first: Array, second: Array) -> bool:
    """Whether any edge of one crosses any edge of the other: ends on different sides, both ways.

    On one line with the other's edge there is no side, whatever rounding says. Edges whose boxes lie apart do not
    cross.
    """

    def side(a: Array, b: Array, p: Array) -> Array:
        ab, ap = (b - a)[:, None], p[None] - a[:, None]
        twice_area = ab[..., 0] * ap[..., 1] - ab[..., 1] * ap[..., 0]
        return np.asarray(np.sign(np.where(np.abs(twice_area) < ROUNDING_MM2, 0.0, twice_area)))

    low, high = ([end(edges[:-1], edges[1:]) for edges in (first, second)] for end in (np.minimum, np.maximum))
    near = np.all((low[0][:, None] <= high[1]) & (low[1] <= high[0][:, None]), axis=2)
    of_second = side(first[:-1], first[1:], second)
    of_first = side(second[:-1], second[1:], first)
    return bool(np.any(near & (of_second[:, :-1] != of_second[:, 1:]) & (of_first[:, :-1] != of_first[:, 1:]).T))


ON_ONE_LINE = [(150.0, -78.0), (167.27665110968795, -85.9067898943957), (168.18594853651362, -86.32293673094284)]
ON_ONE_LINE += [(185.46259964620157, -94.22972662533854)]
"""Three lines, one after the other, straight on but for rounding."""
BENT_BY_7_NM = [(150.0, -80.0), (150.0, -78.0), (150.0, -77.0), (150.000000007, -70.0)]


@settings(max_examples=300)
@given(wild_chains())
@example([Line(f"f{k}", a, b) for k, (a, b) in enumerate(pairwise(ON_ONE_LINE))])
@example([Line(f"f{k}", a, b) for k, (a, b) in enumerate(pairwise(BENT_BY_7_NM))])
def test_crossings_of_features_that_are_no_neighbours(chain: list[Feature]) -> None:
    pairs = [(i, j) for i in range(len(chain)) for j in range(i + 2, len(chain))]
    assume(all(_clear_cut(chain[i], chain[j]) for i, j in pairs))
    found = {(i, j) for i, j, _ in crossings(chain, 1e-3) if j > i + 1}
    assert found == {(i, j) for i, j in pairs if polygons_cross(polygon(chain[i]), polygon(chain[j]))}


def _clear_cut(first: Feature, second: Feature) -> bool:
    """No end of one within 0.05 mm of the other, no near touch: the polygons decide alike."""
    for a, b in ((first, second), (second, first)):
        s, off = a.locate(polygon(b))
        near = (np.abs(off) < 0.05) & (s > -0.05) & (s < a.length_mm + 0.05)
        if near[0] or near[-1] or np.any(near & ((np.abs(s) < 0.05) | (np.abs(s - a.length_mm) < 0.05))):
            return False
    crossing = intersections(first, second)
    return len(crossing) < 2 or math.dist(*crossing) > 1.0
