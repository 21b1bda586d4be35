"""What memory leaves of a series of one number, beside the rules that a user would correct by instead.

200 series of 30 parts each, cut one after the other under every rule: first with a level that drifts, then in the
simulated shop, with an edge that wears, a machine that warms up and a second edge. Errors are the RMS of the true ones
from the sixth part on; times are those of all series.
"""

from collections.abc import Callable

import numpy as np

from benches.ratio import Contender, compare
from scripts.memory_rules import RIVALS, Maker, Memory, run
from studies.memory_level_study import CHANGED, LEVELS, SEED, SHOPS, judged, levels, of_series, rms_um
from trueloop_lab.simulator.series import draw

SERIES, PARTS = 200, 30
RULES: dict[str, Maker] = {"memory": Memory, **RIVALS}


def main() -> None:
    """Each kind of series, each rule; times of the first kind."""
    found: dict[str, dict[str, float]] = {}
    timed: dict[str, Callable[[], np.ndarray]] = {}
    for name, drift_um, gain in LEVELS:
        level, scatter = levels(SERIES, PARTS, drift_um)
        loops = {rule: loop(make, level, scatter, gain, None) for rule, make in RULES.items()}
        timed = timed or loops
        found[f"level: {name}"] = left_um(loops)
    for name, shop in SHOPS:
        error, noise = of_series([draw(shop, np.random.default_rng(SEED + k)) for k in range(SERIES)])
        loops = {rule: loop(make, error, noise, shop.gain, CHANGED) for rule, make in RULES.items()}
        found[f"shop: {name}"] = left_um(loops)
    print(f"\n### Errors left, as multiples of ours\n\n| | ours | {' | '.join(RIVALS)} |\n|---|{'---:|' * len(RULES)}")
    for name, left in found.items():
        ratios = " | ".join(f"{left[rule] / left['memory']:.2f}" for rule in RIVALS)
        print(f"| {name} | {left['memory']:.2f} µm | {ratios} |")
    compare(f"{SERIES} series of {PARTS} parts", [Contender(rule, run) for rule, run in timed.items()], rounds=3)


def left_um(loops: dict[str, Callable[[], np.ndarray]]) -> dict[str, float]:
    """RMS of what each rule leaves."""
    return {rule: rms_um(judged(loop())) for rule, loop in loops.items()}


def loop(
    make: Maker, error: np.ndarray, noise: np.ndarray, gain: float, set_at: int | None
) -> Callable[[], np.ndarray]:
    """All series under a rule."""
    return lambda: run(make(SERIES), error, noise, gain, set_at)


if __name__ == "__main__":
    main()
