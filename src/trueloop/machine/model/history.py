"""Signals made of the past of others: the lags of a model, and the histories of sensors that they are computed from.

A lag is a signal like any other once it is computed, so terms, tables and the compiled form know nothing of time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code


def lagged(time_s: Array, inputs: Array, constants_s: Array) -> Array:
    """Solves τ dy/dt + y = u for each input and time constant, (n, inputs, constants).

    Exact for inputs that run straight between the rows; in equilibrium at the first row (y = u). τ = 0 gives u itself.
    `inputs` (n, inputs), times ascending in any steps. Raises MCH-DATA for times that do not ascend.
    """
    step_s = np.diff(time_s)
    if np.any(step_s <= 0):
        raise Code.MCH_DATA.refusal(
            f"times do not ascend at row {int(np.argmax(step_s <= 0)) + 2}",
            hint="sort the rows by time and drop repeated ones",
        )
    return np.stack([_one(step_s, inputs, max(float(tau), 1e-9)) for tau in constants_s], axis=-1)


def _one(step_s: Array, inputs: Array, tau: float) -> Array:
    """Solves y[k+1] = decay·y[k] + u[k+1] − decay·u[k] − τ·slope·(1 − decay): a bidiagonal system, in one call."""
    from scipy.linalg import solve_banded

    decay = np.exp(-step_s / tau)[:, None]
    slope = np.diff(inputs, axis=0) / step_s[:, None]
    right = np.vstack([inputs[:1], inputs[1:] - decay * inputs[:-1] - tau * slope * (1 - decay)])
    bands = np.ones((2, len(inputs)))
    bands[1, :-1] = -decay[:, 0]
    solution: Array = solve_banded((1, 0), bands, right)
    return solution


STEP = 1e-3
"""Step of ln τ for the derivative by τ: the error of the difference is a millionth of it."""


@dataclass(frozen=True)
class Lag:
    """The signal `name`: `of` to the `power`, after a first-order lag of `constant_s`.

    Bearings heat with a power of speed between one and two: give a lag of each. `between_s` are the bounds within which
    the constant is sought; None: it is given. `u_relative` is the standard uncertainty of ln τ.
    """

    name: str
    of: str
    constant_s: float
    power: int = 1
    between_s: tuple[float, float] | None = None
    u_relative: float = 0.0


@dataclass(frozen=True)
class History:
    """The record of sensors: `time_s` (m,) ascending, each signal (m,) from equilibrium; `units` where known."""

    time_s: Array
    signals: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)

    def until(self, time_s: float) -> "History":
        """Returns the rows up to that time. Raises MCH-HISTORY where there are none."""
        rows = self.time_s <= time_s
        if not rows.any():
            raise Code.MCH_HISTORY.refusal(
                f"the history of the signals begins at {self.time_s[0]:g} s, after {time_s:g} s",
                hint="times are those of the column time_s of the log",
            )
        return History(self.time_s[rows], {name: v[rows] for name, v in self.signals.items()}, self.units)


@dataclass(frozen=True)
class Clock:
    """The times of n readings, `time_s` (n,), on the clock of history number `source` (n,)."""

    time_s: Array
    source: NDArray[np.intp]
    histories: tuple[History, ...]

    def only(self, rows: NDArray[np.bool_]) -> "Clock":
        """Returns some of the readings; histories stay whole."""
        return Clock(self.time_s[rows], self.source[rows], self.histories)


def joined_clocks(clocks: Sequence[Clock]) -> Clock:
    """Readings one after the other, each on its own history."""
    starts = np.cumsum([0, *(len(clock.histories) for clock in clocks)])
    return Clock(
        np.concatenate([clock.time_s for clock in clocks]),
        np.concatenate([clock.source + start for clock, start in zip(clocks, starts, strict=False)]),
        tuple(history for clock in clocks for history in clock.histories),
    )


def units_of(clock: Clock | None) -> dict[str, str]:
    """Returns the units of all histories' signals."""
    histories = clock.histories if clock else ()
    return {name: unit for history in histories for name, unit in history.units.items()}


def lag_units(lags: Sequence[Lag], units: Mapping[str, str]) -> dict[str, str]:
    """Returns the units of lags: those of the signals they follow, to their power."""
    known = [lag for lag in lags if lag.of in units]
    return {lag.name: units[lag.of] if lag.power == 1 else f"({units[lag.of]})^{lag.power}" for lag in known}


def slope_name(lag: Lag) -> str:
    """Returns the name of the signal dy/d ln τ: the change of the lag with its own time constant."""
    return f"d {lag.name} / d ln τ"


def moved_along(lag: Lag, signals: Mapping[str, Array | float]) -> dict[str, Array | float]:
    """Returns the signals with the lag moved by its slope, where they hold one: ln τ larger by 1, to first order."""
    return {**signals, lag.name: signals[lag.name] + signals.get(slope_name(lag), 0.0)}


def logged(clock: Clock) -> dict[str, Array]:
    """Returns each signal that all histories hold, at each reading, (n,), linear between rows. Raises MCH-HISTORY."""
    names = set.intersection(*(set(history.signals) for history in clock.histories))
    found = {name: np.empty(len(clock.time_s)) for name in sorted(names)}
    for number, history in enumerate(clock.histories):
        own = clock.source == number
        _check_covered(clock.time_s[own], history)
        for name, values in found.items():
            values[own] = np.interp(clock.time_s[own], history.time_s, history.signals[name])
    return found


def lag_signals(lags: Sequence[Lag], clock: Clock) -> dict[str, Array]:
    """Returns every lag and its slope at each reading, (n,). Between rows of a history a lag runs straight.

    Raises MCH-HISTORY for readings outside a history, MCH-SIGNAL for a lag of a signal that it does not hold.
    """
    found = {name: np.empty(len(clock.time_s)) for lag in lags for name in (lag.name, slope_name(lag))}
    for number, history in enumerate(clock.histories):
        own = clock.source == number
        _check_covered(clock.time_s[own], history)
        for lag in lags:
            value, slope = _lag_and_slope(lag, history)
            found[lag.name][own] = np.interp(clock.time_s[own], history.time_s, value)
            found[slope_name(lag)][own] = np.interp(clock.time_s[own], history.time_s, slope)
    return found


def signals_at_end(history: History, lags: Sequence[Lag]) -> dict[str, Array | float]:
    """Signals and lags at the last row: what a machine feels now. Raises as `lag_signals`."""
    end = Clock(history.time_s[-1:], np.zeros(1, dtype=np.intp), (history,))
    return {name: float(values[0]) for name, values in (logged(end) | lag_signals(lags, end)).items()}


def check_lags_given(lags: Sequence[Lag], signals: Mapping[str, Array | float]) -> None:
    """Raises MCH-HISTORY for a lag that is not among the signals: one reading of its sensor does not determine it."""
    for lag in lags:
        if lag.name not in signals:
            raise Code.MCH_HISTORY.refusal(
                f"the model needs {lag.name!r}: {lag.of} after a lag of {lag.constant_s:.0f} s, which one reading of "
                f"{lag.of!r} does not say",
                hint=f"give a log with time_s and {lag.of}; or {lag.name} itself, in a steady state {lag.of} "
                + (f"to the power {lag.power}" if lag.power > 1 else "as it is"),
            )


def _lag_and_slope(lag: Lag, history: History) -> tuple[Array, Array]:
    if lag.of not in history.signals:
        raise Code.MCH_SIGNAL.refusal(
            f"{lag.name} is a lag of {lag.of!r}; the history has {len(history.signals)} signals: "
            f"{', '.join(history.signals) or 'none'}",
            hint="record that signal too, in the unit it had in the data that the model was made from",
            values={"signals": [lag.of]},
        )
    constants = lag.constant_s * np.array([1.0, 1.0 - STEP, 1.0 + STEP])
    value, less, more = lagged(history.time_s, history.signals[lag.of][:, None] ** lag.power, constants)[:, 0].T
    return value, (more - less) / (2 * STEP)


def _check_covered(time_s: Array, history: History) -> None:
    if len(time_s) and (time_s.min() < history.time_s[0] or time_s.max() > history.time_s[-1]):
        raise Code.MCH_HISTORY.refusal(
            f"readings from {time_s.min():g} to {time_s.max():g} s, but the history of the signals is from "
            f"{history.time_s[0]:g} to {history.time_s[-1]:g} s",
            hint="both on one clock; record temperatures from before the first reading until after the last",
        )
