"""Points measured more than once: found as a slow search finds them, averaged, and told with what they differ by."""

import numpy as np
import pytest

from tests.support.refusals import refused
from tests.support.surfaces import wavy_surface
from trueloop.arrays import Array
from trueloop.errors import Code, Severity
from trueloop.surface.deviations.deviations import SurfaceDeviations, surface_deviations
from trueloop.surface.deviations.points import MeasuredPoints, averaged, first_of_place

RNG = np.random.default_rng(60)
SURFACE = wavy_surface()
U, V = RNG.uniform(0.02, 0.98, (2, 400))
POINTS, NORMAL = SURFACE.point_mm(U, V), SURFACE.normal(U, V)
ERROR = RNG.normal(0, 0.002, 400)


def measured(index: np.ndarray, error_mm: Array) -> SurfaceDeviations:
    return surface_deviations(SURFACE, MeasuredPoints(POINTS[index] + error_mm[:, None] * NORMAL[index], name="A"))


def searched(points_mm: Array, within_mm: float) -> list[int]:
    """The first point of each point's place, pair by pair."""
    near = np.linalg.norm(points_mm[:, None] - points_mm[None], axis=2) < within_mm
    first = list(range(len(points_mm)))
    for _ in points_mm:
        first = [min(first[k] for k in np.flatnonzero(row)) for row in near]
    return first


@pytest.mark.parametrize("copies", [1, 2, 5])
def test_places_are_those_that_a_search_of_all_pairs_finds(copies: int) -> None:
    spots = np.repeat(RNG.uniform(0, 1, (40, 3)), copies, axis=0)
    chain = np.array([[2.0, 2.0, 2.0 + 0.009 * k] for k in range(12)])
    far = np.array([[3.0, 3.0, 3.0], [3.0, 3.0, 3.02]])
    points = RNG.permutation(np.concatenate([spots + RNG.normal(0, 1e-4, spots.shape), chain, far]))
    found = first_of_place(points, 0.01)
    assert found.tolist() == searched(points, 0.01)
    assert len(np.unique(found)) == 40 + 1 + 2


def test_a_hundred_thousand_points_in_one_spot_are_one_place() -> None:
    values = RNG.normal(0, 1, 100_000)
    error, told = averaged(np.tile([[1.0, 2.0, 3.0]], (100_000, 1)), values)
    assert told is not None and (told.places, len(told.spare)) == (1, 99_999)
    assert error[0] == pytest.approx(np.mean(values)) and np.all(np.isnan(error[1:]))
    assert told.difference_mm == pytest.approx(np.ptp(values))


def test_two_touches_of_one_place_count_as_their_mean_and_are_told() -> None:
    """By hand: 3 µm and 7 µm at the place of point 5 are 5 µm; they differ by 4 µm."""
    error = ERROR.copy()
    error[5] = 0.003
    index = np.append(np.arange(400), 5)
    found = measured(index, np.append(error, 0.007))
    assert np.flatnonzero(~found.measured).tolist() == [400]
    np.testing.assert_allclose(found.error_mm[:400], np.where(np.arange(400) == 5, 0.005, error), atol=1e-9)
    (told,) = found.findings
    assert (told.code, told.severity) == (Code.SRF_DUPLICATE, Severity.NOTE)
    assert "1 of 401 points" in told.message and "(1 places, within 0.1 µm)" in told.message
    assert "by up to 4.00 µm (points 6 and 401)" in told.message


def test_touches_of_one_place_that_contradict_each_other_are_a_warning_with_both_lines() -> None:
    points = POINTS + ERROR[:, None] * NORMAL
    twice = np.concatenate([points, (POINTS[7] + 0.06 * NORMAL[7])[None]])
    lines = np.arange(2, 403)
    found = surface_deviations(SURFACE, MeasuredPoints(twice, name="A", file="A.csv", lines=lines))
    (told,) = found.findings
    assert told.severity is Severity.WARNING
    assert f"by up to {(0.06 - ERROR[7]) * 1000:.2f} µm (points 8 and 401)" in told.message
    assert (told.place.file, told.place.line) == ("A.csv", 402)


def test_two_places_of_a_grid_in_one_spot_are_refused() -> None:
    at = np.linspace(0.1, 0.9, 5)
    u, v = (a.ravel() for a in np.meshgrid(at, at, indexing="ij"))
    points = SURFACE.point_mm(u, v)
    points[20] = points[4] + 0.004 * SURFACE.normal(u[4:5], v[4:5])[0]
    refusal = refused(lambda: surface_deviations(SURFACE, MeasuredPoints(points, shape=(5, 5), name="G")))
    assert refusal.code is Code.SRF_DUPLICATE
    assert "points 5 and 21 of 'G', two places of a grid" in refusal.message


def test_too_few_places_are_refused_however_often_they_were_touched() -> None:
    index = np.repeat(np.arange(10), 4)
    assert refused(lambda: measured(index, ERROR[index])).code is Code.SRF_POINTS
