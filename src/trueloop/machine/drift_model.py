"""Thermal drift as a function of the past of few temperatures and of the spindle speed: a dynamic model, by channel.

    drift = c + Σ over inputs Σ over time constants  b · (lag of the input)

The weights b over a ladder of time constants say how fast a part follows, so the constants are estimated with them:
`mean_constant_s` is their weighted mean. Small data that move together would give any weights; so they are held small
(ridge, in µm/K), few inputs are chosen, each only if it makes blocks of time that were left out better predicted, and
models over several ladders, strengths and blocks are averaged. The mean of linear models is a linear model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Final

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.lag import lagged

LADDERS_S: Final = ((0.0, 600.0, 1800.0, 5400.0, 16200.0), (0.0, 900.0, 3600.0, 14400.0))
STRENGTHS: Final = (0.03, 0.1)
BLOCKS: Final = (6, 9)
MOST_INPUTS: Final = 5
GAIN: Final = 0.03
"""An input is taken when it lowers the mean square of the blocks left out by 3 %."""

ROWS: Final = 1000
"""Rows that a fit uses, evenly taken: drift is slow."""

SQUARE: Final = "²"
SPEED_SCALE: Final = 1000.0
"""Speed in 1000 rev/min, and its square over 5, weigh as much as a few kelvins."""


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

    `known` are the ranges of the data's signals, by the signals' names.
    """

    members: tuple[Member, ...]
    start: Mapping[str, float]
    known: Mapping[str, tuple[float, float]]

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
            )
        inputs = _inputs({name: signals[name] for name in self.signals})
        total = np.zeros(len(time_s))
        for member in self.members:
            total += (
                member.constant + _columns(time_s, inputs, member.inputs, member.ladder_s, self.start) @ member.weights
            )
        return total / len(self.members)


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
        columns = {name: _columns(time_s, inputs, (name,), ladder, start)[rows] for name in inputs}
        for strength, blocks in product(STRENGTHS, BLOCKS):
            members.append(_member(columns, drift[rows], ladder, strength, blocks))
    known = {name: (float(values.min()), float(values.max())) for name, values in signals.items()}
    return DriftModel(tuple(members), start, known)


def _inputs(signals: Mapping[str, Array]) -> dict[str, Array]:
    """Temperatures as they are; a speed in 1000 rev/min, and its square, which is what bearings heat with."""
    inputs: dict[str, Array] = {}
    for name, values in signals.items():
        if "rpm" in name:
            inputs[name] = values / SPEED_SCALE
            inputs[f"{name}{SQUARE}"] = (values / SPEED_SCALE) ** 2 / 5
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


def _member(
    columns: Mapping[str, Array], drift: Array, ladder: tuple[float, ...], strength: float, blocks: int
) -> Member:
    """The heat of the spindle first; then inputs one by one, the best first, while the blocks left out gain by it."""
    chosen = [name for name in columns if name.endswith(SQUARE)]
    best = _left_out(columns, chosen, drift, strength, blocks) if chosen else float(np.var(drift))
    while len(chosen) < min(MOST_INPUTS, len(columns)):
        others = [name for name in columns if name not in chosen]
        error, name = min((_left_out(columns, [*chosen, name], drift, strength, blocks), name) for name in others)
        if chosen and error > best * (1 - GAIN):
            break
        chosen.append(name)
        best = error
    design = _with_constant(np.hstack([columns[name] for name in chosen]))
    solution = np.linalg.solve(design.T @ design + _ridge(design, strength), design.T @ drift)
    weights = np.asarray(solution[1:], dtype=np.float64)
    return Member(tuple(chosen), ladder, weights, float(solution[0]))


def _left_out(columns: Mapping[str, Array], names: Sequence[str], drift: Array, strength: float, blocks: int) -> float:
    """Mean square of what each block of time shows beyond a model made from all others."""
    design = _with_constant(np.hstack([columns[name] for name in names]))
    parts = [
        (design[part].T @ design[part], design[part].T @ drift[part], part) for part in _blocks(len(drift), blocks)
    ]
    normal, right = sum(p[0] for p in parts) + _ridge(design, strength), sum(p[1] for p in parts)
    total = 0.0
    for own_normal, own_right, part in parts:
        rest = drift[part] - design[part] @ np.linalg.solve(normal - own_normal, right - own_right)
        total += float(rest @ rest)
    return total / len(drift)


def _blocks(count: int, blocks: int) -> list[slice]:
    ends = np.linspace(0, count, blocks + 1).astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


def _with_constant(columns: Array) -> Array:
    return np.hstack([np.ones((len(columns), 1)), columns])


def _ridge(design: Array, strength: float) -> Array:
    penalty = strength * len(design) * np.eye(design.shape[1])
    penalty[0, 0] = 0.0
    return penalty
