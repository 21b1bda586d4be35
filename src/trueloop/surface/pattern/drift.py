"""A pattern that changes from part to part: a trend over the parts in the order in which they were cut."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.surface.pattern.outlier import PLACES, shapes_of
from trueloop.surface.separation.spline_surface import SplineSurface

LEAST_PARTS = 5
"""Fewer do not tell a trend from how parts differ."""


@dataclass(frozen=True)
class Drift:
    """How much the pattern changes a part, root mean square over the surface, and the probability of that by chance."""

    per_part_mm: float
    p_value: float


def drift_of(models: Sequence[SplineSurface]) -> Drift | None:
    """The trend b of s parts' models m_k in cutting order, m_k = m̄ + b·(k − k̄); None for fewer than five parts.

    By least squares b = Σ(k − k̄) m_k / Σ(k − k̄)². Its mean square times Σ(k − k̄)², over the variance of what it leaves,
    follows F with ν and (s − 2) ν degrees of freedom where nothing changes; ν counts the shapes in which parts differ,
    as for outlying parts (`outlier`). A single outlying part near either end looks like a trend: leave it out first.
    """
    from scipy.special import fdtrc  # slow to import

    s = len(models)
    if s < LEAST_PARTS:
        return None
    at = np.linspace(0.0, 1.0, PLACES)
    stack = np.stack([model.grid_mm(at, at).ravel() for model in models])
    off = stack - np.mean(stack, axis=0)
    order = np.arange(s) - (s - 1) / 2
    squares = float(order @ order)
    trend = order @ off / squares
    left = off - np.outer(order, trend)
    gram = left @ left.T / stack.shape[1]
    variance, changed = float(np.trace(gram)) / (s - 2), float(np.mean(trend**2)) * squares
    if variance <= 0.0:
        return Drift(float(np.sqrt(np.mean(trend**2))), 0.0 if changed > 0.0 else 1.0)
    shapes = shapes_of(gram, s - 2)
    p_value = float(fdtrc(shapes, (s - 2) * shapes, changed / variance))
    return Drift(float(np.sqrt(np.mean(trend**2))), p_value)
