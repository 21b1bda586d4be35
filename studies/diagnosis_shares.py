"""Shares of trials with their intervals, and tables of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

Z95: Final = 1.959964


@dataclass(frozen=True)
class Share:
    """`good` of `trials`."""

    good: int
    trials: int

    @property
    def value(self) -> float:
        """The share itself."""
        return self.good / max(self.trials, 1)

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval of Wilson's score."""
        n, z = max(self.trials, 1), Z95
        middle = (self.value + z**2 / (2 * n)) / (1 + z**2 / n)
        half = z * np.sqrt(self.value * (1 - self.value) / n + z**2 / (4 * n**2)) / (1 + z**2 / n)
        return float(max(middle - half, 0.0)), float(min(middle + half, 1.0))

    def __str__(self) -> str:
        low, high = self.interval
        return f"{100 * self.value:.1f} % ({100 * low:.1f}…{100 * high:.1f}, n = {self.trials})"


def share(trials: Sequence[bool]) -> Share:
    """Of what was right."""
    return Share(sum(trials), len(trials))


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """In Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in lines)
