"""Touches that lie close: what they have in common widens the band by what it should, and no correction changes.

Held against least squares written out in numpy, and against drawn cuts whose correlation is of another shape than any
that the fit chooses from.
"""

import numpy as np
import pytest

from tests.support.profiles import polyline
from tests.support.touched import noise, touched
from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.error_curve.curve import joined
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.touches.error_vectors import ErrorVectors

SIGMA_MM = 0.002
LINE = checked_profile(polyline([(20.0, -12.0), (20.0, 0.0)]))
STEPS = checked_profile(polyline([(30.0, -9.0), (30.0, 0.0), (21.0, 0.0), (21.0, 9.0), (12.0, 9.0), (12.0, 18.0)]))
TOUCHES = [6] * 5
"""A touch every 1.5 mm on five lines of 9 mm."""


def at_touches(model: ProfileErrorModel) -> tuple[Array, Array]:
    """Curve and half width of the band of the next cut at the touches."""
    along, rows = model.vectors.arc_length_mm, [model.vectors.of_feature(i) for i in range(len(model.curves))]
    curves = list(zip(model.curves, rows, strict=True))
    budget = joined([curve.budget(along[row]) for curve, row in curves])
    return np.concatenate([curve.value_mm(along[row]) for curve, row in curves]), budget.expanded_u_mm


def test_the_curve_is_as_uncertain_as_least_squares_through_such_touches() -> None:
    """Of a line: the process's variance by generalized least squares over ν, and V = A K Aᵀ with A = (XᵀX)⁻¹Xᵀ."""
    vectors, length = touched(LINE, [8], noise(SIGMA_MM)), 1.3
    s = vectors.arc_length_mm
    alike = np.exp(-0.5 * (np.subtract.outer(s, s) / length) ** 2)
    model = fit_profile(LINE, vectors, FitOptions(alike_over_mm=length))
    x = np.column_stack([np.ones_like(s), s])
    a = np.linalg.solve(x.T @ x, x.T)
    inverse = np.linalg.inv(alike)
    generalized = np.linalg.solve(x.T @ inverse @ x, x.T @ inverse) @ vectors.error_mm
    left = vectors.error_mm - x @ generalized
    process_mm2 = float(left @ inverse @ left) / (len(s) - 2)
    assert model.curves[0].repeatability_mm == pytest.approx(process_mm2**0.5, rel=1e-3)
    expected = np.sqrt(np.diag(x @ a @ (process_mm2 * alike) @ a.T @ x.T))
    np.testing.assert_allclose(model.curves[0].standard_deviation_mm(s), expected, rtol=1e-3)


def test_touches_far_apart_have_nothing_in_common() -> None:
    """8 mm: the same numbers, whether they are asked or it is stated. So with one touch a feature."""
    wide = checked_profile(polyline([(40.0, -40.0), (40.0, 0.0), (8.0, 0.0), (8.0, 32.0)]))
    for counts in ([4] * 3, [1] * 3):
        vectors = touched(wide, counts, noise(SIGMA_MM))
        asked, stated = (fit_profile(wide, vectors, FitOptions(alike_over_mm=mm)) for mm in (None, 0.0))
        for a, b in zip(asked.curves, stated.curves, strict=True):
            np.testing.assert_array_equal(a.standard_deviation_mm([0.0, 3.0]), b.standard_deviation_mm([0.0, 3.0]))
            assert a.repeatability_mm == b.repeatability_mm
        assert asked.correlation.shape == (0, 0)


def test_only_touches_that_lie_close_have_a_correlation() -> None:
    """Those of the middle one of three lines: the matrix of a long scan does not fill memory."""
    wide = checked_profile(polyline([(40.0, -40.0), (40.0, 0.0), (8.0, 0.0), (8.0, 32.0)]))
    model = fit_profile(wide, touched(wide, [3, 30, 3], noise(SIGMA_MM)), FitOptions(alike_over_mm=1.0))
    assert model.correlated is not None and model.correlation.shape == (30, 30)
    np.testing.assert_array_equal(model.vectors.feature_index[model.correlated], 1)


def test_no_correction_changes() -> None:
    vectors = touched(STEPS, TOUCHES, noise(SIGMA_MM))
    curves = [at_touches(fit_profile(STEPS, vectors, FitOptions(alike_over_mm=mm))) for mm in (None, 0.0, 1.0)]
    np.testing.assert_array_equal(curves[0][0], curves[1][0])
    np.testing.assert_array_equal(curves[2][0], curves[1][0])
    assert not np.allclose(curves[0][1], curves[1][1])


def cut(profile: Profile, over_mm: float, rng: np.random.Generator) -> Array:
    """Scatter at the touches of one cut: exp(−d/ℓ) along each line, a rough process that no candidate describes."""
    s = np.array([feature.length_mm for feature in profile.features])[0] * (np.arange(6) + 0.5) / 6
    root = np.linalg.cholesky(np.exp(-np.abs(np.subtract.outer(s, s)) / over_mm))
    return np.concatenate([SIGMA_MM * root @ rng.standard_normal(6) for _ in profile.features])


def held(options: FitOptions, over_mm: float, parts: int = 300) -> float:
    """Share of next cuts inside their band; the part has no error but its scatter."""
    rng, inside = np.random.default_rng(17), []
    plan = touched(STEPS, TOUCHES, lambda points, _: np.zeros(len(points)))
    for _ in range(parts):
        errors: ErrorVectors = type(plan)(**{**plan.__dict__, "error_mm": cut(STEPS, over_mm, rng)})
        curve_mm, half_width_mm = at_touches(fit_profile(STEPS, errors, options))
        inside.append(np.mean(np.abs(cut(STEPS, over_mm, rng) - curve_mm) <= half_width_mm))
    return float(np.mean(inside))


@pytest.mark.parametrize("over_mm", [0.3, 0.6, 1.0])
def test_bands_hold_what_they_promise_of_touches_that_lie_close(over_mm: float) -> None:
    assert 0.93 < held(FitOptions(), over_mm) < 0.97


def test_taken_for_independent_they_would_not() -> None:
    assert held(FitOptions(alike_over_mm=0.0), 1.5) < 0.91
