"""Series of one number under memory and its rivals: the tables of `studies.memory_study`."""

from typing import Final

import numpy as np

from scripts.memory_rules import RIVALS, Maker, Memory, averaging, known_gain, run
from trueloop.arrays import Array
from trueloop.memory.level.kalman import TURNING
from trueloop.units import UM_PER_MM
from trueloop_lab.simulator.series import Series, Shop, draw

SERIES: Final = 200
SEED: Final = 530_000
"""No choice in the code was made with these seeds or any above them."""
SCATTER_UM: Final = 3.0
LEVELS: Final = (
    ("right", 0.5, 1.0),
    ("acts 2.2 ×", 0.5, 2.2),
    ("acts 0.5 ×", 0.5, 0.5),
    ("drift 0.1", 0.1, 1.0),
    ("drift 2", 2.0, 1.0),
)
"""Name, drift in µm a part, gain of the actuator."""
CHANGED: Final = 15
ONE: Final = np.array([np.pi / 2])
SHOPS: Final = (
    ("wear, warming, a second edge from the 16th part on", Shop(angle_rad=ONE, changed_at=CHANGED)),
    ("the same, wear three times as fast", Shop(angle_rad=ONE, changed_at=CHANGED, wear_mm=0.018)),
    ("the same, no warming", Shop(angle_rad=ONE, changed_at=CHANGED, warming_mm=0.0)),
    ("the same, acts 2.2 ×", Shop(angle_rad=ONE, changed_at=CHANGED, gain=2.2)),
    ("the same, noise of t₄", Shop(angle_rad=ONE, changed_at=CHANGED, heavy_tails=True)),
)
WEIGHTS: Final = np.arange(0.05, 1.01, 0.05)


def rms_um(values: Array) -> float:
    """Root mean square, in µm."""
    return float(UM_PER_MM * np.sqrt(np.mean(values**2)))


def local_levels(series: int = SERIES, parts: int = 100) -> str:
    """Rivals and memory on series whose level moves as the model says: errors without what scatters."""
    names = ["best gain, known beforehand", "memory", *RIVALS]
    cells: dict[str, list[str]] = {name: [] for name in names}
    found = []
    for name, drift, gain in LEVELS:
        level, scatter = levels(series, parts, drift)
        makers: dict[str, Maker] = {
            names[0]: known_gain(SCATTER_UM / UM_PER_MM, drift / UM_PER_MM, gain, TURNING.setting_mm),
            **RIVALS,
        }
        memory = Memory(series)
        left = {"memory": run(memory, level, scatter, gain)}
        left |= {of: run(make(series), level, scatter, gain) for of, make in makers.items()}
        for of in names:
            early, once, late = (left[of][:, a:b] for a, b in ((1, 11), (5, 30), (30, parts)))
            cells[of].append(f"{rms_um(early):.1f} / {rms_um(once):.2f} / {rms_um(late):.2f}")
        ours, best = (rms_um(left[of][:, 5:30]) for of in ("memory", names[0]))
        inspected, z = np.hypot(ours, SCATTER_UM) / np.hypot(best, SCATTER_UM) - 1, np.array(memory.z)
        found.append(
            f"| {name} | {_percent(inspected)} | {_percent(ours / best - 1)} | {_inside(z[5:30])} | {_inside(z[1:5])} |"
        )
    heads = " | ".join(name for name, _, _ in LEVELS)
    rows = [f"| {of} | {' | '.join(cells[of])} |" for of in names]
    return "\n".join(
        [f"| | {heads} |", f"|---|{'---:|' * len(LEVELS)}", *rows, "", *_found_head("| series |"), *found, ""]
    )


def shops(series: int = SERIES) -> str:
    """The same in the simulated shop, where nothing moves as the model says: errors of the parts as they are."""
    names = ["best constant gain, in hindsight", "memory", *RIVALS]
    rows: dict[str, list[str]] = {name: [] for name in names}
    found = []
    for number, (name, shop) in enumerate(SHOPS):
        drawn = [draw(shop, np.random.default_rng(SEED + 1000 * number + k)) for k in range(series)]
        error, noise = of_series(drawn)
        memory = Memory(series)
        left = {"memory": run(memory, error, noise, shop.gain, CHANGED)}
        left |= {of: run(make(series), error, noise, shop.gain, CHANGED) for of, make in RIVALS.items()}
        hindsight = {w: run(averaging(w)(series), error, noise, shop.gain, CHANGED) for w in WEIGHTS / shop.gain}
        best = min(hindsight, key=lambda w: rms_um(judged(hindsight[w])))
        left[names[0]] = hindsight[best]
        for of in names:
            rows[of].append(f"{rms_um(judged(left[of])):.2f}")
        z = np.array(memory.z)[[k for k in range(5, 30) if not CHANGED <= k < CHANGED + 5]]
        share = rms_um(judged(left["memory"])) / rms_um(judged(left[names[0]])) - 1
        found.append(f"| {name} | {best * shop.gain:.2f} | {_percent(share)} | {_inside(z)} |")
    heads = " | ".join(name for name, _ in SHOPS)
    table = [f"| {of} | {' | '.join(rows[of])} |" for of in names]
    head = ["", "| series | best gain | memory leaves more by | inside 95 % |", "|---|---:|---:|---:|"]
    return "\n".join([f"| | {heads} |", f"|---|{'---:|' * len(SHOPS)}", *table, *head, *found, ""])


def judged(left: Array) -> Array:
    """Parts 6 to 30, without the first five of the second edge."""
    return np.concatenate([left[:, 5:CHANGED], left[:, CHANGED + 5 :]], axis=1)


def levels(series: int, parts: int, drift_um: float) -> tuple[Array, Array]:
    """Levels (series, parts) that walk by chance from where the tool was set, and the scatter of parts about them."""
    rng = np.random.default_rng(SEED)
    steps = drift_um * rng.normal(size=(series, parts)) / UM_PER_MM
    level = TURNING.setting_mm * rng.normal(size=(series, 1)) + np.cumsum(steps, axis=1)
    return level, SCATTER_UM * rng.normal(size=(series, parts)) / UM_PER_MM


def of_series(drawn: list[Series]) -> tuple[Array, Array]:
    """Errors uncorrected and noise of their inspection (series, parts), at the first place."""
    return np.array([s.uncorrected_mm[:, 0] for s in drawn]), np.array([s.noise_mm[:, 0] for s in drawn])


def _found_head(first: str) -> list[str]:
    head = f"{first} memory leaves more, as inspected | level alone | inside 95 %, parts 6–30 | parts 2–5 |"
    return [head, "|---|---:|---:|---:|---:|"]


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _inside(z: Array) -> str:
    return _percent(float(np.mean(np.abs(z) < 1.96)))
