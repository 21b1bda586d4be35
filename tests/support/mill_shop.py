"""A milling shop written apart from `trueloop.milled`: it cuts a plate by geometry, and measures what came out.

It knows circles, widths and heights; no normals, no errors of surfaces, no state.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading

BORES = {
    f"B{k}": (x, y, 12.0 + 2.0 * k, 20.0)
    for k, (x, y) in enumerate([(-50, -30), (0, -30), (50, -30), (-50, 30), (0, 30), (50, 30)])
}
BOSSES = {"S0": (-25.0, 0.0, 16.0, 10.0), "S1": (25.0, 0.0, 16.0, 10.0)}
PLANES = {"top": 0.0, "step": -8.0, "floor": -15.0}
ROUGH_TOOL, FINE_TOOL = 1, 2
"""The planes and the bosses are cut with the first, the bores with the second, both from G54."""


@dataclass
class Mill:
    """A machining centre with its errors: mm and rad. `entered` are the numbers at its control."""

    radius: dict[int, float] = field(default_factory=lambda: {1: 0.0, 2: 0.0})  # how much larger a tool is than set
    length: dict[int, float] = field(default_factory=lambda: {1: 0.0, 2: 0.0})
    zero: tuple[float, float, float] = (0.0, 0.0, 0.0)  # how far the work offset is from the datums
    turn: float = 0.0
    bend: float = 0.0  # the fine tool's tip stays away from the wall by so much at the bore's end
    scatter: float = 0.0
    clamped: float = 0.0  # how far a part lies off from clamping to clamping
    uneven: float = 0.0  # how far each feature is off on every part
    fine_floor: bool = False  # the floor is cut with the fine tool
    seed: int = 0
    entered: dict[str, float] = field(default_factory=dict)  # "radius 1", "length 2", "x", "y", "z", "turn"

    def cut(self, rng: np.random.Generator) -> dict[str, tuple[float, ...]]:
        """Returns the true x, y, diameter at the middle of the depth, or z, of each feature."""
        said = self.entered.get
        own_of = np.random.default_rng(self.seed)
        lies = rng.normal(0.0, self.clamped, 3) if self.clamped else np.zeros(3)
        turn = self.turn + said("turn", 0.0)
        made: dict[str, tuple[float, ...]] = {}

        def own() -> float:
            return float(rng.normal(0.0, self.scatter))

        def always() -> float:
            return float(own_of.normal(0.0, self.uneven)) if self.uneven else 0.0

        def place(x: float, y: float) -> tuple[float, float]:
            dx, dy = self.zero[0] + said("x", 0.0), self.zero[1] + said("y", 0.0)
            return (
                x * math.cos(turn) - y * math.sin(turn) + dx + own() + always() + lies[0],
                x * math.sin(turn) + y * math.cos(turn) + dy + own() + always() + lies[1],
            )

        for name, (x, y, diameter, _) in BORES.items():
            # the centre of the tool runs on a circle smaller than the bore by the radius that the control believes
            path = diameter / 2.0 - (8.0 / 2.0 + said("radius 2", 0.0))
            made[name] = (*place(x, y), 2.0 * (path + 4.0 + self.radius[2] - self.bend / 2.0) + own() + always())
        for name, (u, v, across, _) in BOSSES.items():
            path = across / 2.0 + (10.0 + said("radius 1", 0.0))
            made[name] = (*place(u, v), 2.0 * (path - 10.0 - self.radius[1]) + own() + always())
        for name, height in PLANES.items():
            tool = FINE_TOOL if name == "floor" and self.fine_floor else ROUGH_TOOL
            made[name] = (
                height
                - self.length[tool]
                + said(f"length {tool}", 0.0)
                + self.zero[2]
                + said("z", 0.0)
                + own()
                + always()
                + lies[2],
            )
        return made

    def measured(self, rng: np.random.Generator, noise: float = 0.0) -> list[Reading]:
        """Returns what a measuring machine reports of a part cut now, in the frame of the datums."""
        found = list[Reading]()
        for name, values in self.cut(rng).items():
            seen = [float(value + rng.normal(0.0, noise)) for value in values]
            if len(seen) == 1:
                found.append(
                    Reading(
                        f"{name}.z",
                        Quantity.POSITION,
                        seen[0],
                        PLANES[name],
                        PLANES[name] - 0.02,
                        PLANES[name] + 0.02,
                        name,
                        axis="z",
                    )
                )
                continue
            x, y, diameter, _ = {**BORES, **BOSSES}[name]
            found.append(Reading(f"{name}.x", Quantity.POSITION, seen[0], x, x - 0.02, x + 0.02, name, axis="x"))
            found.append(Reading(f"{name}.y", Quantity.POSITION, seen[1], y, y - 0.02, y + 0.02, name, axis="y"))
            found.append(
                Reading(f"{name}.d", Quantity.DIAMETER, seen[2], diameter, diameter - 0.01, diameter + 0.01, name)
            )
        return found
