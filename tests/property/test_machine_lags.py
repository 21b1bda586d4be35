"""A lag through a whole history: a truth integrated step by step, never by the code under test, is found again."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.machines import chain_with_travel
from trueloop.arrays import Array
from trueloop.machine.identify.identify import identify
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.history import Clock, History, Lag, lag_signals
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import CONSTANT, Part, Term

MILL = Machine("mill", chain_with_travel("mill-table-x"))
TERM = Term(error_name("EZ0S"), (Part(), Part(CONSTANT, "late", 20.0)))
OFFSET_MM, PER_KELVIN_MM = 3e-3, 2e-3
STEPS = 40
"""Steps of the integration between two rows of the history."""


def _history(rng: np.random.Generator) -> History:
    """Ten hours in rows of 20 to 100 s: two waves and a step, straight between the rows."""
    time_s = np.cumsum(np.r_[0.0, rng.uniform(20.0, 100.0, 600)])
    phases = (time_s / rng.uniform(1500, 9000) + rng.uniform(0, 6) for _ in range(2))
    waves: Array = np.sum([rng.uniform(0.5, 3) * np.sin(phase) for phase in phases], axis=0)
    return History(time_s, {"T1": 22 + waves + 2.0 * (time_s > rng.uniform(5000, 25000))})


def _felt(history: History, constant_s: float) -> Array:
    """τ dy/dt + y = u by the classical Runge-Kutta method, (m,)."""
    time_s, felt, u = history.time_s, [history.signals["T1"][0]], history.signals["T1"]
    for k in range(len(time_s) - 1):
        h, y = (time_s[k + 1] - time_s[k]) / STEPS, felt[-1]
        at = np.linspace(u[k], u[k + 1], 2 * STEPS + 1)
        for here, middle, there in zip(at[:-2:2], at[1:-1:2], at[2::2], strict=True):
            k1 = (here - y) / constant_s
            k2 = (middle - y - 0.5 * h * k1) / constant_s
            k3 = (middle - y - 0.5 * h * k2) / constant_s
            k4 = (there - y - h * k3) / constant_s
            y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        felt.append(y)
    return np.array(felt)


def _readings(history: History, felt: Array, rng: np.random.Generator, noise_mm: float, count: int) -> Observations:
    """The growth of the spindle, read along Z at any times."""
    time_s = np.sort(rng.choice(history.time_s, count, replace=False))
    warm = np.interp(time_s, history.time_s, felt)
    reading = OFFSET_MM + PER_KELVIN_MM * (warm - 20.0) + rng.normal(0.0, noise_mm, count)
    clock = Clock(time_s, np.zeros(count, dtype=np.intp), (history,))
    state = State(
        np.broadcast_to(MILL.chain.positions({}), (count, len(MILL.chain.order))),
        0.0,
        {"T1": np.interp(time_s, history.time_s, history.signals["T1"])},
    )
    along, u = np.tile([0.0, 0.0, 1.0], (count, 1)), np.full(count, max(noise_mm, 1e-6))
    return Observations(state, along, reading, np.zeros(count, bool), u, ("1",) * count, clock=clock)


def _found(data: Observations) -> MachineModel:
    sought = Lag("late", "T1", 2000.0, between_s=(200.0, 15000.0))
    return identify(MILL, (TERM,), data, robust=False, lags=(sought,)).model


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), constant_s=st.floats(400.0, 7000.0))
def test_without_noise_the_truth_is_found_and_holds_at_every_row_of_the_history(seed: int, constant_s: float) -> None:
    rng = np.random.default_rng(seed)
    history = _history(rng)
    felt = _felt(history, constant_s)
    model = _found(_readings(history, felt, rng, 0.0, 200))
    assert abs(model.lags[0].constant_s / constant_s - 1.0) < 1e-3
    every = Clock(history.time_s, np.zeros(len(felt), dtype=np.intp), (history,))
    at = State(np.broadcast_to(MILL.chain.positions({}), (len(felt), 3)), 0.0, lag_signals(model.lags, every))
    truth = OFFSET_MM + PER_KELVIN_MM * (felt - 20.0)
    assert np.max(np.abs(model.error_mm(at)[:, 2] - truth)) < 2e-5


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), constant_s=st.floats(400.0, 7000.0))
def test_with_noise_the_truth_is_within_what_is_said_of_it(seed: int, constant_s: float) -> None:
    """0.5 µm on each reading. Five standard uncertainties: the bands themselves are counted elsewhere."""
    rng = np.random.default_rng(seed)
    history = _history(rng)
    model = _found(_readings(history, _felt(history, constant_s), rng, 0.5e-3, 200))
    lag = model.lags[0]
    assert abs(np.log(lag.constant_s / constant_s)) <= 5.0 * lag.u_relative
    assert abs(model.coefficients[1] - PER_KELVIN_MM) <= 5.0 * np.sqrt(model.covariance[1, 1])
