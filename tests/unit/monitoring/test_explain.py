"""What explains an alarm: probabilities beside direct integration, and on series whose cause is known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate

from trueloop.arrays import Array
from trueloop.monitoring.segments import SIZE, Explanation, correlation, explained

RNG = np.random.default_rng(6876)


def step(first: int, count: int) -> Array:
    return (np.arange(count) >= first).astype(float)


def integrated(z: Array, shape: Array, power: int = 0) -> float:
    """The marginal likelihood of a shape against that of nothing, times a power of its size, by quadrature.

    Normal densities are written out: those of scipy take forty times as long for one value.
    """
    squares = float(z @ z)

    def density(size: float) -> float:
        left = z - size * shape
        exponent = (squares - left @ left - (size / SIZE) ** 2) / 2
        return float(size**power * math.exp(exponent) / (SIZE * math.sqrt(2 * math.pi)))

    return float(integrate.quad(density, -40.0, 40.0, points=[0.0], limit=400)[0])


@given(st.integers(0, 5), st.floats(-2.0, 2.0))
def test_probabilities_are_those_of_integrated_likelihoods(first: int, size: float) -> None:
    z = np.array([0.3, -0.4, 1.1, 0.2, -1.0, 0.7]) + size * step(first, 6)
    ramp = np.arange(6) / 5.0
    found = explained(z, [Explanation("ramp", "wear", ramp), Explanation("step", "set", step(3, 6))])
    weights = [integrated(z, ramp), integrated(z, step(3, 6))]
    unknown = float(np.mean([integrated(z, step(k, 6)) for k in range(6)]))
    total = sum(weights) + unknown + 1.0
    by_kind = {one.kind: one.probability for one in found.likely}
    assert by_kind == pytest.approx({"ramp": weights[0] / total, "step": weights[1] / total}, rel=1e-6)
    assert (found.unknown, found.chance) == pytest.approx((unknown / total, 1.0 / total), rel=1e-6)
    for one, shape in zip(sorted(found.likely, key=lambda one: one.kind), (ramp, step(3, 6)), strict=True):
        mean, square = (integrated(z, shape, power) / integrated(z, shape) for power in (1, 2))
        assert (one.size, one.size_u) == pytest.approx((mean, math.sqrt(square - mean**2)), rel=1e-6, abs=1e-6)


def test_a_setting_is_named_where_the_step_begins_with_it_and_not_elsewhere() -> None:
    z = RNG.normal(size=30) + 4.0 * step(20, 30)
    found = explained(z, [Explanation("early", "", step(8, 30)), Explanation("right", "", step(20, 30))])
    assert (found.likely[0].kind, found.since) == ("right", 20)
    assert found.likely[0].probability > 0.9 and found.likely[1].probability < 0.01
    assert abs(found.likely[0].size - 4.0) < 3.0 * found.likely[0].size_u
    assert found.likely[0].size_u == pytest.approx(1.0 / np.sqrt(10.0), rel=0.01)


def test_wear_is_told_from_a_step_and_a_fall_has_a_negative_size() -> None:
    ramp = np.linspace(0.0, 1.0, 30)
    known = [Explanation("wear", "", ramp), Explanation("set", "", step(15, 30))]
    assert explained(RNG.normal(size=30) - 6.0 * ramp, known).likely[0].kind == "wear"
    assert explained(RNG.normal(size=30) - 6.0 * ramp, known).likely[0].size < -4.0
    assert explained(RNG.normal(size=30) - 6.0 * step(15, 30), known).likely[0].kind == "set"


def test_a_step_that_nobody_knows_of_is_not_laid_on_what_happened_elsewhere() -> None:
    z = RNG.normal(size=30) + 5.0 * step(25, 30)
    found = explained(z, [Explanation("set", "", step(5, 30))])
    assert found.unknown > 0.95 and found.since == 25


def test_nothing_is_likeliest_where_nothing_moved() -> None:
    found = explained(0.3 * RNG.normal(size=30), [Explanation("set", "", step(10, 30))])
    assert found.chance > 0.6


def test_what_did_not_act_yet_explains_nothing() -> None:
    found = explained(np.array([0.0, 0.0, 4.0]), [Explanation("later", "", np.zeros(3))])
    assert found.likely[0].probability == 0.0


@pytest.mark.parametrize(("phi", "width"), [(0.0, 1.0), (0.6, np.sqrt(0.4)), (-0.5, np.sqrt(1.5))])
def test_moving_ranges_of_correlated_values_are_as_much_too_narrow_as_said(phi: float, width: float) -> None:
    z = np.empty(40_000)
    z[0] = 0.0
    for k in range(1, len(z)):
        z[k] = phi * z[k - 1] + np.sqrt(1.0 - phi**2) * RNG.normal()
    found = correlation(z)
    assert found.lag_1 == pytest.approx(phi, abs=0.02) and found.width == pytest.approx(width, abs=0.02)
    assert np.abs(np.diff(z)).mean() * np.sqrt(np.pi) / 2.0 == pytest.approx(found.width, rel=0.02)


def test_the_correlation_of_neighbours_by_hand() -> None:
    """About their mean 1, 2, 3 are −1, 0, 1: neighbours' products are 0, without the bias 1/3. Equal values: none."""
    found = correlation(np.array([1.0, 2.0, 3.0]))
    assert (found.lag_1, found.limit) == pytest.approx((1.0 / 3.0, 1.96 / np.sqrt(3.0)), rel=1e-4)
    assert correlation(np.array([5.0, 5.0, 5.0])).lag_1 == 0.0


def test_independent_values_are_called_alike_as_often_as_said() -> None:
    said = [correlation(RNG.normal(size=20)).significant for _ in range(2000)]
    assert 0.02 < np.mean(said) < 0.06


def test_the_evidence_of_one_value_by_hand() -> None:
    """3 σ off, a step of 0 ± 5 σ: 26^(−1/2) exp(9 · 25 / 52) = 14.848 times what chance has, which weighs as much."""
    found = explained(np.array([3.0]), [])
    assert found.unknown == pytest.approx(14.848 / 15.848, abs=1e-5)
