"""Deviations along the normals: sign, ball, alignment, holes, advice."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.surfaces import random_surface, sphere, wavy_surface
from trueloop.arrays import Array
from trueloop.errors import Code, Severity, TrueloopError
from trueloop.geometry.surface import Feet, Surface, fit_grid
from trueloop.surface.deviations.alignment import Faces
from trueloop.surface.deviations.deviations import fit_of_faces, inside_trim, sampling_advice, surface_deviations
from trueloop.surface.deviations.points import MeasuredPoints, _ball, on_face

RNG = np.random.default_rng(11)
SURFACE = wavy_surface()
AT = np.linspace(0.02, 0.98, 25)
U, V = (a.ravel() for a in np.meshgrid(AT, AT, indexing="ij"))
NOMINAL, NORMAL = SURFACE.point_mm(U, V), SURFACE.normal(U, V)
ERROR = RNG.normal(0, 0.006, 625)


def centres(radius_mm: float) -> Array:
    return NOMINAL + (radius_mm + ERROR)[:, None] * NORMAL


def test_of_points_chosen_from_a_scan_those_that_the_fit_takes_off_the_face_are_left_out() -> None:
    """Stated points there are refused."""
    points = MeasuredPoints(centres(0.0), name="A")
    found = surface_deviations(SURFACE, points, fit=True)
    kept = inside_trim(replace(points, numbers=np.arange(len(U)) + 1), found, lambda u, v: u > 0.8)
    np.testing.assert_array_equal(kept.measured, found.measured & (found.u <= 0.8))
    with pytest.raises(TrueloopError) as caught:
        inside_trim(points, found, lambda u, v: u > 0.8)
    assert caught.value.code is Code.SRF_OUTSIDE


def _plane(*corners: tuple[float, float, float]) -> Surface:
    """A level patch through three corners: the first, and where u and v lead."""
    first, along, across = (np.array(corner) for corner in corners)
    u, v = (at[..., None] for at in np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), indexing="ij"))
    return fit_grid(first + u * (along - first) + v * (across - first)).surface


@pytest.mark.parametrize("radius_mm", [0.0, 2.0])
def test_three_faces_of_a_block_that_sits_off_are_brought_back_together_with_the_ball_s_radius_off(
    radius_mm: float,
) -> None:
    """Ball centres on top and two sides of a block that is 0.03, −0.05 and 0.02 mm off and turned by up to half a
    milliradian: any face alone leaves three motions open, all together none.
    """
    block = [
        _plane((0, 0, 30), (50, 0, 30), (0, 40, 30)),
        _plane((50, 0, 0), (50, 40, 0), (50, 0, 30)),
        _plane((0, 0, 0), (50, 0, 0), (0, 0, 30)),
    ]
    rng, shift = np.random.default_rng(3), np.array([0.03, -0.05, 0.02])
    turn = Rotation.from_rotvec([3e-4, -5e-4, 2e-4])
    parts = []
    for face, out in zip(block, ([0, 0, 1], [1, 0, 0], [0, -1, 0]), strict=True):
        u, v = rng.uniform(0.05, 0.95, (2, 150))
        np.testing.assert_allclose(face.normal(u, v), np.tile(np.array(out, float), (150, 1)), atol=1e-9)
        at = face.point_mm(u, v) + (radius_mm + rng.normal(0.0, 1e-4, 150))[:, None] * np.array(out)
        parts.append(MeasuredPoints(turn.apply(at) + shift, radius_mm, name="A"))
    alignment = fit_of_faces(block, parts)
    assert not alignment.left
    np.testing.assert_allclose(
        alignment.apply(np.array([[25.0, 20.0, 15.0]]) @ turn.as_matrix().T + shift), [[25, 20, 15]], atol=1e-4
    )
    for face, part in zip(block, parts, strict=True):
        found = surface_deviations(face, part, fit=alignment)
        assert np.max(np.abs(found.error_mm)) < 6e-4


def test_form_over_several_faces_is_wide_where_their_points_spread_most() -> None:
    """Points within 50, 10 and 0.1 mm of their middle along three axes askew: the coordinates along the first two."""
    axes = Rotation.from_rotvec([0.4, -0.7, 0.2]).as_matrix()
    size = np.array([50.0, 10.0, 0.1]) * np.random.default_rng(4).uniform(-1, 1, (400, 3))
    size -= np.mean(size, axis=0)
    spans = np.linalg.qr(size)[0] * np.array([50.0, 10.0, 0.1])
    place, zero = 3.0 + spans @ axes.T, np.zeros(400)
    feet = Feet(u=zero, v=zero, point_mm=place, normal=place, distance_mm=zero, beyond_mm=zero)
    first, second = Faces((SURFACE, SURFACE), np.zeros(400, int)).wide(feet)
    np.testing.assert_allclose(np.abs(first), np.abs(spans[:, 0]), atol=1e-6)
    np.testing.assert_allclose(np.abs(second), np.abs(spans[:, 1]), atol=1e-6)


def test_points_of_a_scan_go_by_their_numbers_in_it() -> None:
    """Five points above the face come first: two more, 8 µm apart in one place, are the eighth and ninth."""
    points = centres(0.0)
    points[3] = points[2] + 0.008 * NORMAL[2]
    scan = MeasuredPoints(np.concatenate([points[:5] + 50.0 * NORMAL[:5], points]), name="A")
    found = surface_deviations(SURFACE, on_face(SURFACE, scan, None, 1.0), fit=False)
    (twice,) = [one for one in found.findings if one.code is Code.SRF_DUPLICATE]
    assert twice.values["points"] == [8, 9] and "(points 8 and 9)" in twice.message


@pytest.mark.parametrize("radius_mm", [0.0, 1.0, 2.0])
def test_ball_centres_give_the_same_errors_as_points_of_the_surface(radius_mm: float) -> None:
    found = surface_deviations(SURFACE, MeasuredPoints(centres(radius_mm), radius_mm, (25, 25), "A"))
    np.testing.assert_allclose(found.error_mm, ERROR, atol=1e-12)
    assert found.alignment.kind == "datum"
    assert not found.findings


def test_material_left_on_is_positive_and_turning_the_surface_over_turns_the_sign() -> None:
    above = MeasuredPoints(NOMINAL + 0.01 * NORMAL)
    np.testing.assert_allclose(surface_deviations(SURFACE, above).error_mm, 0.01, atol=1e-12)
    np.testing.assert_allclose(surface_deviations(SURFACE.turned_over(), above).error_mm, -0.01, atol=1e-12)


def test_a_best_fit_takes_out_location_and_orientation_and_nothing_else() -> None:
    bare = surface_deviations(SURFACE, MeasuredPoints(centres(2.0), 2.0), fit=True)
    moved = centres(2.0) @ Rotation.from_rotvec([0.001, -0.002, 0.0015]).as_matrix().T + [0.03, -0.02, 0.05]
    fitted = surface_deviations(SURFACE, MeasuredPoints(moved, 2.0), fit=True)
    assert fitted.alignment.kind == "best fit"
    assert fitted.alignment.left == ()
    # Errors are read at slightly other feet where a point also moved sideways: second order in motion times slope.
    np.testing.assert_allclose(fitted.error_mm, bare.error_mm, atol=1e-9)
    bound = surface_deviations(SURFACE, MeasuredPoints(moved, 2.0))
    assert np.std(bound.error_mm) > 3 * np.std(fitted.error_mm)


def test_a_chip_on_a_few_points_does_not_move_the_best_fit() -> None:
    """0.3 mm on four points beside each other: the fit is that of the other 621."""
    moved = centres(2.0) @ Rotation.from_rotvec([0.001, -0.002, 0.0015]).as_matrix().T + [0.03, -0.02, 0.05]
    chip = [52, 53, 77, 78]
    chipped, without = moved.copy(), moved.copy()
    chipped[chip] += 0.3 * NORMAL[chip]
    without[chip] = np.nan
    found = surface_deviations(SURFACE, MeasuredPoints(chipped, 2.0, (25, 25), "A"), fit=True)
    judge = surface_deviations(SURFACE, MeasuredPoints(without, 2.0, (25, 25), "A"), fit=True)
    others = np.setdiff1d(np.arange(625), chip)
    np.testing.assert_allclose(found.error_mm[others], judge.error_mm[others], atol=1e-8)
    np.testing.assert_allclose(found.error_mm[chip], 0.3 + ERROR[chip], atol=0.01)
    (finding,) = (one for one in found.findings if one.code is Code.SRF_OFF)
    assert finding.severity is Severity.WARNING and "4 of 625 points of 'A' deviate far more" in finding.message
    wide = moved.copy()
    wide[:100] += 0.3 * NORMAL[:100]  # a sixth of the part is form
    assert not any(
        one.code is Code.SRF_OFF for one in surface_deviations(SURFACE, MeasuredPoints(wide, 2.0), fit=True).findings
    )


def test_what_the_surface_does_not_determine_stays_where_it_was() -> None:
    ball = sphere()
    u, v = RNG.uniform(0.05, 0.95, (2, 300))
    fitted = surface_deviations(ball, MeasuredPoints(1.0002 * ball.point_mm(u, v)), fit=True)
    assert len(fitted.alignment.left) == 3  # a sphere turns in itself
    assert all(motion.endswith("(not determined by the points)") for motion in fitted.alignment.left)
    assert np.all(np.abs(fitted.alignment.shift_mm) < 0.02)


def nearly_flat(sag_mm: float) -> Surface:
    """A square patch of 50 mm that bows by so much from the middle to the edges, and a little to one side."""
    x, y = np.meshgrid(np.linspace(-25, 25, 21), np.linspace(-25, 25, 21), indexing="ij")
    return fit_grid(np.stack([x, y, sag_mm * (np.cos(x / 25) * np.cos(y / 30) + (x / 50) ** 3)], axis=2)).surface


def of_form(surface: Surface, form_mm: Array) -> Array:
    """Points of the grid off by a form; misplaced if moved afterwards."""
    return surface.point_mm(U, V) + form_mm[:, None] * surface.normal(U, V)


def least_squares_without(form_mm: Array, shapes: list[Array]) -> Array:
    """What is left when so many columns are taken out, by another routine."""
    columns = np.stack(shapes, axis=1)
    left: Array = form_mm - columns @ np.linalg.lstsq(columns, form_mm, rcond=None)[0]
    return left


@pytest.mark.parametrize("sag_mm", [0.1, 0.3, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_a_pattern_on_a_nearly_flat_patch_stays(sag_mm: float, seed: int) -> None:
    """A pattern of 4 µm, no misalignment: only height and the two tilts, which every patch has, may take of it. A fit
    of all six motions slides the part by up to millimetres and leaves less.
    """
    surface = nearly_flat(sag_mm)
    pattern = random_surface(np.random.default_rng(seed), 6, 1.0).value_mm(U, V)
    form = 0.004 * pattern / np.std(pattern)
    height = least_squares_without(form, [np.ones(625), U, V])
    fitted = surface_deviations(surface, MeasuredPoints(of_form(surface, form), name="A"), fit=True)
    assert np.sqrt(np.mean((fitted.error_mm - height) ** 2)) < 0.02 * np.std(height)
    assert len(fitted.alignment.left) == 3
    assert np.max(np.abs(fitted.alignment.shift_mm[:2])) < 1e-3
    note = fitted.findings[-1]
    assert (note.code, note.severity) == (Code.SRF_SETUP, Severity.NOTE)
    assert "'A' leaves 3 of 6 motions" in note.message


def test_a_better_known_set_up_leaves_more_and_a_worse_one_less() -> None:
    surface = nearly_flat(1.0)
    pattern = of_form(surface, random_surface(np.random.default_rng(1), 6, 0.012).value_mm(U, V))
    left = [
        len(surface_deviations(surface, MeasuredPoints(pattern), fit=True, setup_mm=setup).alignment.left)
        for setup in (1e-4, 0.2, 20.0)
    ]
    assert left == [6, 3, 0]


def test_a_misplaced_part_on_a_curved_patch_comes_back_under_its_pattern() -> None:
    """A tenth of a millimetre and milliradians: what remains is the pattern as without them."""
    pattern = random_surface(np.random.default_rng(2), 6, 0.004).value_mm(U, V)
    form = of_form(SURFACE, pattern)
    moved = (form - [25, 25, 0]) @ Rotation.from_rotvec([0.002, -0.001, 0.003]).as_matrix().T + [25.1, 24.9, 0.08]
    fitted, bare = (surface_deviations(SURFACE, MeasuredPoints(p), fit=True) for p in (moved, form))
    assert fitted.alignment.left == bare.alignment.left == ()
    np.testing.assert_allclose(fitted.error_mm, bare.error_mm, atol=1e-8)
    assert np.max(np.abs(surface_deviations(SURFACE, MeasuredPoints(moved)).error_mm - pattern)) > 0.05


def test_a_part_farther_off_than_its_set_up_can_be_is_refused() -> None:
    sunk = MeasuredPoints(of_form(SURFACE, ERROR) - [0.0, 0.0, 0.3], name="S07")
    with pytest.raises(TrueloopError, match=r"points of 'S07' by 0\.300 mm along z.*off by 0\.2 mm") as refused:
        surface_deviations(SURFACE, sunk, fit=True)
    assert refused.value.code is Code.SRF_SETUP
    allowed = surface_deviations(SURFACE, sunk, fit=True, setup_mm=0.4)
    assert allowed.alignment.shift_mm[2] == pytest.approx(0.3, abs=1e-3)


def test_holes_stay_holes_and_are_told() -> None:
    points = centres(2.0)
    points[[3, 77]] = np.nan
    found = surface_deviations(SURFACE, MeasuredPoints(points, 2.0, (25, 25), "A"))
    assert np.flatnonzero(~found.measured).tolist() == [3, 77]
    assert [finding.code for finding in found.findings] == [Code.SRF_HOLES]
    np.testing.assert_allclose(found.error_mm[found.measured], np.delete(ERROR, [3, 77]), atol=1e-12)


def test_advice_takes_the_ball_s_radius_as_step() -> None:
    advice = sampling_advice(SURFACE, 2.0)
    assert advice.step_mm == 2.0
    assert advice.shortest_wave_mm == 4.0
    assert 26 <= advice.rows <= 29  # 50 mm and a little more along the waves
    assert advice.reaches_everywhere
    assert not sampling_advice(SURFACE, 80.0).reaches_everywhere
    inside = sphere(20.0).turned_over()
    hollow = sampling_advice(inside, 1.0)
    assert hollow.hollow_radius_mm == pytest.approx(20.0, rel=1e-6)


def test_a_ball_too_large_for_a_hollow_is_told() -> None:
    """A valley with radius 1 / (0.4 · 1.5²) = 1.11 mm at its ground."""
    x, y = np.meshgrid(np.linspace(0, 12, 49), np.linspace(0, 12, 25), indexing="ij")
    valleys = fit_grid(np.stack([x, y, -0.4 * np.sin(1.5 * x)], axis=2)).surface
    u, v = RNG.uniform(0.05, 0.95, (2, 200))
    for radius, told in ((0.9, []), (1.4, [Code.SRF_BALL])):
        touched = valleys.point_mm(u, v) + radius * valleys.normal(u, v)
        found = surface_deviations(valleys, MeasuredPoints(touched, radius))
        assert [finding.code for finding in found.findings] == told


def test_the_share_of_the_area_that_a_ball_cannot_reach_is_that_of_lines_between_its_edges() -> None:
    """z = −x³/600 is hollow with 1/κ = −100/x (1 + (x²/200)²)^1.5 mm: a ball of 50 mm fits from x = −2 mm on. Of 40
    lines 0.1 mm apart, the first 0.1 mm inside the edge x = −4.05 mm, 20 are before.
    """
    low, high = -4.05, 0.05
    control = np.empty((4, 2, 3))
    control[:, :, 0] = np.linspace(low, high, 4)[:, None]
    control[:, :, 1] = [0.0, 10.0]
    control[:, :, 2] = -np.array([low**3, low**2 * high, low * high**2, high**3])[:, None] / 600  # of Bézier
    ends = np.repeat([0.0, 1.0], 4)
    bent = Surface((3, 1), ends, ends[2:-2], control, np.ones((4, 2)))
    at, none = np.array([0.0, 1.0]), np.zeros(2)
    feet = Feet(u=at, v=at, point_mm=np.zeros((2, 3)), normal=np.zeros((2, 3)), distance_mm=none, beyond_mm=none)
    radius_mm = 100 / 3.95 * (1 + (3.95**2 / 200) ** 2) ** 1.5
    (found,) = _ball(bent, feet, 50.0)
    assert f"on 50% of the area: the surface is concave with radius {radius_mm:.3f} mm at x -3.950" in found.message


@pytest.mark.parametrize(
    ("stated_mm", "hint"), [(2.0, "a ball of radius 1.500 mm"), (0.0, "give ball_radius_mm"), (1.5, "")]
)
def test_a_ball_of_another_radius_is_reported_with_the_one_that_fits(stated_mm: float, hint: str) -> None:
    """Centres of a ball of 1.5 mm: their distance from the surface is its radius, and the error is what is left."""
    at = np.linspace(0.1, 0.9, 9)
    u, v = (grid.ravel() for grid in np.meshgrid(at, at))
    centres = SURFACE.point_mm(u, v) + 1.5 * SURFACE.normal(u, v)
    found = surface_deviations(SURFACE, MeasuredPoints(centres, stated_mm, name="A"), farthest_mm=2.0)
    assert found.error_mm == pytest.approx(1.5 - stated_mm, abs=1e-9)
    hints = [one.hint for one in found.findings if one.code is Code.SRF_SIGN]
    assert (hint in hints[0]) if hint else hints == []
