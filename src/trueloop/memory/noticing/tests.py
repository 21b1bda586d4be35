"""The tests themselves: how unlikely a part's innovations are, by chance alone.

Innovations e ~ N(0, V) are what n places showed beyond their prediction. Those of level are H δ, H = (sin φ, cos φ):
the generalised least-squares δ explains T = δᵀ(HᵀV⁻¹H)δ of eᵀV⁻¹e, which is χ² with the rank of H; the rest is that of
shape, with what degrees of freedom are left. A correction C of which the share g arrived leaves e = (1 − g) C, as
E = F + C counts it whole.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import chdtrc, ndtr

from trueloop.arrays import Array

SAME_DIRECTION: Final = 1e-3
"""The share of the largest singular value below which a direction is unseen: with all touches on a cylinder nothing is
seen along Z."""


@dataclass(frozen=True)
class White:
    """Innovations and what they are compared with, multiplied by L⁻¹, V = L Lᵀ: independent, with variance 1."""

    error: Array
    lower: Array

    @classmethod
    def of(cls, error: Array, covariance: Array) -> "White":
        """Raises `LinAlgError` where the covariance is not positive definite."""
        lower: Array = np.asarray(np.linalg.cholesky(covariance), np.float64)
        return cls(np.asarray(np.linalg.solve(lower, error), np.float64), lower)

    def seen(self, directions: Array) -> Array:
        """Columns (n, m) as the white innovations see them."""
        return np.asarray(np.linalg.solve(self.lower, directions))


def level_and_shape(white: White, contact_angle_rad: Array) -> tuple[Array, float, float]:
    """Returns (dX, dZ), mm, the shortest for that level; probabilities of level and of shape, 1 where unseen."""
    directions = white.seen(np.column_stack([np.sin(contact_angle_rad), np.cos(contact_angle_rad)]))
    u, sizes, v = np.linalg.svd(directions, full_matrices=False)
    seen = sizes > SAME_DIRECTION * sizes[0]
    along = u.T @ white.error
    level = float(np.sum(along[seen] ** 2))
    rest = float(white.error @ white.error) - level
    shift = v.T @ np.where(seen, along / np.where(seen, sizes, 1.0), 0.0)
    return shift, _chance(level, int(seen.sum())), _chance(rest, len(white.error) - int(seen.sum()))


@dataclass(frozen=True)
class Gain:
    """Share of a correction that arrived, its standard uncertainty, and probabilities: `by_chance` that of such a share
    if all arrived, `rest` that of what it leaves unexplained.
    """

    share: float
    u: float
    by_chance: float
    rest: float


def gain_of(white: White, correction_mm: Array) -> Gain:
    """Estimates the gain by regressing the innovations on the correction."""
    seen = white.seen(correction_mm)
    square, all_chi2, n = float(seen @ seen), float(white.error @ white.error), len(white.error)
    if square == 0:
        return Gain(1.0, float("inf"), 1.0, _chance(all_chi2, n))
    missing, u = float(seen @ white.error) / square, 1 / np.sqrt(square)
    rest = _chance(all_chi2 - (missing / u) ** 2, n - 1)
    return Gain(1 - missing, float(u), float(2 * ndtr(-abs(missing) / u)), rest)


def _chance(chi2: float, degrees: int) -> float:
    return float(chdtrc(degrees, max(chi2, 0.0))) if degrees else 1.0
