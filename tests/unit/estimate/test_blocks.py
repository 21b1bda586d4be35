"""Blocks of columns: the marginal likelihood against the dense normal distribution, sizes against those put in."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from trueloop.arrays import Array
from trueloop.estimate.blocks import NOISE_LN, Block, _Badness, mixed

RNG = np.random.default_rng(4)
ROWS = RNG.normal(size=(60, 7))
OWN = np.array([0, 0, 0, 1, 1, 2, 2])


def test_likelihood_and_gradient_are_those_of_the_dense_normal_distribution() -> None:
    """Values of weight w have the variance σ²/w; up to a constant, and with the noise's own prior."""
    values, weight = RNG.normal(0, 2.0, 60), RNG.uniform(0.4, 1.0, 60)
    badness = _Badness(ROWS, values, weight, (60.0, 1.5), OWN)

    def dense(sizes: Array) -> float:
        scaled = ROWS * np.exp(sizes[:-1])[OWN]
        covariance = scaled @ scaled.T + np.exp(2 * sizes[-1]) * np.diag(1 / weight)
        likely = multivariate_normal(np.zeros(60), covariance).logpdf(values)
        return float(0.5 * ((sizes[-1] - np.log(1.5)) / NOISE_LN) ** 2 - likely)

    here, there = np.array([0.3, -0.2, 0.7, 0.1]), np.array([-2.0, 1.0, 0.0, 0.6])
    assert badness.of(there)[0] - badness.of(here)[0] == pytest.approx(dense(there) - dense(here), rel=1e-9)
    slopes = [(dense(here + step) - dense(here - step)) / 2e-5 for step in 1e-5 * np.eye(4)]
    assert badness.of(here)[1] == pytest.approx(slopes, rel=1e-5)


def test_sizes_are_those_put_in_and_a_slip_is_named() -> None:
    """Blocks of 40 columns that act with 3 and not at all, one whose scale is known; noise of 0.5, expected 1."""
    n = 400
    rows = [RNG.normal(size=(n, 40)), RNG.normal(size=(n, 40)), RNG.normal(size=(n, 1))]
    truth = 3.0 * RNG.normal(size=40)
    values = rows[0] @ truth + 2.0 * rows[2][:, 0] + RNG.normal(0, 0.5, n)
    values[7] += 40.0
    blocks = {"acts": Block(rows[0], 1e-3, 64.0), "idle": Block(rows[1], 1e-3, 64.0), "known": Block(rows[2], 5.0, 5.0)}
    found = mixed(values, blocks, np.ones(n), 1.0)
    assert found.scales["acts"] == pytest.approx(np.sqrt(np.mean(truth**2)), rel=0.1)
    assert found.scales["idle"] < 0.03 and found.scales["known"] == pytest.approx(5.0)
    assert found.noise == pytest.approx(0.5, rel=0.15)
    assert np.flatnonzero(found.outlier).tolist() == [7]
    off = found.scales["acts"] * found.mean["acts"] - truth
    u = found.scales["acts"] * np.sqrt(np.diag(found.covariance)[:40])
    assert 0.7 < np.sqrt(np.mean((off / u) ** 2)) < 1.4
    assert 5.0 * found.mean["known"][0] == pytest.approx(2.0, abs=0.15)
