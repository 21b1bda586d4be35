"""The published experiment [MPM §8] on a simulated process, and what it gives over many seeds.

Ten parts are measured; one part each is cut after correction by the pattern, by one part's deterministic model, by that
part's raw data. `python -m tests.support.pattern_experiment` prints the figures that docs/surface.md tells.
"""

from dataclasses import dataclass

import numpy as np

from tests.support.surfaces import GRID, NEAR, SQUARE
from trueloop.error_surface.pattern import pattern_of
from trueloop.error_surface.separate import separate
from trueloop.simulator.surface_process import published_process

PARTS, TAKEN = 10, 3
"""Ten parts; the fourth (S4) gives the single model and the raw data."""


@dataclass(frozen=True)
class Outcome:
    """Worst deviations in µm of the three new parts, scatter of their random parts, and of MPM's deterministic part."""

    worst_um: dict[str, float]
    random_um: dict[str, float]
    coverage: float

    @property
    def in_order(self) -> bool:
        """MPM best, raw data worst."""
        return self.worst_um["pattern"] < self.worst_um["model"] < self.worst_um["raw"]


def experiment(seed: int) -> Outcome:
    rng = np.random.default_rng(seed)
    process = published_process(rng)
    measured = [process.part_mm(rng, GRID, GRID).ravel() for _ in range(PARTS)]
    parts = [separate(SQUARE, errors, near=NEAR) for errors in measured]
    pattern = pattern_of(parts, [f"S{k + 1}" for k in range(PARTS)])
    corrections = {
        "pattern": pattern.mean.grid_mm(GRID, GRID),
        "model": parts[TAKEN].deterministic.grid_mm(GRID, GRID),
        "raw": measured[TAKEN].reshape(25, 25),
    }
    after = {name: process.part_mm(rng, GRID, GRID, by) for name, by in corrections.items()}
    off = np.abs(corrections["pattern"] - process.pattern.grid_mm(GRID, GRID))
    return Outcome(
        {name: 1e3 * float(np.max(np.abs(errors))) for name, errors in after.items()},
        {name: 1e3 * separate(SQUARE, errors.ravel(), near=NEAR).sigma_mm for name, errors in after.items()},
        float(np.mean(off <= pattern.uncertainty_grid_mm(GRID, GRID))),
    )


def main(first_seed: int = 1000, seeds: int = 100) -> None:
    outcomes = [experiment(first_seed + k) for k in range(seeds)]
    for name in ("pattern", "model", "raw"):
        worst = np.array([o.worst_um[name] for o in outcomes])
        scatter = np.mean([o.random_um[name] for o in outcomes])
        print(f"{name}: worst median {np.median(worst):.2f} µm, 90 % below {np.quantile(worst, 0.9):.2f}, within 8 µm "
              f"{np.mean(worst <= 8):.0%}, random part {scatter:.2f} µm")  # fmt: skip
    first = [min(o.worst_um, key=lambda name: o.worst_um[name]) for o in outcomes]
    print(f"order holds in {np.mean([o.in_order for o in outcomes]):.0%}; pattern best in "
          f"{np.mean([f == 'pattern' for f in first]):.0%}; raw worst in "
          f"{np.mean([max(o.worst_um, key=lambda n: o.worst_um[n]) == 'raw' for o in outcomes]):.0%}; "
          f"coverage {np.mean([o.coverage for o in outcomes]):.3f}")  # fmt: skip


if __name__ == "__main__":
    main()
