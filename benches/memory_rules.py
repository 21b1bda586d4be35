"""What memory leaves of a series of one number, beside the rules that a user would correct by instead.

200 series of 30 parts each, cut one after the other under every rule: first with a level that drifts, then in the
simulated shop, with an edge that wears, a machine that warms up and a second edge. The last column is the RMS of the
true errors from the sixth part on, and its ratio to ours; times are of all 200 series.
"""

from collections.abc import Callable

import numpy as np

from benches.ratio import Contender, compare
from scripts.memory_level_study import CHANGED, LEVELS, SEED, SHOPS, judged, levels, of_series, rms_um
from scripts.memory_rules import RIVALS, Maker, Memory, run
from trueloop.simulator.series import draw

SERIES, PARTS = 200, 30
RULES: dict[str, Maker] = {"memory": Memory, **RIVALS}


def main() -> None:
    """Each kind of series, each rule."""
    for name, drift_um, gain in LEVELS:
        level, scatter = levels(SERIES, PARTS, drift_um)
        both(f"a level, {name}", {rule: loop(make, level, scatter, gain, None) for rule, make in RULES.items()})
    for name, shop in SHOPS:
        error, noise = of_series([draw(shop, np.random.default_rng(SEED + k)) for k in range(SERIES)])
        both(f"the shop: {name}", {rule: loop(make, error, noise, shop.gain, CHANGED) for rule, make in RULES.items()})


def both(title: str, loops: dict[str, Callable[[], np.ndarray]]) -> None:
    """Errors left as a note, times by rounds."""
    left = {rule: rms_um(judged(loop())) for rule, loop in loops.items()}
    notes = {rule: f"{um:.2f} µm, {um / left['memory']:.2f} ×" for rule, um in left.items()}
    compare(title, [Contender(rule, loops[rule], notes[rule]) for rule in loops], rounds=3, note_heading="RMS left")


def loop(
    make: Maker, error: np.ndarray, noise: np.ndarray, gain: float, set_at: int | None
) -> Callable[[], np.ndarray]:
    """All series under a rule."""
    return lambda: run(make(SERIES), error, noise, gain, set_at)


if __name__ == "__main__":
    main()
