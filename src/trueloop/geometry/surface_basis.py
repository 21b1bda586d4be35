"""B-spline basis functions of one direction at many places at once, with first and second derivatives."""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array


@dataclass(frozen=True, eq=False)
class BasisRows:
    """At each of n places: index of the first function that differs from zero (n,), and values and first and second
    derivatives of the degree + 1 functions from there on, each (n, degree + 1).
    """

    first: np.ndarray
    values: Array
    slopes: Array
    bends: Array


def basis_rows(knots: Array, degree: int, at: Array) -> BasisRows:
    """Basis functions on a clamped knot vector by the recursion of Cox and de Boor.

    Places outside the knots are those of the nearest end piece continued. Derivatives are differences of the functions
    a degree lower: B′ = p (B₍ᵢ,ₚ₋₁₎/(tᵢ₊ₚ − tᵢ) − B₍ᵢ₊₁,ₚ₋₁₎/(tᵢ₊ₚ₊₁ − tᵢ₊₁)).
    """
    count = len(knots) - degree - 1
    span = np.clip(np.searchsorted(knots, at, side="right") - 1, degree, count - 1)
    while np.any(empty := (knots[span + 1] <= knots[span]) & (span > degree)):
        span = np.where(empty, span - 1, span)
    levels = [np.ones((len(at), 1))]
    for level in range(1, degree + 1):
        levels.append(_raised(levels[-1], knots, span, level, at))
    none = np.zeros((len(at), degree + 1))
    slopes = _derived(levels[degree - 1], knots, span, degree) if degree >= 1 else none
    lower = _derived(levels[degree - 2], knots, span, degree - 1) if degree >= 2 else None
    bends = none if lower is None else _derived(lower, knots, span, degree)
    return BasisRows(span - degree, levels[degree], slopes, bends)


def basis_matrix(knots: Array, degree: int, at: Array) -> Array:
    """Returns the values as a matrix (n, functions)."""
    rows = basis_rows(knots, degree, at)
    matrix = np.zeros((len(at), len(knots) - degree - 1))
    np.put_along_axis(matrix, rows.first[:, None] + np.arange(degree + 1), rows.values, axis=1)
    return matrix


def clamped_knots(count: int, degree: int) -> Array:
    """Knots on [0, 1], evenly spaced within, for so many functions."""
    inner = np.linspace(0.0, 1.0, count - degree + 1)[1:-1]
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def _raised(lower: Array, knots: Array, span: np.ndarray, level: int, at: Array) -> Array:
    """Functions of degree `level` on a piece from those of the degree below."""
    raised = np.zeros((len(at), level + 1))
    for k in range(level):
        left, right = knots[span - level + 1 + k], knots[span + 1 + k]
        share = lower[:, k] / (right - left)
        raised[:, k] += (right - at) * share
        raised[:, k + 1] += (at - left) * share
    return raised


def _derived(lower: Array, knots: Array, span: np.ndarray, degree: int) -> Array:
    """Derivatives of the functions of `degree` from the functions, or their derivatives, of the degree below."""
    derived = np.zeros((len(span), degree + 1))
    for k in range(degree):
        share = degree * lower[:, k] / (knots[span + 1 + k] - knots[span - degree + 1 + k])
        derived[:, k] -= share
        derived[:, k + 1] += share
    return derived
