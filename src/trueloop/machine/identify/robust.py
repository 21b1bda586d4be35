"""Linear least squares in which outliers count less: Huber's weights, with the covariance that they leave."""

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.chain import AxisKind, Chain
from trueloop.machine.model.kinematics import tool_in_work_mm
from trueloop.machine.model.term import Term

DIRECTIONS = 3
"""A run that was read along more directions than these is one channel whose direction turns."""

SAME = 1e-9
"""Difference of direction cosines, or of positions in mm, that rounding makes."""

INSIDE = 1e-5
"""Share of a column beyond the span of others under which it counts as lying in it."""

Rows = NDArray[np.intp]


def zero_columns(readings: Observations) -> Array:
    """Columns (n, zeros) of every channel whose zero is its own, of unit size."""
    columns = [np.zeros((len(readings), 0))]
    for rows in _channels(readings, np.broadcast_to(readings.own_zero, len(readings))):
        along = readings.along[rows]
        own = np.ones((len(rows), 1)) if _alike(along) else np.hstack([np.ones((len(rows), 1)), along])
        columns.append(_at(rows, own, len(readings)))
    return np.hstack(columns)


def instrument_columns(readings: Observations) -> Array:
    """Returns the columns (n, k) of the instruments' unknowns that may be common to several runs."""
    return readings.unknown.reshape(len(readings), -1)


def slope_columns(chain: Chain, readings: Observations) -> Array:
    """Columns (n, slopes) of every channel whose slope is its own: displacements across the one axis that moved, −1
    to 1 over its way.
    """
    columns = [np.zeros((len(readings), 0))]
    for rows in _channels(readings, readings.own_slope & ~readings.is_angle):
        way = _way(chain, readings, rows)
        if way is not None:
            columns.append(_at(rows, way[:, None], len(readings)))
    return np.hstack(columns)


def constants_of(terms: Iterable[Term]) -> tuple[Term, ...]:
    """Returns the part of the terms that is equal everywhere and always, as constant terms."""
    return tuple(
        Term(term.name)
        for term in terms
        if any(part.signal is None and not part.basis.zero_at for part in term.parts)
        and not (term.name.place and term.name.axis in "XYZ")
    )


def determined_zeros(zeros: Array, constants: Array) -> Array:
    """Returns the zeros that no constant of the model takes the place of, (n, ≤ zeros).

    Where the model's `constants` (n, k) do the same as the zeros of all runs together, the model says it, and the zeros
    are what is beyond. Nothing else is chosen so: what differs between runs stays unknown.
    """
    size = np.linalg.norm(constants, axis=0)
    if zeros.shape[1] == 0 or not size.any():
        return zeros
    constants, own = orthonormal(constants), orthonormal(zeros)
    _, strength, directions = np.linalg.svd(constants - own @ (own.T @ constants), full_matrices=False)
    both = constants @ directions[strength < INSIDE].T
    left, strength, _ = np.linalg.svd(without(both, own), full_matrices=False)
    return np.asarray(left[:, strength > INSIDE]) if both.shape[1] else zeros


def orthonormal(columns: Array) -> Array:
    """Returns an orthonormal basis (n, rank) of the span of the columns."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns[:, size > 0] / size[size > 0]
    strength, directions = np.linalg.eigh(scaled.T @ scaled)
    kept = strength > 1e-11 * strength.max(initial=0.0)
    basis: Array = scaled @ (directions[:, kept] / np.sqrt(strength[kept]))
    return basis


def without(columns: Array, values: Array) -> Array:
    """Returns the part of `values`, (n,) or (n, k), that the columns do not explain."""
    basis = orthonormal(columns)
    rest: Array = values - basis @ (basis.T @ values)
    return rest


def _channels(readings: Observations, own: NDArray[np.bool_]) -> Iterator[Rows]:
    """Rows of what each instrument read in each run, among those marked `own`."""
    runs = np.unique(readings.run, return_inverse=True)[1]
    for run in np.unique(runs[own]):
        for angle in (False, True):
            rows = np.flatnonzero(own & (runs == run) & (readings.is_angle == angle))
            directions, which = np.unique(np.round(readings.along[rows], 9), axis=0, return_inverse=True)
            if len(directions) > DIRECTIONS:
                yield rows
            else:
                yield from (rows[which.ravel() == k] for k in range(len(directions)))


def _alike(along: Array) -> bool:
    return bool(np.abs(along - along[0]).max() < SAME)


def _way(chain: Chain, readings: Observations, rows: Rows) -> Array | None:
    """Returns the positions, −1 to 1, where one linear axis alone moves and the readings are square to it."""
    positions, along = readings.state.positions[rows], readings.along[rows]
    moving = np.flatnonzero(np.ptp(positions, axis=0) > SAME)
    if len(moving) != 1 or not _alike(along):
        return None
    position = positions[:, moving[0]]
    low, high = position.min(), position.max()
    ends = tool_in_work_mm(chain, positions[[position.argmin(), position.argmax()]], np.zeros(3))
    across = abs(float(along[0] @ (ends[1] - ends[0]))) < 1e-6 * (high - low)
    if chain.axis(chain.order[int(moving[0])]).kind is not AxisKind.LINEAR or not across:
        return None
    way: Array = (2 * position - low - high) / (high - low)
    return way


def _at(rows: Rows, own: Array, count: int) -> Array:
    columns = np.zeros((count, own.shape[1]))
    columns[rows] = own
    return columns


HUBER = 1.345
"""Bound of Huber's weights in standard deviations: 95 % efficiency on clean normal data (Huber 1964)."""

OUTLIER = 4.0
"""A reading further off than this many standard deviations is named as an outlier."""

ROUNDS = 50


def robust_solution(rows: Array, values: Array, robust: bool) -> tuple[Array, Array, float, Array, NDArray[np.bool_]]:
    """Returns (solution, covariance, scatter, weights, outliers) of rows · solution ≈ values; weights are 1 if not
    `robust`.

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
        # Solves weighted least squares in orthonormal columns: QᵀWQ = I − Σ (1 − w) q qᵀ over the rows with w < 1
        less = share < 1.0
        part = q[less] * np.sqrt(1.0 - share[less])[:, None]
        normal = np.eye(q.shape[1]) - part.T @ part
        better = np.asarray(np.linalg.solve(normal, q.T @ (share * values)), dtype=np.float64)
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


def least_squares(rows: Array, values: Array) -> Array:
    """Solves rows · solution ≈ values, by QR."""
    q, r = np.linalg.qr(rows)
    solution: Array = np.linalg.solve(r, q.T @ values)
    return solution


def _spread(rest: Array, parameters: int) -> float:
    """Estimates the standard deviation from the median absolute residual, which outliers do not move; exact for normal
    residuals.

    A fit with p parameters to n readings makes residuals smaller by √(1 − p/n).
    """
    return float(np.median(np.abs(rest)) / 0.6745 / np.sqrt(1 - parameters / len(rest)))


def _scatter(rest: Array, share: Array, parameters: int) -> float:
    """Returns the standard deviation of unit weight. With Huber's weights: K √(Σψ²/(n−p)) / m,

    K = 1 + (p/n)(1−m)/m, m = mean ψ′ [Huber 1981 §7.6].
    """
    freedom = len(rest) - parameters
    inside = float(np.mean(share >= 1.0))
    if inside == 1.0:
        return float(np.sqrt(np.sum(rest**2) / freedom))
    correction = 1 + parameters / len(rest) * (1 - inside) / inside
    return float(correction * np.sqrt(np.sum((share * rest) ** 2) / freedom) / inside)
