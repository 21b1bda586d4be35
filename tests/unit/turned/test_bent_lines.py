"""A line whose touches show a bow is corrected by a curve; a straight one stays straight."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtrit

from tests.support.profiles import polyline
from tests.support.touched import touched
from trueloop.arrays import Array
from trueloop.geometry.validate import checked_profile
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.options import FitOptions

UM = 1e-3
LENGTH = 100.0
BAR = checked_profile(polyline([(20.0, -LENGTH), (20.0, 0.0), (0.0, 0.0)], ["cylinder", "face"]))
ALONG = np.linspace(0.0, LENGTH, 41)

BOWS = {
    "beam between centres": lambda s: 4.0 * s * (LENGTH - s) / LENGTH**2,
    "sine": lambda s: np.sin(np.pi * s / LENGTH),
    "held at one end": lambda s: (LENGTH - s) ** 2 * (2.0 * LENGTH + s) / (2.0 * LENGTH**3),
}
"""Shapes of 1 at their largest: a cut between centres, a hot bed, a bar that yields at its free end."""


def bowed(shape: str, size_um: float, touches: int, seed: int, noise_um: float = 0.7) -> ProfileErrorModel:
    rng = np.random.default_rng(seed)

    def error(points: Array, normals: Array) -> Array:
        return np.asarray((10.0 + size_um * BOWS[shape](points[:, 1] + LENGTH)) * UM)

    true = touched(BAR, [touches, 0], error, 0.4 * UM)
    scattered = replace(true, error_mm=true.error_mm + rng.normal(0.0, noise_um * UM, touches))
    return fit_profile(BAR, scattered)


@pytest.mark.parametrize("shape", BOWS)
@pytest.mark.parametrize("size_um", [15.0, 30.0, -30.0])
@pytest.mark.parametrize("touches", [6, 11])
def test_a_bow_is_followed(shape: str, size_um: float, touches: int) -> None:
    """Touches that scatter by 0.7 µm about a bow of 15 or 30 µm: at most 2 µm RMS are left, and no touch is bad."""
    left, suspects, scatter = [], 0, []
    for seed in range(20):
        model = bowed(shape, size_um, touches, seed)
        off_um = 10.0 + size_um * BOWS[shape](ALONG) - model.curves[0].value_mm(ALONG) / UM
        left.append(math.sqrt(float(np.mean(off_um**2))))
        suspects += len(model.suspects)
        scatter.append(model.scatter_mm / UM)
    assert np.median(left) < 2.0 and np.sort(left)[-2] < 2.5
    assert np.median(scatter) < 2.0, "what is left counts as scatter"
    assert suspects == 0


def test_the_band_holds_what_is_left_of_a_bow() -> None:
    inside = []
    for seed in range(40):
        curve = bowed("beam between centres", 20.0, 8, seed).curves[0]
        off = 10.0 + 20.0 * BOWS["beam between centres"](ALONG) - curve.value_mm(ALONG) / UM
        assert curve.degrees_of_freedom is not None
        k = float(stdtrit(curve.degrees_of_freedom, 0.975))
        inside.append(np.abs(off) <= k * curve.standard_deviation_mm(ALONG) / UM)
    assert 0.92 <= np.mean(inside) <= 0.99


@pytest.mark.parametrize("touches", [5, 8, 20, 40])
def test_a_straight_error_stays_straight(touches: int) -> None:
    """A taper, and touches that scatter by 1 µm: at most 2 in 100 pass for bent by chance, more than 4 of 60 never."""
    rng, bent = np.random.default_rng(touches), 0
    for _ in range(60):
        true = touched(BAR, [touches, 0], lambda points, normals: 0.01 - 1e-4 * points[:, 1], 0.4 * UM)
        model = fit_profile(BAR, replace(true, error_mm=true.error_mm + rng.normal(0.0, UM, touches)))
        bent += model.curves[0].spline.degree > 1
    assert bent <= 4


@pytest.mark.parametrize("options", [FitOptions(knot_every=3), FitOptions(TangentPolicy.PATH, 3)])
def test_the_published_fit_keeps_lines_straight(options: FitOptions) -> None:
    vectors = touched(BAR, [11, 0], lambda points, normals: 0.03 * np.sin(np.pi * points[:, 1] / -LENGTH), 0.4 * UM)
    assert fit_profile(BAR, vectors, options).curves[0].spline.degree == 1


def test_touches_on_the_middle_of_a_line_do_not_show_how_it_bends_at_its_ends() -> None:
    vectors = touched(BAR, [11, 0], lambda points, normals: 0.03 * np.sin(np.pi * points[:, 1] / -LENGTH), 0.4 * UM)
    middle = replace(vectors, arc_length_mm=20.0 + 0.6 * vectors.arc_length_mm)
    assert fit_profile(BAR, middle).curves[0].spline.degree == 1


@pytest.mark.parametrize("size_um", [0.0, 15.0, 30.0])
def test_a_gross_touch_on_a_bowed_line_is_named_alone(size_um: float) -> None:
    """One of eleven is off by 40 µm: it is left out, or nothing is; no other touch ever."""
    rng, right = np.random.default_rng(3), 0
    for _ in range(20):
        true = touched(BAR, [11, 0], lambda p, n: size_um * UM * np.sin(np.pi * p[:, 1] / -LENGTH), 0.4 * UM)
        errors, bad = true.error_mm + rng.normal(0.0, 0.7 * UM, 11), int(rng.integers(11))
        errors[bad] += rng.choice([-0.04, 0.04])
        left_out = {one.position for one in fit_profile(BAR, replace(true, error_mm=errors)).suspects if one.left_out}
        assert left_out <= {bad}
        right += left_out == {bad}
    assert right >= 18
