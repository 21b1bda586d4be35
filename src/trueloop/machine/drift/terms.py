"""A drift model as terms of a machine model: both are linear in lags of signals, so a drift becomes one error's term.

A channel moves the tool as seen from the work along X, Y or Z; the term is the displacement of place that does so.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.drift.model import SPEED_SCALE, SQUARE, SQUARE_SCALE, DriftModel
from trueloop.machine.model.chain import ZERO, Chain
from trueloop.machine.model.history import Lag
from trueloop.machine.model.jacobian import influences
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.names import ErrorName
from trueloop.machine.model.position_basis import CONSTANT
from trueloop.machine.model.term import Part, Signals, Term
from trueloop.units import SIGNALS, UM_PER_MM


def with_drift(model: MachineModel, drift: DriftModel, error: ErrorName) -> MachineModel:
    """The model and a drift, in µm along the axis of `error`, a displacement of place such as EZ0S.

    Its standard uncertainty is what the drift model left of rows held out, the same everywhere. Raises MCH-AXIS for an
    error that the machine does not have or that is none of place, MCH-DATA for one that the model has already.
    """
    sense = _sense(model.machine.chain, error)
    if any(term.name == error for term in model.terms):
        raise TrueloopError(
            Code.MCH_DATA,
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
    """The drift of a channel that reads the other way."""
    members = [replace(one, weights=-one.weights, constant=-one.constant) for one in drift.members]
    return replace(drift, members=tuple(members))


def zeroed_at(model: MachineModel, then: Signals) -> MachineModel:
    """The model of a machine whose work zero was set when its signals and lags were `then`.

    What it had drifted by that moment lies in the zero: displacements of place that depend on signals count from there,
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
    """Whether the error moves the tool as seen from the work forward or back along its own axis."""
    if error not in chain.errors() or not error.place or error.is_rotation:
        places = [str(name) for name in chain.errors() if name.place and not name.is_rotation]
        raise TrueloopError(
            Code.MCH_AXIS,
            f"{error} is no displacement of place of the machine; it has {len(places)}: {' '.join(places)}",
            hint="a drift moves the spindle as a whole: EX0S, EY0S, EZ0S, on a lathe EX0C, EZ0C",
        )
    unit = influences(chain, chain.positions({}), ZERO, {error})[error].displacement[0]
    return float(unit[error.number])


def _weights(drift: DriftModel) -> tuple[float, Mapping[tuple[str, float, int], float]]:
    """The constant, and the weight of every input after every time constant, summed over the members; µm."""
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
    """The signal behind an input; None where it is a sensor as it is."""
    if constant_s == 0.0 and power == 1:
        return None
    return Lag(f"{error}: {_signal(name)}^{power} after {constant_s:g} s", _signal(name), constant_s, power)


def _signal(column: str) -> str:
    return column.removesuffix(SQUARE).rpartition("_")[0]


def _raw(value: float, name: str) -> float:
    """A drift model's input in the unit of the signal, or of its square."""
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
