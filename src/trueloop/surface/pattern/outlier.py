"""A part that does not belong: its surface differs from the mean of the others by more than parts differ."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.surface.separation.spline_surface import SplineSurface

LEAST_OTHERS = 3
"""Fewer do not determine how much parts differ."""
PLACES = 31
"""Places a side that parts are compared at: closer together than control points, of which a pattern has hardly 25."""


@dataclass(frozen=True)
class Outlier:
    """A part with its root mean square distance from the mean of the others, how many times that of the others it is,
    and the probability of so much by chance, among so many parts.
    """

    name: str
    off_mm: float
    times: float
    p_value: float


def on_square(models: Sequence[SplineSurface]) -> Array:
    """Values of splines on a square of places, (s, n)."""
    at = np.linspace(0.0, 1.0, PLACES)
    return np.stack([model.grid_mm(at, at).ravel() for model in models])


def outliers(stack: Array, names: Sequence[str], confidence: float = 0.99) -> tuple[Outlier, ...]:
    """Parts that stand out, each judged against the others.

    The squared distance of a part from the mean of the others, over the variance among those, follows F with ν and
    (s − 2) ν degrees of freedom, where ν counts the independent shapes in which parts differ (Satterthwaite, from the
    eigenvalues of their differences). The limit is shared among the s parts (Bonferroni). `stack`: (s, n), as
    `on_square` has it.
    """
    found = [_judged(stack, k, names[k], len(stack)) for k in range(len(stack))] if len(stack) > LEAST_OTHERS else []
    return tuple(odd for odd in found if odd.p_value < 1.0 - confidence)


def last_judged(stack: Array, name: str) -> Outlier | None:
    """The last part against those before it, by the same test, of one part; None where fewer than three are before."""
    return _judged(stack, len(stack) - 1, name, 1) if len(stack) > LEAST_OTHERS else None


def _judged(stack: Array, k: int, name: str, tests: int) -> Outlier:
    from scipy.special import fdtrc  # slow to import

    others = np.delete(stack, k, axis=0)
    s = len(others)
    differences = others - np.mean(others, axis=0)
    gram = differences @ differences.T / stack.shape[1]
    variance = float(np.trace(gram)) / (s - 1)
    off = float(np.mean((stack[k] - np.mean(others, axis=0)) ** 2))
    if variance <= 0.0:
        return Outlier(name, off**0.5, float("inf") if off else 1.0, 0.0 if off else 1.0)
    shapes = shapes_of(gram, s - 1)
    ratio = off / (variance * (1 + 1 / s))
    return Outlier(name, off**0.5, ratio**0.5, min(1.0, tests * float(fdtrc(shapes, (s - 1) * shapes, ratio))))


def shapes_of(gram: Array, freedom: int) -> float:
    """ν = (tr Σ)²/tr Σ², with the bias of tr S² from few parts taken off: E tr S² = (1 + 1/f) tr Σ² + (tr Σ)²/f.

    Few parts tell ν badly, and too large a ν cries wolf: it is lowered by 1 + 4/f, which keeps false alarms at one to
    two in a hundred patterns of 5 to 10 parts, for differences of few shapes or many (simulated in the tests).
    """
    trace, square = float(np.trace(gram)) / freedom, float(np.sum(gram**2)) / freedom**2
    unbiased = freedom**2 / ((freedom - 1) * (freedom + 2)) * (square - trace**2 / freedom)
    many = trace**2 / unbiased if unbiased > 1e-4 * trace**2 else 1e4
    return float(max(1.0, many / (1 + 4 / freedom)))
