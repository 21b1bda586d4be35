"""Deterministic and random parts, on patterns that are known."""

import math

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import f

from tests.support.surfaces import NEAR, SQUARE, on_grid, random_surface, square_places
from trueloop.errors import Severity, TrueloopError
from trueloop.surface.separation.moran import lilliefors_p, normality
from trueloop.surface.separation.separate import FORM, log_likelihood, of_size, scattering_part, separate
from trueloop.surface.separation.spline_surface import Places, Size, basis, projector, regress, splines

CRITERIA = ("likelihood", "randomness")
NOISE_MM = 0.0022
"""A random part within ±6.5 µm, as published, is about three times this."""


@pytest.mark.parametrize(("criterion", "true"), [("randomness", 9), ("likelihood", 9), ("likelihood", 15)])
def test_the_size_of_a_known_pattern_is_found_to_one_step_in_nine_runs_of_ten(criterion: str, true: int) -> None:
    """With control values of 8 µm standard deviation: at 15 × 15 the published tests find it in two of three runs."""
    rng, runs, near = np.random.default_rng(9), 40, 0
    for _ in range(runs):
        errors = on_grid(random_surface(rng, true, 0.008)) + rng.normal(0, NOISE_MM, 625)
        size = separate(SQUARE, errors, near=NEAR, criterion=criterion).chosen.size
        near += abs(size.rows - true) <= 1 and abs(size.columns - true) <= 1
    assert near >= 0.9 * runs


def test_the_parts_add_up_and_the_random_part_has_its_scatter() -> None:
    rng = np.random.default_rng(2)
    truth = random_surface(rng, 8, 0.010)
    errors = on_grid(truth) + rng.normal(0, NOISE_MM, 625)
    found = separate(SQUARE, errors, near=NEAR)
    np.testing.assert_allclose(on_grid(found.deterministic) + found.random_mm, errors, atol=1e-13)
    assert found.sigma_mm == pytest.approx(NOISE_MM, rel=0.1)
    assert np.sqrt(np.mean((on_grid(found.deterministic) - on_grid(truth)) ** 2)) < 0.6 * NOISE_MM
    assert found.chosen.random(0.99)
    assert found.chosen.normal(0.99)
    assert found.permutation_p > 0.01
    assert not found.findings


@pytest.mark.parametrize("criterion", CRITERIA)
def test_noise_alone_takes_the_smallest_surface(criterion: str) -> None:
    errors = np.random.default_rng(3).normal(0, NOISE_MM, 625)
    assert separate(SQUARE, errors, near=NEAR, criterion=criterion).chosen.size.controls <= 16


@pytest.mark.parametrize("criterion", CRITERIA)
def test_a_long_narrow_pattern_gets_fewer_control_points_across(criterion: str) -> None:
    rng = np.random.default_rng(8)
    along = np.sin(np.outer(SQUARE.u, 25 * np.ones(1)).ravel())
    errors = 0.012 * along + rng.normal(0, NOISE_MM, 625)
    found = separate(SQUARE, errors, near=NEAR, criterion=criterion)
    assert found.chosen.size.columns < found.chosen.size.rows
    assert found.criterion == criterion


def test_likelihood_does_not_care_for_form_errors() -> None:
    """A tilt and a bow of many times the pattern's size change nothing: every size contains them."""
    rng = np.random.default_rng(4)
    errors = on_grid(random_surface(rng, 8, 0.010)) + rng.normal(0, NOISE_MM, 625)
    bow = 5.0 + 0.3 * SQUARE.u - 0.2 * SQUARE.v**2
    for size in (Size(3, 3, 2), Size(8, 8), Size(12, 7), Size(9, 9, 2)):
        plain, bowed = (log_likelihood(SQUARE, values, size) for values in (errors, errors + bow))
        assert bowed == pytest.approx(plain, abs=1e-5)


def test_values_without_noise_are_followed() -> None:
    errors = on_grid(random_surface(np.random.default_rng(6), 8, 0.010))
    found = separate(SQUARE, errors, near=NEAR)
    assert np.sqrt(np.mean((on_grid(found.deterministic) - errors) ** 2)) < 1e-4


def test_log_likelihood_is_that_of_its_normal_law() -> None:
    """Against the density written out with whole matrices, at the best of many ratios of variances."""
    rng = np.random.default_rng(7)
    places, size = square_places(9), Size(5, 4, 2)
    values = on_grid(random_surface(rng, 5, 0.01), np.linspace(0, 1, 9)) + rng.normal(0, NOISE_MM, 81)
    b, x = splines(places, size).combined(np.eye(size.controls)), projector(places, FORM).columns
    spread = np.sum(b * b) / size.controls

    def written_out(ratio: float) -> float:
        v = np.eye(81) + ratio / spread * (b @ b.T)
        inverse = np.linalg.inv(v)
        normal = x.T @ inverse @ x
        p = inverse - inverse @ x @ np.linalg.inv(normal) @ x.T @ inverse
        variance = values @ p @ values / 72
        return float(-0.5 * (72 * np.log(variance) + np.linalg.slogdet(v)[1] + np.linalg.slogdet(normal)[1]))

    best = max(written_out(ratio) for ratio in np.exp(np.linspace(0, 18, 721)))
    assert log_likelihood(places, values, size) == pytest.approx(best, abs=0.05)


def test_single_bad_touches_are_told_as_not_normal() -> None:
    rng = np.random.default_rng(6)
    errors = on_grid(random_surface(rng, 7, 0.008)) + rng.normal(0, NOISE_MM, 625)
    errors[[40, 300, 501]] += [0.03, -0.04, 0.03]
    found = separate(SQUARE, errors, near=NEAR, name="S4")
    assert [finding.severity for finding in found.findings if "'S4'" in finding.message] == [Severity.WARNING]
    assert "not normal" in found.findings[0].message
    assert abs(found.chosen.size.rows - 7) <= 1


def test_holes_and_scattered_points_are_bridged_smoothly() -> None:
    rng = np.random.default_rng(12)
    truth = random_surface(rng, 7, 0.010)
    u, v = rng.uniform(0, 1, (2, 700))
    hole = (u > 0.4) & (u < 0.5) & (v > 0.3) & (v < 0.4)
    u, v = u[~hole], v[~hole]
    places = Places(np.stack([50 * u, 50 * v, 0 * u], 1), u, v)
    errors = truth.value_mm(u, v) + rng.normal(0, NOISE_MM, len(u))
    found = separate(places, errors, degrees=(3,))
    assert abs(found.chosen.size.rows - 7) <= 1
    inside = found.deterministic.value_mm(np.array([0.45]), np.array([0.35]))
    assert inside[0] == pytest.approx(truth.value_mm(np.array([0.45]), np.array([0.35]))[0], abs=3 * NOISE_MM)


def test_smoothing_changes_nothing_where_points_decide() -> None:
    rng = np.random.default_rng(13)
    errors = on_grid(random_surface(rng, 9, 0.010))
    scattered = Places(SQUARE.points_mm, SQUARE.u, SQUARE.v)
    exact, smooth = (on_grid(regress(places, errors, Size(9, 9))) for places in (SQUARE, scattered))
    np.testing.assert_allclose(smooth, exact, atol=2e-7)  # a trace of 1e-6: a fifth of a nanometre


def test_normality_is_judged_of_residuals_over_their_own_scatter() -> None:
    """A touch at a corner, which the surface follows, leaves √(1 − h) of its scatter, h of the hat matrix written out;
    at the corners of 9 × 9 control points over 25 × 25 touches h is above 0.5.
    """
    errors, side = np.random.default_rng(7).normal(0, NOISE_MM, 625), Size(9, 9)
    along = basis(side, 0, np.linspace(0.0, 1.0, 25))
    line = along @ np.linalg.inv(along.T @ along) @ along.T
    hat = np.kron(line, line)
    left = errors - hat @ errors
    found = of_size(SQUARE, errors, side, NEAR).chosen.normality
    assert np.max(np.diag(hat)) > 0.5
    assert found.distance == pytest.approx(normality(left / np.sqrt(1.0 - np.diag(hat))).distance, rel=1e-6)
    assert abs(found.distance - normality(left).distance) > 1e-4


def test_the_scatter_of_two_parts_is_judged_by_fisher_s_test() -> None:
    """625 touches less 81 control points leave 544 degrees of freedom, 625 less 25 leave 600; either part may be it."""
    rng = np.random.default_rng(6)
    quiet, loud = (
        of_size(SQUARE, rng.normal(0, scatter, 625), Size(side, side), NEAR)
        for scatter, side in ((NOISE_MM, 9), (1.1 * NOISE_MM, 5))
    )
    found = scattering_part([quiet, loud])
    assert (found.index, found.sigma_mm, found.others_mm) == pytest.approx((1, loud.sigma_mm, quiet.sigma_mm))
    by_chance = 2 * f.sf((loud.sigma_mm / quiet.sigma_mm) ** 2, 600, 544)
    assert 1e-4 < by_chance < 0.5 and found.p_value == pytest.approx(by_chance, rel=1e-9)
    assert scattering_part([quiet] * 3).p_value == 1.0  # three times a half


@pytest.mark.parametrize("n", [8, 30, 200])
def test_lilliefors_p_values_of_normal_samples_are_uniform(n: int) -> None:
    """20,000 samples: a share is known to 0.0035, and the formulas join to a few hundredths of theirs."""
    values = np.sort(np.random.default_rng(21).normal(3.0, 2.0, (20_000, n)), axis=1)
    law = ndtr((values - values.mean(axis=1, keepdims=True)) / values.std(axis=1, ddof=1, keepdims=True))
    steps = np.arange(n + 1) / n
    distance = np.maximum((steps[1:] - law).max(axis=1), (law - steps[:-1]).max(axis=1))
    p = np.array([lilliefors_p(each, n) for each in distance.tolist()])
    levels = np.array([0.01, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 0.98])
    shares = np.mean(p[:, None] < levels, axis=0)
    assert np.all(np.abs(shares - levels) < 0.003 + 0.08 * np.minimum(levels, 1.0 - levels)), shares


def test_kolmogorov_smirnov_on_estimated_moments_hardly_ever_rejects() -> None:
    """One sample by hand: of 0, 0, 0, 0, 10 mean 2, s = √20; at the fourth step the distance is 4/5 − Φ(−2/√20)."""
    found = normality(np.array([0.0, 10.0, 0.0, 0.0, 0.0]))
    distance = 0.8 - 0.3273604
    assert found.distance == pytest.approx(distance, abs=1e-6)
    both_ways = 2 * sum((-1) ** (k - 1) * math.exp(-2 * k * k * 5 * distance**2) for k in range(1, 20))
    assert found.ks_p == pytest.approx(both_ways, rel=1e-6)
    assert found.lilliefors_p < 0.01 and found.ks_p > 0.2
    with pytest.raises(TrueloopError):
        normality(np.array([0.0, 1.0, 0.0, 1.0]))


@pytest.mark.parametrize(
    ("statistic", "level"), [(0.775, 0.15), (0.819, 0.1), (0.895, 0.05), (0.955, 0.025), (1.035, 0.01)]
)
def test_p_values_are_those_of_stephens_table(statistic: float, level: float) -> None:
    """Stephens (1974), Journal of the American Statistical Association 69: D (√n − 0.01 + 0.85/√n) of a normal law."""
    for n in (8, 20, 100):
        assert lilliefors_p(statistic / (n**0.5 - 0.01 + 0.85 / n**0.5), n) == pytest.approx(level, rel=0.13)


def test_the_p_value_of_ten_million_touches_lies_between_those_of_stephens_table() -> None:
    """At 0.905 between 0.05 of 0.895 and 0.025 of 0.955, in proportion to its logarithm 0.0445."""
    n = 10_000_000
    assert lilliefors_p(0.905 / (n**0.5 - 0.01 + 0.85 / n**0.5), n) == pytest.approx(0.0445, rel=0.13)
