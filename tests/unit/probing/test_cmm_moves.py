"""Ways of a measuring machine's ball: none of them through the part."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial import KDTree

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile, Side, junctions_of
from trueloop.probing.calibration import stock_obstacle, whole_obstacle
from trueloop.probing.cmm_plan import MARGIN_MM, CmmApproach, CmmMove, CmmTouch, cmm_moves, cmm_plan, way_back
from trueloop.probing.probe_plan import Spacing, equally_spaced

FEATURES = (
    Line("journal", (15.0, -80.0), (15.0, -60.0)),
    Line("back", (15.0, -60.0), (30.0, -60.0)),
    Line("collar", (30.0, -60.0), (30.0, -50.0)),
    Line("front", (30.0, -50.0), (20.0, -50.0)),
    Line("cylinder", (20.0, -50.0), (20.0, -20.0)),
    Line("cone", (20.0, -20.0), (10.0, -10.0)),
    Arc("dome", (10.0, -10.0), (0.0, 0.0), (0.0, -10.0), math.pi / 2),
)
PROFILE = Profile(FEATURES, junctions_of(FEATURES))
APPROACH = CmmApproach()


def _moves(*angles_deg: float, approach: CmmApproach = APPROACH, **counts: int) -> tuple[CmmMove, ...]:
    counts = counts or {feature.name: 3 for feature in FEATURES}
    points = equally_spaced(PROFILE, {name: Spacing(count) for name, count in counts.items()})
    names = [str(k + 1) for k in range(len(points.arc_length_mm))]
    touches = cmm_plan(PROFILE, points, names, angles_deg or (0.0,), diameters=True)
    return cmm_moves(touches, stock_obstacle(PROFILE, approach.allowance_mm), approach)


SURFACE = KDTree(np.concatenate([one.point_mm(np.linspace(0.0, one.length_mm, 4000)) for one in FEATURES]))
"""Of the half plane, its points 0.01 mm apart at most: a way that enters the part comes close to one of them."""


def _closest_mm(start: tuple[float, ...], end: tuple[float, ...]) -> float:
    """Between the ball's centre and the surface of revolution on a straight move, looked at every 0.1 mm."""
    places = np.linspace(start, end, max(2, int(math.dist(start, end) / 0.1)))
    half_plane = np.stack([np.hypot(places[:, 0], places[:, 1]), places[:, 2]], axis=1)
    return float(np.min(SURFACE.query(half_plane)[0]))


def test_no_move_comes_closer_than_the_margin() -> None:
    moves = _moves(0.0, 90.0, 200.0)
    positions = [position for move in moves for position in move.way_mm] + list(way_back(moves))
    assert len(moves) == 3 * 21 + 3 * 9  # journal, collar and cylinder also half a turn further
    for start, end in itertools.pairwise(positions):
        assert _closest_mm(start, end) >= APPROACH.ball_radius_mm + MARGIN_MM, (start, end)


def test_a_touch_begins_on_its_normal_and_its_move_meets_nothing_before() -> None:
    for move in _moves(0.0, 120.0):
        start, normal = np.array(move.way_mm[-1]), np.array(move.touch.outward_normal)
        far = APPROACH.ball_radius_mm + APPROACH.approach_mm
        assert start == pytest.approx(np.array(move.touch.nominal_mm) + far * normal)
        assert _closest_mm(tuple(start), tuple(start - APPROACH.approach_mm * normal)) >= 1.0 - 0.01


def test_by_hand_a_cylinder_is_entered_radially_and_a_dome_s_pole_along_z() -> None:
    on_cylinder = CmmTouch("1", "cylinder", (20.0, -35.0), (1.0, 0.0), 180.0)
    at_pole = CmmTouch("2", "dome", (0.0, 0.0), (0.0, 1.0), 180.0)
    ways = [move.way_mm for move in cmm_moves([on_cylinder, at_pole], stock_obstacle(PROFILE), APPROACH)]
    # largest radius 30 + ball 1 + clearance 10; approach 3 and ball 1 off the surface
    assert ways[0] == ((-41.0, 0.0, 11.0), (-41.0, 0.0, -35.0), (-24.0, 0.0, -35.0))
    assert ways[1] == (
        *((-24.0, 0.0, -35.0), (-41.0, 0.0, -35.0), (-41.0, 0.0, 11.0)),
        *((0.0, 0.0, 11.0), (0.0, 0.0, 4.0)),
    )


TURNED_AT_BOTH_ENDS = (
    Line("bore", (10.0, -62.0), (10.0, -80.0)),
    Line("back", (10.0, -80.0), (19.0, -80.0)),
    Line("seat", (19.0, -80.0), (19.0, -50.0)),
    Line("back-step", (19.0, -50.0), (26.0, -50.0)),
    Line("collar", (26.0, -50.0), (26.0, 0.0)),
    Line("front", (26.0, 0.0), (4.0, 0.0)),
)


@pytest.mark.parametrize("angles", [(0.0,), (0.0, 90.0, 200.0)])
def test_a_part_that_is_turned_at_both_its_ends_is_reached_from_behind(angles: tuple[float, ...]) -> None:
    features = TURNED_AT_BOTH_ENDS
    profile = Profile(features, junctions_of(features), Side.AROUND)
    points = equally_spaced(profile, {one.name: Spacing(3) for one in features})
    names = [str(k + 1) for k in range(len(points.arc_length_mm))]
    moves = cmm_moves(cmm_plan(profile, points, names, angles), whole_obstacle(profile), APPROACH)
    ends = (*features, Line("face about the axis", (4.0, 0.0), (0.0, 0.0)), Line("ground", (0.0, -62.0), (10.0, -62.0)))
    surface = KDTree(np.concatenate([one.point_mm(np.linspace(0.0, one.length_mm, 4000)) for one in ends]))
    positions = np.array([position for move in moves for position in move.way_mm] + list(way_back(moves)))
    for start, end in itertools.pairwise(positions):
        places = np.linspace(start, end, max(2, int(math.dist(start, end) / 0.1)))
        half_plane = np.stack([np.hypot(places[:, 0], places[:, 1]), places[:, 2]], axis=1)
        assert np.min(surface.query(half_plane)[0]) >= APPROACH.ball_radius_mm + MARGIN_MM, (start, end)
    bore = [move.way_mm for move in moves if move.touch.feature == "bore" and move.touch.angle_deg == 0.0]
    # by hand: 4 mm inside of the wall, from 11 mm behind the back face at z −80
    assert all(way[-2:] == ((6.0, 0.0, -91.0), (6.0, 0.0, way[-1][2])) for way in bore)
    assert max(places[2] for way in bore for places in way) == 11.0  # from bore to bore beyond the front


def test_what_cannot_be_reached_is_refused_with_the_point() -> None:
    deep = (Line("a", (20.0, -40.0), (20.0, -22.0)), Line("w", (20.0, -22.0), (10.0, -22.0)),
            Line("floor", (10.0, -22.0), (10.0, -18.0)), Line("v", (10.0, -18.0), (20.0, -18.0)),
            Line("b", (20.0, -18.0), (20.0, 0.0)))  # fmt: skip
    wall = CmmTouch("7", "w", (15.0, -22.0), (0.0, 1.0))
    obstacle = stock_obstacle(Profile(deep, junctions_of(deep)))
    with pytest.raises(TrueloopError) as refused:
        cmm_moves([wall], obstacle, APPROACH)  # the ball stands against the other wall, 4 mm away
    assert (refused.value.code, refused.value.values["point"]) == (Code.PRB_BALL, "7")
    floor = CmmTouch("8", "floor", (10.0, -20.0), (1.0, 0.0))
    with pytest.raises(TrueloopError) as refused:
        cmm_moves([floor], obstacle, CmmApproach(ball_radius_mm=1.8))
    assert refused.value.code is Code.PRB_REACH
    assert cmm_moves([floor], obstacle, APPROACH)


@pytest.mark.parametrize(
    "approach", [CmmApproach(approach_mm=0.5), CmmApproach(approach_mm=12.0), CmmApproach(allowance_mm=2.6)]
)
def test_an_approach_within_the_allowance_or_beyond_the_clearance_is_refused(approach: CmmApproach) -> None:
    with pytest.raises(TrueloopError) as refused:
        _moves(approach=approach)
    assert refused.value.code is Code.TCH_PLAN
