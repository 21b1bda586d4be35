"""Ends of a program's moves and the moves in place of its arcs and bent lines, by hand arithmetic."""

import itertools
import math

import numpy as np
import pytest

from tests.support.profiles import polyline
from trueloop.arrays import Array
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.compensation.displaced import CentrePiece, centre_pieces, shifted_contour
from trueloop.turned.compensation.moves import Move
from trueloop.turned.compensation.shift import ZERO, Shift, constant, sampled
from trueloop.turned.compensation.targets import (
    Cut,
    EndShift,
    Fitting,
    bent_lines,
    cramped_lines,
    end_shifts,
    replaced_arcs,
    with_edges,
)

NOSE_MM = 0.8
SHOULDER = checked_profile(polyline([(10.0, -20.0), (10.0, 0.0), (0.0, 0.0)], ["cylinder", "face"]))
STEPS = checked_profile(polyline([(14.0, -20.0), (10.0, -20.0), (10.0, 0.0), (9.0, math.sqrt(3.0))], ["a", "b", "c"]))
"""Turns of 90° (concave) before the cylinder "b", 20 mm long, and of 30° after it."""
FILLET = checked_profile([Arc("fillet", (50.0, 0.0), (30.0, 20.0), (50.0, 20.0), -np.pi / 2)])


def pieces(profile: Profile, *shifts: Shift) -> tuple[CentrePiece, ...]:
    given = shifts or (ZERO,) * len(profile.features)
    return centre_pieces(profile, shifted_contour(profile, given, NOSE_MM))


def parabola(begins_mm: float, second_per_mm: float, length_mm: float = 0.0) -> Shift:
    """0 up to a place, then of constant second derivative; before the place and not after it for a length below 0."""
    half = second_per_mm / 2.0
    bent = np.array([0.0, 0.0, half])
    rows = [bent, np.zeros(3)] if length_mm < 0.0 else [np.zeros(3), bent]
    return Shift(np.array([begins_mm]), np.array(rows))


def deltas(cuts: list[Cut], *shifts: Shift) -> tuple[Array, dict[int, Array]]:
    before, after = pieces(SHOULDER), pieces(SHOULDER, *shifts)
    start, found = end_shifts(cuts, with_edges(cuts, before, after), before, after)
    assert len({each.move for each in found}) == len(found)
    return start, {each.move: each.delta_mm for each in found}


def test_ends_move_with_the_corner_and_at_free_ends_with_their_own_feature() -> None:
    """Cylinder +20 µm, face −10 µm: the corner of the centre's path moves by both, whichever way it is cut."""
    out, back = constant(0.02), constant(-0.01)
    start, ends = deltas([Cut(3, 0, 0.0, 20.0), Cut(4, 1, 0.0, 10.0)], out, back)
    assert start == pytest.approx([0.02, 0.0], abs=1e-12)
    assert ends[3] == pytest.approx([0.02, -0.01], abs=1e-12) and ends[4] == pytest.approx([0.0, -0.01], abs=1e-12)
    start, ends = deltas([Cut(3, 1, 10.0, 0.0), Cut(4, 0, 20.0, 0.0)], out, back)
    assert start == pytest.approx([0.0, -0.01], abs=1e-12)
    assert ends[3] == pytest.approx([0.02, -0.01], abs=1e-12) and ends[4] == pytest.approx([0.02, 0.0], abs=1e-12)


@pytest.mark.parametrize("from_mm", [-5.0, 0.0, 3.0])
def test_a_taper_moves_the_start_of_a_cut_by_what_it_is_there(from_mm: float) -> None:
    """u = s/1000: the nose leans by α = atan(1/1000), and its centre passes the same z, R sin α further along."""
    taper, lean = sampled(np.array([0.0, 20.0]), np.array([0.0, 0.02])), math.atan(1e-3)
    start, _ = deltas([Cut(3, 0, from_mm, 20.0), Cut(4, 1, 0.0, 10.0)], taper, ZERO)
    s = from_mm + NOSE_MM * math.sin(lean)
    assert start == pytest.approx([1e-3 * s + NOSE_MM * (math.cos(lean) - 1.0), 0.0], abs=1e-12)


def test_a_taper_moves_a_cut_s_free_end_by_what_it_is_there() -> None:
    """Of the face, cut 2 mm beyond the axis: u = 1 µm a millimetre from its start."""
    taper, lean = sampled(np.array([0.0, 10.0]), np.array([0.0, 0.01])), math.atan(1e-3)
    _, ends = deltas([Cut(3, 0, 0.0, 20.0), Cut(4, 1, 0.0, 12.0)], ZERO, taper)
    s = 12.0 + NOSE_MM * math.sin(lean)
    assert ends[4] == pytest.approx([0.0, 1e-3 * s + NOSE_MM * (math.cos(lean) - 1.0)], abs=1e-12)


def test_where_moves_about_an_edge_stand_between_both_cuts_end_with_the_corner() -> None:
    """Both ends of the edge go with the corner of the centre's path: 10 µm along the cylinder, whose taper is 0.01 µm
    less there; the last move about the edge, 5, ends 20.79 µm along the face: the taper at z = −0.01, a nose of 0.8 mm.
    """
    taper = sampled(np.array([0.0, 20.0]), np.array([0.0, 0.02]))
    start, ends = deltas([Cut(3, 0, 0.0, 18.0), Cut(6, 1, 0.5, 10.0)], taper, constant(-0.01))
    assert set(ends) == {3, 5, 6} and start[0] == pytest.approx(0.0, abs=1e-6)
    assert ends[3] == pytest.approx([1e-3 * 17.99, -0.01], abs=1e-6)
    assert ends[5] == pytest.approx([1e-3 * (19.99 + NOSE_MM), -0.01], abs=1e-6)
    assert ends[6] == pytest.approx([0.0, -0.01], abs=1e-12)


@pytest.mark.parametrize(("tolerance_mm", "bent"), [(2.1e-3, [3]), (2.2e-3, [])])
def test_a_line_is_bent_where_it_leaves_its_chord_by_half_the_tolerance(tolerance_mm: float, bent: list[int]) -> None:
    """A second derivative of 2e-5 /mm along 20 mm and the nose's 0.8 mm: a sagitta of 2e-5 · 20.8² / 8 = 1.08 µm."""
    cuts, moved = [Cut(3, 0, 0.0, 20.0), Cut(4, 1, 0.0, 10.0)], pieces(SHOULDER, parabola(0.0, 2e-5), ZERO)
    assert bent_lines(cuts, [], moved, tolerance_mm) == bent
    assert bent_lines(cuts, [3], moved, tolerance_mm) == []  # an arc in the program


def test_a_curved_feature_is_no_bent_line() -> None:
    assert bent_lines([Cut(0, 0, 0.0, FILLET.length_mm)], [], pieces(FILLET), 1e-4) == []


@pytest.mark.parametrize(("backwards", "cut_mm"), [(False, (0.0, 20.0)), (True, (20.0, 0.0))])
@pytest.mark.parametrize(
    ("shift", "sagitta_mm"),
    [
        (parabola(3.0, 4e-3, -1.0), 4e-3 * 1.2**2 / 8),
        (parabola(17.0, 4e-3), 4e-3 * (1.2 * math.tan(math.pi / 12)) ** 2 / 8),
    ],
    ids=["before 90°", "before 30°"],
)
def test_a_line_is_cramped_where_it_bends_within_the_nose_s_room_before_a_corner(
    shift: Shift, sagitta_mm: float, backwards: bool, cut_mm: tuple[float, float]
) -> None:
    """Of a nose of 0.8 mm 1.5 · 0.8 tan(θ/2): 1.2 mm before the corner of 90°, 0.32 mm before that of 30°."""
    cuts = [Cut(0, 0, 0.0, 4.0), Cut(1, 1, *cut_mm), Cut(2, 2, 0.0, 2.0)]
    if backwards:
        cuts = [Cut(0, 2, 2.0, 0.0), Cut(1, 1, *cut_mm), Cut(2, 0, 4.0, 0.0)]
    moved = pieces(STEPS, ZERO, shift, ZERO)
    for factor, found in ((0.9, [1]), (1.1, [])):
        fitting = Fitting(factor * sagitta_mm, lines=True, nose_mm=NOSE_MM)
        assert cramped_lines(cuts, [], moved, fitting) == found
        assert cramped_lines(cuts, [1], moved, fitting) == []


@pytest.mark.parametrize(("end", "begins_mm", "before"), [(0, 4.0, -1.0), (-1, 16.0, 1.0)])
def test_at_a_free_end_the_sharpest_corner_is_looked_at(end: int, begins_mm: float, before: float) -> None:
    """1.5 · 0.8 tan(1.1) = 2.3577 mm: a second derivative of 4e-3 /mm bends by 2.78 µm over it."""
    profile = checked_profile([Line("bar", (10.0, 0.0), (10.0, 20.0))])
    moved, sagitta = pieces(profile, parabola(begins_mm, 4e-3, before)), 4e-3 * 2.3577**2 / 8
    for factor, found in ((0.97, [0]), (1.03, [])):
        fitting = Fitting(factor * sagitta, lines=True, nose_mm=NOSE_MM)
        assert cramped_lines([Cut(0, 0, 0.0, 20.0)], [], moved, fitting) == found


def test_the_centre_s_own_path_needs_no_room_before_corners() -> None:
    cuts = [Cut(0, 0, 0.0, 4.0), Cut(1, 1, 0.0, 20.0), Cut(2, 2, 0.0, 2.0)]
    assert cramped_lines(cuts, [], pieces(STEPS, ZERO, parabola(3.0, 4e-3, -1.0), ZERO), Fitting(1e-6)) == []


def off_mm(moves: tuple[Move, ...], at: Array) -> Array:
    """Distances of points (n, 2) from the moves, each taken as 200 chords."""
    best = np.full(len(at), np.inf)
    for move in moves:
        share, start, end = np.linspace(0.0, 1.0, 201)[:, None], np.array(move.start_mm), np.array(move.end_mm)
        places = start + share * (end - start)
        if move.centre_mm is not None:
            arm = start - np.array(move.centre_mm)
            angle = np.arctan2(arm[0], arm[1]) - share * move.sweep_rad
            places = move.centre_mm + math.hypot(*arm) * np.hstack([np.sin(angle), np.cos(angle)])
        chord, to = np.diff(places, axis=0), at[:, None] - places[:-1]
        foot = np.clip(np.sum(to * chord, axis=2) / np.sum(chord**2, axis=1), 0.0, 1.0)
        best = np.minimum(best, np.min(np.linalg.norm(to - foot[..., None] * chord, axis=2), axis=1))
    return best


@pytest.mark.parametrize("style", ["lines", "arcs", "auto"])
@pytest.mark.parametrize("backwards", [False, True])
def test_moves_in_place_of_an_arc_keep_to_the_path_and_closer_at_touches(style: str, backwards: bool) -> None:
    """A fillet of 20 mm whose error waves by 20 µm: its touches lie within a tenth of the tolerance."""
    length = FILLET.length_mm
    at = np.linspace(0.0, length, 201)
    moved = pieces(FILLET, sampled(at, 0.02 * np.sin(at / 2.0)))
    touches = np.array([3.3, 11.1, 20.2, 29.9])
    cut = Cut(7, 0, *((length, 0.0) if backwards else (0.0, length)))
    (made,) = replaced_arcs([cut], [7], moved, [touches], Fitting(5e-4, style, nose_mm=NOSE_MM))
    assert made.move == 7 and len(made.moves) > 3
    path = moved[0].shifted.centre_mm(np.linspace(0.0, length, 400))
    first, last = made.moves[0].start_mm, made.moves[-1].end_mm
    if backwards:
        first, last = last, first
    assert first[0] == pytest.approx(50.0, abs=1e-9) and first[1] == pytest.approx(path[0, 1], abs=1e-4)
    assert last[1] == pytest.approx(20.0, abs=1e-9) and last[0] == pytest.approx(path[-1, 0], abs=1e-4)
    assert all(one.end_mm == next_.start_mm for one, next_ in itertools.pairwise(made.moves))
    assert np.max(off_mm(made.moves, path[1:-1])) < 5.1e-4
    assert np.max(off_mm(made.moves, moved[0].shifted.centre_mm(touches))) < 0.51e-4
    assert any(move.centre_mm is not None for move in made.moves) == (style != "lines")
    assert replaced_arcs([cut], [6], moved, [touches], Fitting(5e-4, style)) == ()


@pytest.mark.parametrize("backwards", [False, True])
def test_a_bent_line_becomes_lines_whose_first_and_last_leave_the_nose_its_room(backwards: bool) -> None:
    """1.2 mm before the corner of 90°, 1.2 tan 15° = 0.32 mm before that of 30°; a touch nearer is no end of a move."""
    cuts = [Cut(0, 0, 0.0, 4.0), Cut(1, 1, 0.0, 20.0), Cut(2, 2, 0.0, 2.0)]
    if backwards:
        cuts = [Cut(0, 2, 2.0, 0.0), Cut(1, 1, 20.0, 0.0), Cut(2, 0, 4.0, 0.0)]
    moved = pieces(STEPS, ZERO, Shift(np.array([]), np.array([[0.0, 0.0, 2e-4]])), ZERO)
    touches = [np.empty(0), np.array([0.9, 10.0, 19.75]), np.empty(0)]
    fitting = Fitting(5e-5, "arcs", lines=True, nose_mm=NOSE_MM)
    (made,) = replaced_arcs(cuts, [1], moved, touches, fitting)
    assert all(move.centre_mm is None for move in made.moves) and len(made.moves) > 10
    lengths = [math.dist(move.start_mm, move.end_mm) for move in made.moves]
    first, last = (lengths[-1], lengths[0]) if backwards else (lengths[0], lengths[-1])
    assert first >= 0.999 * 1.2 and 0.999 * 1.2 * math.tan(math.pi / 12) <= last
    starts, ends = moved[1].shifted.centre_mm(np.array([moved[1].start_mm, moved[1].end_mm]))
    wanted = (ends, starts) if backwards else (starts, ends)
    assert made.moves[0].start_mm == pytest.approx(wanted[0]) and made.moves[-1].end_mm == pytest.approx(wanted[1])


def test_cuts_end_where_their_features_do_beside_an_arc_about_the_edge() -> None:
    cuts = [Cut(3, 0, 0.0, 20.0), Cut(6, 1, 0.0, 10.0)]
    before, after = pieces(SHOULDER), pieces(SHOULDER, constant(0.02), constant(-0.01))
    (first, second), about = with_edges(cuts, before, after), with_edges(cuts, before, after, [4])
    assert (first.end_mm, second.start_mm) == pytest.approx((20.0 - 0.01, -0.02), abs=1e-9)
    assert list(about) == cuts and list(with_edges(cuts, before, after, [7])) == [first, second]


def test_a_correction_that_moves_nothing_moves_no_end() -> None:
    cuts = [Cut(3, 0, 0.0, 20.0), Cut(4, 1, 0.0, 10.0)]
    start, found = end_shifts(cuts, cuts, pieces(SHOULDER), pieces(SHOULDER))
    assert not np.any(start) and all(isinstance(each, EndShift) and not np.any(each.delta_mm) for each in found)
