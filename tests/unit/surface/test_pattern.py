"""The machining pattern model: recovered within its uncertainty, an odd part found, how many parts are enough."""

import numpy as np
import pytest
from scipy.stats import t, ttest_1samp

from tests.support.surfaces import GRID, NEAR, SQUARE, on_grid, random_surface, square_places
from trueloop.surface.pattern.pattern import (
    PLACES,
    Pattern,
    by_chance,
    common_size,
    on_square,
    outliers,
    part_maps,
    parts_needed,
    pattern_of,
)
from trueloop.surface.separation.separate import Separation, of_size, separate, student
from trueloop.surface.separation.spline_surface import Size, SplineSurface, basis, projector

NOISE_MM, BETWEEN_MM = 0.0022, 0.0025
NAMES = tuple(f"S{k}" for k in range(1, 11))


def parts(rng: np.random.Generator, truth: np.ndarray, count: int = 10) -> list[Separation]:
    return [
        of_size(
            SQUARE, truth + on_grid(random_surface(rng, 5, BETWEEN_MM)) + rng.normal(0, NOISE_MM, 625), Size(9, 9), NEAR
        )
        for _ in range(count)
    ]


def test_the_true_pattern_lies_within_the_predicted_uncertainty() -> None:
    """95 % intervals over 120 patterns, each of some 25 independent shapes: 93 to 97 % must cover."""
    rng, covered = np.random.default_rng(31), []
    for _ in range(120):
        truth = on_grid(random_surface(rng, 9, 0.010))
        pattern = pattern_of(parts(rng, truth), NAMES)
        off = np.abs(pattern.mean.grid_mm(GRID, GRID).ravel() - truth)
        covered.append(np.mean(off <= pattern.uncertainty_grid_mm(GRID, GRID).ravel()))
    assert 0.93 <= np.mean(covered) <= 0.97


def one_pattern(seed: int, odd_mm: float = 0.0) -> Pattern:
    rng = np.random.default_rng(seed)
    truth = on_grid(random_surface(rng, 9, 0.010))
    found = parts(rng, truth)
    if odd_mm:
        found[3] = of_size(SQUARE, found[3].measured_mm + on_grid(random_surface(rng, 5, odd_mm)), Size(9, 9), NEAR)
    return pattern_of(found, NAMES)


def test_an_odd_part_is_named_and_others_are_not() -> None:
    assert [odd.name for odd in one_pattern(1, odd_mm=0.010).outlying] == ["S4"]


@pytest.mark.parametrize("count", [5, 10])
def test_false_alarms_are_rare(count: int) -> None:
    """At one or two in a hundred patterns, eight in 150 come once in a thousand."""
    rng, alarms = np.random.default_rng(3), 0
    for _ in range(150):
        alarms += bool(outliers(on_square([random_surface(rng, 6, BETWEEN_MM) for _ in range(count)]), NAMES))
    assert alarms < 8


def test_the_mean_is_the_mean_of_the_parts_models() -> None:
    pattern = one_pattern(2)
    stack = np.stack([model.grid_mm(GRID, GRID) for model in pattern.models])
    np.testing.assert_allclose(pattern.mean.grid_mm(GRID, GRID), stack.mean(axis=0), atol=1e-15)
    np.testing.assert_allclose(pattern.scatter_grid_mm(GRID, GRID), stack.std(axis=0, ddof=1), atol=1e-15)
    assert pattern.sigma_mm == pytest.approx(NOISE_MM, rel=0.05)


def test_the_scatter_of_equal_parts_is_the_variance_of_the_fit() -> None:
    rng = np.random.default_rng(17)
    same = [of_size(SQUARE, rng.normal(0, NOISE_MM, 625), Size(9, 9), NEAR) for _ in range(40)]
    pattern = pattern_of(same, [f"P{k}" for k in range(40)], size=Size(9, 9))
    along = basis(Size(9, 9), 0, GRID)
    one_way = np.diag(along @ np.linalg.inv(along.T @ along) @ along.T)  # the grid of touches is GRID both ways
    own = same[0].sigma_mm ** 2 * np.outer(one_way, one_way)
    assert np.mean(pattern.scatter_grid_mm(GRID, GRID) ** 2) == pytest.approx(np.mean(own), rel=0.1)


def test_parts_needed_is_the_least_that_reaches_the_target() -> None:
    pattern = one_pattern(3)
    at = np.linspace(0, 1, 41)
    scatter = np.sqrt(np.mean(pattern.scatter_grid_mm(at, at) ** 2))
    needed = parts_needed(pattern, 0.001)
    assert student(0.95, needed - 1) * scatter / np.sqrt(needed) <= 0.001
    assert student(0.95, needed - 2) * scatter / np.sqrt(needed - 1) > 0.001


def test_the_mean_of_the_parts_says_which_size_the_pattern_needs() -> None:
    """Noise takes a part alone for a smaller size; the mean of all has a third of the noise."""
    rng = np.random.default_rng(23)
    truth = on_grid(random_surface(rng, 15, 0.004))
    found = [separate(SQUARE, truth + rng.normal(0, NOISE_MM, 625), near=NEAR, name=name) for name in NAMES]
    assert len({part.chosen.size for part in found}) > 1
    assert pattern_of(found, NAMES).size == Size(15, 15)


def test_parts_measured_at_different_places_are_modelled_with_the_largest_size_any_needs() -> None:
    rng = np.random.default_rng(23)
    found = [
        separate(square_places(), on_grid(random_surface(rng, n, 0.010)) + rng.normal(0, NOISE_MM, 625))
        for n in (6, 9, 7)
    ]
    pattern = pattern_of(found, ("a", "b", "c"))
    assert pattern.size == common_size(found)
    assert pattern.size.rows == max(part.chosen.size.rows for part in found)
    assert pattern.missed_mm == 0.0


def test_what_no_size_follows_is_part_of_the_uncertainty() -> None:
    """A pattern that is no spline: the size stops where noise hides the rest, and that rest is told."""
    rng, covered, missed, told = np.random.default_rng(41), [], [], []
    for _ in range(25):
        truth = on_grid(random_surface(rng, 5, 0.006)) + 0.006 * np.sin(25 * SQUARE.u + rng.uniform(0, 6))
        pattern = pattern_of(parts(rng, truth), NAMES)
        mean = pattern.mean.grid_mm(GRID, GRID).ravel()
        covered.append(np.mean(np.abs(mean - truth) <= pattern.uncertainty_grid_mm(GRID, GRID).ravel()))
        missed.append(np.mean(projector(SQUARE, pattern.size).residuals(truth) ** 2))
        told.append(pattern.missed_mm**2)
    assert 0.93 <= np.mean(covered) <= 0.97
    assert np.mean(told) == pytest.approx(np.mean(missed), rel=0.3)


def test_a_next_part_scatters_about_a_mean_that_is_uncertain_itself() -> None:
    """By hand: t of nine degrees of freedom, times the parts' scatter, times √(1 + 1/10)."""
    pattern = one_pattern(1)
    scatter = np.std([model.grid_mm(GRID, GRID) for model in pattern.models], axis=0, ddof=1)
    expected = t.ppf(0.975, 9) * scatter * np.sqrt(1.1)
    np.testing.assert_allclose(pattern.next_part_grid_mm(GRID, GRID), expected, rtol=1e-6)


def test_maps_of_a_part_by_what_was_put_in() -> None:
    """Corrected by the others' mean it keeps what it alone has and what that mean has of the others; the variance
    between parts is that of what was added to each, without that of the fits.
    """
    rng = np.random.default_rng(5)
    truth = on_grid(random_surface(rng, 9, 0.010))
    own = np.stack([on_grid(random_surface(rng, 5, BETWEEN_MM)) for _ in range(10)])
    noise = rng.normal(0, NOISE_MM, own.shape)
    found = [of_size(SQUARE, truth + each, Size(9, 9), NEAR) for each in own + noise]
    maps = part_maps(pattern_of(found, NAMES, size=Size(9, 9)), found[3], "S4", 1.0)
    kept = own[3] + noise[3] - np.mean(np.delete(own, 3, axis=0), axis=0)
    assert np.std(maps.predicted_mm - kept) < NOISE_MM / 5  # the fits' noise, of nine parts on average
    larger = [*found[:3], of_size(SQUARE, found[3].measured_mm + 0.01, Size(9, 9), NEAR), *found[4:]]
    again = part_maps(pattern_of(larger, NAMES, size=Size(9, 9)), larger[3], "S4", 1.0)
    np.testing.assert_allclose(again.predicted_mm, maps.predicted_mm + 0.01, atol=1e-12)  # none of it corrects itself
    half = part_maps(pattern_of(found, NAMES, size=Size(9, 9)), found[3], "S4", 0.5).predicted_mm
    np.testing.assert_allclose(half, (maps.predicted_mm + found[3].measured_mm) / 2, atol=1e-12)
    assert np.mean(maps.variability_mm**2) == pytest.approx(np.mean(np.var(own, axis=0, ddof=1)), rel=0.06)


WHOLE = np.ones(PLACES**2, bool)


@pytest.mark.parametrize("count", [3, 4, 10])
def test_parts_that_differ_by_their_set_up_alone_show_no_pattern_and_a_pattern_is_seen(count: int) -> None:
    """Heights and tilts alone: at 5 %, 20 of 200 come once in five hundred. A pattern of bends is seen."""
    rng, alarms = np.random.default_rng(5), 0
    at = np.linspace(-0.5, 0.5, 6)
    size = Size(6, 6)
    for _ in range(200):
        motions = rng.normal(0, 0.05, (count, 3))
        alarms += by_chance([SplineSurface(size, a + b * at[:, None] + c * at) for a, b, c in motions], WHOLE) < 0.05
    assert alarms < 20
    truth = random_surface(rng, 9, 0.010).coefficients_mm
    alike = [
        SplineSurface(Size(9, 9), truth + random_surface(rng, 9, BETWEEN_MM).coefficients_mm) for _ in range(count)
    ]
    assert by_chance(alike, WHOLE) < 0.01


def test_parts_that_differ_by_height_alone_are_judged_by_student_s_test() -> None:
    """F with 1 and s − 1 degrees of freedom: the square of Student's t of their heights."""
    for heights in ([1.0, 2.0, 4.0], [0.5, 3.0, 2.0, -0.5, 1.0]):
        models = [SplineSurface(Size(6, 6), np.full((6, 6), 1e-3 * height)) for height in heights]
        assert by_chance(models, WHOLE) == pytest.approx(ttest_1samp(heights, 0.0).pvalue, rel=1e-9)


def test_what_trimming_cut_away_makes_no_pattern() -> None:
    """Parts that have a bump alike in one corner alone, which is cut away, and differ by heights of ±1 µm elsewhere."""
    rng = np.random.default_rng(3)
    corner = np.zeros((9, 9))
    corner[6:, 6:] = 0.1
    alike = [SplineSurface(Size(9, 9), corner + height) for height in rng.normal(0, 0.001, 5)]
    there = np.ones((PLACES, PLACES), bool)
    there[12:, 12:] = False
    assert by_chance(alike, WHOLE) < 0.01
    assert by_chance(alike, there.ravel()) > 0.05
