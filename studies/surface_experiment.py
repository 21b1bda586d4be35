"""The published experiment [MPM §8] on a simulated process.

Ten parts are measured; one new part each is cut after correction by the pattern, by one part's deterministic model, by
that part's raw data. What no laboratory can do stands beside: correction by the true pattern, the best there is, and
the very same new part corrected in each way, which leaves out the luck of having got another part.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from studies.surface_truths import GRID, NEAR, SQUARE
from trueloop.arrays import Array
from trueloop.surface.pattern.pattern import pattern_of
from trueloop.surface.separation.separate import separate
from trueloop_lab.simulator.machine import (
    EXTREME_MM,
    EXTREME_OF_625,
    LEAST_MM,
    MOST_MM,
    WAVES,
    Variation,
    published_process,
)

PARTS: Final = 10
LEFT_BY_15: Final = np.sqrt(1 - 15 * 15 / 625)
"""Share of the noise's scatter that a least-squares model of 15 × 15 control points leaves of 25 × 25 places."""
TAKEN: Final = 3
"""The fourth part (S4) gives the single model and the raw data."""
WAYS: Final = ("true", "pattern", "model", "raw")


@dataclass(frozen=True)
class Reading:
    """What the published limits are taken to mean. `sigmas`: those between parts in standard deviations.

    `of_extremes`: they are those of the smallest and of the largest deviation, and the variability goes evenly with the
    pattern's value; else the larger holds at the edges, the smaller in the middle. `noise_mm`: of one touch.
    """

    sigmas: float
    of_extremes: bool = False
    noise_mm: float = EXTREME_MM / EXTREME_OF_625

    def variation_mm(self, rng: np.random.Generator, truth_mm: Array) -> Array:
        """How one part differs from the pattern at every place of the grid."""
        least, most, weights = LEAST_MM / self.sigmas, MOST_MM / self.sigmas, rng.normal(size=(WAVES, WAVES))
        if self.of_extremes:
            size = np.interp(truth_mm, [truth_mm.min(), truth_mm.max()], [most, least])
            return np.asarray(size * Variation(1.0, 1.0, weights).grid_mm(GRID, GRID))
        return Variation(least, most, weights).grid_mm(GRID, GRID)


THREE_SIGMA: Final = Reading(3.0)


@dataclass(frozen=True)
class Outcome:
    """Worst deviations in µm by way of correction, of a new part each (`worst_um`) and of the same new part for all
    (`same_um`); the scatter of the new parts' random part; the share of places that the uncertainty covers; half the
    range of the smallest and of the largest value of the deterministic models (`varied_um`).
    """

    worst_um: dict[str, float]
    same_um: dict[str, float]
    random_um: dict[str, float]
    coverage: float
    varied_um: tuple[float, float]


def experiment(seed: int, reading: Reading = THREE_SIGMA, parts: int = PARTS) -> Outcome:
    """One experiment, the published limits read in one of their ways."""
    rng = np.random.default_rng(seed)
    truth = published_process(rng).pattern.grid_mm(GRID, GRID)
    measured = [_part_mm(rng, truth, reading).ravel() for _ in range(parts)]
    apart = [separate(SQUARE, errors, near=NEAR) for errors in measured]
    pattern = pattern_of(apart, [f"S{k + 1}" for k in range(parts)])
    taken = min(TAKEN, parts - 1)
    by = {
        "true": truth,
        "pattern": pattern.mean.grid_mm(GRID, GRID),
        "model": apart[taken].deterministic.grid_mm(GRID, GRID),
        "raw": measured[taken].reshape(len(GRID), len(GRID)),
    }
    after = {way: _part_mm(rng, truth, reading) - by[way] for way in WAYS}
    same = _part_mm(rng, truth, reading)
    random = {way: 1e3 * separate(SQUARE, after[way].ravel(), near=NEAR).sigma_mm for way in WAYS}
    covered = np.abs(by["pattern"] - truth) <= pattern.uncertainty_grid_mm(GRID, GRID)
    return Outcome(
        {way: _worst_um(errors) for way, errors in after.items()},
        {way: _worst_um(same - by[way]) for way in WAYS},
        random,
        float(np.mean(covered)),
        _varied_um(np.array([part.deterministic.grid_mm(GRID, GRID) for part in apart])),
    )


def _part_mm(rng: np.random.Generator, truth_mm: Array, reading: Reading) -> Array:
    """Measured deviations of one new part, as machined without any correction."""
    noise = rng.normal(0.0, reading.noise_mm, truth_mm.shape)
    return np.asarray(truth_mm + reading.variation_mm(rng, truth_mm) + noise)


def _varied_um(models_mm: Array) -> tuple[float, float]:
    smallest, largest = models_mm.min(axis=(1, 2)), models_mm.max(axis=(1, 2))
    return 500.0 * float(np.ptp(smallest)), 500.0 * float(np.ptp(largest))


def _worst_um(errors_mm: Array) -> float:
    return 1e3 * float(np.max(np.abs(errors_mm)))
