"""Readings of a machine's characterization: where it stood, what was read, along which direction."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.history import Clock, Lag, joined_clocks, lag_signals, moved_along
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
