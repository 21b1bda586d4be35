"""Lines and tangent arcs fitted to a path stay within tolerance, keep their ends, and arcs keep the tangent."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.arrays import Array
from trueloop.turned.compensation.moves import (
    Move,
    SampledPath,
    as_arcs,
    as_lines,
    between,
    fewest_moves,
    within_quadrants,
)


def wavy(amplitude_mm: float, waves: float, tolerance_mm: float = 5e-4) -> SampledPath:
    """A quarter circle of 38 mm whose radius waves by an amplitude."""
    angle = np.linspace(0.0, math.pi / 2, 1501)
    radius = 38.0 + amplitude_mm * np.sin(waves * angle)
    slope = amplitude_mm * waves * np.cos(waves * angle)
    radial = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    direction = slope[:, None] * radial + radius[:, None] * across
    tangent = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return SampledPath(radius[:, None] * radial, tangent, np.full(len(angle), tolerance_mm))


def distance_to(moves: tuple[Move, ...], point: Array) -> float:
    """Distance of a point to the moves themselves, ends included, by dense sampling of each: the slow way."""
    best = math.inf
    for move in moves:
        points = _points(move)
        chord = np.diff(points, axis=0)
        foot = np.clip(np.sum((point - points[:-1]) * chord, axis=1) / np.sum(chord**2, axis=1), 0, 1)
        best = min(best, float(np.linalg.norm(points[:-1] + foot[:, None] * chord - point, axis=1).min()))
    return best


def _points(move: Move) -> Array:
    share = np.linspace(0, 1, 2001)[:, None]
    start, end = np.asarray(move.start_mm), np.asarray(move.end_mm)
    if move.centre_mm is None:
        return np.asarray(start + share * (end - start))
    arm = start - np.asarray(move.centre_mm)
    turned = -move.sweep_rad * share  # clockwise with z right and x up: the angle from z towards x falls
    cos, sin = np.cos(turned), np.sin(turned)
    rotated = np.concatenate([cos * arm[0] + sin * arm[1], -sin * arm[0] + cos * arm[1]], axis=1)
    return np.asarray(np.asarray(move.centre_mm) + rotated)


SWEEPS = st.floats(-6.2, 6.2).filter(lambda sweep: abs(sweep) > 0.01)
PLACES = st.floats(-3.2, 3.2)


@given(SWEEPS, PLACES, PLACES, PLACES)
def test_gap_counts_ends_and_sweep(sweep_rad: float, from_rad: float, x: float, z: float) -> None:
    start, end = ((4 + 2 * math.sin(a), 2 * math.cos(a) - 9) for a in (from_rad, from_rad - sweep_rad))
    arc = Move(start, end, (4.0, -9.0), sweep_rad)
    chord = Move(arc.start_mm, arc.end_mm)
    point = np.array([4 + x, z - 9])
    for move in (arc, chord):
        assert move.gap_mm(point[None])[0] == pytest.approx(distance_to((move,), point), abs=1e-5)


def test_gap_of_a_move_that_goes_nowhere() -> None:
    assert Move((1.0, 2.0), (1.0, 2.0)).gap_mm(np.array([[4.0, 6.0]])) == pytest.approx([5.0])


@given(st.floats(-0.1, 0.1), st.floats(0.5, 12.0))
def test_arcs_stay_within_tolerance_and_chain(amplitude_mm: float, waves: float) -> None:
    path = wavy(amplitude_mm, waves)
    moves = as_arcs(path)
    assert moves[0].start_mm == pytest.approx(path.point_mm[0], abs=0)
    assert moves[-1].end_mm == pytest.approx(path.point_mm[-1], abs=1e-12)
    for before, after in itertools.pairwise(moves):
        assert before.end_mm == pytest.approx(after.start_mm, abs=1e-12)
    for k in range(0, len(path.point_mm), 97):
        assert distance_to(moves, path.point_mm[k]) <= 5e-4 + 2e-6  # the sagitta of the slow sampling


@given(st.floats(-0.1, 0.1), st.floats(0.5, 12.0))
def test_arcs_keep_the_tangent(amplitude_mm: float, waves: float) -> None:
    for before, after in itertools.pairwise(as_arcs(wavy(amplitude_mm, waves))):
        leaving, arriving = _points(before)[-2:], _points(after)[:2]
        a, b = leaving[1] - leaving[0], arriving[1] - arriving[0]
        sine = (a[0] * b[1] - a[1] * b[0]) / (np.linalg.norm(a) * np.linalg.norm(b))
        assert abs(sine) < 1e-3  # half a step of the sampling on either side


def test_chord_count_is_the_sagitta_formula() -> None:
    """A circle of radius R in chords of sagitta δ: angle 2 arccos(1 − δ/R) each."""
    moves = as_lines(wavy(0.0, 1.0))
    ideal = (math.pi / 2) / (2 * math.acos(1 - 5e-4 / 38.0))
    assert ideal <= len(moves) <= 1.15 * ideal


def test_a_true_circle_needs_one_pair_of_arcs() -> None:
    moves = fewest_moves(wavy(0.0, 1.0))
    assert len(moves) == 2
    assert sum(move.sweep_rad for move in moves) == pytest.approx(math.pi / 2, abs=1e-9)  # x to z: G02
    for move in moves:
        assert move.centre_mm == pytest.approx((0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize("fit", [as_lines, as_arcs, fewest_moves])
def test_a_path_elsewhere_has_the_same_moves_there(fit: Callable[[SampledPath], tuple[Move, ...]]) -> None:
    path, by = wavy(0.05, 7.0), np.array([120.0, -310.0])
    here, there = fit(path), fit(SampledPath(path.point_mm + by, path.tangent, path.tolerance_mm))
    assert len(here) == len(there) > 4
    for one, other in zip(here, there, strict=True):
        assert np.subtract(other.end_mm, one.end_mm) == pytest.approx(by, abs=1e-9)
        assert other.sweep_rad == pytest.approx(one.sweep_rad, abs=1e-7)


def test_an_s_of_two_arcs_is_these_two() -> None:
    """30° of 10 mm to one side and as much to the other: the pair with equal legs meets where they do."""
    turned = np.linspace(0.0, math.pi / 6, 65)  # the pair is tried at 128 samples, by doubling
    first = 10.0 * np.stack([1.0 - np.cos(turned), np.sin(turned)], axis=1)
    second = 2 * first[-1] - first[-2::-1]
    heading = np.concatenate([turned, turned[-2::-1]])
    tangent = np.stack([np.sin(heading), np.cos(heading)], axis=1)
    one, other = as_arcs(SampledPath(np.concatenate([first, second]), tangent, np.full(len(heading), 1e-6)))
    assert one.end_mm == pytest.approx(first[-1], abs=1e-9)
    assert (one.sweep_rad, other.sweep_rad) == pytest.approx((-math.pi / 6, math.pi / 6), abs=1e-9)


def test_a_straight_path_is_one_line() -> None:
    s = np.linspace(0, 10, 101)
    path = SampledPath(np.stack([s, 2 * s], axis=1), np.tile([1, 2] / np.sqrt(5), (101, 1)), np.full(101, 5e-4))
    assert len(as_lines(path)) == len(fewest_moves(path)) == 1
    assert all(move.centre_mm is None for move in as_arcs(path))


def test_tight_samples_pull_the_moves_to_them() -> None:
    """A gauging point has a tolerance of its own: the moves pass it that much closer."""
    path = wavy(0.05, 7.0)
    tight = path.tolerance_mm.copy()
    tight[[300, 700, 1100]] = 2e-5
    moves = as_lines(SampledPath(path.point_mm, path.tangent, tight))
    for k in (300, 700, 1100):
        assert min(float(m.distance_mm(path.point_mm[[k]])[0]) for m in moves) <= 2e-5


@pytest.mark.parametrize("sweep_rad", [1.2, -1.2, 4.0, -4.0])
def test_an_arc_between_new_ends_keeps_radius_and_side(sweep_rad: float) -> None:
    centre = (3.0, -7.0)
    start = (3.0 + 2.0 * math.sin(0.3), -7.0 + 2.0 * math.cos(0.3))
    end = (3.0 + 2.0 * math.sin(0.3 - sweep_rad), -7.0 + 2.0 * math.cos(0.3 - sweep_rad))
    shift = np.array([0.01, -0.02])
    moved = between(
        Move(start, end, centre, sweep_rad),
        (start[0] + shift[0], start[1] + shift[1]),
        (end[0] + shift[0], end[1] + shift[1]),
    )
    assert moved.centre_mm == pytest.approx((centre[0] + shift[0], centre[1] + shift[1]), abs=1e-9)
    assert moved.sweep_rad == pytest.approx(sweep_rad, abs=1e-9)


@given(st.floats(-3.1, 3.1), st.floats(0.2, 6.0), st.booleans())
def test_pieces_within_quadrants_are_the_same_arc(start_rad: float, sweep_rad: float, clockwise: bool) -> None:
    sign = 1 if clockwise else -1
    radius = 20.0
    angles = (start_rad, start_rad - sign * sweep_rad)
    at = [(3.0 + radius * math.sin(a), -7.0 + radius * math.cos(a)) for a in angles]
    pieces = within_quadrants(Move(at[0], at[1], (3.0, -7.0), sign * sweep_rad))
    assert pieces[0].start_mm == at[0]
    assert pieces[-1].end_mm == at[1]
    assert sum(piece.sweep_rad for piece in pieces) == pytest.approx(sign * sweep_rad)
    for before, after in itertools.pairwise(pieces):
        assert before.end_mm == after.start_mm
        assert min(abs(before.end_mm[0] - 3.0), abs(before.end_mm[1] + 7.0)) < 1e-9  # cut on an axis of the circle
    for piece in pieces:
        assert piece.centre_mm == (3.0, -7.0)
        inner = _points(piece)[50:-50] - [3.0, -7.0]
        signs = np.sign(inner[np.all(np.abs(inner) > 0.011, axis=1)])
        assert len(np.unique(signs, axis=0)) <= 1


def test_a_line_between_new_ends_is_a_line_and_has_no_quadrants() -> None:
    moved = between(Move((1.0, 2.0), (3.0, 4.0)), (1.1, 2.0), (3.1, 4.0))
    assert moved == Move((1.1, 2.0), (3.1, 4.0)) and within_quadrants(moved) == (moved,)


@pytest.mark.parametrize(("beyond_mm", "pieces"), [(0.005, 1), (0.02, 2)])
def test_a_sliver_beyond_a_quadrant_stays_attached(beyond_mm: float, pieces: int) -> None:
    """A quarter of 90° less 30°, from 30° to the z axis on a radius of 20 mm, and a little more."""
    angle = np.pi / 6 + beyond_mm / 20.0
    start, end = ((20.0 * np.sin(a), 20.0 * np.cos(a)) for a in (np.pi / 6, -beyond_mm / 20.0))
    move = Move((float(start[0]), float(start[1])), (float(end[0]), float(end[1])), (0.0, 0.0), float(angle))
    assert len(within_quadrants(move)) == pieces


def test_no_short_move_is_left_at_the_end() -> None:
    """Chords of an arc of 20 mm reach 0.4 mm each, 2 √(2 · 20 mm · 1 µm): no rest is below 0.1 mm."""
    for length_mm in np.arange(2.0, 2.8, 0.02):
        angle = np.linspace(0.0, length_mm / 20.0, round(length_mm / 0.01) + 1)
        points = 20.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        tangents = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        last = as_lines(SampledPath(points, tangents, np.full(len(angle), 1e-3)))[-1]
        assert np.hypot(*np.subtract(last.end_mm, last.start_mm)) > 0.1 - 1e-9
