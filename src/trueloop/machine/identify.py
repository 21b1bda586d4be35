"""Identification: the coefficients of error terms from readings, by weighted least squares, with their covariance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.collinearity import collinear_findings
from trueloop.machine.history import Lag, lag_units, slope_name
from trueloop.machine.model import Machine, MachineModel
from trueloop.machine.observations import Observations, ranges
from trueloop.machine.term import Term, block_diagonal
from trueloop.machine.time_constants import at_bounds, sought_constants, with_lag_covariance
from trueloop.units import UM_PER_MM, URAD_PER_RAD

HUBER = 1.345
"""Bound of Huber's weights in standard deviations: 95 % efficiency on clean normal data (Huber 1964)."""

OUTLIER = 4.0
"""A reading further off than this many standard deviations is named as an outlier."""

ROUNDS = 50

LAG_ROUNDS = 5
"""Outliers named, time constants sought without them, outliers named anew …, until they are the same."""


@dataclass(frozen=True)
class Identification:
    """The model and how well it stands: residuals = reading − model, mm or rad, and their scatter in units of u.

    `scatter` is the standard deviation of unit weight: 1 when `standard_u` was right, the standard deviation of the
    readings themselves when none was given.
    """

    model: MachineModel
    residual: Array
    scatter: float
    degrees_of_freedom: int
    outlier: NDArray[np.bool_]
    findings: tuple[Finding, ...]


def identify(
    machine: Machine, terms: Sequence[Term], readings: Observations, *, robust: bool = True, lags: Sequence[Lag] = ()
) -> Identification:
    """The coefficients that minimise Σ ρ((reading − model)/u), subject to the terms' zeros.

    ρ is Huber's with `robust`, else the square. Covariance s²(AᵀWA)⁻¹ with s from the residuals (for Huber's weights
    with the correction of Huber 1981 §7.6). Raises MCH-DATA for an axis without data, MCH-COLLINEAR for parameters
    that the readings cannot tell apart at all; pairs that they hardly tell apart come as findings.
    """
    terms = tuple(terms)
    if sum(term.size for term in terms) == 0:
        raise _too_few(0, len(readings))
    _check_axes_have_data(machine, terms, readings)
    lags = tuple(lag for lag in lags if any(lag.name in term.needs() for term in terms))
    found = _with_given_lags(machine, terms, readings.with_lags(lags), robust, lags)
    for _ in range(LAG_ROUNDS if any(lag.between_s for lag in lags) else 0):
        lags = _found_lags(machine, terms, readings.only(~found.outlier), lags)
        before, found = found, _with_given_lags(machine, terms, readings.with_lags(lags), robust, lags)
        if np.array_equal(before.outlier, found.outlier):
            break
    return found


def _found_lags(
    machine: Machine, terms: tuple[Term, ...], readings: Observations, lags: tuple[Lag, ...]
) -> tuple[Lag, ...]:
    return sought_constants(
        lags,
        lambda tried: _badness(machine, terms, readings.with_lags(tried)),
        lambda tried: _lag_step(machine, terms, readings.with_lags(tried), tried),
    )


def _with_given_lags(
    machine: Machine, terms: tuple[Term, ...], readings: Observations, robust: bool, lags: tuple[Lag, ...]
) -> Identification:
    rows, values, free = weighted_rows(machine, terms, readings)
    if len(rows) <= rows.shape[1]:
        raise _too_few(rows.shape[1], len(rows))
    findings = collinear_findings(terms, rows) + at_bounds(lags)
    solution, covariance, scatter, outlier = _solve(rows, values, robust)
    slopes = [slope_name(lag) for lag in lags]
    identified = {name: known for name, known in ranges(machine.chain, readings).items() if name not in slopes}
    units = {**readings.units, **lag_units(lags, readings.units)}
    model = MachineModel(machine, terms, free @ solution, free @ covariance @ free.T, identified, lags, units)
    residual = readings.reading - readings.predicted(model)
    findings += _outlier_findings(readings, residual, outlier)
    freedom = len(rows) - rows.shape[1]
    if lags:
        weighted = readings.lag_slopes(model) * _weights(readings)[:, None]
        model = with_lag_covariance(model, rows, free, scatter, weighted)
        freedom -= sum(lag.between_s is not None for lag in lags)
    return Identification(model, residual, scatter, freedom, outlier, tuple(findings))


def weighted_rows(machine: Machine, terms: tuple[Term, ...], readings: Observations) -> tuple[Array, Array, Array]:
    """(rows, values, free): rows · solution ≈ values, coefficients = free · solution."""
    weight = _weights(readings)
    free = block_diagonal([term.admissible() for term in terms])
    return (readings.design(machine.chain, terms) @ free) * weight[:, None], readings.reading * weight, free


def _badness(machine: Machine, terms: tuple[Term, ...], readings: Observations) -> float:
    """Weighted sum of squares that the best coefficients leave."""
    rows, values, _ = weighted_rows(machine, terms, readings)
    rest = values - rows @ _least_squares(rows, values)
    return float(rest @ rest)


def _lag_step(machine: Machine, terms: tuple[Term, ...], readings: Observations, lags: tuple[Lag, ...]) -> Array:
    """Change of the ln τ that are sought, coefficients and they made linear together."""
    rows, values, free = weighted_rows(machine, terms, readings)
    solution = _least_squares(rows, values)
    model = MachineModel(machine, terms, free @ solution, np.zeros((0, 0)), lags=lags)
    slopes = readings.lag_slopes(model) * _weights(readings)[:, None]
    both = np.hstack([rows, slopes[:, [k for k, lag in enumerate(lags) if lag.between_s]]])
    step = np.linalg.lstsq(both, values - rows @ solution, rcond=None)[0]
    return np.asarray(step[rows.shape[1] :], dtype=np.float64)


def _weights(readings: Observations) -> Array:
    """1/u where u is known; else 1 for all alike, angles scaled so that 1 µrad counts as 1 µm."""
    if np.all(np.isfinite(readings.standard_u)):
        inverse: Array = 1.0 / readings.standard_u
        return inverse
    return np.where(readings.is_angle, URAD_PER_RAD / UM_PER_MM, 1.0)


def _solve(rows: Array, values: Array, robust: bool) -> tuple[Array, Array, float, NDArray[np.bool_]]:
    """(solution, covariance, scatter, outliers) of rows · solution ≈ values."""
    scale = np.linalg.norm(rows, axis=0)
    scaled = rows / scale
    solution = _least_squares(scaled, values)
    share = np.ones(len(values))
    for _ in range(ROUNDS if robust else 0):
        rest = values - scaled @ solution
        spread = _spread(rest, rows.shape[1])
        if spread <= 1e-12 * np.abs(values).max(initial=0.0):
            break
        share = np.minimum(1.0, HUBER * spread / np.maximum(np.abs(rest), 1e-300))
        root = np.sqrt(share)
        better = _least_squares(scaled * root[:, None], values * root)
        settled = np.abs(better - solution).max() <= 1e-10 * np.abs(better).max()
        solution = better
        if settled:
            break
    rest = values - scaled @ solution
    scatter = _scatter(rest, share, rows.shape[1])
    covariance = scatter**2 * np.linalg.inv(scaled.T @ scaled) / np.outer(scale, scale)
    spread = _spread(rest, rows.shape[1]) if robust else scatter
    outlier = np.abs(rest) > OUTLIER * spread if spread > 0 else np.zeros(len(rest), dtype=bool)
    return solution / scale, covariance, scatter, outlier


def _least_squares(rows: Array, values: Array) -> Array:
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


def _check_axes_have_data(machine: Machine, terms: tuple[Term, ...], readings: Observations) -> None:
    """A term whose axis stood still all the time cannot be found."""
    for term in terms:
        if term.name.axis not in machine.chain.order or all(part.basis.size == 1 for part in term.parts):
            continue
        axis = machine.chain.axis(term.name.axis)
        position = readings.state.positions[:, machine.chain.order.index(axis.name)]
        if np.ptp(position) == 0.0:
            raise TrueloopError(
                Code.MCH_DATA,
                f"{term.name}: axis {axis.name} stands at {axis.shown(position[0])} in all {len(readings)} readings",
                hint=f"measure along {axis.name}, or leave {term.name} out of the model",
            )


def _too_few(parameters: int, count: int) -> TrueloopError:
    return TrueloopError(
        Code.MCH_DATA,
        f"{count} readings cannot determine {parameters} parameters",
        hint="measure more positions, or name at least one term and give each fewer segments",
    )


def _outlier_findings(readings: Observations, residual: Array, outlier: NDArray[np.bool_]) -> list[Finding]:
    found = []
    for k in np.flatnonzero(outlier):
        size, unit = (residual[k] * URAD_PER_RAD, "µrad") if readings.is_angle[k] else (residual[k] * UM_PER_MM, "µm")
        line = int(readings.line[k]) if len(readings.line) else None
        found.append(
            Finding(
                Severity.WARNING,
                Code.MCH_OUTLIER,
                f"reading {k + 1} of run {readings.run[k]!r} is {size:+.2f} {unit} off the model",
                hint="a slipped reading: look at the instrument's record of that run, or measure it again",
                place=Place(line=line),
            )
        )
    return found
