"""Constrained least-squares splines in exact or extended arithmetic: the truth that the kernel is measured against.

The clamped B-spline basis by Cox–de Boor's recursion, the Karush–Kuhn–Tucker equations by Gaussian elimination.
`number` is `fractions.Fraction` (exact for every float) or `numpy.longdouble` (64 bits of mantissa).
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Number = Callable[[float], Any]


def basis(x: Any, t: Sequence[Any], degree: int) -> list[Any]:
    """All B-splines of a degree on the full knot sequence at x; the last piece is closed on the right."""
    zero = x - x
    last = max(i for i in range(len(t) - 1) if t[i] < t[i + 1])
    at = max(i for i in range(last + 1) if t[i] < t[i + 1] and t[i] <= x)
    values = [zero + int(i == at) for i in range(len(t) - 1)]
    for p in range(1, degree + 1):
        values = [
            _share(x - t[i], t[i + p] - t[i], values[i])
            + _share(t[i + p + 1] - x, t[i + p + 1] - t[i + 1], values[i + 1])
            for i in range(len(t) - p - 1)
        ]
    return values


def slopes(x: Any, t: Sequence[Any], degree: int) -> list[Any]:
    """Their first derivatives."""
    lower = basis(x, t, degree - 1)
    return [
        degree * (_share(1, t[i + degree] - t[i], lower[i]) - _share(1, t[i + degree + 1] - t[i + 1], lower[i + 1]))
        for i in range(len(t) - degree - 1)
    ]


def coefficients(
    points: Sequence[float],
    values: Sequence[float],
    interior: Sequence[float],
    length: float,
    degree: int,
    ends: tuple[float | None, float | None, float | None, float | None],
    number: Number,
) -> NDArray[Any]:
    """Coefficients that minimize the sum of squares under the end conditions (values and slopes at start and end)."""
    t = [number(k) for k in [0.0] * (degree + 1) + list(interior) + [length] * (degree + 1)]
    A = np.array([basis(number(x), t, degree) for x in points])
    y = np.array([number(v) for v in values])
    rows = [(f, x) for f, x in ((basis, 0.0), (slopes, 0.0), (basis, length), (slopes, length))]
    given = [(f(number(x), t, degree), number(v)) for (f, x), v in zip(rows, ends, strict=True) if v is not None]
    n, m = A.shape[1], len(given)
    system = np.full((n + m, n + m + 1), number(0.0))
    system[:n, :n] = A.T @ A
    system[:n, -1] = A.T @ y
    for k, (row, value) in enumerate(given):
        system[n + k, :n] = system[:n, n + k] = row
        system[n + k, -1] = value
    return _eliminate(system)[:n]


def _eliminate(system: NDArray[Any]) -> NDArray[Any]:
    """Gaussian elimination with partial pivoting on the augmented matrix."""
    n = len(system)
    for k in range(n):
        pivot = k + int(np.argmax(np.abs(system[k:, k])))
        system[[k, pivot]] = system[[pivot, k]]
        factors = system[k + 1 :, k] / system[k, k]
        touched = np.flatnonzero(factors != 0)
        system[k + 1 + touched, k:] -= factors[touched, None] * system[k, k:]
    for k in range(n - 1, -1, -1):
        system[k, -1] = (system[k, -1] - system[k, k + 1 : n] @ system[k + 1 :, -1]) / system[k, k]
    return system[:, -1]


def _share(part: Any, whole: Any, value: Any) -> Any:
    return part * value / whole if whole != 0 else 0 * value
