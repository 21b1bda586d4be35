"""Errors of a forward model of its own: a bow, shafts; what is left, and whether it is within its band.

The model's functions (parabola, powers, cosines of the contact angle) are none of the catalogue's.
"""

import numpy as np
import pytest

from tests.support.cut_places import CYLINDER, places, touches
from tests.support.shaft_truth import Shaft
from trueloop.estimate.catalogue import turned_catalogue
from trueloop.estimate.places import Places
from trueloop.estimate.sizes import fitted_sizes
from trueloop.estimate.state import State
from trueloop.statistics import rms

CATALOGUE = turned_catalogue()
SHAFTS = 10


@pytest.mark.parametrize("bow_um", [15.0, 30.0])
@pytest.mark.parametrize("count", [6, 11])
def test_a_bowed_cylinder_is_corrected_by_its_form(bow_um: float, count: int) -> None:
    """Ø40 × 100, error 10 + bow·(1 − u²) µm, repeatability 0.7 µm."""

    def at(share: np.ndarray, finish: bool) -> Places:
        return places(CYLINDER, 100 * share - 50, share, finish=finish)

    def truth(share: np.ndarray) -> np.ndarray:
        return np.asarray(10 + bow_um * (1 - (2 * share - 1) ** 2))

    along, touched = np.linspace(0, 1, 41), np.linspace(0.02, 0.98, count)
    for seed in range(5):
        read = truth(touched) + np.random.default_rng(seed).normal(0, 0.7, count)
        seen = touches(at(touched, False), read, 0.3)
        updated = State.before(CATALOGUE, fitted_sizes(CATALOGUE, [seen])).given(seen)
        expected = updated.state.predict(at(along, True))
        left = truth(along) - 1e3 * expected.mean_mm
        assert rms(left) < 2.0
        assert np.all(np.abs(left) < 1.96e3 * expected.standard_u_mm)
        assert np.max(updated.gross) < 0.5


def test_shafts_by_touches_and_by_six_diameters() -> None:
    """43 touches, or one at each of six diameters: RMS of what the finish cut, measured by 1.2 µm, is left with."""
    left: dict[str, list[np.ndarray]] = {"touches": [], "diameters": []}
    for seed in range(SHAFTS):
        shaft = Shaft.drawn(seed)
        for name, rows in (("touches", np.arange(len(shaft.semifinish_um))), ("diameters", shaft.diameters)):
            seen = touches(shaft.places(False).chosen(rows), shaft.semifinish_um[rows], 0.3)
            state = State.before(CATALOGUE, fitted_sizes(CATALOGUE, [seen])).given(seen).state
            expected = state.predict(shaft.places(True))
            left[name].append(shaft.finish_um - 1e3 * expected.mean_mm)
            assert np.mean(np.abs(left[name][-1]) < 1.96e3 * expected.standard_u_mm) > 0.9
    assert rms(np.concatenate(left["touches"])) < 2.5
    assert rms(np.concatenate(left["diameters"])) < 8.0
    uncorrected = [Shaft.drawn(seed).finish_um for seed in range(SHAFTS)]
    assert rms(np.concatenate(uncorrected)) > 10.0
