"""No polynomial piece without a touch; beyond the last touch the curve is straight, and less certain the farther."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.support.touched import noise, touched
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.chain_fit import every_rth
from trueloop.turned.fit.options import FitOptions

RADIUS_MM = 2.0


def edge() -> Profile:
    """A cylinder of 20 mm radius whose edge to the face is rounded with 2 mm: an arc of 3.1 mm between corners."""
    cylinder = Line("cylinder", (20.0, 0.0), (20.0, 30.0))
    arc = Arc("edge", (20.0, 30.0), (18.0, 32.0), (18.0, 30.0), math.pi / 2)
    return checked_profile([cylinder, arc, Line("face", (18.0, 32.0), (5.0, 32.0))])


PROFILE = edge()
EDGE = 1


def edge_curve(seed: int, knot_every: int, last_mm: float) -> ErrorCurve:
    """1 µm of scatter about nothing; the last of eight touches on the edge lies `last_mm` before its end."""
    vectors = touched(PROFILE, [0, 8, 0], noise(0.001, seed))
    along = np.linspace(0.3, PROFILE.features[EDGE].length_mm - last_mm, 8)
    return fit_profile(PROFILE, replace(vectors, arc_length_mm=along), FitOptions(knot_every=knot_every)).curves[EDGE]


@pytest.mark.parametrize("r", [2, 3, 4, 5, 8])
def test_every_knot_has_touches_on_both_sides(r: int) -> None:
    points = np.linspace(1.0, 8.0, 8)
    for knot in every_rth(points, (0.0,), 9.0, r):
        assert np.any(points < knot) and np.any(points > knot)
    assert set(every_rth(points, (0.0,), 9.0, r)) == {float(p) for p in points[r - 1 :: r] if p < 8.0}


def test_a_micrometre_of_scatter_bends_no_steep_end() -> None:
    """With a knot on the eighth touch, a cubic piece ran 0.3 mm on without a touch: tens of µm/mm."""
    slopes = [float(edge_curve(seed, 4, 0.3).slope(PROFILE.features[EDGE].length_mm)[0]) for seed in range(40)]
    assert np.max(np.abs(slopes)) < 0.015
    assert np.sqrt(np.mean(np.square(slopes))) < 0.006


def test_beyond_the_last_touch_it_goes_on_along_the_tangent() -> None:
    curve = edge_curve(1, 4, 0.6)
    end = curve.length_mm
    s = np.array([end - 0.6, end - 0.3, end])
    slope = curve.slope(s)
    np.testing.assert_allclose(slope, slope[0], rtol=1e-9)
    np.testing.assert_allclose(np.diff(curve.value_mm(s)), 0.3 * slope[0], rtol=1e-6, atol=1e-12)
    begins, coefficients = curve.pieces
    np.testing.assert_allclose(coefficients[begins >= end - 0.6 - 1e-9][:, 2:], 0.0, atol=1e-9)


def test_its_uncertainty_grows_with_the_distance() -> None:
    curve = edge_curve(1, 4, 0.6)
    u = curve.standard_deviation_mm(curve.length_mm - np.array([0.6, 0.4, 0.2, 0.0]))
    assert np.all(np.diff(u) > 0.0) and u[-1] > 1.5 * u[0]


def test_the_uncertainty_beyond_the_touches_holds_what_a_bend_does() -> None:
    """A true error of a nose over the edge, touched up to 0.5 mm before its end: the band at the end holds it."""
    inside = []
    for seed in range(60):
        vectors = touched(PROFILE, [3, 10, 3], lambda p, n: 0.02 * n[:, 0] ** 2 + 0.01 * n[:, 1])
        length = PROFILE.features[EDGE].length_mm
        along = np.concatenate([[5.0, 15.0, 25.0], np.linspace(0.5, length - 0.5, 10), [3.0, 6.0, 9.0]])
        normal = np.array(
            [PROFILE.features[i].outward_normal(s) for i, s in zip(vectors.feature_index, along, strict=True)]
        )
        true = 0.02 * normal[:, 0] ** 2 + 0.01 * normal[:, 1]
        scatter = 0.001 * np.random.default_rng(seed).standard_normal(len(true))
        model = fit_profile(
            PROFILE, replace(vectors, arc_length_mm=along, outward_normal=normal, error_mm=true + scatter)
        )
        curve = model.curves[EDGE]
        end_normal = PROFILE.features[EDGE].outward_normal(length)
        expected = 0.02 * end_normal[0] ** 2 + 0.01 * end_normal[1]
        inside.append(abs(curve.value_mm(length)[0] - expected) <= curve.half_band_mm(length)[0])
    assert np.mean(inside) > 0.85
