"""Figures of a surface's correction by hand: ridges, places of a pass, a cutter's edge, motions of a part, lattices."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.support.surfaces import wavy_surface
from trueloop.arrays import Array
from trueloop.errors import TrueloopError
from trueloop.geometry.surface import Surface, fit_grid
from trueloop.nc.program.program import read_program
from trueloop.surface.compensation import shift
from trueloop.surface.compensation.cutter import Cutter, edge_centres_mm, tool_axes
from trueloop.surface.compensation.program import _cuts
from trueloop.surface.compensation.shift import MovedFace, SurfaceJob, moved_locations, moved_over_faces, places
from trueloop.surface.deviations.alignment import (
    DATUM,
    Faces,
    best_fit,
    count_told,
    form_size,
    rigid_motions,
    spread_of,
)
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.deviations.points import MeasuredPoints, on_face, refuse_unit
from trueloop.surface.pattern.support import between
from trueloop.surface.separation.moran import lattice_of
from trueloop.surface.separation.separate import averaged_over_cells
from trueloop.surface.separation.spline_surface import _lines
from trueloop_lab.loops.surface import form_alone_mm
from trueloop_lab.simulator.zigzag import ZigzagOptions, scallop_step_mm, zigzag

FLAT = wavy_surface(20.0, 0.0)


@pytest.mark.parametrize("across_mm", [-12.0, math.inf, 12.0], ids=["hollow", "flat", "convex"])
def test_the_step_between_passes_leaves_ridges_of_that_height(across_mm: float) -> None:
    """Balls of 3 mm run on a circle of 9 mm in a hollow of 12 mm, of 15 mm around such a cylinder."""
    step = float(scallop_step_mm(3.0, 0.002, np.array(1.0 / across_mm)))
    if math.isinf(across_mm):
        ridge = 3.0 - math.sqrt(9.0 - step**2 / 4.0)
    else:
        half, runs_mm = step / 24.0, abs(across_mm + 3.0)
        crosses = math.copysign(math.sqrt(9.0 - (runs_mm * math.sin(half)) ** 2), -across_mm)
        ridge = math.copysign(runs_mm * math.cos(half) + crosses - 12.0, 1.0)
    assert ridge == pytest.approx(0.002, rel=0.01)


def test_passes_of_a_zigzag_over_a_plane() -> None:
    """20 mm in steps of at most √(8 · 3 · 0.002) = 0.219 mm: 92 of them, to and fro, two points each."""
    passes = zigzag(FLAT, ZigzagOptions(3.0, 0.002, 0.001))
    assert len(passes) == 93 and all(len(tips) == 2 for tips in passes)
    for k, tips in enumerate(passes):
        wanted = [[0.0, 20.0 * k / 92, 0.0], [20.0, 20.0 * k / 92, 0.0]]
        np.testing.assert_allclose(tips, wanted[:: -1 if k % 2 else 1], atol=1e-9)


@pytest.mark.parametrize("bend", [1.0, -1.0], ids=["ridge", "trough"])
def test_points_of_a_pass_over_a_cylinder_keep_the_chord(bend: float) -> None:
    """Of 8 mm, along its arc: the ball's centre goes on 8 ± 3 mm, where a step's sagitta is to be 1 µm at most."""
    x, y = np.meshgrid(np.linspace(-5, 5, 61), np.linspace(-1, 1, 9), indexing="ij")
    surface = fit_grid(np.stack([x, y, bend * (np.sqrt(64 - x**2) - 8)], axis=2)).surface
    tips = zigzag(surface, ZigzagOptions(3.0, 0.01, 0.001))[0]
    radius = np.hypot(tips[:, 0], tips[:, 2] + 3.0 + bend * 8.0)
    np.testing.assert_allclose(radius, 8.0 + bend * 3.0, atol=2e-4)
    chords = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    assert 0.5e-3 < np.max(chords) ** 2 / (8 * (8.0 + bend * 3.0)) < 1.1e-3


def test_places_along_moves_are_no_further_apart_than_asked_for() -> None:
    """10 mm in steps of 0.5 mm; 1 mm with a turn by 25° in steps of 1°; of a turn about two axes both count."""
    text = "G21 G90 G94 G17\nG1 X0 Y0 Z0 A0 C0 F100\nX10\nX11 A25\nX12 A20 C-10\nM2\n"
    program = read_program(text.encode(), "linuxcnc")
    path = program.run()
    axes = tool_axes(program, path, "CA", (0.0, 0.0, 1.0))
    last = np.arange(len(path))[-3:]
    np.testing.assert_allclose(axes.turned_deg(last), [0.0, 25.0, 15.0])
    move, share = places(path, axes, last, 0.5)
    for each, pieces in zip(last, (20, 25, 15), strict=True):
        np.testing.assert_allclose(share[move == each], np.arange(pieces + 1) / pieces)


def test_a_vector_turns_by_the_angle_between_its_ends() -> None:
    text = "G21 G90 G94 G17\nG1 X0 Y0 Z0 I0 J0 K1 F100\nX10 I1 K1\nX11 I0 J-1 K0\nM2\n"
    program = read_program(text.encode(), "linuxcnc")
    path = program.run()
    axes = tool_axes(program, path, "IJK", (0.0, 0.0, 1.0))
    np.testing.assert_allclose(axes.turned_deg(np.arange(len(path))[-2:]), [45.0, 90.0], atol=1e-9)


@pytest.mark.parametrize(
    ("letters", "words", "written"),
    [
        ("CA", "C20. A10.5", " C20.0000 A10.5000"),
        ("CA", "C20.123456 A10.", " C20.123456 A10.000000"),
        ("IJK", "I0. J-0.6 K0.8", " I0.000000 J-0.600000 K0.800000"),
    ],
)
def test_new_words_have_the_digits_of_their_kind_or_of_the_program_s_own(
    letters: str, words: str, written: str
) -> None:
    """Four of an angle, 1.7 µrad, and six of a vector, 1 µrad, at least."""
    program = read_program(f"G21 G90 G94 G17\nG1 X0 Y0 Z0 {words} F100\nX10\nM2\n".encode(), "linuxcnc")
    path = program.run()
    assert tool_axes(program, path, letters, (0.0, 0.0, 1.0)).text(len(path) - 1, 0.5) == written


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.36, -0.48, 0.8), (0.0, 1.0, 0.0)])
def test_the_corner_s_centre_runs_around_the_axis(axis: tuple[float, float, float]) -> None:
    """Of a cutter of 5 mm with corners of 1 mm: a circle of 4 mm about the axis, 1 mm above the tip."""
    tip, up = np.array([[1.0, 2.0, 3.0]]), np.array([axis])
    arms = np.concatenate(list(edge_centres_mm(Cutter(5.0, 1.0), tip, up, 8))) - (tip + up)
    np.testing.assert_allclose(np.linalg.norm(arms, axis=1), 4.0, rtol=1e-12)
    np.testing.assert_allclose(arms @ np.array(axis), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.einsum("ij,ij->i", arms, np.roll(arms, 1, axis=0)), 16.0 * math.sqrt(0.5), rtol=1e-12)
    assert list(edge_centres_mm(Cutter(3.0, 3.0), tip, up, 8)) == []


def test_what_a_location_stands_off_is_kept_and_what_does_not_cut_stays() -> None:
    """The corrected plane stands 30 µm higher. 49 µm off the nominal one, above or below, is cutting; 51 µm is not, and
    neither is what lies 60 µm beside the patch.
    """
    raised = fit_grid(FLAT.grid_mm(np.linspace(0, 1, 9), np.linspace(0, 1, 9)) + np.array([0.0, 0.0, 0.03])).surface
    z = [0.0, 0.049, -0.049, 0.051, -0.051, 0.0, 0.0]
    x = [5.0, 6.0, 7.0, 8.0, 9.0, -0.04, -0.06]
    tips = np.column_stack([x, np.full(7, 10.0), z])
    found = moved_locations(FLAT, raised, Cutter(3.0, 3.0), tips, np.tile([0.0, 0.0, 1.0], (7, 1)))
    cuts = np.array([True, True, True, False, False, True, False])
    np.testing.assert_array_equal(found.cutting, cuts)
    np.testing.assert_allclose(found.tips_mm - tips, np.outer(cuts, [0.0, 0.0, 0.03]), atol=1e-7)
    np.testing.assert_allclose(found.gap_mm[:5], z[:5], atol=1e-9)


def _patch(*corners: tuple[float, float, float]) -> Surface:
    """A level patch through three corners: the first, and where u and v lead."""
    first, along, across = (np.array(corner) for corner in corners)
    u, v = (at[..., None] for at in np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), indexing="ij"))
    return fit_grid(first + u * (along - first) + v * (across - first)).surface


def _quarter(radius_mm: float) -> Surface:
    """A hollow quarter of a cylinder about (5, y, 5), from the floor z = 0 to the wall x = 0, its normals inwards."""
    angle, y = (
        at[..., None] for at in np.meshgrid(np.linspace(0, np.pi / 2, 33), np.linspace(0, 10, 9), indexing="ij")
    )
    at = np.concatenate([5 - radius_mm * np.sin(angle), y, 5 - radius_mm * np.cos(angle)], axis=2)
    made = fit_grid(at).surface
    return made if made.normal(np.array([0.5]), np.array([0.5]))[0, 2] > 0 else made.turned_over()


def _shifted(face: Surface, by_mm: tuple[float, float, float]) -> MovedFace:
    return MovedFace(face, replace(face, control_mm=face.control_mm + np.array(by_mm)))


def test_a_ball_in_a_corner_is_moved_by_floor_and_wall_and_on_either_by_that_alone() -> None:
    """By hand: 10 µm more on the floor and 4 µm on the wall take a ball of 5 mm in the corner to (4, 0, 10), 1.5 µm
    off the wall too; 2.5 µm off, which is more than 2 µm, the floor alone counts.
    """
    floor = _shifted(_patch((0, 0, 0), (20, 0, 0), (0, 10, 0)), (0.0, 0.0, 0.010))
    wall = _shifted(_patch((0, 0, 0), (0, 10, 0), (0, 0, 20)), (0.004, 0.0, 0.0))
    tips, up = np.array([[5.0, 5.0, 0.0], [9.0, 5.0, 0.0], [5.0, 5.0, 9.0]]), np.tile([0.0, 0.0, 1.0], (3, 1))
    found, nearest = moved_over_faces([floor, wall], Cutter(5.0, 5.0), tips, up)
    np.testing.assert_allclose(1e3 * (found.tips_mm - tips), [[4, 0, 10], [0, 0, 10], [4, 0, 0]], atol=1e-6)
    assert list(nearest[1:]) == [0, 1] and np.all(found.cutting)
    beside = np.array([[5.0015, 5.0, 0.0], [5.0025, 5.0, 0.0]])
    moved, _ = moved_over_faces([floor, wall], Cutter(5.0, 5.0), beside, up[:2])
    np.testing.assert_allclose(1e3 * (moved.tips_mm - beside), [[4, 0, 10], [0, 0, 10]], atol=1e-6)


def test_a_ball_that_fills_a_fillet_is_moved_by_all_that_it_touches_wherever_the_nearest_place_is() -> None:
    """Floor and wall end where the fillet begins. All lie 10 µm higher and 4 µm farther in: so does the ball."""
    floor, wall = _patch((5, 0, 0), (20, 0, 0), (5, 10, 0)), _patch((0, 0, 5), (0, 10, 5), (0, 0, 20))
    faces = [_shifted(face, (0.004, 0.0, 0.010)) for face in (floor, _quarter(5.0), wall)]
    tip, up = np.array([[5.0, 5.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    found, _ = moved_over_faces(faces, Cutter(5.0, 5.0), tip, up)
    np.testing.assert_allclose(1e3 * (found.tips_mm - tip), [[4, 0, 10]], atol=1e-2)


@pytest.mark.parametrize(
    ("cutter", "hollow_mm", "rise_mm", "filled"),
    [(Cutter(5.0, 5.0), 5.2, 0.05, True), (Cutter(6.0, 3.0), 6.2, 0.2, False), (Cutter(3.0, 3.0), 6.2, 0.2, False)],
)
def test_a_hollow_that_the_corner_fills_moves_it_by_what_the_place_touched_is_moved_by(
    cutter: Cutter, hollow_mm: float, rise_mm: float, filled: bool
) -> None:
    """A hollow quarter that comes inwards by more from floor to wall, touched at 75°. A corner of nearly its radius
    goes with the place touched, by 75/90 of the rise; a smaller one, whatever the cutter is, until it touches
    again: places r(θ) from the axis are all c from its centre, so that d = r cos δ − √(c² − r² sin² δ) is the least.
    """
    angle, touched = np.linspace(0, np.pi / 2, 65), math.radians(75)
    y, out = np.linspace(0, 10, 9), np.array([math.sin(touched), 0.0, math.cos(touched)])

    def hollow(radius_mm: Array) -> Surface:
        at = np.stack([5 - radius_mm * np.sin(angle), 0 * angle, 5 - radius_mm * np.cos(angle)], axis=1)[:, None]
        made = fit_grid(at + np.stack([0 * y, y, 0 * y], axis=1)).surface
        return made if made.normal(np.array([0.5]), np.array([0.5]))[0, 2] > 0 else made.turned_over()

    share = angle / (np.pi / 2)
    face = MovedFace(hollow(hollow_mm + 0 * angle), hollow(hollow_mm - rise_mm * share), lambda u, v: np.zeros(len(u)))
    corner, up = cutter.corner_mm, np.array([[0.0, 0.0, 1.0]])
    centre = np.array([5.0, 5.0, 5.0]) - (hollow_mm - corner) * out
    tip = centre + np.array([[cutter.radius_mm - corner, 0.0, -corner]])
    found, _ = moved_over_faces([face], cutter, tip, up)
    fine = touched + np.linspace(-0.2, 0.2, 100_001)
    radius = hollow_mm - rise_mm * fine / (np.pi / 2)
    least = min(
        radius * np.cos(fine - touched) - np.sqrt(np.maximum(corner**2 - (radius * np.sin(fine - touched)) ** 2, 0.0))
    )
    by_place, until_it_touches = rise_mm * 75 / 90, hollow_mm - corner - least
    assert until_it_touches - by_place > 1e-3
    np.testing.assert_allclose(found.tips_mm - tip, [(by_place if filled else until_it_touches) * out], atol=1e-4)


def test_a_face_s_shift_is_that_of_the_place_at_its_share_of_both_parameters() -> None:
    """Parameters from 2 to 4 and from −3 to 3 for the nominal, from 0 to 1 for the corrected one, which is 10 µm higher
    at the end of u and 40 µm lower at that of v: 7.5 − 10 µm at (3.5, −1.5).
    """
    flat = _patch((0, 0, 0), (20, 0, 0), (0, 10, 0))
    nominal = replace(flat, knots_u=2 + 2 * flat.knots_u, knots_v=6 * flat.knots_v - 3)
    face = MovedFace(nominal, _patch((0, 0, 0), (20, 0, 0.010), (0, 10, -0.040)))
    shift_um = 1e3 * face.shift_mm(np.array([3.5, 2.0, 4.0]), np.array([-1.5, 3.0, -3.0]))
    np.testing.assert_allclose(shift_um, [-2.5, -40.0, 10.0], atol=1e-6)


@pytest.mark.parametrize(("between_deg", "together"), [(12.0, True), (18.0, True), (22.0, False), (60.0, False)])
def test_two_faces_of_nearly_one_direction_move_a_ball_by_their_mean(between_deg: float, together: bool) -> None:
    """In a flat V of two planes, 10 µm and 14 µm higher along their normals. By hand: the mean along the middle, by
    least squares 12 cos(α/2) / cos²(α/2); where they are two directions, 2 / sin(α/2) sideways besides.
    """
    half = math.radians(between_deg / 2)
    left = _patch((0, 0, 0), (0, 10, 0), (-20 * math.cos(half), 0, 20 * math.sin(half)))
    right = _patch((0, 10, 0), (0, 0, 0), (20 * math.cos(half), 10, 20 * math.sin(half)))
    out = np.array([[math.sin(half), 0.0, math.cos(half)], [-math.sin(half), 0.0, math.cos(half)]])
    for face, normal in zip((left, right), out, strict=True):
        np.testing.assert_allclose(face.normal(np.array([0.5]), np.array([0.5]))[0], normal, atol=1e-9)
    faces = [
        _shifted(face, tuple(by * normal)) for face, by, normal in zip((left, right), (0.010, 0.014), out, strict=True)
    ]
    tip = np.array([[0.0, 5.0, 5.0 / math.cos(half) - 5.0]])
    found, _ = moved_over_faces(faces, Cutter(5.0, 5.0), tip, np.array([[0.0, 0.0, 1.0]]))
    sideways = 0.0 if together else -2.0 / math.sin(half)
    np.testing.assert_allclose(1e3 * (found.tips_mm - tip), [[sideways, 0.0, 12.0 / math.cos(half)]], atol=1e-3)


SQUARE = np.array([[1.0, 1.0, 5.0], [1.0, -1.0, 5.0], [-1.0, 1.0, 5.0], [-1.0, -1.0, 5.0]])
UP = np.tile([0.0, 0.0, 1.0], (4, 1))


def test_motions_of_four_corners_of_a_square() -> None:
    """1 mm along z moves all four deviations by 1: √4. A turn of 1 mm at the spread √2 tilts by 1/√2 at ±1: √2. The
    plane says nothing of the other three.
    """
    centre = SQUARE.mean(axis=0)
    assert spread_of(SQUARE, centre) == pytest.approx(math.sqrt(2.0))
    found = rigid_motions(SQUARE, UP, centre, math.sqrt(2.0))
    np.testing.assert_allclose(found.size[:3], [2.0, math.sqrt(2.0), math.sqrt(2.0)])
    assert np.all(found.size[3:] < 1e-12)
    np.testing.assert_allclose(np.abs(found.motion[0]), [0, 0, 1, 0, 0, 0], atol=1e-12)
    for motion, shape, size in zip(found.motion[:3], found.shapes.T, found.size, strict=False):
        turned = np.cross(motion[3:] / math.sqrt(2.0), SQUARE - centre)
        np.testing.assert_allclose(size * shape, (motion[:3] + turned)[:, 2], atol=1e-12)
    # Three standard deviations of 0.1 mm · 1/√2 = 0.2121 mm for the tilts, of half of it for the height.
    assert [count_told(found, 0.1, setup) for setup in (0.149, 0.151, 0.212, 0.2122)] == [0, 1, 1, 3]


def test_the_form_is_what_motions_do_not_explain_spread_over_twelve_shapes() -> None:
    """Polynomials up to degree 4 in two variables are 15, less three motions of a plane. A tilt is no form: 10 nm."""
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), indexing="ij"))
    points, normal = np.stack([20 * u, 20 * v, 0 * u], axis=1), np.tile([0.0, 0.0, 1.0], (81, 1))
    centre = points.mean(axis=0)
    motions = rigid_motions(points, normal, centre, spread_of(points, centre))
    saddle, tilt = 0.01 * (2 * u - 1) * (2 * v - 1), 0.003 + 0.02 * u - 0.01 * v
    size = float(np.linalg.norm(saddle)) / math.sqrt(12.0)
    assert form_size(motions, u, v, saddle) == pytest.approx(size, rel=1e-9)
    assert form_size(motions, u, v, saddle + tilt) == pytest.approx(size, rel=1e-9)
    assert form_size(motions, u, v, tilt) == pytest.approx(1e-5)
    np.testing.assert_allclose(form_alone_mm(points, normal, u, v, saddle + tilt, 0.2), saddle, atol=1e-12)
    np.testing.assert_allclose(form_alone_mm(points, normal, u, v, saddle + tilt, 1e-4), saddle + tilt, atol=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 2.5, 3.0, 6.0, 9.0])
@pytest.mark.parametrize(("rows", "columns", "holes"), [(5, 9, 0), (8, 4, 3), (4, 6, 5), (13, 3, 1)])
def test_weights_on_a_lattice_are_those_of_all_pairs(rows: int, columns: int, holes: int, exponent: float) -> None:
    """A skew lattice in space, in any order, with holes: beside the sum over all pairs written out."""
    rng = np.random.default_rng(rows)
    at = np.array([[i, j] for i in range(rows) for j in range(columns)])
    at = rng.permutation(at)[holes:]
    points = at @ np.array([[1.0, 0.2, 0.1], [-0.3, 0.7, 0.5]]) + [5.0, -7.0, 2.0]
    found, values = lattice_of(points, exponent), rng.normal(size=(len(at), 2))
    assert found is not None and sorted(found.shape) == sorted((rows, columns))
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    np.fill_diagonal(apart, np.inf)
    weights = apart**-exponent
    np.testing.assert_allclose(found.times(values), weights @ values, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(
        found.products(values), np.sum(values * (weights @ values), axis=0), rtol=1e-8, atol=1e-8
    )


def test_places_off_a_lattice_have_none() -> None:
    """One point a millionth of a step aside, two on one place, and rows that are no steps of one length."""
    at = np.array([[i, j, 0] for i in range(5) for j in range(5)], float)
    assert lattice_of(at, 3.0) is not None
    assert lattice_of(at[:15], 3.0) is None  # too few to look for
    aside, twice, uneven = at.copy(), at.copy(), at.copy()
    aside[12, 0] += 1e-6
    twice[12] = twice[13]
    uneven[:, 0] = uneven[:, 0] ** 1.5
    assert [lattice_of(points, 3.0) for points in (aside, twice, uneven)] == [None] * 3


def test_a_chip_is_left_out_by_how_far_it_is_from_the_others_though_all_are_off() -> None:
    """A fit that may move nothing: all points are 40 µm high, one 100 µm. It is 60 µm from the middle, more than 50."""
    at = np.linspace(2.0, 18.0, 9)
    x, y = (a.ravel() for a in np.meshgrid(at, at))
    points = np.column_stack([x, y, np.full(81, 0.04)])
    points[30, 2] = 0.1
    faces = Faces((FLAT,), np.zeros(81, int))
    alignment, _, aside = best_fit(faces, points, 0.0, faces.closest(points), 1e-9)
    np.testing.assert_allclose(alignment.apply(points), points, atol=1e-12)
    assert np.flatnonzero(aside).tolist() == [30]


def test_cells_are_at_shares_of_the_parameters() -> None:
    """Parameters from 2 to 4 and from −3 to 3, two points to a cell of 10 × 2.5 mm: their mean is at its middle."""
    flat = _patch((0, 0, 0), (20, 0, 0), (0, 10, 0))
    nominal = replace(flat, knots_u=2 + 2 * flat.knots_u, knots_v=6 * flat.knots_v - 3)
    u, v = np.repeat([2.4, 2.6, 3.1, 3.9], 4), np.tile([-2.0, -0.1, 1.4, 2.9], 4)
    error = np.arange(16, dtype=np.float64)
    scanned = SurfaceDeviations("P1", u, v, nominal.point_mm(u, v), nominal.normal(u, v), error, None, DATUM)
    places, means = averaged_over_cells(nominal, scanned, (2, 4))
    np.testing.assert_allclose(places.points_mm[:, 0], np.repeat([5.0, 15.0], 4), atol=1e-9)
    np.testing.assert_allclose(places.points_mm[:, 1], np.tile([1.25, 3.75, 6.25, 8.75], 2), atol=1e-9)
    np.testing.assert_allclose(means, [2, 3, 4, 5, 10, 11, 12, 13])


@pytest.mark.parametrize(
    ("tenths", "full"),
    [
        (range(11), True),
        ((0, 1, 2, 3, 5, 6, 7, 8, 9, 10), True),
        ((0, 1, 2, 3, 6, 7, 8, 9, 10), False),
        (range(8, -1, -1), True),
        (range(8), False),
        (range(2, 11), True),
        (range(3, 11), False),
    ],
)
def test_rows_of_a_grid_that_leave_two_and_a_half_steps_open_are_no_full_grid(
    tenths: Sequence[int], full: bool
) -> None:
    """Steps of a tenth: two are left open where a row is missing, three where two are, at either edge as inside."""
    found = _lines(np.repeat(np.array(tenths)[:, None] / 10, 3, axis=1))
    assert (found is not None) is full


def test_between_samples_a_value_is_on_the_straight_line_between_them_up_to_the_last() -> None:
    """Squares of 0, 1, 2 along v, ten more a row: 2.5 between 1 and 4, and 15 between rows 1 and 2."""
    samples = 10.0 * np.arange(3)[:, None] + np.arange(3.0) ** 2
    u, v = np.array([0.0, 0.75, 1.0, 0.25]), np.array([0.75, 0.0, 1.0, 0.25])
    np.testing.assert_allclose(between(samples, u, v), [2.5, 15.0, 24.0, 5.5])


def test_a_vector_of_which_one_part_is_said_has_none_of_the_others() -> None:
    program = read_program(b"G21 G90 G94 G17\nG1 X0 Y0 Z0 F100\nX10 K1\nX20 I1\nM2\n", "linuxcnc")
    path = program.run()
    axes = tool_axes(program, path, "IJK", (0.0, 0.0, 1.0))
    last = np.arange(len(path))[-3:]
    wanted = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [math.sqrt(0.5), 0.0, math.sqrt(0.5)]])
    np.testing.assert_allclose(axes.directions(last, np.ones(3)), wanted, atol=1e-12)


@dataclass(frozen=True)
class _Beside:
    """A face beside, cut away beyond v = 0.5."""

    surface: Surface
    number: int = 2

    def trimmed_away(self, u: Array, v: Array) -> np.ndarray:
        """Returns which places are cut away."""
        return np.asarray(v > 0.5)


def test_a_face_beside_is_cut_where_the_ball_touches_what_is_there_of_it_and_it_runs_on() -> None:
    """A ball of 5 mm touches a floor of 20 × 10 mm within 50 µm; neither beside it, nor where it is cut away, nor
    around an edge, from a face whose normal is more than 37° away; one with its normal inwards is as good.
    """
    centres = np.array([[5, 4, 5.0], [5, 4, 5.04], [5, 4, 5.06], [30, 4, 5], [5, 6, 5], [5, 4, 5], [5, 4, 5]], float)
    normal = np.array([[0, 0, 1.0]] * 5 + [[0, 0.8, 0.6], [0, 0.5, 0.75**0.5]])
    floor = _patch((0, 0, 0), (20, 0, 0), (0, 10, 0))
    for face in (floor, floor.turned_over()):
        cut = _cuts(_Beside(face), centres, normal, SurfaceJob(Cutter(5.0, 5.0)))
        assert cut[[0, 1, 2, 3, 5, 6]].tolist() == [True, True, False, False, False, True]
    assert not _cuts(_Beside(floor), centres, normal, SurfaceJob(Cutter(5.0, 5.0)))[4]


@pytest.mark.parametrize(("as_wide", "told"), [(1.4, True), (1.6, False), (0.35, True), (0.25, False)])
def test_points_in_inch_are_told_where_they_are_about_as_wide_as_the_face(as_wide: float, told: bool) -> None:
    """Widths from 0.3 to 1.5 of the face's; all lie in its plane."""
    x, y = (a.ravel() for a in np.meshgrid(*[np.linspace(0.0, 20.0 * as_wide, 5)] * 2))
    points = np.column_stack([x, y, 0 * x]) / 25.4
    if told:
        with pytest.raises(TrueloopError, match=r"multiplied by 25\.4 they fit"):
            refuse_unit(FLAT, points, np.full(25, 5.0), 0.0, "P1")
    else:
        refuse_unit(FLAT, points, np.full(25, 5.0), 0.0, "P1")


def test_a_scan_all_of_which_is_far_off_but_not_farther_is_kept() -> None:
    """0.6 mm high of 1 mm that is allowed, and nothing beyond: not cut off there, as it would be in another frame."""
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(1, 19, 9), np.linspace(1, 19, 9)))
    scan = MeasuredPoints(np.column_stack([x, y, np.full(81, 0.6)]))
    assert len(on_face(FLAT, scan, np.tile([0.0, 0.0, 1.0], (81, 1)), 1.0).points_mm) == 81


@pytest.mark.parametrize(("degree", "count", "repeated"), [(3, 1, 2), (3, 2, 3), (2, 1, 3), (5, 1, 1), (5, 2, 1)])
def test_a_cubic_refit_is_at_a_knot_as_smooth_as_the_normal(degree: int, count: int, repeated: int) -> None:
    """A knot counted m times in degree p leaves p − m derivatives, the normal one less: 3 − (p − m − 1) times, from
    once to three times.
    """
    knots = np.concatenate([np.zeros(degree + 1), np.full(count, 0.5), np.ones(degree + 1)])
    refit = shift._lines(knots, degree, 8)
    assert np.count_nonzero(refit.knots == 0.5) == repeated
    assert np.count_nonzero(refit.knots == 0.25) == 1
