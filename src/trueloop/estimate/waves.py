"""Smooth functions in a finite basis: sines on an interval, of which a length scale sets the sizes.

Hilbert-space approximation of a Gaussian process (Solin and Särkkä, Statistics and Computing 30, 2020): eigenfunctions
of the Laplacian on an interval wider than the one of interest; the spectral density at their frequencies is the
variance of their coefficients. The basis does not depend on the length scale.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array

MARGIN: Final = 2.5
"""By so many lengths the interval is wider at either end: the basis is zero at its own ends."""

FINENESS: Final = 4.0 / math.pi
"""Waves per length of the interval: the covariance is right within a percent."""


@dataclass(frozen=True)
class Waves:
    """Sines over [low, high], fit for squared-exponential functions of lengths around `length`."""

    low: float
    high: float
    length: float

    @property
    def _half(self) -> float:
        return 0.5 * (self.high - self.low) + MARGIN * self.length

    @property
    def count(self) -> int:
        """Returns the number m of functions."""
        return math.ceil(FINENESS * 2.0 * self._half / (0.7 * self.length))

    @property
    def frequency(self) -> Array:
        """Returns the angular frequencies, (m,)."""
        return np.asarray(np.arange(1, self.count + 1) * (math.pi / (2.0 * self._half)), dtype=np.float64)

    def at(self, x: Array) -> Array:
        """Values of the functions, (n, m)."""
        away = np.asarray(x)[:, None] - 0.5 * (self.low + self.high) + self._half
        return np.asarray(np.sin(self.frequency * away) / math.sqrt(self._half))

    def spread(self, sd: float, length: float) -> Array:
        """Returns the standard deviations of the coefficients of a function of that deviation and length, (m,)."""
        density = math.sqrt(math.sqrt(2.0 * math.pi) * length)
        return np.asarray(sd * density * np.exp(-0.25 * (length * self.frequency) ** 2))
