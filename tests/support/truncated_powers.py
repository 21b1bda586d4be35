"""The spline of [6517 §4] as the report writes it: truncated powers, generalized inverses, compaction. Slow, readable.

x: points, t: interior knots, (a, b): the interval; c: coefficients of 1, x, x², x³, (x − t₁)³₊ … [Eq. 2].
"""

import numpy as np

from trueloop.arrays import Array


def design(x: Array, t: Array) -> Array:
    """A [Eq. 9]."""
    powers = x[:, None] ** np.arange(4)
    truncated = np.maximum(x[:, None] - t, 0.0) ** 3
    return np.hstack([powers, truncated])


def conditions(a: float, b: float, t: Array) -> Array:
    """B [Eq. 14]: values at a and b, slopes at a and b. Rows in the order of f [Eq. 15]."""
    ends = np.array([a, b])
    slopes = np.hstack(
        [np.arange(4) * ends[:, None] ** np.array([0, 0, 1, 2]), 3 * np.maximum(ends[:, None] - t, 0) ** 2]
    )
    return np.vstack([design(ends, t), slopes])


def generalized_inverse(matrix: Array, rank: int | None = None) -> Array:
    """A⁺ = V D⁺ Uᵀ [Eq. 20–22], with a generic tolerance or with the rank given."""
    u, d, v = np.linalg.svd(matrix, full_matrices=False)
    kept = d > max(matrix.shape) * np.finfo(float).eps * d[0] if rank is None else np.arange(len(d)) < rank
    inverse = np.where(kept, 1.0 / np.where(kept, d, 1.0), 0.0)
    result: Array = (v.T * inverse) @ u.T
    return result


def as_printed(x: Array, y: Array, t: Array, a: float, b: float, f: Array) -> Array:
    """c = B⁺f + (AZ)⁺(y − AB⁺f), Z = I − B⁺B [Eq. 25, 26]."""
    return _solution(x, y, t, a, b, f, rank=None, project=False)


def with_rank(x: Array, y: Array, t: Array, a: float, b: float, f: Array) -> Array:
    """As printed, with the rank of AZ set to n − 4, which it is."""
    return _solution(x, y, t, a, b, f, rank=len(t), project=False)


def mended(x: Array, y: Array, t: Array, a: float, b: float, f: Array) -> Array:
    """With the rank set and one more Z in front: c = B⁺f + Z(AZ)⁺(y − AB⁺f). The reference of the tests."""
    return _solution(x, y, t, a, b, f, rank=len(t), project=True)


def compacted(c: Array, t: Array) -> Array:
    """Coefficients of 1, x, x², x³ on each interval [Eq. 30, 33], one row an interval."""
    rows = [c[:4]]
    for knot, step in zip(t, c[4:], strict=True):
        rows.append(rows[-1] + step * np.array([-(knot**3), 3 * knot**2, -3 * knot, 1.0]))
    return np.array(rows)


def _solution(x: Array, y: Array, t: Array, a: float, b: float, f: Array, rank: int | None, project: bool) -> Array:
    A, B = design(x, t), conditions(a, b, t)
    B_inverse = generalized_inverse(B)
    Z = np.eye(B.shape[1]) - B_inverse @ B
    particular = B_inverse @ f
    correction = generalized_inverse(A @ Z, rank) @ (y - A @ particular)
    return particular + (Z @ correction if project else correction)
