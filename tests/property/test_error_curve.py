"""What must hold for error curves on every profile and every set of touches."""

from dataclasses import replace

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.support.profiles import polyline, profiles
from tests.support.touched import noise, tool_offsets, touched
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.geometry.validate import checked_profile
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.fit.chain_fit import TangentPolicy, chains_of
from trueloop.turned.fit.options import BadTouches, FitOptions
from trueloop.turned.fit.spline import least_squares_spline
from trueloop.turned.touches.error_vectors import ErrorVectors

POLICIES = st.sampled_from(TangentPolicy)


@st.composite
def cases(draw: st.DrawFn) -> tuple[Profile, ErrorVectors]:
    """A profile, touched unevenly, errors of hundredths of a millimetre."""
    profile = draw(profiles())
    counts = draw(st.lists(st.integers(0, 9), min_size=len(profile.features), max_size=len(profile.features)))
    assume(sum(counts) > 0)
    return profile, touched(profile, counts, noise(0.02, draw(st.integers(0, 1000))), 0.0004)


@given(cases(), POLICIES)
def test_curves_join_where_features_do(case: tuple[Profile, ErrorVectors], policy: TangentPolicy) -> None:
    """Tangent junctions: equal values within a picometre (and slopes, under PATH). Corners: one meeting point."""
    profile, vectors = case
    model = fit_profile(profile, vectors, FitOptions(junctions=policy))
    for i, junction in enumerate(profile.junctions):
        before, after = model.curves[i], model.curves[i + 1]
        if junction.kind == JunctionKind.TANGENT:
            assert abs(before.value_mm(before.length_mm)[0] - after.value_mm(0.0)[0]) < 1e-12
        displaced = model.junctions[i + 1]
        flat = "too flat" in displaced.note
        assert flat or displaced.gap_mm < 1e-12
        assert all(np.isfinite([*displaced.displacement_mm, *displaced.standard_u_mm, displaced.gap_mm]))


@given(cases())
def test_uncertainties_are_numbers_and_never_zero(case: tuple[Profile, ErrorVectors]) -> None:
    profile, vectors = case
    model = fit_profile(profile, vectors)
    for curve in model.curves:
        s = np.linspace(-0.1, curve.length_mm + 0.1, 9)
        u = curve.standard_deviation_mm(s)
        assert np.all(np.isfinite(curve.value_mm(s)))
        assert np.all(u > 0.0)
        assert np.all(curve.half_band_mm(s) > u)
        assert np.all(curve.budget(s).standard_u_mm > u)


@given(cases(), POLICIES)
def test_twice_the_errors_give_twice_the_curves(case: tuple[Profile, ErrorVectors], policy: TangentPolicy) -> None:
    """Doubling is exact in binary, so that no choice on the way may turn out differently.

    Features that no touch reaches are known by priors of a size, which is not doubled.
    """
    profile, vectors = case
    options = FitOptions(junctions=policy, bad_touches=BadTouches.KEEP)  # what is bad is a matter of micrometres
    once = fit_profile(profile, vectors, options)
    twice = fit_profile(profile, replace(vectors, error_mm=2.0 * vectors.error_mm), options)
    reached = [i for c in chains_of(profile) if np.any(np.isin(vectors.feature_index, c.features)) for i in c.features]
    for a, b in ((once.curves[i], twice.curves[i]) for i in reached):
        s = np.linspace(0.0, a.length_mm, 7)
        np.testing.assert_allclose(b.value_mm(s), 2.0 * a.value_mm(s), atol=1e-12)


@given(cases(), st.data())
def test_a_touch_left_out_is_predicted_as_the_formula_says(
    case: tuple[Profile, ErrorVectors], data: st.DataObject
) -> None:
    """Residual / (1 − leverage) against a second fit without the touch, on a single arc or line with given knots.

    All touches are kept: a fit that leaves another one out is the fit of other touches.
    """
    profile, _ = case
    feature = replace(profile.features[0], name="only")
    alone = checked_profile([feature])
    vectors = touched(alone, [12], noise(0.02, data.draw(st.integers(0, 1000))))
    options = FitOptions(knot_every=5, bad_touches=BadTouches.KEEP)
    model = fit_profile(alone, vectors, options)
    k = data.draw(st.integers(0, 11))
    kept = np.arange(12) != k
    spline = model.curves[0].spline
    again = least_squares_spline(
        vectors.arc_length_mm[kept], vectors.error_mm[kept], spline.interior_knots_mm, spline.length_mm, spline.degree
    ).spline
    # The formula predicts an outermost touch by the polynomial, which the curve leaves at its last touch.
    polynomial = replace(again, supported_mm=None)
    predicted = polynomial.of(polynomial.value_form(vectors.arc_length_mm[k]))[0]
    np.testing.assert_allclose(model.leave_one_out_mm[k], vectors.error_mm[k] - predicted, atol=1e-11)


@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.lists(st.integers(2, 5), min_size=3, max_size=3))
def test_a_tool_offset_displaces_every_corner_by_itself(dx_mm: float, dz_mm: float, counts: list[int]) -> None:
    """On lines the errors n · (dX, dZ) are constant, and displaced corners meet in the corner plus (dX, dZ)."""
    profile = checked_profile(polyline([(40.0, -60.0), (40.0, -30.0), (25.0, -20.0), (10.0, 0.0)]))
    model = fit_profile(profile, touched(profile, counts, tool_offsets(dx_mm, dz_mm)))
    for junction in model.junctions[1:-1]:
        np.testing.assert_allclose(junction.displacement_mm, (dx_mm, dz_mm), atol=1e-10)
    np.testing.assert_allclose(model.residual_mm, 0.0, atol=1e-12)


def _curve_values(model: ProfileErrorModel) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Values and slopes of all curves, and the kinks at tangent junctions, in one row."""
    parts = []
    for curve in model.curves:
        s = np.linspace(0.0, curve.length_mm, 4)
        parts += [curve.value_mm(s), curve.slope(s)]
    return np.concatenate([*parts, [one.kink for one in model.tangency]])


@settings(max_examples=30)
@given(cases(), POLICIES)
def test_uncertainty_is_the_touches_scatter_carried_through(
    case: tuple[Profile, ErrorVectors], policy: TangentPolicy
) -> None:
    """With knots given the fit is linear in the touches: its variance is σ² times the squared responses, summed.

    Every feature is touched, so that all uncertainty comes from the touches; lines hand theirs on to arcs. Touches have
    nothing in common (`tests/unit/turned/test_likeness.py` has those that do).
    """
    profile, _ = case
    counts = [9] * len(profile.features)
    vectors = touched(profile, counts, noise(0.02))
    kept = BadTouches.KEEP  # else it is not linear
    options = FitOptions(junctions=policy, knot_every=4, bad_touches=kept, alike_over_mm=0.0)
    model = fit_profile(profile, vectors, options)
    at_rest = _curve_values(model)
    unit = np.eye(len(vectors.error_mm))
    moved = [fit_profile(profile, replace(vectors, error_mm=vectors.error_mm + e), options) for e in unit]
    response = np.array([_curve_values(one) - at_rest for one in moved])
    expected = model.scatter_mm * np.sqrt(np.sum(response**2, axis=0))
    parts = []
    among: list[np.ndarray[tuple[int], np.dtype[np.bool_]]] = []
    for i, curve in enumerate(model.curves):
        s = np.linspace(0.0, curve.length_mm, 4)
        low, high = curve.start_mm, min(curve.start_mm + curve.length_mm, curve.spline.length_mm)
        parts += [
            curve.standard_deviation_mm(s),
            np.sqrt(curve.spline.variance(curve.spline.slope_form(s + curve.start_mm, low, high))),
        ]
        touches = vectors.arc_length_mm[vectors.of_feature(i)]
        among += [(touches[0] <= s) & (s <= touches[-1])] * 2
    kinks = [one.standard_u_rad for one in model.tangency]
    computed = np.concatenate([*parts, kinks])
    inside = np.concatenate([*among, np.ones(len(kinks), dtype=bool)])
    if policy == TangentPolicy.PATH:
        # The kinks come from the slope-free fit, whose scatter is another one.
        computed, expected, inside = (row[: len(row) - len(kinks)] for row in (computed, expected, inside))
    # beyond the outermost touches of a curve an uncertainty of going on straight comes on top
    assert np.all(computed >= expected * (1.0 - 1e-6) - 1e-12)
    computed, expected = computed[inside], expected[inside]
    np.testing.assert_allclose(computed, expected, rtol=1e-6, atol=1e-12)
