"""Lags of a model while the machine runs: one step at a time, as exact as `lagged` (`machine/model/history.py`) is.

A lag follows from all readings of its sensor. What was before the first reading is not known: the lag begins in
equilibrium, and whatever that hides dies away with e^(−t/τ). It counts as known when `settle` time constants have
passed, or at once where an operator states that the machine was in equilibrium then.
"""

import math
from dataclasses import dataclass, replace

from trueloop.machine.model.history import History, Lag


@dataclass(frozen=True)
class LagRules:
    """Rules for when a lag is known. `settle` and `gap` count time constants, all else is in s.

    A pause of the sensor longer than `gap` τ, and than `least_gap_s`, begins the lag anew; through shorter ones it runs
    straight. `equilibrium_s`: when the machine was in equilibrium, on the clock of the readings; NaN: not stated.
    """

    settle: float = 5.0
    gap: float = 0.2
    least_gap_s: float = 3.0
    equilibrium_s: float = math.nan

    def gap_s(self, lag: Lag) -> float:
        """Returns the longest pause between two readings that does not begin the lag anew, s."""
        return max(self.gap * lag.constant_s, self.least_gap_s)


@dataclass(frozen=True)
class LagState:
    """A lag at `time_s`: `input`, its sensor's reading to its power, and `value`, in the same unit. `since_s`: when it
    was begun; `stated`: in equilibrium then, as an operator stated.
    """

    time_s: float
    input: float
    value: float
    since_s: float
    stated: bool

    def known(self, lag: Lag, rules: LagRules) -> bool:
        """Returns whether what was before the lag's beginning has died away."""
        return self.stated or self.known_in_s(lag, rules) <= 0

    def known_in_s(self, lag: Lag, rules: LagRules) -> float:
        """Returns the time until the lag is known, s, where readings go on."""
        return 0.0 if self.stated else self.since_s + rules.settle * lag.constant_s - self.time_s


def advanced(state: LagState | None, lag: Lag, rules: LagRules, time_s: float, reading: float) -> LagState:
    """Returns the lag one reading later, the sensor having run straight since the last one. None: there was none.

    A reading that is not later than the last one changes nothing.
    """
    given = reading**lag.power
    stated = 0 <= time_s - rules.equilibrium_s <= rules.gap_s(lag)
    if state is None or (stated and state.time_s < rules.equilibrium_s):
        return LagState(time_s, given, given, time_s, stated)
    step_s = time_s - state.time_s
    if step_s <= 0:
        return state
    if step_s > rules.gap_s(lag):
        return LagState(time_s, given, given, time_s, stated=False)
    return replace(state, time_s=time_s, input=given, value=_stepped(state, lag, step_s, given))


def _stepped(state: LagState, lag: Lag, step_s: float, given: float) -> float:
    """Returns the solution of τ dy/dt + y = u after a step in which u runs straight."""
    tau = max(lag.constant_s, 1e-9)
    decay = math.exp(-step_s / tau)
    slope = (given - state.input) / step_s
    return decay * state.value + given - decay * state.input - tau * slope * (1 - decay)


def from_history(lag: Lag, rules: LagRules, history: History) -> LagState | None:
    """Returns the lag at the last row of a history; None where its sensor is not in it."""
    state = None
    for time_s, reading in zip(history.time_s.tolist(), history.signals.get(lag.of, ()), strict=False):
        state = advanced(state, lag, rules, time_s, float(reading))
    return state
