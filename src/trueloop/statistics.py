"""One value for many, and what holds them."""

from typing import Final

import numpy as np

from trueloop.arrays import Array

NORMAL_95: Final = 1.96
"""Standard deviations to either side of the mean that hold 95 % of a normal distribution."""


def rms(values: Array) -> float:
    """Root of the mean square, about zero and not about the mean; NaN of no values."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def root_of(covariance: Array) -> Array:
    """Returns R with R Rᵀ = covariance."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
