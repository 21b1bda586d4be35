"""Readings of a machine's characterization: where it stood, what was read, along which direction."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.machine.model.chain import AxisKind, Chain
from trueloop.machine.model.history import Clock, Lag, joined_clocks, lag_signals, moved_along
from trueloop.machine.model.kinematics import tool_in_work_mm
from trueloop.machine.model.model import MachineModel, State, design
from trueloop.machine.model.term import Term


@dataclass(frozen=True)
class Observations:
    """n readings: `along · E` in mm, or where `is_angle` the rotation of the tool about `along` in rad.

    E is actual − commanded position of the tool as seen from the work, whatever the instrument: laser, straight edge,
    step gauge, or a ball bar (`along` from its centre to the tool, the reading its change of length). `standard_u` is
    each reading's standard uncertainty, NaN where it is not known. `run` names the readings measured in one go:
    hold-out leaves out whole runs. `clock` says when each reading was taken and what the sensors said before. `units`
    are those of the signals, where they are known. `own_zero` marks readings whose instrument was zeroed for their run
    alone, `own_slope` those whose straightedge was laid by eye: both unknown. `unknown` (n, k) holds the readings, mm
    or rad, that a unit of each further unknown of an instrument causes: a bar's length, a ball's place, a drift.
    """

    state: State
    along: Array
    reading: Array
    is_angle: NDArray[np.bool_]
    standard_u: Array
    run: tuple[str, ...]
    line: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    clock: Clock | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    own_zero: NDArray[np.bool_] | bool = False
    own_slope: NDArray[np.bool_] | bool = False
    unknown: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def __len__(self) -> int:
        return len(self.reading)

    def only(self, rows: NDArray[np.bool_]) -> "Observations":
        """Returns some of the readings."""
        count = len(self)
        travel = np.broadcast_to(self.state.travel, self.state.positions.shape)
        tool = np.broadcast_to(self.state.tool_mm, (count, 3))
        signals = {name: np.broadcast_to(value, (count,))[rows] for name, value in self.state.signals.items()}
        return Observations(
            state=State(self.state.positions[rows], travel[rows], signals, tool[rows]),
            along=self.along[rows],
            reading=self.reading[rows],
            is_angle=self.is_angle[rows],
            standard_u=self.standard_u[rows],
            run=tuple(run for run, keep in zip(self.run, rows, strict=True) if keep),
            line=self.line[rows] if len(self.line) else self.line,
            clock=self.clock.only(rows) if self.clock else None,
            units=self.units,
            own_zero=np.broadcast_to(self.own_zero, (count,))[rows],
            own_slope=np.broadcast_to(self.own_slope, (count,))[rows],
            unknown=self.unknown[rows] if self.unknown.size else self.unknown,
        )

    def with_lags(self, lags: Sequence[Lag]) -> "Observations":
        """Adds the lags to the signals, from the history; raises MCH-HISTORY without one, and as `lag_signals`."""
        if not lags:
            return self
        if self.clock is None:
            raise Code.MCH_HISTORY.refusal(
                f"{lags[0].name!r} is a lag of {lags[0].of!r}: it needs the time of each of the {len(self)} readings",
                hint="give every readings file a column time_s",
            )
        return replace(self, state=replace(self.state, signals={**self.state.signals, **lag_signals(lags, self.clock)}))

    def design(self, chain: Chain, terms: tuple[Term, ...]) -> Array:
        """Readings as a linear map of all coefficients, (n, all)."""
        displacement: Array = np.einsum("ni,nij->nj", self.along, design(chain, terms, self.state))
        if not self.is_angle.any():
            return displacement
        angle = np.einsum("ni,nij->nj", self.along, design(chain, terms, self.state, rotations=True))
        return np.where(self.is_angle[:, None], angle, displacement)

    def lag_slopes(self, model: MachineModel) -> Array:
        """Returns the change of each reading as the model predicts it by ln τ of each lag, (n, lags)."""
        here = self.predicted(model)
        changed = [
            replace(self, state=replace(self.state, signals=moved_along(lag, self.state.signals))).predicted(model)
            for lag in model.lags
        ]
        return np.stack([*changed, here], axis=1)[:, :-1] - here[:, None]

    def predicted(self, model: MachineModel) -> Array:
        """Returns each reading as predicted by the model, (n,); its lags have to be among the signals."""
        predicted: Array = self.design(model.machine.chain, model.terms) @ model.coefficients
        return predicted


def joined(parts: list[Observations]) -> Observations:
    """Joins several sets of readings into one. Signals must be the same in all. Raises MCH-SIGNAL."""
    from scipy.linalg import block_diag

    names = set(parts[0].state.signals)
    for part in parts[1:]:
        if set(part.state.signals) != names:
            raise Code.MCH_SIGNAL.refusal(
                f"{len(parts)} sets of readings differ in their signals: {sorted(names ^ set(part.state.signals))}",
                hint="every file needs every temperature column that the model uses",
                values={"signals": sorted(names ^ set(part.state.signals))},
            )
    whole = [part.only(np.ones(len(part), dtype=bool)) for part in parts]
    clocks = [part.clock for part in parts if part.clock is not None]
    state = State(
        np.concatenate([p.state.positions for p in whole]),
        np.concatenate([np.asarray(p.state.travel) for p in whole]),
        {name: np.concatenate([np.atleast_1d(p.state.signals[name]) for p in whole]) for name in names},
        np.concatenate([np.asarray(p.state.tool_mm) for p in whole]),
    )
    return Observations(
        state=state,
        along=np.concatenate([p.along for p in whole]),
        reading=np.concatenate([p.reading for p in whole]),
        is_angle=np.concatenate([p.is_angle for p in whole]),
        standard_u=np.concatenate([p.standard_u for p in whole]),
        run=tuple(run for p in whole for run in p.run),
        line=np.concatenate([p.line for p in whole]),
        clock=joined_clocks(clocks) if len(clocks) == len(parts) else None,
        units={name: unit for p in parts for name, unit in p.units.items()},
        own_zero=np.concatenate([np.asarray(p.own_zero) for p in whole]),
        own_slope=np.concatenate([np.asarray(p.own_slope) for p in whole]),
        unknown=block_diag(*[p.unknown.reshape(len(p), -1) for p in whole]),
    )


def ranges(chain: Chain, observations: Observations) -> Mapping[str, tuple[float, float]]:
    """Returns least and largest of every axis position and signal."""
    found = dict(zip(chain.order, observations.state.positions.T, strict=True))
    found |= {name: np.atleast_1d(value) for name, value in observations.state.signals.items()}
    return {name: (float(values.min()), float(values.max())) for name, values in found.items()}


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
    """Columns (n, slopes) of channels with an own slope: displacements across the moved axis, −1 to 1 over its way."""
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
    """Returns s of unit weight; by Huber K √(Σψ²/(n−p)) / m, K = 1 + (p/n)(1−m)/m, m = mean ψ′ [Huber 1981 §7.6]."""
    freedom = len(rest) - parameters
    inside = float(np.mean(share >= 1.0))
    if inside == 1.0:
        return float(np.sqrt(np.sum(rest**2) / freedom))
    correction = 1 + parameters / len(rest) * (1 - inside) / inside
    return float(correction * np.sqrt(np.sum((share * rest) ** 2) / freedom) / inside)
