"""A milling process on a free-form surface whose errors are known: pattern, variability between parts, and noise."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.surface.separation.spline_surface import Size, SplineSurface

EXTREME_OF_625: Final = 3.08
"""Expected largest of 625 standard normal values: what a published ± of 625 residuals means in standard deviations."""

LEAST_MM: Final = 0.0024
MOST_MM: Final = 0.0043
EXTREME_MM: Final = 0.0065
"""Published limits [MPM §8]: of the variability between parts, and of the random part."""

FREQUENCIES: Final = (1.0, 2.5, 4.0)
"""Of the waves by which parts differ, in radians over a side."""
WAVES: Final = 2 * len(FREQUENCIES)


@dataclass(frozen=True, eq=False)
class SurfaceProcess:
    """`pattern` is what every part gets. Parts differ from it by smooth surfaces, whose standard deviation over parts
    grows from `least_mm` in the middle to `most_mm` at the edges; `noise_mm` is that of one touch.
    """

    pattern: SplineSurface
    least_mm: float
    most_mm: float
    noise_mm: float

    def variation(self, rng: np.random.Generator) -> "Variation":
        """How one part differs from the pattern: a normal weight for every wave along u times every one along v."""
        return Variation(self.least_mm, self.most_mm, rng.normal(size=(WAVES, WAVES)))

    def part_mm(self, rng: np.random.Generator, u: Array, v: Array, correction_mm: Array | float = 0.0) -> Array:
        """Measured deviations of one new part, machined with a correction taken off the surface."""
        noise = rng.normal(0.0, self.noise_mm, (len(u), len(v)))
        return self.pattern.grid_mm(u, v) + self.variation(rng).grid_mm(u, v) + noise - correction_mm


@dataclass(frozen=True, eq=False)
class Variation:
    """A smooth surface over [0, 1] × [0, 1] in mm: waves whose size grows from the middle to the edges.

    `weights` (6, 6): of each wave along u with each along v. The squares of either direction's waves add up to one
    everywhere: weights that are drawn independently with unit variance make that size the standard deviation.
    """

    least_mm: float
    most_mm: float
    weights: Array

    def value_mm(self, u: Array, v: Array) -> Array:
        """Values at pairs of parameters."""
        return self._scaled(u, v, np.sum((_harmonics(u) @ self.weights) * _harmonics(v), axis=1))

    def grid_mm(self, u: Array, v: Array) -> Array:
        """Values at every u with every v."""
        return self._scaled(u[:, None], v[None, :], _harmonics(u) @ self.weights @ _harmonics(v).T)

    def _scaled(self, u: Array, v: Array, field: Array) -> Array:
        edge = np.maximum(np.abs(2 * u - 1), np.abs(2 * v - 1))
        return np.asarray((self.least_mm + (self.most_mm - self.least_mm) * edge) * field)


def published_process(rng: np.random.Generator, pattern_mm: float = 0.008, controls: int = 9) -> SurfaceProcess:
    """A process of the size of [MPM §8]: variability between parts ±2.4 to ±4.3 µm, random part within ±6.5 µm.

    The extremes are read as three standard deviations for the few parts' models, and as the largest of 625 values for
    the random part. The pattern itself is drawn, its control values with the given standard deviation.
    """
    pattern = SplineSurface(Size(controls, controls), rng.normal(0.0, pattern_mm, (controls, controls)))
    return SurfaceProcess(pattern, LEAST_MM / 3, MOST_MM / 3, EXTREME_MM / EXTREME_OF_625)


def _harmonics(at: Array) -> Array:
    """Six smooth functions whose squares add up to one everywhere: a field of them varies alike in all places."""
    waves = [wave(w * at) for w in FREQUENCIES for wave in (np.cos, np.sin)]
    return np.asarray(np.stack(waves, axis=1) / np.sqrt(len(FREQUENCIES)))
