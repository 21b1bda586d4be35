"""Patterns that repeats follow beside their scatter: nothing, a drift, a step, a warm-up."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array

SETTLING: Final = (0.1, 0.15, 0.2, 0.25, 0.3)
"""Time constants of a warm-up that are tried, of the whole time: longer ones are a drift."""
SETTLED: Final = 3.0
"""Time constants after which 95 % of a warm-up is over."""


@dataclass(frozen=True)
class Pattern:
    """A pattern by least squares: `change_mm` is its size, `scatter_mm` one reading's about it, of `spare` residuals.

    `scatter_mm` is what the residuals have, `change_u_mm` follows from that or from what is expected, if that is more.
    `weight` is the logarithm of its likelihood with ½ ln n taken off a parameter, and ln of the number of places or
    time constants that were tried. `at`: the first reading of a step.
    """

    name: str
    change_mm: float
    change_u_mm: float
    scatter_mm: float
    spare: int
    weight: float
    at: int = 0
    settles_after: float | None = None


def best_pattern(values: Array, expected_mm: float) -> Pattern:
    """The likeliest pattern of readings (n,) in order of time; `expected_mm` is what they scatter by at least."""
    return max(_patterns(values, expected_mm), key=lambda pattern: pattern.weight)


def step_terms(values: Array) -> tuple[Array, Array]:
    """Of a step at each place 1 … n − 1: mean behind less mean before, and its uncertainty for readings of u = 1."""
    n = len(values)
    before = np.arange(1, n)
    sums = np.cumsum(values)[:-1]
    change = (values.sum() - sums) / (n - before) - sums / before
    return change, np.sqrt(1.0 / before + 1.0 / (n - before))


def _patterns(values: Array, expected_mm: float) -> Iterator[Pattern]:
    i = np.arange(len(values), dtype=np.float64)
    last = i[-1]
    yield _fit("constant", values, expected_mm, None, 1)
    yield _fit("drift", values, expected_mm, i / last, 2)
    for k in range(1, len(values)):
        yield _fit("step", values, expected_mm, (i >= k).astype(np.float64), 3, len(values) - 1, at=k)
    for share in SETTLING:
        constant = share * last
        shape = 1.0 - np.exp(-i / constant)
        yield _fit("warm-up", values, expected_mm, shape, 3, len(SETTLING), settles_after=SETTLED * constant)


def _fit(
    name: str,
    values: Array,
    expected_mm: float,
    shape: Array | None,
    parameters: int,
    tried: int = 1,
    at: int = 0,
    settles_after: float | None = None,
) -> Pattern:
    """A constant and a shape by least squares."""
    n = len(values)
    residual, change, shape_squares = values - values.mean(), 0.0, np.inf
    if shape is not None:
        centred = shape - shape.mean()
        shape_squares = float(centred @ centred)
        change = float(centred @ values) / shape_squares
        residual = residual - change * centred
    squares, spare = float(residual @ residual), n - parameters
    variance = max(squares / n, expected_mm**2)
    weight = -0.5 * (n * np.log(variance) + squares / variance + parameters * np.log(n)) - np.log(tried)
    scatter = float(np.sqrt(squares / spare))
    change_u = max(scatter, expected_mm) / np.sqrt(shape_squares)
    return Pattern(name, change, float(change_u), scatter, spare, float(weight), at, settles_after)
