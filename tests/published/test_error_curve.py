"""Error curves on the measured parts of [6517] Table 1 and [6811] Tables 8–11."""

import numpy as np
import pytest

from tests.support.nist_errors import finish_um, nist_parts, semifinish, table1
from trueloop.arrays import Array
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.spline import EndConditions, least_squares_spline
from trueloop.units import UM_PER_MM

DOME = slice(12, 32)
"""Points 13 to 32 of Table 1 lie on the dome."""

PATH_R3 = FitOptions(junctions=TangentPolicy.PATH, knot_every=3)
PART_R3 = FitOptions(junctions=TangentPolicy.PART, knot_every=3)


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def residual_um(model: ProfileErrorModel) -> Array:
    return model.residual_mm * UM_PER_MM


def test_the_published_fit_leaves_what_the_published_cut_showed() -> None:
    """[6517] Table 1, knots at every third point of the dome's own [Eq. 5], the cylinder's value, zero slope."""
    profile, vectors, finish = table1()
    left = residual_um(fit_profile(profile, vectors, PATH_R3))[DOME]
    np.testing.assert_allclose(left[:6], [9.0, 3.5, -0.3, -3.9, -1.0, 0.9], atol=0.05)
    assert rms(left) == pytest.approx(2.65, abs=0.005)
    assert np.corrcoef(left, finish[DOME])[0, 1] == pytest.approx(0.820, abs=0.005)


def test_the_residual_of_the_published_fit_shows_on_every_finished_part() -> None:
    """[6811] Tables 8 and 9: each part's own semi-finish errors predict its finish errors on the dome."""
    for part in nist_parts("MODBAS2"):
        left = residual_um(fit_profile(part.profile, semifinish(part), PATH_R3))[DOME]
        assert np.corrcoef(left, finish_um(part)[DOME])[0, 1] >= 0.55, part.number


def test_with_the_slope_free_the_fit_leaves_half() -> None:
    """The kink at the junction is real: 6 µm a mm, more than five times its standard uncertainty."""
    profile, vectors, _ = table1()
    free, tangent = fit_profile(profile, vectors, PART_R3), fit_profile(profile, vectors, PATH_R3)
    assert rms(residual_um(free)[DOME]) == pytest.approx(1.17, abs=0.005)
    (kink,) = tangent.tangency
    assert 1e3 * kink.predicted_rad == pytest.approx(6.44, abs=0.01)
    assert kink.predicted_rad > 5 * kink.standard_u_rad
    assert [(one.predicted_rad, one.kink) for one in free.tangency] == [(0.0, kink.kink)]


def test_r_chosen_by_leave_one_out_predicts_unseen_touches() -> None:
    """Table 1: 1.65 µm for touches left out, where r = 3 gives 21 µm: its last knot leaves two touches to the axis."""
    profile, vectors, _ = table1()
    dome = len(profile.features) - 1
    chosen, published = fit_profile(profile, vectors), fit_profile(profile, vectors, PART_R3)
    assert chosen.residual_rms_mm[dome] * UM_PER_MM <= 1.3
    assert chosen.leave_one_out_rms_mm[dome] * UM_PER_MM == pytest.approx(1.65, abs=0.01)
    assert published.leave_one_out_rms_mm[dome] * UM_PER_MM == pytest.approx(21.2, abs=0.1)


@pytest.mark.parametrize("policy", list(TangentPolicy))
def test_dome_and_neck_join_as_the_policy_says(policy: TangentPolicy) -> None:
    """MODBAS2: value within a picometre under both; slope within a microradian under PATH."""
    profile, vectors, _ = table1()
    model = fit_profile(profile, vectors, FitOptions(junctions=policy))
    neck, dome = model.curves[-2:]
    assert abs(neck.value_mm(neck.length_mm)[0] - dome.value_mm(0.0)[0]) < 1e-12
    mismatch = abs(neck.slope(neck.length_mm)[0] - dome.slope(0.0)[0])
    assert mismatch < 1e-6 if policy == TangentPolicy.PATH else mismatch > 1e-3


def test_piecs11_closes_its_corner_with_the_slope_free() -> None:
    """[6811 §5.3]: cone and knob meet at an angle; the displaced curves meet in one point."""
    for part in nist_parts("PIECS11"):
        model = fit_profile(part.profile, semifinish(part))
        junction = model.junctions[-2]
        displacement = np.array(junction.displacement_mm)
        cone, knob = part.profile.features[-2:]
        normals = np.stack([cone.outward_normal(cone.length_mm), knob.outward_normal(0.0)])
        errors = [junction.error_before_mm, junction.error_after_mm]
        np.testing.assert_allclose(normals @ displacement, np.array(errors, dtype=float), atol=1e-12)
        assert junction.gap_mm < 1e-12
        assert model.tangency == ()


def test_facetst_is_fitted_by_lines_whose_tapers_show() -> None:
    """[6811 §5.1, Table 4]: tapers of 12 µm on cylinders and 25 µm on faces, cut on purpose, opposite in sign."""
    for part in nist_parts("FACETST"):
        model = fit_profile(part.profile, semifinish(part))
        tapers = [float(c.slope(0.0)[0]) * c.length_mm * UM_PER_MM for c in model.curves]
        assert all(curve.spline.degree == 1 for curve in model.curves)
        assert tapers[0] * tapers[2] < 0.0, part.number
        assert max(model.residual_rms_mm) * UM_PER_MM < 2.6


def test_a_polynomial_of_order_12_swings_and_the_spline_does_not() -> None:
    """The lesson of [6517] Figures 1 and 2, on Table 1: order 12 through thirteen points of the dome.

    The polynomial passes through its points and misses what lies between them near an end by tens of micrometres. A
    clamped spline through the same points stays within a few.
    """
    _, vectors, _ = table1()
    s, y = vectors.arc_length_mm[DOME], vectors.error_mm[DOME] * UM_PER_MM
    length = float(s[-1] + s[0])
    chosen = np.unique(np.round(np.linspace(0, 19, 13)).astype(int))
    others = np.setdiff1d(np.arange(20), chosen)
    polynomial = np.polynomial.Polynomial.fit(s[chosen], y[chosen], 12)
    slopes = EndConditions(start_slope=4.0, end_slope=-12.0)
    spline = least_squares_spline(s[chosen], y[chosen], s[chosen][1:-1], length, 3, slopes).spline
    assert np.max(np.abs(polynomial(s[chosen]) - y[chosen])) < 1e-6
    assert np.max(np.abs(spline.of(spline.value_form(s[chosen])) - y[chosen])) < 1e-6
    swing = np.max(np.abs(polynomial(s[others]) - y[others]))
    stays = np.max(np.abs(spline.of(spline.value_form(s[others])) - y[others]))
    assert swing > 5 * stays


def test_other_readings_of_every_rth_point_do_not_give_the_published_residuals() -> None:
    """[6517 Eq. 5] read otherwise: counting the junction as a point, or beginning at the first point."""
    profile, vectors, _ = table1()
    s, y = vectors.arc_length_mm[DOME], vectors.error_mm[DOME]
    length = profile.features[-1].length_mm
    ends = EndConditions(start_value_mm=float(vectors.error_mm[11]), start_slope=0.0)
    published = np.array([9.0, 3.5, -0.3, -3.9, -1.0, 0.9])

    def left(first: int) -> Array:
        knots = s[first::3]
        return least_squares_spline(s, y, knots[knots < s[-1]], length, 3, ends).residual_mm[:6] * UM_PER_MM

    assert np.max(np.abs(left(2) - published)) < 0.05
    assert min(float(np.max(np.abs(left(first) - published))) for first in (0, 1, 3)) > 1.0


def test_bands_of_untouched_features_hold_on_metal() -> None:
    """Every second part, one feature after the other left out: 23.8 µm RMS by the nose's form and a spread alone."""
    off, u = list[Array](), list[Array]()
    for part in (one for family in ("MODBAS2", "PIECS11") for one in nist_parts(family)[::2]):
        vectors = semifinish(part)
        for feature in np.unique(vectors.feature_index).tolist():
            left_out = (vectors.feature_index == feature) & ~vectors.at_reference
            curve = fit_profile(part.profile, vectors.chosen(np.flatnonzero(~left_out))).curves[feature]
            s = vectors.arc_length_mm[left_out]
            off.append(UM_PER_MM * (vectors.error_mm[left_out] - curve.value_mm(s)))
            u.append(UM_PER_MM * curve.standard_deviation_mm(s))
    inside = np.abs(np.concatenate(off)) <= 1.96 * np.hypot(np.concatenate(u), 1.0)
    assert 0.9 <= np.mean(inside) <= 0.99
    assert rms(np.concatenate(off)) < 20.0
