"""Linear least squares in which outliers count less: Huber's weights, with the covariance that they leave."""

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array

HUBER = 1.345
"""Bound of Huber's weights in standard deviations: 95 % efficiency on clean normal data (Huber 1964)."""

OUTLIER = 4.0
"""A reading further off than this many standard deviations is named as an outlier."""

ROUNDS = 50


def robust_solution(rows: Array, values: Array, robust: bool) -> tuple[Array, Array, float, Array, NDArray[np.bool_]]:
    """(solution, covariance, scatter, weights, outliers) of rows · solution ≈ values; weights are 1 if not `robust`.

    One QR; weights then change normal equations in its orthonormal columns, which are well conditioned, by the rows
    beyond Huber's bound alone.
    """
    scale = np.linalg.norm(rows, axis=0)
    q, r = np.linalg.qr(rows / scale)
    inverse: Array = np.linalg.inv(r) / scale[:, None]
    solution = np.asarray(q.T @ values, dtype=np.float64)
    share = np.ones(len(values))
    for _ in range(ROUNDS if robust else 0):
        rest = values - q @ solution
        spread = _spread(rest, q.shape[1])
        if spread <= 1e-12 * np.abs(values).max(initial=0.0):
            break
        share = np.minimum(1.0, HUBER * spread / np.maximum(np.abs(rest), 1e-300))
        better = _reweighted(q, values, share)
        settled = np.abs(better - solution).max() <= 1e-10 * np.abs(better).max()
        solution = better
        if settled:
            break
    rest = values - q @ solution
    scatter = _scatter(rest, share, q.shape[1])
    covariance = scatter**2 * inverse @ inverse.T
    spread = _spread(rest, q.shape[1]) if robust else scatter
    outlier = np.abs(rest) > OUTLIER * spread if spread > 0 else np.zeros(len(rest), dtype=bool)
    return inverse @ solution, covariance, scatter, share, outlier


def _reweighted(q: Array, values: Array, share: Array) -> Array:
    """Weighted least squares in orthonormal columns: QᵀWQ = I − Σ (1 − w) q qᵀ over the rows with w < 1."""
    less = share < 1.0
    part = q[less] * np.sqrt(1.0 - share[less])[:, None]
    normal = np.eye(q.shape[1]) - part.T @ part
    return np.asarray(np.linalg.solve(normal, q.T @ (share * values)), dtype=np.float64)


def least_squares(rows: Array, values: Array) -> Array:
    """Solution of rows · solution ≈ values, by QR."""
    q, r = np.linalg.qr(rows)
    solution: Array = np.linalg.solve(r, q.T @ values)
    return solution


def _spread(rest: Array, parameters: int) -> float:
    """Standard deviation from the median absolute residual, which outliers do not move; exact for normal residuals.

    A fit with p parameters to n readings makes residuals smaller by √(1 − p/n).
    """
    return float(np.median(np.abs(rest)) / 0.6745 / np.sqrt(1 - parameters / len(rest)))


def _scatter(rest: Array, share: Array, parameters: int) -> float:
    """Standard deviation of unit weight. With Huber's weights: K √(Σψ²/(n−p)) / m,

    K = 1 + (p/n)(1−m)/m, m = mean ψ′ [Huber 1981 §7.6].
    """
    freedom = len(rest) - parameters
    inside = float(np.mean(share >= 1.0))
    if inside == 1.0:
        return float(np.sqrt(np.sum(rest**2) / freedom))
    correction = 1 + parameters / len(rest) * (1 - inside) / inside
    return float(correction * np.sqrt(np.sum((share * rest) ** 2) / freedom) / inside)
