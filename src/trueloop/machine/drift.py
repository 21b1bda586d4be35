"""Thermal drift of one point as a function of temperatures and speeds."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity
from trueloop.machine.model.chain import ZERO, Chain, ErrorName
from trueloop.machine.model.history import Lag, lagged
from trueloop.machine.model.kinematics import influences
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import CONSTANT, Part, Signals, Term
from trueloop.machine.model.validity import check_ranges
from trueloop.statistics import rms
from trueloop.units import SIGNALS, UM_PER_MM


@dataclass(frozen=True)
class Drift:
    """The drift of one channel, in its unit: range over the whole test, and the largest within `window_s`."""

    channel: str
    total_range: float
    window_s: float
    window_range: float
    window_start_s: float


@dataclass(frozen=True)
class DriftTest:
    """Displacements (mm), temperatures (°C) and speeds (rev/min) by name at `time_s`, (m,) each."""

    time_s: Array
    displacement_mm: Mapping[str, Array]
    temperature: Mapping[str, Array]
    speed: Mapping[str, Array]

    @property
    def signals(self) -> dict[str, Array]:
        """Temperatures and speeds as a drift model takes them: under their columns' names, NAME_degC and NAME_rpm."""
        warm = {f"{name}_degC": values for name, values in self.temperature.items()}
        return warm | {f"{name}_rpm": values for name, values in self.speed.items()}


def drift(time_s: Array, values: Array, channel: str, window_s: float) -> Drift:
    """Analyses one channel, (n,) each. Raises MCH-DATA where time does not ascend or does not cover a window."""
    if len(time_s) < 2 or np.any(np.diff(time_s) <= 0) or time_s[-1] - time_s[0] < window_s:
        raise Code.MCH_DATA.refusal(
            f"{channel}: {len(time_s)} rows do not cover {window_s:g} s in ascending time",
            hint="sort the rows by time, or choose a shorter window",
        )
    starts = np.flatnonzero(time_s <= time_s[-1] - window_s + 1e-9)
    ends = np.searchsorted(time_s, time_s[starts] + window_s, side="right")
    ranges = np.array([np.ptp(values[a:b]) for a, b in zip(starts, ends, strict=True)])
    worst = int(ranges.argmax())
    return Drift(channel, float(np.ptp(values)), window_s, float(ranges[worst]), float(time_s[starts[worst]]))


LADDERS_S: Final = ((0.0, 600.0, 1800.0, 5400.0, 16200.0), (0.0, 1800.0, 7200.0), (0.0, 120.0, 600.0, 3000.0))
STRENGTHS: Final = tuple(np.geomspace(1e-4, 3.0, 14).tolist())
BLOCKS: Final = (8, 6, 4)

ROWS: Final = 1000
"""Rows that a fit uses, evenly taken: drift is slow."""

SQUARE: Final = "²"
SPEED_SCALE: Final = 1000.0
SQUARE_SCALE: Final = 5e6
"""Speed in 1000 rev/min, and its square in 5 million, are as large as a few kelvins."""


@dataclass(frozen=True)
class Member:
    """One linear model: inputs by name, its ladder, weights (inputs · constants,), constant, in the drift's unit."""

    inputs: tuple[str, ...]
    ladder_s: tuple[float, ...]
    weights: Array
    constant: float


@dataclass(frozen=True)
class DriftModel:
    """The mean of its members. `start` are the inputs' values at the first row of the data: lags count from there.

    `known` are the ranges of the data's signals, by the signals' names. `left_um` is what models of earlier rows left
    of later ones, RMS; 0 where that was not tried.
    """

    members: tuple[Member, ...]
    start: Mapping[str, float]
    known: Mapping[str, tuple[float, float]]
    left_um: float = 0.0

    @property
    def inputs(self) -> tuple[str, ...]:
        """Returns all inputs that any member uses."""
        return tuple(dict.fromkeys(name for member in self.members for name in member.inputs))

    @property
    def signals(self) -> tuple[str, ...]:
        """Returns the signals from which those inputs are made."""
        return tuple(dict.fromkeys(name.removesuffix(SQUARE) for name in self.inputs))

    @property
    def mean_constant_s(self) -> dict[str, float]:
        """Returns the time constant of each input: mean over the ladders, weighted with the size of the weights."""
        found: dict[str, list[tuple[float, float]]] = {}
        for member in self.members:
            size = np.abs(member.weights.reshape(len(member.inputs), -1))
            for name, row in zip(member.inputs, size, strict=True):
                found.setdefault(name, []).append((float(row @ np.array(member.ladder_s)), float(row.sum())))
        return {name: sum(a for a, _ in pairs) / max(sum(b for _, b in pairs), 1e-300) for name, pairs in found.items()}

    def predict(self, time_s: Array, signals: Mapping[str, Array]) -> Array:
        """Predicts drift (n,) from rows that begin in equilibrium, as the data did. Raises MCH-SIGNAL."""
        if missing := [name for name in self.signals if name not in signals]:
            raise Code.MCH_SIGNAL.refusal(
                f"{len(missing)} signals that the drift model needs are not given: {', '.join(missing)}",
                hint="log the temperatures and the speed that it was made from, under the same names",
                values={"signals": missing},
            )
        inputs = _inputs({name: signals[name] for name in self.signals})
        total = np.zeros(len(time_s))
        for member in self.summed():
            total += (
                member.constant + _columns(time_s, inputs, member.inputs, member.ladder_s, self.start) @ member.weights
            )
        return total / len(self.members)

    def summed(self) -> list[Member]:
        """Returns a ladder's members and the inputs added up: the model is their sum over `len(members)`."""
        found: dict[tuple[object, object], Member] = {}
        for member in self.members:
            key = (member.inputs, member.ladder_s)
            if key in found:
                weights, constant = found[key].weights + member.weights, found[key].constant + member.constant
                found[key] = replace(member, weights=weights, constant=constant)
            else:
                found[key] = member
        return list(found.values())


def fit_drift(
    time_s: Array, signals: Mapping[str, Array], drift: Array, ladders_s: Sequence[tuple[float, ...]] = LADDERS_S
) -> DriftModel:
    """Finds the model of one channel. `signals` are temperatures, and the spindle's speed under a name with `rpm`.

    Ladders of (0,) alone make a static model. Raises MCH-DATA for less than 100 rows or without a signal.
    Valid within the speeds and temperatures of the data and a little beyond: heat grows with speed and its square, and
    no faster.
    """
    if len(time_s) < 100 or len(drift) != len(time_s) or not signals:
        raise Code.MCH_DATA.refusal(
            f"{len(time_s)} times, {len(drift)} displacements and {len(signals)} signals determine no dynamic model",
            hint="record temperatures or speeds through a warm-up and a cool-down, a row every few seconds to a minute",
        )
    inputs = _inputs(signals)
    start = {name: float(values[0]) for name, values in inputs.items()}
    rows = np.unique(np.linspace(0, len(time_s) - 1, min(ROWS, len(time_s))).astype(int))
    members = []
    for ladder in ladders_s:
        columns = _columns(time_s, inputs, tuple(inputs), ladder, start)[rows]
        members += [_member(tuple(inputs), columns, drift[rows], ladder, blocks) for blocks in BLOCKS]
    known = {name: (float(values.min()), float(values.max())) for name, values in signals.items()}
    return DriftModel(tuple(members), start, known)


def _inputs(signals: Mapping[str, Array]) -> dict[str, Array]:
    """Temperatures as they are; a speed in 1000 rev/min, and its square, which is what bearings heat with."""
    inputs: dict[str, Array] = {}
    for name, values in signals.items():
        if "rpm" in name:
            inputs[name] = values / SPEED_SCALE
            inputs[f"{name}{SQUARE}"] = values**2 / SQUARE_SCALE
        else:
            inputs[name] = values
    return inputs


def _columns(
    time_s: Array,
    inputs: Mapping[str, Array],
    names: Sequence[str],
    ladder_s: Sequence[float],
    start: Mapping[str, float],
) -> Array:
    chosen = np.stack([inputs[name] - start[name] for name in names], axis=1)
    return lagged(time_s, chosen, np.array(ladder_s)).reshape(len(time_s), -1)


def _member(inputs: tuple[str, ...], columns: Array, drift: Array, ladder: tuple[float, ...], blocks: int) -> Member:
    """Fits a member with all inputs, its weights held as small as leaves least of the blocks left out."""
    errors = np.zeros(len(STRENGTHS))
    ends = np.linspace(0, len(drift), blocks + 1).astype(int)
    for part in [slice(int(a), int(b)) for a, b in pairwise(ends)]:
        others = np.delete(np.arange(len(drift)), part)
        weights, constants = _held_small(columns[others], drift[others])
        errors += np.sum((drift[part, None] - columns[part] @ weights - constants) ** 2, axis=0)
    best = int(errors.argmin())
    weights, constants = _held_small(columns, drift)
    return Member(inputs, ladder, weights[:, best], float(constants[best]))


def _held_small(columns: Array, drift: Array) -> tuple[Array, Array]:
    """Returns (weights (columns, strengths), constants (strengths,)) of ridge regressions over unit-spread columns."""
    mean, spread = columns.mean(axis=0), columns.std(axis=0)
    spread = np.where(spread > 1e-9 * np.abs(columns).max(initial=0.0), spread, np.inf)
    scaled = (columns - mean) / spread
    size, directions = np.linalg.eigh(scaled.T @ scaled)
    right = directions.T @ (scaled.T @ (drift - drift.mean()))
    penalties = np.array(STRENGTHS) * len(drift)
    weights: Array = directions @ (right[:, None] / (size[:, None] + penalties)) / spread[:, None]
    constants: Array = drift.mean() - mean @ weights
    return weights, constants


REZEROED_H: Final = (1.0, 2.0, 4.0, 8.0)
"""Hours between references that are tried."""

STATIC = ((0.0,),)
"""The ladder of a model that knows no past."""


@dataclass(frozen=True)
class DriftRun:
    """One channel, µm: `predicted_um` (k,) for its last k rows, and root mean squares over them.

    `rms_um` of what the model of the earlier rows leaves there, `static_rms_um` of what one without the past leaves,
    `raw_um` of the displacement itself against the mean of the earlier rows, `rezeroed_um` of what is left where an
    operator's reference sets it to zero every so many hours (hours to RMS).
    """

    channel: str
    predicted_um: Array
    rms_um: float
    static_rms_um: float
    raw_um: float
    rezeroed_um: Mapping[float, float] = field(default_factory=dict)


def held_out(test: DriftTest, share: float) -> list[DriftRun]:
    """Predicts every channel's last `share` of the time from the time before. Raises MCH-DATA for too few rows."""
    known = test.time_s <= test.time_s[-1] - share * (test.time_s[-1] - test.time_s[0])
    before = {name: values[known] for name, values in test.signals.items()}
    runs = []
    for channel, moved_mm in test.displacement_mm.items():
        moved = UM_PER_MM * moved_mm
        model = fit_drift(test.time_s[known], before, moved[known])
        static = fit_drift(test.time_s[known], before, moved[known], STATIC)
        found = model.predict(test.time_s, test.signals)[~known]
        still = static.predict(test.time_s, test.signals)[~known]
        rest = moved[~known]
        rezeroed = {hours: rms(since_reference(test.time_s[~known], rest - found, hours)) for hours in REZEROED_H}
        raw = rms(rest - float(moved[known].mean()))
        runs.append(
            DriftRun(
                channel=channel,
                predicted_um=found,
                rms_um=rms(rest - found),
                static_rms_um=rms(rest - still),
                raw_um=raw,
                rezeroed_um=rezeroed,
            )
        )
    return runs


def judged_models(test: DriftTest, runs: Sequence[DriftRun]) -> dict[str, DriftModel]:
    """Returns each channel's model of the log, with the residual of its beginning's model. Raises MCH-DATA."""
    return {
        run.channel: replace(
            fit_drift(test.time_s, test.signals, UM_PER_MM * test.displacement_mm[run.channel]), left_um=run.rms_um
        )
        for run in runs
    }


def since_reference(time_s: Array, off: Array, every_h: float) -> Array:
    """Returns the residual of deviations (n,) where each is counted from the first row of its `every_h` hours."""
    number = np.floor((time_s - time_s[0]) / (3600 * every_h))
    _, first, own = np.unique(number, return_index=True, return_inverse=True)
    left: Array = off - off[first[own.ravel()]]
    return left


def predicted_um(
    models: Mapping[str, DriftModel], test: DriftTest, extrapolate: Collection[str] = ()
) -> dict[str, Array]:
    """Predicts each channel's drift (n,) at the log's times. Raises MCH-SIGNAL, and MCH-RANGE for signals beyond the
    data.

    Those in `extrapolate`, named with or without their unit, may leave the data: the model goes on as its functions do.
    """
    found = {channel: model.predict(test.time_s, test.signals) for channel, model in models.items()}
    known = {(column, model.known[column]) for model in models.values() for column in model.signals}
    named = [(column, *column.rpartition("_")[::2], limits) for column, limits in sorted(known)]
    check_ranges(
        (name, test.signals[column], limits, SIGNALS[f"_{ending}"])
        for column, name, ending, limits in named
        if not {name, column} & set(extrapolate)
    )
    return found


STILL_RPM: Final = 1.0
"""Difference of a spindle's speed at a log's first row from that of the model's data within which both begin alike."""


def begun_warm(models: Mapping[str, DriftModel], test: DriftTest) -> list[Finding]:
    """Returns a warning for each spindle that turns at the log's first row otherwise than where the data began.

    Lags count from the first row as from equilibrium: what the machine felt before is not in the log.
    """
    start = {column: model.start[column] for model in models.values() for column in model.signals}
    turning = {
        name: float(speed[0])
        for name, speed in test.speed.items()
        if abs(speed[0] - start.get(f"{name}_rpm", speed[0])) > STILL_RPM
    }
    return [
        Finding(
            Severity.WARNING,
            Code.MCH_HISTORY,
            f"the log begins with {name} at {speed:g} rev/min, the model's data at {start[f'{name}_rpm']:g} rev/min: "
            "what the machine felt before is not known, and is taken for equilibrium",
            hint="begin the log before the spindle starts; deviations fade within three time constants of the model",
        )
        for name, speed in turning.items()
    ]


def compared(found_um: Mapping[str, Array], test: DriftTest) -> dict[str, tuple[float, float]]:
    """Compares the channels that the log holds as well: RMS of read − predicted in µm, and that about its mean."""
    left = {
        name: UM_PER_MM * test.displacement_mm[name] - found_um[name]
        for name in found_um
        if name in test.displacement_mm
    }
    return {name: (rms(rest), float(np.std(rest))) for name, rest in left.items()}


def with_drift(model: MachineModel, drift: DriftModel, error: ErrorName) -> MachineModel:
    """Adds a drift to the model, in µm along the axis of `error`, a displacement of place such as EZ0S.

    Its standard uncertainty is the residual of the drift model in rows held out, the same everywhere. Raises MCH-AXIS
    for an error that the machine does not have or that does not depend on place, MCH-DATA for one that the model has
    already.
    """
    sense = _sense(model.machine.chain, error)
    if any(term.name == error for term in model.terms):
        raise Code.MCH_DATA.refusal(
            f"the model of {len(model.terms)} terms has {error} already: what drifts would count twice",
            hint=f"leave {error} out of the machine file and fit again, or add the drift to another model",
        )
    constant, found = _weights(drift)
    lags, parts = {}, [Part(CONSTANT)]
    for name, constant_s, power in found:
        lag = _lag(error, name, constant_s, power)
        if lag is not None:
            lags[lag.name] = lag
        parts.append(Part(CONSTANT, lag.name if lag else _signal(name), _raw(drift.start[name], name)))
    own = np.array([constant, *(b / _raw(1.0, name) for (name, _, _), b in found.items())]) * sense / UM_PER_MM
    known = {_signal(column): ends for column, ends in drift.known.items()}
    known |= {lag.name: _powered(known[lag.of], lag.power) for lag in lags.values()}
    units = {_signal(column): SIGNALS[f"_{column.rpartition('_')[2]}"] for column in drift.known}
    return replace(
        model,
        terms=(*model.terms, Term(error, tuple(parts))),
        coefficients=np.concatenate([model.coefficients, own]),
        covariance=_covariance(model, len(own), len(lags), drift.left_um / UM_PER_MM),
        identified={**known, **model.identified},
        lags=(*model.lags, *lags.values()),
        units={**units, **model.units},
        version=None,
    )


def turned(drift: DriftModel) -> DriftModel:
    """Returns the drift of a channel that reads in the opposite sense."""
    members = [replace(member, weights=-member.weights, constant=-member.constant) for member in drift.members]
    return replace(drift, members=tuple(members))


def zeroed_at(model: MachineModel, then: Signals) -> MachineModel:
    """Returns the model of a machine whose work zero was set when its signals and lags were `then`.

    The drift up to that moment lies in the zero: displacements of place that depend on signals count from there,
    and their constants are gone.
    """
    terms, coefficients = [], model.coefficients.copy()
    for term, where in zip(model.terms, model.slices(), strict=True):
        drifts = term.name.place and not term.name.is_rotation and term.needs()
        parts = [_from(part, then) for part in term.parts] if drifts else list(term.parts)
        if drifts:
            still = np.concatenate([np.full(part.basis.size, part.signal is None) for part in term.parts])
            coefficients[where] *= ~np.tile(still, 2 if term.both_ways else 1)
        terms.append(replace(term, parts=tuple(parts)))
    return replace(model, terms=tuple(terms), coefficients=coefficients)


def _from(part: Part, then: Signals) -> Part:
    if part.signal is None:
        return part
    part.factor(then)
    return replace(part, reference=float(np.mean(then[part.signal])))


def _sense(chain: Chain, error: ErrorName) -> float:
    """Returns the sense in which the error moves the tool as seen from the work, forward or back along its own axis."""
    if error not in chain.errors() or not error.place or error.is_rotation:
        places = [str(name) for name in chain.errors() if name.place and not name.is_rotation]
        raise Code.MCH_AXIS.refusal(
            f"{error} is no displacement of place of the machine; it has {len(places)}: {' '.join(places)}",
            hint="a drift moves the spindle as a whole: EX0S, EY0S, EZ0S, on a lathe EX0C, EZ0C",
        )
    unit = influences(chain, chain.positions({}), ZERO, {error})[error].displacement[0]
    return float(unit[error.number])


def _weights(drift: DriftModel) -> tuple[float, Mapping[tuple[str, float, int], float]]:
    """Returns the constant, and the weight of every input after every time constant, summed over the members; µm."""
    share, constant = 1.0 / len(drift.members), 0.0
    found: dict[tuple[str, float, int], float] = {}
    for member in drift.members:
        constant += share * member.constant
        keys = [(name, tau) for name in member.inputs for tau in member.ladder_s]
        for (name, tau), weight in zip(keys, member.weights.tolist(), strict=True):
            key = (name, tau, 2 if name.endswith(SQUARE) else 1)
            found[key] = found.get(key, 0.0) + share * weight
    return constant, found


def _lag(error: ErrorName, name: str, constant_s: float, power: int) -> Lag | None:
    """Returns the signal behind an input; None where it is a sensor as it is."""
    if constant_s == 0.0 and power == 1:
        return None
    return Lag(f"{error}: {_signal(name)}^{power} after {constant_s:g} s", _signal(name), constant_s, power)


def _signal(column: str) -> str:
    return column.removesuffix(SQUARE).rpartition("_")[0]


def _raw(value: float, name: str) -> float:
    """Returns a drift model's input in the unit of the signal, or of its square."""
    if name.endswith(SQUARE):
        return value * SQUARE_SCALE
    return value * SPEED_SCALE if "rpm" in name else value


def _powered(ends: tuple[float, float], power: int) -> tuple[float, float]:
    return ends if power == 1 else (min(0.0, ends[0]) ** 2, max(map(abs, ends)) ** 2)


def _covariance(model: MachineModel, own: int, lags: int, left_mm: float) -> Array:
    """Those of the model, the drift's constant with `left_mm`, what else it has with none."""
    old, size = len(model.coefficients), len(model.coefficients) + own + len(model.lags) + lags
    covariance = np.zeros((size, size))
    places = np.concatenate([np.arange(old), old + own + np.arange(len(model.lags))])
    covariance[np.ix_(places, places)] = model.covariance
    covariance[old, old] = left_mm**2
    return covariance
