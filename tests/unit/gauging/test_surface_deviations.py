"""Deviations along the normals: sign, ball, alignment, holes, advice."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.support.surfaces import sphere, wavy_surface
from trueloop.errors import Code
from trueloop.gauging.surface_deviations import MeasuredPoints, surface_deviations
from trueloop.gauging.surface_sampling import sampling_advice
from trueloop.geometry.feature import Array
from trueloop.geometry.surface_fit import fit_grid

RNG = np.random.default_rng(11)
SURFACE = wavy_surface()
AT = np.linspace(0.02, 0.98, 25)
U, V = (a.ravel() for a in np.meshgrid(AT, AT, indexing="ij"))
NOMINAL, NORMAL = SURFACE.point_mm(U, V), SURFACE.normal(U, V)
ERROR = RNG.normal(0, 0.006, 625)


def centres(radius_mm: float) -> Array:
    return NOMINAL + (radius_mm + ERROR)[:, None] * NORMAL


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
    assert fitted.alignment.free == 0
    # Errors are read at slightly other feet where a point also moved sideways: second order in motion times slope.
    np.testing.assert_allclose(fitted.error_mm, bare.error_mm, atol=1e-9)
    bound = surface_deviations(SURFACE, MeasuredPoints(moved, 2.0))
    assert np.std(bound.error_mm) > 3 * np.std(fitted.error_mm)


def test_what_the_surface_does_not_determine_stays_where_it_was() -> None:
    ball = sphere()
    u, v = RNG.uniform(0.05, 0.95, (2, 300))
    fitted = surface_deviations(ball, MeasuredPoints(1.0002 * ball.point_mm(u, v)), fit=True)
    assert fitted.alignment.free == 3  # a sphere turns in itself
    assert np.all(np.abs(fitted.alignment.shift_mm) < 0.02)


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
