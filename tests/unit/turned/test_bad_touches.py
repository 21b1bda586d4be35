"""A bad touch is found, left out and named; clean touches keep their weight; what cannot be decided is called so."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from studies.bad_touch_study import KEEP, DrawnPart, draw, families, spoiled, suspected, worst_um
from tests.support.profiles import facetst
from tests.support.touched import noise, touched
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.error_curve.uncertainty import finish
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.fit_chains import Known, fit_chains, fit_touched
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.fit.prior.part_state import part_state
from trueloop.turned.touches.error_vectors import ErrorVectors

FAMILIES = families()
LARGE, OFTEN = FAMILIES["MODBAS2"], FAMILIES["49"]


def clean(seed: int = 5) -> DrawnPart:
    return draw(OFTEN, np.random.default_rng(seed))


def with_error(touches: ErrorVectors, position: int, error_mm: float) -> ErrorVectors:
    errors = touches.error_mm.copy()
    errors[position] = error_mm
    return replace(touches, error_mm=errors)


def on(counts: list[int], errors_um: dict[int, float]) -> ProfileErrorModel:
    """FACETST with a scatter of 1 µm about 20 µm, and some touches at other errors."""
    vectors = touched(facetst(), counts, noise(0.001), 0.0004)
    vectors = replace(vectors, error_mm=vectors.error_mm + 0.020)
    for position, error_um in errors_um.items():
        vectors = with_error(vectors, position, error_um / 1000)
    return fit_profile(facetst(), vectors)


def test_a_bad_touch_of_49_is_left_out_and_named() -> None:
    """60 µm for 28.9 on a cylinder."""
    part = clean()
    position = 19
    assert OFTEN.profile.names[part.touches.feature_index[position]] == "cylinder"
    level = 0.0289 - part.true_mm[position]
    touches = replace(part.touches, error_mm=part.touches.error_mm + level)
    model = fit_profile(OFTEN.profile, with_error(touches, position, 0.060))
    (suspect,) = model.suspects
    assert (suspect.position, suspect.point, suspect.feature) == (position, "p19", "cylinder")
    assert suspect.probability > 0.999 and suspect.left_out
    assert suspect.expected_mm == pytest.approx(0.0289, abs=0.002)
    assert "touch p19 on cylinder: +60.0 µm" in suspect.words and "weight 0" in suspect.words
    np.testing.assert_array_equal(np.flatnonzero(model.weight == 0.0), [position])
    assert model.residual_mm[position] == pytest.approx(0.060 - suspect.expected_mm, abs=1e-4)
    assert worst_um(OFTEN.profile, model.vectors, part.true_mm + level, FitOptions()) < 4.0
    assert worst_um(OFTEN.profile, model.vectors, part.true_mm + level, KEEP) > 6.0


def test_clean_touches_have_weight_one_and_the_very_same_curves() -> None:
    part = clean().touches
    found, kept = fit_profile(OFTEN.profile, part), fit_profile(OFTEN.profile, part, KEEP)
    assert not found.suspects and np.all(found.weight == 1.0)
    for a, b in zip(found.curves, kept.curves, strict=True):
        np.testing.assert_array_equal(a.spline.coefficients_mm, b.spline.coefficients_mm)
        np.testing.assert_array_equal(a.spline.covariance_band_mm2, b.spline.covariance_band_mm2)


@pytest.mark.parametrize("name", FAMILIES)
def test_clean_parts_are_hardly_ever_suspected(name: str) -> None:
    """Of 2,400 parts fewer than 1 in 100 (`studies/bad_touch_study.py`); here a few of each family."""
    assert suspected(FAMILIES[name], 40, np.random.default_rng(7))[0] <= 1


@pytest.mark.parametrize(("size_mm", "how_many"), [(0.020, 1), (0.030, 1), (0.040, 1), (0.030, 2)])
def test_bad_touches_hardly_move_the_correction(size_mm: float, how_many: int) -> None:
    rng, right, before, after = np.random.default_rng(11), 0, [], []
    for _ in range(12):
        part = draw(OFTEN, rng)
        touches, bad = spoiled(part, size_mm, how_many, rng)
        suspects = fit_profile(OFTEN.profile, touches).suspects
        right += {one.position for one in suspects if one.left_out} == bad
        before.append(worst_um(OFTEN.profile, touches, part.true_mm, KEEP))
        after.append(worst_um(OFTEN.profile, touches, part.true_mm, FitOptions()))
    assert right >= 9
    assert np.median(after) < 3.0 < np.median(before)


def test_one_of_three_touches_on_a_line_cannot_be_decided() -> None:
    """Each of the three explains the others' disagreement as well: all are named, none is left out."""
    model = on([4, 4, 4, 3], {13: 60.0})
    assert {one.position for one in model.suspects} == {12, 13, 14}
    assert not any(one.left_out for one in model.suspects) and np.all(model.weight == 1.0)
    assert sum(one.probability for one in model.suspects) == pytest.approx(1.0, abs=0.01)
    assert all(one.probability < 0.95 and "cannot be decided" in one.words for one in model.suspects)


def test_one_of_four_touches_on_a_line_is_decided() -> None:
    (suspect,) = on([4, 4, 4, 3], {6: 40.0}).suspects
    assert suspect.position == 6 and suspect.left_out


def test_a_tapered_line_of_two_touches_is_no_bad_touch() -> None:
    """Two touches that differ by 25 µm may well be a taper; the note says that a bad touch would look the same."""
    model = on([4, 4, 4, 2], {12: 8.0, 13: 33.0})
    assert not model.suspects
    assert any("a bad one would look like a taper" in note for note in model.notes)


def test_a_lone_touch_far_from_its_contact_angle_elsewhere_is_named_and_kept() -> None:
    """140 µm on the end face, where the other face was cut by the same stretch of the nose at 20 µm."""
    (suspect,) = on([4, 4, 4, 1], {12: 140.0}).suspects
    assert suspect.position == 12 and not suspect.left_out and suspect.probability > 0.9


def test_a_bad_z_reference_is_named_as_such() -> None:
    vectors = touched(facetst(), [4, 4, 4, 4], noise(0.001), 0.0004)
    reference = np.arange(16) == 13
    shifted = vectors.error_mm - np.where(vectors.outward_normal[:, 1] > 0.5, 0.03, 0.0)
    bad = replace(vectors, error_mm=np.where(reference, 0.0, shifted), at_reference=reference)
    (suspect,) = fit_profile(facetst(), bad).suspects
    assert suspect.position == 13 and "z was taken from it" in suspect.words


def test_few_touches_about_nothing_are_not_judged() -> None:
    """Without a touch to spare there is no scatter to judge by."""
    assert not on([1, 1, 0, 0], {1: 80.0}).suspects


@pytest.mark.parametrize("policy", TangentPolicy)
@pytest.mark.parametrize("name", FAMILIES)
def test_chains_fitted_once_serve_as_those_fitted_anew_to_every_choice_of_touches(
    name: str, policy: TangentPolicy
) -> None:
    rng, profile, options = np.random.default_rng(3), FAMILIES[name].profile, FitOptions(policy)
    known: Known = {}
    touches = draw(FAMILIES[name], rng).touches
    for _ in range(12):
        some = touches.chosen(np.flatnonzero(rng.random(len(touches.point)) < rng.choice([0.2, 0.9])))
        state = partial(part_state, profile, some, fitted=False)
        whole = finish(fit_chains(profile, some, options, None, state)[0], some)
        found = finish(fit_touched(profile, some, options, None, known)[0], some)
        assert sorted(found.fits) == [i for i, fit in whole.fits.items() if len(fit.touches)]
        assert found.degrees_of_freedom == whole.degrees_of_freedom
        for i, fit in found.fits.items():
            np.testing.assert_array_equal(fit.touches, whole.fits[i].touches)
            np.testing.assert_array_equal(fit.leave_one_out_mm, whole.fits[i].leave_one_out_mm)
            np.testing.assert_array_equal(found.splines[i].coefficients_mm, whole.splines[i].coefficients_mm)
            np.testing.assert_array_equal(found.splines[i].covariance_band_mm2, whole.splines[i].covariance_band_mm2)
            assert found.scatter_mm[i] == whole.scatter_mm[i]
