"""The restricted likelihood of a pattern against plain linear algebra, its slopes against differences."""

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.machine.standards import PatternLikelihood, Plate, fit_pattern

PARAMETERS = np.array([80.0, 6e-3, 3e-3, 4e-3])


def _holes(count: int, rng: np.random.Generator) -> tuple[Array, Array, np.ndarray, np.ndarray]:
    nominal = rng.uniform(-300, 300, (count, 2))
    tool = rng.integers(0, 3, count).astype(np.float64)
    z = nominal[:, 0] + 1j * nominal[:, 1]
    error = 5e-3 * (np.sin(z.real / 90) + 1j * np.cos(z.imag / 70)) + 3e-3 * tool
    error = error + 4e-3 * (rng.normal(size=count) + 1j * rng.normal(size=count))
    return nominal, tool, error, np.column_stack([np.ones(count), z / 600])


def _by_hand(nominal: Array, tool: Array, error: np.ndarray, nuisance: np.ndarray, parameters: Array) -> float:
    length, spread, tools, noise = parameters
    covariance = np.zeros((len(error), len(error)))
    for i in range(len(error)):
        for j in range(len(error)):
            x, y = np.sqrt(3) * np.abs(nominal[i] - nominal[j]) / length
            covariance[i, j] = spread**2 * (1 + x) * np.exp(-x) * (1 + y) * np.exp(-y)
            covariance[i, j] += tools**2 * (tool[i] == tool[j] > 0) + (noise**2 + 1e-12 * spread**2) * (i == j)
    inverse = np.linalg.inv(covariance)
    normal = nuisance.conj().T @ inverse @ nuisance
    rest = inverse - inverse @ nuisance @ np.linalg.inv(normal) @ nuisance.conj().T @ inverse
    logs = np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(normal)[1]
    return float(logs + (error.conj() @ rest @ error).real)


def test_likelihood_and_slopes() -> None:
    holes = _holes(60, np.random.default_rng(3))
    likelihood = PatternLikelihood(*holes)
    badness, slopes = likelihood.badness_and_slope(PARAMETERS)
    assert badness == pytest.approx(_by_hand(*holes, PARAMETERS), abs=1e-6)
    for k in range(4):
        moved = [PARAMETERS * np.exp(step * np.eye(4)[k]) for step in (1e-4, -1e-4)]
        difference = (_by_hand(*holes, moved[0]) - _by_hand(*holes, moved[1])) / 2e-4
        assert slopes[k] == pytest.approx(difference, abs=1e-3 * np.abs(slopes).max())


def test_many_holes_give_what_the_whole_search_gives() -> None:
    """Parameters found among some holes and refined among all are as likely as those of a long search."""
    nominal, tool, error, _ = _holes(900, np.random.default_rng(4))
    measured = nominal + np.column_stack([error.real, error.imag])
    found = fit_pattern([Plate(nominal[k::2], measured[k::2], tool[k::2]) for k in (0, 1)]).parameters
    z = nominal[:, 0] + 1j * nominal[:, 1]
    half = np.arange(900) % 2
    nuisance = np.column_stack([half == 0, half == 1, (half == 0) * z, (half == 1) * z]).astype(complex)
    whole = PatternLikelihood(nominal, tool, error, nuisance)
    best, _ = whole.most_likely(np.array([200.0, 5e-3, 5e-3, 5e-3]), 200)
    assert whole.badness_and_slope(found)[0] < whole.badness_and_slope(best)[0] + 0.5
