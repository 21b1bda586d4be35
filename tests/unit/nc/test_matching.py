"""Which moves cut which feature: mock errors, passes, run-outs, many moves a feature, and what is refused."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.feed_moves import backwards, cut, largest_deviation_mm, to
from tests.support.nist_programs import nist_program
from tests.support.profiles import NOSE_RADIUS_MM, facetst, modbas2, piecs11, polyline, profiles, simple
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.match.matching import ContourMatch, match_contour
from trueloop.nc.program.along import FeedMove, feed_moves
from trueloop.nc.program.program import read_program

SHARES = np.linspace(0.0, 1.0, 33)


def centre_path(profile: Profile, allowance_mm: float = 0.0) -> tuple[Feature, ...]:
    return nose_centre_path(profile, NOSE_RADIUS_MM + allowance_mm).features


def matched(moves: list[FeedMove], profile: Profile, **options: float) -> ContourMatch:
    return match_contour(moves, profile, NOSE_RADIUS_MM, **options)  # type: ignore[arg-type]


def lines_of(match: ContourMatch) -> list[list[int]]:
    return [[m.move.line for m in feature.moves] for feature in match.features]


@given(profiles(), st.booleans())
def test_its_own_centre_path_matches_without_deviation(profile: Profile, reverse: bool) -> None:
    path = centre_path(profile)
    n = len(path)
    match = matched(cut(backwards(path) if reverse else path), profile)
    order = range(n, 0, -1) if reverse else range(1, n + 1)
    assert lines_of(match) == [[10 * k] for k in order]
    assert all(feature.backwards == reverse for feature in match.features)
    assert largest_deviation_mm(match) < 1e-9
    assert (match.lead, match.run_out, match.between) == ((), (), ())


def test_taper_of_35_um_is_a_linear_deviation() -> None:
    """[6811 §5.1] mock errors: the end of the large cylinder's cut 35 µm out (P47), of the step face 25 µm up (P44)."""
    profile = facetst()
    ends = [list(f.end_mm) for f in centre_path(profile)]
    start = centre_path(profile)[0].start_mm
    ends[0][0] += 0.035
    ends[1][1] += 0.025
    points: list[Point] = [start, *((x, z) for x, z in ends)]
    match = matched(cut(polyline(points)), profile)
    large, step = match.features[0], match.features[1]
    along = SHARES * large.feature.length_mm
    np.testing.assert_allclose(large.deviation_mm(along), 0.035 * along / centre_path(profile)[0].length_mm, atol=1e-12)
    before_mm = NOSE_RADIUS_MM + 0.035
    share = before_mm / (centre_path(profile)[1].length_mm + 0.035)
    assert float(step.deviation_mm(0.0)) == pytest.approx(0.025 * share, abs=1e-12)
    assert largest_deviation_mm(match) == pytest.approx(0.035, rel=0.02)


def test_arc_cut_as_lines_deviates_by_the_chords_sagitta() -> None:
    profile = modbas2()
    *lines, dome = centre_path(profile)
    n = 50
    points = [(float(x), float(z)) for x, z in dome.point_mm(np.linspace(0, dome.length_mm, n + 1))]
    chords = polyline(points)
    match = matched(cut([*lines, *chords]), profile)
    cutting = match.features[-1]
    assert len(cutting.moves) == n
    step = cutting.feature.length_mm / n
    half_angle = math.pi / 4 / n
    assert isinstance(dome, Arc)
    sagitta = dome.radius_mm * (1 - math.cos(half_angle))
    deviation = cutting.deviation_mm(np.array([0.0, 0.5, 1.0, 1.5, n - 0.5]) * step)
    np.testing.assert_allclose(deviation, [0, -sagitta, 0, -sagitta, -sagitta], atol=1e-9)


def test_wrong_arc_radius_is_measured_along_the_nominal_normal() -> None:
    """The commanded dome 50 µm too large about a centre 30 µm off: d = ρ' − ρ + shift · n to first order."""
    profile = modbas2()
    *lines, dome = centre_path(profile)
    assert isinstance(dome, Arc)
    (x, z), shift = dome.centre_mm, np.array([0.0, 0.03])
    larger = turned((x, z + 0.03), dome.radius_mm + 0.05, dome.sweep_rad)
    match = matched(cut([*lines, larger]), profile)
    feature = match.features[-1].feature
    s = SHARES * feature.length_mm
    expected = 0.05 + feature.outward_normal(s) @ shift
    np.testing.assert_allclose(match.features[-1].deviation_mm(s), expected, atol=2e-5)


def turned(centre: Point, radius_mm: float, sweep_rad: float) -> Arc:
    start, end = (centre[0] + radius_mm, centre[1]), (centre[0], centre[1] + radius_mm)
    return Arc("", start, end, centre, sweep_rad)


def test_pass_before_the_last_is_not_this_one_but_that_of_its_allowance() -> None:
    """Passes 0.254 mm apart [6811 §A]: each is found under its own allowance, neither under the other's."""
    profile = modbas2()
    semifinish, finish = centre_path(profile, 0.254), centre_path(profile)
    moves = [*cut(semifinish), *cut(finish, first=len(semifinish), chain=1)]
    assert lines_of(matched(moves, profile)) == [[10 * k] for k in range(8, 15)]
    before = matched(moves, profile, allowance_mm=0.254)
    assert lines_of(before) == [[10 * k] for k in range(1, 8)]
    assert largest_deviation_mm(before) < 1e-9


def test_lead_and_run_out() -> None:
    """Plunge before, X−0.0625 past the axis and pull-out after, as in [6811 §A.3.3]."""
    profile = modbas2()
    path = centre_path(profile)
    start, end = path[0].start_mm, path[-1].end_mm
    past = (-0.79, end[1])
    moves = cut([to((80.0, start[1]), start), *path, to(end, past), to(past, (-0.79, 9.0))])
    match = matched(moves, profile)
    assert [m.line for m in match.lead] == [10, 100]
    assert [m.line for m in match.run_out] == [90]
    turned_round = matched(cut(backwards([m.path for m in moves])), profile)
    assert [m.line for m in turned_round.run_out] == [20]
    assert [m.line for m in turned_round.lead] == [10, 100]


@pytest.mark.parametrize(("tolerance_mm", "lengthens"), [(0.125, False), (0.25, True)])
def test_a_run_out_begins_as_near_to_the_end_as_the_callers_tolerance_says(
    tolerance_mm: float, lengthens: bool
) -> None:
    """The end face stops 0.4 mm short and is gone on with: within twice 0.25 mm, not within twice 0.125 mm."""
    path = centre_path(modbas2())
    start, end = path[0].start_mm, path[-1].end_mm
    last = path[-1]
    x, z = (float(c) for c in last.point_mm(last.length_mm - 0.4))
    along_x, along_z = (float(c) for c in last.tangent(last.length_mm))
    short, on = (x, z), (x + 2.0 * along_x, z + 2.0 * along_z)
    assert isinstance(last, Arc)
    stopped = Arc("", last.start_mm, short, last.centre_mm, last.sweep_rad * (1 - 0.4 / last.length_mm))
    moves = cut([to((80.0, start[1]), start), *path[:-1], stopped, to(short, on)])
    match = matched(moves, modbas2(), tolerance_mm=tolerance_mm)
    assert bool(match.run_out) is lengthens and math.dist(short, end) > 0.25


def test_end_of_a_move_beyond_the_profile() -> None:
    """FACETST's end face runs to X−0.03125, 0.397 mm past the axis, in the same move [6811 §A.2.3]."""
    profile = facetst()
    *others, face = centre_path(profile)
    match = matched(cut([*others, to(face.start_mm, (-0.396875, face.end_mm[1]))]), profile)
    last = match.features[-1].moves[0]
    assert last.end_mm == pytest.approx(match.features[-1].feature.length_mm + 0.396875)
    assert last.start_mm == pytest.approx(-NOSE_RADIUS_MM), "a convex corner: the path comes from beyond the edge"


def test_arc_about_an_edge_stands_between() -> None:
    """A path that rounds the edges by arcs of the nose radius instead of running on to the intersection."""
    profile = facetst()
    nominal = profile.features
    path = list(centre_path(profile))
    edge, corner = nominal[0].end_mm, NOSE_RADIUS_MM
    path[0] = replace(simple(path[0]), end_mm=(edge[0] + corner, edge[1]))
    path[1] = replace(simple(path[1]), start_mm=(edge[0], edge[1] + corner))
    about = Arc("", path[0].end_mm, path[1].start_mm, edge, math.pi / 2)
    match = matched(cut([path[0], about, *path[1:]]), profile)
    assert [m.line for m in match.between] == [20]
    assert largest_deviation_mm(match) < 1e-12


def test_one_move_over_two_features_cuts_both() -> None:
    profile = checked_profile(polyline([(20.0, -30.0), (20.0, -12.0), (20.0, 0.0), (5.0, 0.0)], ["a", "b", "end"]))
    path = centre_path(profile)
    match = matched(cut([to(path[0].start_mm, path[1].end_mm), path[2]]), profile)
    assert lines_of(match) == [[10], [10], [20]]
    assert match.features[1].moves[0].start_mm == pytest.approx(-18.0)


def test_features_cut_in_separate_chains() -> None:
    """The end face first, then the rest from the free end to the chuck: a habit of many shops."""
    profile = facetst()
    path = centre_path(profile)
    face = to((30.0, path[3].start_mm[1]), (-0.5, path[3].end_mm[1]))
    moves = [*cut([face]), *cut(backwards(path[:3]), first=1, chain=1)]
    match = matched(moves, profile)
    assert lines_of(match) == [[40], [30], [20], [10]]
    assert [f.backwards for f in match.features] == [True, True, True, False]


def _refusal(moves: list[FeedMove], profile: Profile, **options: float) -> TrueloopError:
    with pytest.raises(TrueloopError) as refusal:
        matched(moves, profile, **options)
    return refusal.value


def test_two_finish_passes_are_ambiguous_until_lines_are_named() -> None:
    profile = piecs11()
    path = centre_path(profile)
    moves = [*cut(path), *cut(path, first=4, chain=1)]
    refusal = _refusal(moves, profile)
    assert refusal.code is Code.NC_AMBIGUOUS
    assert "lines 10, 50" in refusal.message and refusal.place.line == 50
    assert "finish_lines = [from, to]" in refusal.hint
    assert lines_of(matched(moves, profile, lines=(50, 80))) == [[50], [60], [70], [80]]  # type: ignore[arg-type]


def test_a_pass_of_the_contour_and_one_of_the_nose_s_centre_are_ambiguous_until_lines_are_named() -> None:
    """A pass under G42 and one without it that fits as well: either may be the finish cut."""
    profile = piecs11()
    contour = [replace(move, compensation=41) for move in cut(profile.features, first=4, chain=1)]
    for moves in ([*cut(centre_path(profile)), *contour], [*contour, *cut(centre_path(profile), first=8)]):
        refusal = _refusal(moves, profile)
        assert refusal.code is Code.NC_AMBIGUOUS and "finish_lines = [from, to]" in (refusal.hint or "")
        other = moves[0].line if not moves[0].on_contour else moves[4].line
        assert {"50 (G41)", str(other)} == set(refusal.message.rpartition("lines ")[2].split(", "))
    both = [*cut(centre_path(profile)), *contour]
    assert lines_of(matched(both, profile, lines=(10, 40))) == [[10], [20], [30], [40]]  # type: ignore[arg-type]
    assert lines_of(matched(both, profile, lines=(50, 80))) == [[50], [60], [70], [80]]  # type: ignore[arg-type]
    far = cut(centre_path(profile, allowance_mm=0.3))
    assert lines_of(matched([*far, *contour], profile)) == [[50], [60], [70], [80]]


def test_passes_of_the_same_lines_are_to_be_written_out() -> None:
    """Lines cannot choose between the runs of a loop's body."""
    path = centre_path(piecs11())
    refusal = _refusal([*cut(path), *cut(path, chain=1)], piecs11())
    assert refusal.code is Code.NC_AMBIGUOUS
    assert "lines 10, 10" in refusal.message and "write the finish pass out" in refusal.hint


def test_feature_that_is_not_cut_names_the_nearest_line_and_distance() -> None:
    profile = facetst()
    path = list(centre_path(profile))
    x, z = path[2].start_mm
    path[2] = to((x + 0.254, z), (x + 0.254, path[2].end_mm[1]))
    refusal = _refusal(cut(path), profile)
    assert refusal.code is Code.NC_NO_MATCH
    assert "'small cylinder' within 0.125 mm: the nearest, line 30, passes its middle at 0.254 mm" in refusal.message
    assert refusal.place.line == 30


def test_feature_that_is_cut_in_part() -> None:
    profile = facetst()
    path = list(centre_path(profile))
    path[0] = to((path[0].start_mm[0], -60.0), path[0].end_mm)
    refusal = _refusal(cut(path), profile)
    assert refusal.code is Code.NC_NO_MATCH
    assert "'large cylinder' is cut on 9.994 mm of 51.594 mm only, from line 10 on" in refusal.message


def test_empty_program_and_wrong_nose() -> None:
    profile = facetst()
    assert "there are 0 moves" in _refusal([], profile).message
    assert "at 0.794 mm" in _refusal(cut(profile.features), profile).message


@given(profiles(), st.integers(0, 5), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_displaced_corner_still_matches(profile: Profile, index: int, dx: float, dz: float) -> None:
    """Any path point moved by up to 0.1 mm in x and z (within the tolerance along every normal) is the same contour."""
    path = list(centre_path(profile))
    k = index % (len(path) - 1)
    if not (isinstance(path[k], Line) and isinstance(path[k + 1], Line)) or math.hypot(dx, dz) > 0.12:
        return
    x, z = path[k].end_mm
    path[k] = to(path[k].start_mm, (x + dx, z + dz))
    path[k + 1] = to((x + dx, z + dz), path[k + 1].end_mm)
    match = matched(cut(path), profile)
    assert lines_of(match) == [[10 * (i + 1)] for i in range(len(path))]
    assert largest_deviation_mm(match) < 0.125 * 1.5


def _nist_moves(corpus: Path, number: str, **parameters: float) -> tuple[FeedMove, ...]:
    given_in = {"P42": 8.0, "P44": 0.0, "P45": 0.0, "P46": 5.62, "P47": 0.0, "P48": 0.0, **parameters}
    return feed_moves(read_program(nist_program(corpus, number), "ge2000t").run(given_in))


@pytest.mark.corpus
@pytest.mark.parametrize("family", ["0600", "0300", "3500", "3600", "3700", "3800", "3900"])
def test_published_programs_cut_what_they_say(family: str, corpus: Path) -> None:
    """[6811 Appendix]: each semi-finish program leaves 0.254 mm to 1e-5 in, and neither passes for the other."""
    parameters = {"P46": 3.52} if family == "0300" else {}
    semifinish, finish = (_nist_moves(corpus, family + kind, **parameters) for kind in ("11", "21"))
    profile = contour_of_program(finish, NOSE_RADIUS_MM).profile
    for moves, allowance_mm in ((semifinish, 0.254), (finish, 0.0)):
        match = matched(list(moves), profile, allowance_mm=allowance_mm)
        assert largest_deviation_mm(match) < 1e-5 * 25.4
        assert [len(feature.moves) for feature in match.features] == [1] * len(profile.features)
        refusal = _refusal(list(moves), profile, allowance_mm=0.254 - allowance_mm)
        assert refusal.code is Code.NC_NO_MATCH and "at 0.254 mm" in refusal.message


@pytest.mark.corpus
def test_mock_errors_of_the_published_facetst_program(corpus: Path) -> None:
    """[6811 §5.1]: about 12 µm at the ends of the turned cuts (P47, P48, on the diameter), 25 µm of the faces."""
    mock = {"P47": 0.001, "P48": -0.001, "P44": -0.001, "P45": 0.001}
    match = matched(list(_nist_moves(corpus, "060021", **mock)), facetst(5.62))
    face = match.features[1]
    travelled = NOSE_RADIUS_MM + 0.0127 + np.array([0.0, face.feature.length_mm])
    np.testing.assert_allclose(
        face.deviation_mm(np.array([0.0, face.feature.length_mm])),
        -0.0254 * travelled / (face.feature.length_mm + 0.0127),
        atol=1e-12,
    )
    ends = [float(feature.deviation_mm(feature.feature.length_mm)) for feature in match.features]
    assert ends == pytest.approx([0.0127, -0.0254, -0.0127, 0.0254], rel=0.02)
