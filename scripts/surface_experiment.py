"""The published experiment [MPM §8] on a simulated process.

Ten parts are measured; one new part each is cut after correction by the pattern, by one part's deterministic model, by
that part's raw data. What no laboratory can do stands beside: correction by the true pattern, the best there is, and
the very same new part corrected in each way, which leaves out the luck of having got another part.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from scripts.surface_truths import GRID, NEAR, SQUARE
from trueloop.error_surface.pattern import pattern_of
from trueloop.error_surface.separate import separate
from trueloop.geometry.feature import Array
from trueloop.simulator.surface_process import published_process

PARTS: Final = 10
TAKEN: Final = 3
"""The fourth part (S4) gives the single model and the raw data."""
WAYS: Final = ("true", "pattern", "model", "raw")


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


def experiment(seed: int, sigmas: float = 3.0, parts: int = PARTS) -> Outcome:
    """One experiment; `sigmas`: how many standard deviations the published limits between parts are read as."""
    rng = np.random.default_rng(seed)
    process = published_process(rng)
    wider = 3.0 / sigmas
    process = replace(process, least_mm=process.least_mm * wider, most_mm=process.most_mm * wider)
    measured = [process.part_mm(rng, GRID, GRID).ravel() for _ in range(parts)]
    apart = [separate(SQUARE, errors, near=NEAR) for errors in measured]
    pattern = pattern_of(apart, [f"S{k + 1}" for k in range(parts)])
    truth = process.pattern.grid_mm(GRID, GRID)
    taken = min(TAKEN, parts - 1)
    by = {
        "true": truth,
        "pattern": pattern.mean.grid_mm(GRID, GRID),
        "model": apart[taken].deterministic.grid_mm(GRID, GRID),
        "raw": measured[taken].reshape(len(GRID), len(GRID)),
    }
    after = {way: process.part_mm(rng, GRID, GRID, by[way]) for way in WAYS}
    same = process.part_mm(rng, GRID, GRID)
    random = {way: 1e3 * separate(SQUARE, after[way].ravel(), near=NEAR).sigma_mm for way in WAYS}
    covered = np.abs(by["pattern"] - truth) <= pattern.uncertainty_grid_mm(GRID, GRID)
    return Outcome(
        {way: _worst_um(errors) for way, errors in after.items()},
        {way: _worst_um(same - by[way]) for way in WAYS},
        random,
        float(np.mean(covered)),
        _varied_um(np.array([part.deterministic.grid_mm(GRID, GRID) for part in apart])),
    )


def _varied_um(models_mm: Array) -> tuple[float, float]:
    smallest, largest = models_mm.min(axis=(1, 2)), models_mm.max(axis=(1, 2))
    return 500.0 * float(np.ptp(smallest)), 500.0 * float(np.ptp(largest))


def _worst_um(errors_mm: Array) -> float:
    return 1e3 * float(np.max(np.abs(errors_mm)))
