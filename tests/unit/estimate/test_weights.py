"""Gross touches, and features that are off as a whole."""

import numpy as np
import pytest

from tests.support.cut_places import CYLINDER, FACE, places, touches
from trueloop.estimate.catalogue import turned_catalogue
from trueloop.estimate.places import joined
from trueloop.estimate.state import State
from trueloop.estimate.weights import Heavy, more_noise, weighted

CATALOGUE = turned_catalogue()
ANGLES = np.linspace(FACE, CYLINDER, 20)


def smooth(rng: np.random.Generator) -> np.ndarray:
    return np.asarray(12 * np.sin(ANGLES) + 4 * np.cos(2 * ANGLES) + rng.normal(0, 1, len(ANGLES)))


@pytest.mark.parametrize("error_um", [40.0, -25.0])
def test_a_gross_touch_is_named_and_hardly_moves_the_curve(error_um: float) -> None:
    clean = smooth(np.random.default_rng(5))
    bad = clean + error_um * (np.arange(20) == 7)
    expected = [State.before(CATALOGUE).given(touches(places(ANGLES), v, 0.5)) for v in (clean, bad)]
    assert np.flatnonzero(expected[1].gross > 0.5).tolist() == [7]
    assert expected[1].gross[7] > 0.99
    assert expected[1].left_out_mm[7] == pytest.approx(1e-3 * error_um, abs=0.005)
    means = [one.state.predict(places(ANGLES, finish=True)).mean_mm for one in expected]
    assert np.max(np.abs(means[1] - means[0])) < 0.002
    assert not np.any(expected[0].gross > 0.1)


def test_two_percent_gross_touches_cost_less_than_five_percent() -> None:
    rng = np.random.default_rng(6)
    left = {False: 0.0, True: 0.0}
    for _ in range(40):
        truth = 12 * rng.normal() * np.sin(ANGLES) + 4 * rng.normal() * np.cos(2 * ANGLES + rng.uniform(0, 6))
        read = truth + rng.normal(0, 1.2, 20)
        gross = (rng.random(20) < 0.02) * rng.choice([-1, 1], 20) * rng.uniform(15, 60, 20)
        for with_gross in left:
            state = State.before(CATALOGUE).given(touches(places(ANGLES), read + with_gross * gross, 0.5)).state
            left[with_gross] += float(np.sum((1e3 * state.predict(places(ANGLES)).mean_mm - truth) ** 2))
    assert np.sqrt(left[True] / left[False]) < 1.05


def test_a_feature_of_one_part_that_is_tilted_has_no_gross_touches() -> None:
    share = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
    cylinder, face = places(CYLINDER, 40 * share, share, 0), places(FACE, 50, share, 1)
    error = np.r_[10 + 0 * share, 10 + 60 * (share - 0.5)] + np.random.default_rng(7).normal(0, 0.7, 10)
    updated = State.before(CATALOGUE).given(touches(joined([cylinder, face]), error, 0.5))
    assert np.max(updated.gross) < 0.5
    mean = updated.state.predict(places(FACE, 50, [0.1, 0.9], 1)).mean_mm
    assert mean[1] - mean[0] == pytest.approx(0.048, abs=0.005)


@pytest.mark.parametrize("off_um", [(0, 40, 30, 0, 60, 10), (0, 60, 60, 0, 60, 60)])
def test_weights_and_scales_that_do_not_come_to_rest_are_those_of_the_factor(off_um: tuple[int, ...]) -> None:
    """Two features of three touches, 2 µm for each, 8 µm for both, noise 1 µm. With scales of a round later than the
    factor's more variance is taken away than there is, and the next part ends in a matrix that is not positive.
    """
    noise, level = np.full(6, 1e-6), np.repeat(np.eye(2), 3, axis=0)
    covariance = np.diag(noise) + 64e-6 + 4e-6 * level @ level.T
    heavy = [Heavy(level[:, [k]], np.array([4e-6]), 3.0) for k in (0, 1)]
    found = weighted(covariance, noise, 1e-3 * np.array(off_um), CATALOGUE, heavy)
    of_features = level @ np.diag(4e-6 * (found.scales - 1.0)) @ level.T
    expected = covariance + np.diag(more_noise(noise, found.gross, CATALOGUE)) + of_features
    np.testing.assert_allclose(found.factor @ found.factor.T, expected, rtol=1e-9)
