"""Identification: the coefficients of error terms from readings, by weighted least squares, with their covariance.

The parts of a model that the readings cannot separate: condition indices and variance shares [Belsley 1980, ch. 3].

Each part (and each way of travel) is made orthonormal by itself first, so that only likeness *between* parts counts:
two temperature sensors that moved together, or two errors that no reading distinguishes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.machine.identify.observations import (
    Observations,
    constants_of,
    determined_zeros,
    instrument_columns,
    least_squares,
    orthonormal,
    ranges,
    robust_solution,
    slope_columns,
    without,
    zero_columns,
)
from trueloop.machine.model.history import Lag, lag_units, slope_name
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import Term
from trueloop.units import UM_PER_MM, URAD_PER_RAD

WARN_INDEX = 30.0
"""Condition index from which Belsley calls the likeness strong."""

REFUSE_INDEX = 1e7
"""Beyond this the difference of two parts is rounding."""

SHARE = 0.5
"""Share of a part's variance that one combination must take for the part to belong to it [Belsley]."""


def collinear_findings(terms: Sequence[Term], rows: Array, before: Array | None = None) -> list[Finding]:
    """Warnings about parts of `terms` that are hardly distinguishable in `rows` (n, free); raises MCH-COLLINEAR.

    The columns of `rows` are the free parameters in the order of `Term.admissible`; `before` are the same where
    something was taken out of them: what that leaves of a part is measured by what the part was.
    """
    names, blocks = _blocks(terms, rows)
    wholes = blocks if before is None else _blocks(terms, before)[1]
    left, sizes = [], []
    for name, block, whole in zip(names, blocks, wholes, strict=True):
        basis, strength, _ = np.linalg.svd(block, full_matrices=False)
        most = float(np.linalg.norm(whole, 2))
        if strength[-1] <= most / REFUSE_INDEX:
            raise _refusal([name], float("inf") if strength[-1] == 0 else most / float(strength[-1]))
        left.append(basis)
        sizes.append(basis.shape[1])
    strength, directions = _spectrum(np.hstack(left))
    owner = np.repeat(np.arange(len(names)), sizes)
    findings = []
    for index, members in _combinations(strength, directions, owner):
        involved = [names[k] for k in members]
        if index > REFUSE_INDEX:
            raise _refusal(involved, index)
        findings.append(_warning(involved, index))
    return findings


def _blocks(terms: Sequence[Term], rows: Array) -> tuple[list[str], list[Array]]:
    names, blocks, start = [], [], 0
    for term in terms:
        ways = ["forward ", "return "] if term.both_ways else [""]
        for way in ways:
            for part in term.parts:
                free = part.basis.size if way == "return " else part.basis.admissible().shape[1]
                if free:
                    names.append(f"{way}{term.name}" + (f"·{part.signal}" if part.signal else ""))
                    blocks.append(rows[:, start : start + free])
                start += free
    return names, blocks


def _spectrum(matrix: Array) -> tuple[Array, Array]:
    """Returns singular values and right vectors; a value that rounding decides counts as its size."""
    _, strength, directions = np.linalg.svd(matrix, full_matrices=False)
    return np.maximum(strength, strength[0] * np.finfo(float).eps), directions


def _combinations(strength: Array, directions: Array, owner: NDArray[np.intp]) -> list[tuple[float, list[int]]]:
    """Returns weak combinations, strongest likeness first: (condition index, the parts whose variance it makes up)."""
    parts = range(int(owner.max()) + 1)
    variance = directions**2 / strength[:, None] ** 2
    by_part = np.stack([variance[:, owner == k].sum(axis=1) for k in parts], axis=1)
    shares = by_part / by_part.sum(axis=0)
    found = []
    for row in np.argsort(strength):
        index = float(strength[0] / strength[row])
        if index <= WARN_INDEX:
            break
        members = [k for k in parts if shares[row, k] > SHARE / 2]
        if members:
            found.append((index, members))
    return found


def _warning(names: list[str], index: float) -> Finding:
    return Finding(
        Severity.WARNING,
        Code.MCH_COLLINEAR,
        f"{' and '.join(names)} are hardly separated by these readings (condition index {index:.0f})",
        hint="measure where they differ (another tool length, another warm-up), or leave one out",
        values={"parameters": names},
    )


def _refusal(names: list[str], index: float) -> TrueloopError:
    return Code.MCH_COLLINEAR.refusal(
        f"{' and '.join(names)} cannot be separated by these readings (condition index {index:.1e})",
        hint="leave one out: keep the sensor nearest the heat source, or one of two errors with the same effect",
        values={"parameters": names},
    )


GRID = 9
"""Constants tried for each lag in turn, from bound to bound in equal ratios, before all are refined together."""

STEPS = 20
SMALL = 1e-6
"""A step of ln τ that ends the search: far below any uncertainty."""

Badness = Callable[[tuple[Lag, ...]], float]
"""Sum of squares that the best coefficients leave with lags of these constants."""

Step = Callable[[tuple[Lag, ...]], Array]
"""Gauss and Newton's step of ln τ from there, one number a lag that is sought."""


def sought_constants(lags: Sequence[Lag], badness: Badness, step: Step) -> tuple[Lag, ...]:
    """Determines the lags' constants, those without bounds kept: the best of a grid, then Gauss–Newton."""
    found = tuple(lags)
    for k, lag in enumerate(lags):
        tried = [_with_constant(found, k, tau) for tau in np.geomspace(*lag.between_s, GRID)] if lag.between_s else []
        found = min(tried, key=badness, default=found)
    least = badness(found)
    for _ in range(STEPS if any(lag.between_s for lag in lags) else 0):
        whole = step(found)
        for share in (1.0, 0.5, 0.25, 0.125, 0.0625):
            tried_lags = _moved(found, share * whole)
            if (error := badness(tried_lags)) <= least:
                break
        else:
            break
        found, least = tried_lags, error
        if np.abs(whole).max() < SMALL:
            break
    return found


def _with_constant(lags: tuple[Lag, ...], k: int, constant_s: float) -> tuple[Lag, ...]:
    return (*lags[:k], replace(lags[k], constant_s=float(constant_s)), *lags[k + 1 :])


def _moved(lags: tuple[Lag, ...], logarithms: Array) -> tuple[Lag, ...]:
    """Constants changed by factors exp(…), within their bounds."""
    sought = [k for k, lag in enumerate(lags) if lag.between_s]
    for k, by in zip(sought, logarithms, strict=True):
        lag = lags[k]
        assert lag.between_s is not None
        low, high = lag.between_s
        # a step of more than e-fold is beyond what the derivative says
        lags = _with_constant(lags, k, min(max(lag.constant_s * float(np.exp(np.clip(by, -1, 1))), low), high))
    return lags


def at_bounds(lags: Sequence[Lag]) -> list[Finding]:
    """Returns a warning for each constant that came out at a bound: the bound stopped it there."""
    return [
        Finding(
            Severity.WARNING,
            Code.MCH_LAG,
            f"the time constant of {lag.name!r} ended at a bound: {lag.constant_s:.3g} s",
            hint="widen its bounds, or take the lag out: the readings do not show it",
            values={"lag": lag.name, "constant_s": lag.constant_s},
        )
        for lag in lags
        if lag.between_s is not None and min(abs(np.log(lag.constant_s / end)) for end in lag.between_s) < 1e-3
    ]


def with_lag_covariance(model: MachineModel, rows: Array, free: Array, scatter: float, slopes: Array) -> MachineModel:
    """Returns the covariance of coefficients and ln τ together: of the problem made linear at its solution.

    `rows` and `slopes` are the weighted readings' derivatives by the free coefficients and by each ln τ.
    """
    sought = [k for k, lag in enumerate(model.lags) if lag.between_s is not None]
    both = np.hstack([rows, slopes[:, sought]])
    scale = np.maximum(np.linalg.norm(both, axis=0), 1e-300)
    variance = scatter**2 * (len(rows) - rows.shape[1]) / max(len(rows) - both.shape[1], 1)
    small = variance * np.linalg.pinv((both / scale).T @ (both / scale)) / np.outer(scale, scale)
    spread = np.zeros((len(free) + len(model.lags), both.shape[1]))
    spread[: len(free), : rows.shape[1]] = free
    spread[len(free) + np.array(sought, dtype=int), rows.shape[1] + np.arange(len(sought))] = 1.0
    covariance = spread @ small @ spread.T
    deviation = np.sqrt(np.diag(covariance)[len(free) :])
    lags = tuple(replace(lag, u_relative=float(u)) for lag, u in zip(model.lags, deviation, strict=True))
    return replace(model, covariance=covariance, lags=lags)


LAG_ROUNDS = 5
"""Outliers named, time constants sought without them, outliers named anew …, until they are the same."""


@dataclass(frozen=True)
class Identification:
    """The model and how well it stands: residuals = reading − model − the runs' own zeros and slopes, mm or rad, and
    their scatter in units of u.

    `scatter` is the standard deviation of unit weight: 1 when `standard_u` was right, the standard deviation of the
    readings themselves when none was given. `share` are the weights that outliers were given, 1 for the others.
    `lack_of_fit`: by how much the standard uncertainties of the model's coefficients are larger than by the scatter.
    """

    model: MachineModel
    residual: Array
    scatter: float
    degrees_of_freedom: int
    outlier: NDArray[np.bool_]
    share: Array
    findings: tuple[Finding, ...]
    lack_of_fit: float = 1.0


def identify(
    machine: Machine, terms: Sequence[Term], readings: Observations, *, robust: bool = True, lags: Sequence[Lag] = ()
) -> Identification:
    """Determines the coefficients that minimise Σ ρ((reading − zero and slope of its run − model)/u), subject to the
    terms' zeros.

    ρ is Huber's with `robust`, else the square. Covariance s²(AᵀWA)⁻¹ with s from the residuals (for Huber's weights
    with the correction of Huber 1981 §7.6). Raises MCH-DATA for an axis without data, MCH-COLLINEAR for parameters
    that the readings cannot tell apart at all; pairs that they hardly tell apart come as findings.
    """
    terms = tuple(terms)
    if sum(term.size for term in terms) == 0:
        raise _too_few(0, len(readings))
    # Refuses a term whose axis stood still all the time: it cannot be determined
    for term in terms:
        if term.name.axis not in machine.chain.order or all(part.basis.size == 1 for part in term.parts):
            continue
        axis = machine.chain.axis(term.name.axis)
        position = readings.state.positions[:, machine.chain.order.index(axis.name)]
        if np.ptp(position) == 0.0:
            raise Code.MCH_DATA.refusal(
                f"{term.name}: axis {axis.name} stands at {axis.shown(position[0])} in all {len(readings)} readings",
                hint=f"measure along {axis.name}, or leave {term.name} out of the model",
            )
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
    opened = unknown_columns(machine, terms, readings)
    if len(rows) <= rows.shape[1] + opened.shape[1]:
        raise _too_few(rows.shape[1] + opened.shape[1], len(rows))
    findings = _collinear(terms, rows, opened) + at_bounds(lags)
    whole, covariance, scatter, share, outlier = robust_solution(np.hstack([rows, opened]), values, robust)
    solution, covariance = whole[: rows.shape[1]], covariance[: rows.shape[1], : rows.shape[1]]
    slopes = [slope_name(lag) for lag in lags]
    identified = {name: known for name, known in ranges(machine.chain, readings).items() if name not in slopes}
    units = {**readings.units, **lag_units(lags, readings.units)}
    model = MachineModel(
        machine=machine,
        terms=terms,
        coefficients=free @ solution,
        covariance=free @ covariance @ free.T,
        identified=identified,
        lags=lags,
        units=units,
    )
    residual = (values - np.hstack([rows, opened]) @ whole) / values_weight(readings)
    found = []
    for run in dict.fromkeys(readings.run):
        own = np.array([name == run for name in readings.run])
        off = np.flatnonzero(own & outlier)
        if len(off) > MOST_SLIPS * np.count_nonzero(own):
            largest = int(off[np.argmax(np.abs(residual[off]))])
            found.append(_off_the_model(readings, residual, largest, f"{len(off)} of {np.count_nonzero(own)} readings"))
        else:
            found += [_off_the_model(readings, residual, int(k)) for k in off]
    findings += found
    freedom = len(rows) - len(whole)
    if lags:
        weighted = readings.lag_slopes(model) * values_weight(readings)[:, None]
        model = with_lag_covariance(model, without(opened, rows), free, scatter, without(opened, weighted))
        freedom -= sum(lag.between_s is not None for lag in lags)
    return Identification(
        model=model,
        residual=residual,
        scatter=scatter,
        degrees_of_freedom=freedom,
        outlier=outlier,
        share=share,
        findings=tuple(findings),
    )


def weighted_rows(machine: Machine, terms: tuple[Term, ...], readings: Observations) -> tuple[Array, Array, Array]:
    """Returns (rows, values, free): rows · solution ≈ values, coefficients = free · solution."""
    from scipy.linalg import block_diag

    weight = values_weight(readings)
    free = block_diag(np.zeros((0, 0)), *(term.admissible() for term in terms))
    return (readings.design(machine.chain, terms) @ free) * weight[:, None], readings.reading * weight, free


def closed_rows(machine: Machine, terms: tuple[Term, ...], readings: Observations) -> tuple[Array, Array]:
    """Returns (rows, values) as `weighted_rows`, the share of the runs' zeros and slopes taken out of both."""
    rows, values, _ = weighted_rows(machine, terms, readings)
    opened = unknown_columns(machine, terms, readings)
    return without(opened, rows), without(opened, values)


def unknown_columns(machine: Machine, terms: tuple[Term, ...], readings: Observations) -> Array:
    """Returns a basis of the weighted columns of runs' zeros, slopes and instruments, without the model's constants."""
    weight = values_weight(readings)[:, None]
    zeros, constants = np.hstack([zero_columns(readings), instrument_columns(readings)]) * weight, constants_of(terms)
    if constants:
        zeros = determined_zeros(zeros, weighted_rows(machine, constants, readings)[0])
    return orthonormal(np.hstack([zeros, slope_columns(machine.chain, readings) * weight]))


def _collinear(terms: tuple[Term, ...], rows: Array, opened: Array) -> list[Finding]:
    """Applies `collinear_findings` to rows without the runs' own zeros and slopes; refusals name these as cause."""
    if opened.shape[1] == 0:
        return collinear_findings(terms, rows)
    try:
        return collinear_findings(terms, without(opened, rows), rows)
    except TrueloopError as error:
        collinear_findings(terms, rows)
        raise error.code.refusal(
            f"{error.message}, beside {opened.shape[1]} zeros and slopes of runs and other unknowns of instruments",
            hint="mark what was read against a square, the spindle or a common zero: column absolute, slope or yes; "
            "measure diagonals; turn a ball bar both ways, its length calibrated or the scales read by a laser",
            values=error.values,
        ) from error


def _badness(machine: Machine, terms: tuple[Term, ...], readings: Observations) -> float:
    """Returns the weighted sum of squares that the best coefficients leave."""
    rows, values = closed_rows(machine, terms, readings)
    rest = values - rows @ least_squares(rows, values)
    return float(rest @ rest)


def _lag_step(machine: Machine, terms: tuple[Term, ...], readings: Observations, lags: tuple[Lag, ...]) -> Array:
    """Returns the change of the ln τ that are sought, coefficients and they made linear together."""
    plain, values, free = weighted_rows(machine, terms, readings)
    opened = unknown_columns(machine, terms, readings)
    rows, values = without(opened, plain), without(opened, values)
    solution = least_squares(rows, values)
    model = MachineModel(machine, terms, free @ solution, np.zeros((0, 0)), lags=lags)
    slopes = without(opened, readings.lag_slopes(model) * values_weight(readings)[:, None])
    both = np.hstack([rows, slopes[:, [k for k, lag in enumerate(lags) if lag.between_s]]])
    step = np.linalg.lstsq(both, values - rows @ solution, rcond=None)[0]
    return np.asarray(step[rows.shape[1] :], dtype=np.float64)


def values_weight(readings: Observations) -> Array:
    """Returns 1/u where u is known; else 1 for all alike, angles scaled so that 1 µrad counts as 1 µm."""
    if np.all(np.isfinite(readings.standard_u)):
        inverse: Array = 1.0 / readings.standard_u
        return inverse
    return np.where(readings.is_angle, URAD_PER_RAD / UM_PER_MM, 1.0)


def _too_few(parameters: int, count: int) -> TrueloopError:
    return Code.MCH_DATA.refusal(
        f"{count} readings cannot determine {parameters} parameters",
        hint="measure more positions, or name at least one term and give each fewer segments",
    )


MOST_SLIPS = 0.3
"""Share of a run's readings off the model from which the run is named, not each of its readings."""


def _off_the_model(readings: Observations, residual: Array, k: int, many: str = "") -> Finding:
    """Returns the warning of one reading, or of `many` of its run, of which it is the furthest off."""
    size, unit = (residual[k] * URAD_PER_RAD, "µrad") if readings.is_angle[k] else (residual[k] * UM_PER_MM, "µm")
    what, run = f"reading {k + 1} of run {readings.run[k]!r}", str(readings.run[k])
    message = f"{many} of run {run!r} are off the model, {what} the most: {size:+.2f} {unit}"
    return Finding(
        Severity.WARNING,
        Code.MCH_OUTLIER,
        message if many else f"{what} is {size:+.2f} {unit} off the model",
        hint="so many are no slips: look at sign, unit, axis and temperature of the run"
        if many
        else "a slipped reading: look at the instrument's record of that run, or measure it again",
        place=Place(line=int(readings.line[k]) if len(readings.line) else None),
        values={"run": run, "reading": k + 1, "off": float(size), "unit": unit},
    )
