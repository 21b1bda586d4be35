"""Thermal drift as a function of the past of all temperatures and of the spindle speed: a dynamic model, by channel.

    drift = c + Σ over inputs Σ over time constants  b · (lag of the input)

The weights b over a ladder of time constants say how fast a part follows, so the constants are estimated with them:
`mean_constant_s` is their weighted mean. Small data that move together would give any weights; so all are held small
together (ridge over columns of unit spread). Choosing few inputs instead, one by one, takes those that happen to fit.
How small is decided by blocks of consecutive rows left out in turn, for which no neighbour in time helps, of several
lengths; models over several ladders and block lengths are averaged. The mean of linear models is a linear model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.lag import lagged

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
        """All inputs that any member uses."""
        return tuple(dict.fromkeys(name for member in self.members for name in member.inputs))

    @property
    def signals(self) -> tuple[str, ...]:
        """The signals that those are made of."""
        return tuple(dict.fromkeys(name.removesuffix(SQUARE) for name in self.inputs))

    @property
    def mean_constant_s(self) -> dict[str, float]:
        """Time constant of each input: mean over the ladders, weighted with the size of the weights."""
        found: dict[str, list[tuple[float, float]]] = {}
        for member in self.members:
            size = np.abs(member.weights.reshape(len(member.inputs), -1))
            for name, row in zip(member.inputs, size, strict=True):
                found.setdefault(name, []).append((float(row @ np.array(member.ladder_s)), float(row.sum())))
        return {name: sum(a for a, _ in pairs) / max(sum(b for _, b in pairs), 1e-300) for name, pairs in found.items()}

    def predict(self, time_s: Array, signals: Mapping[str, Array]) -> Array:
        """Drift (n,) from rows that begin in equilibrium, as the data did. Raises MCH-SIGNAL for a signal left out."""
        if missing := [name for name in self.signals if name not in signals]:
            raise TrueloopError(
                Code.MCH_SIGNAL,
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
        """The members of one ladder and the same inputs added up: the model is their sum over `len(members)`."""
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
    time_s: Array,
    signals: Mapping[str, Array],
    drift: Array,
    ladders_s: Sequence[tuple[float, ...]] = LADDERS_S,
) -> DriftModel:
    """Finds the model of one channel. `signals` are temperatures, and the spindle's speed under a name with `rpm`.

    Ladders of (0,) alone make a static model. Raises MCH-DATA for less than 100 rows or without a signal.
    Valid within the speeds and temperatures of the data and a little beyond: heat grows with speed and its square, and
    no faster.
    """
    if len(time_s) < 100 or len(drift) != len(time_s) or not signals:
        raise TrueloopError(
            Code.MCH_DATA,
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
    """All inputs, held as small as leaves least of the blocks left out."""
    errors = np.zeros(len(STRENGTHS))
    for part in _blocks(len(drift), blocks):
        others = np.delete(np.arange(len(drift)), part)
        weights, constants = _held_small(columns[others], drift[others])
        errors += np.sum((drift[part, None] - columns[part] @ weights - constants) ** 2, axis=0)
    best = int(errors.argmin())
    weights, constants = _held_small(columns, drift)
    return Member(inputs, ladder, weights[:, best], float(constants[best]))


def _held_small(columns: Array, drift: Array) -> tuple[Array, Array]:
    """(weights (columns, strengths), constants (strengths,)) of ridge regressions over columns of unit spread."""
    mean, spread = columns.mean(axis=0), columns.std(axis=0)
    spread = np.where(spread > 1e-9 * np.abs(columns).max(initial=0.0), spread, np.inf)
    scaled = (columns - mean) / spread
    size, directions = np.linalg.eigh(scaled.T @ scaled)
    right = directions.T @ (scaled.T @ (drift - drift.mean()))
    penalties = np.array(STRENGTHS) * len(drift)
    weights: Array = directions @ (right[:, None] / (size[:, None] + penalties)) / spread[:, None]
    constants: Array = drift.mean() - mean @ weights
    return weights, constants


def _blocks(count: int, blocks: int) -> list[slice]:
    ends = np.linspace(0, count, blocks + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]
