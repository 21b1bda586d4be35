"""Terms that feel temperatures and speed a while later: time constants found with honest bands, sensors chosen."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from tests.support.exact_kinematics import exact_error_mm
from tests.support.machines import chain_with_travel, random_directions
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.identify.form import Choice, Form, fit_form
from trueloop.machine.identify.identify import Identification, identify
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.history import Clock, History, Lag, lag_signals, signals_at_end, slope_name
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import CONSTANT, Part, Term, segments
from trueloop.machine.model.validity import check_state

MILL = Machine("mill", chain_with_travel("mill-table-x"))
COLUMN = Lag("column", "T1", 3000.0, between_s=(300.0, 20000.0))
BEARING = Lag("bearing", "spindle", 900.0, power=2, between_s=(100.0, 10000.0))
TERMS = (
    Term(error_name("EZ0S"), (Part(), Part(CONSTANT, "column", 20.0), Part(CONSTANT, "bearing"))),
    Term(error_name("EAZ"), (Part(segments(-300.0, 0.0, 1, 1, (0.0,))), Part(CONSTANT, "column", 20.0))),
)
TRUE = np.array([2e-3, 1.5e-3, 2e-9, 3e-5, 0.0, 4e-6])
"""2 µm, 1.5 µm/K, 8 µm at 2000 rev/min, 30 µrad at the end of Z, 4 µrad/K."""

SPEEDS = [0.0, 0.0, 0.0, 1000.0, 1000.0, 2000.0, 2000.0, 2000.0]


def _history(rng: np.random.Generator) -> History:
    """Eight hours: a hall that warms in waves, the spindle on and off."""
    time_s = np.arange(0.0, 8 * 3600.0, 60.0)
    hall = 22 + 3 * np.sin(time_s / 6000 + rng.uniform(0, 6)) + rng.normal(0, 0.02, len(time_s))
    return History(time_s, {"T1": hall, "spindle": np.repeat(rng.permutation(SPEEDS), 60)})


def _readings(rng: np.random.Generator, noise_mm: float, count: int = 400) -> Observations:
    history = _history(rng)
    time_s = np.sort(rng.uniform(0, history.time_s[-1], count))
    clock = Clock(time_s, np.zeros(count, dtype=np.intp), (history,))
    positions = np.stack([rng.uniform(*MILL.chain.axis(n).travel, count) for n in "XYZ"], axis=1)
    signals = {n: np.interp(time_s, history.time_s, v) for n, v in history.signals.items()}
    state = State(positions, 0.0, signals | lag_signals((COLUMN, BEARING), clock), rng.uniform(-150, 150, (count, 3)))
    truth = MachineModel(MILL, TERMS, TRUE, np.zeros((6, 6)))
    along = random_directions(count, rng)
    exact = exact_error_mm(MILL.chain, positions, state.tool_mm, truth.values(state))
    reading = np.einsum("ni,ni->n", along, exact) + rng.normal(0, noise_mm, count)
    bare = State(positions, 0.0, signals, state.tool_mm)
    u = np.full(count, max(noise_mm, 1e-6))
    return Observations(bare, along, reading, np.zeros(count, bool), u, ("1",) * count, clock=clock)


def _found(data: Observations, robust: bool = False) -> Identification:
    return identify(MILL, TERMS, data, robust=robust, lags=(COLUMN, BEARING))


def test_without_noise_constants_and_coefficients_are_found() -> None:
    model = _found(_readings(np.random.default_rng(71), 0.0)).model
    assert [lag.constant_s for lag in model.lags] == pytest.approx([3000.0, 900.0], rel=1e-3)
    np.testing.assert_allclose(model.coefficients, TRUE, atol=1e-6)


def test_95_percent_bands_of_constants_coefficients_and_error() -> None:
    """A hundred and twenty machines, 0.5 µm noise: constants, coefficients, and E at an hour nobody measured."""
    rng = np.random.default_rng(72)
    held: dict[str, list[bool]] = {"constants": [], "coefficients": [], "error": []}
    place = MILL.chain.positions({"X": 100.0, "Y": 0.0, "Z": np.full(20, -200.0)})
    for _ in range(120):
        found = _found(_readings(rng, 0.5e-3, 150))
        model, quantile = found.model, float(student.ppf(0.975, found.degrees_of_freedom))
        for lag, true in zip(model.lags, (COLUMN, BEARING), strict=True):
            held["constants"].append(abs(np.log(lag.constant_s / true.constant_s)) <= quantile * lag.u_relative)
        u = np.sqrt(np.diag(model.covariance))[:6]
        held["coefficients"] += list((np.abs(model.coefficients - TRUE) <= quantile * u)[[0, 1, 2, 3, 5]])
        clock = Clock(np.linspace(3600, 28000, 20), np.zeros(20, dtype=np.intp), (_history(rng),))
        ours, theirs = (State(place, 0.0, lag_signals(lags, clock)) for lags in (model.lags, (COLUMN, BEARING)))
        off = model.error_mm(ours) - MachineModel(MILL, TERMS, TRUE, model.covariance[:6, :6]).error_mm(theirs)
        held["error"] += list((np.abs(off) <= quantile * model.standard_u_mm(ours))[:, 2])
    for name, inside in held.items():
        assert 0.93 <= np.mean(inside) <= 0.97, (name, np.mean(inside), len(inside))


def test_a_constant_that_is_given_is_kept_and_has_no_band() -> None:
    data = _readings(np.random.default_rng(73), 0.5e-3)
    given = Lag("column", "T1", 3000.0)
    model = identify(MILL, TERMS, data, lags=(given, BEARING)).model
    assert model.lags[0] == given
    assert model.lags[1].u_relative > 0


def test_a_constant_at_its_bound_is_told() -> None:
    data = _readings(np.random.default_rng(74), 0.5e-3)
    narrow = Lag("column", "T1", 500.0, between_s=(400.0, 700.0))
    found = identify(MILL, TERMS, data, lags=(narrow, BEARING))
    assert [f.code for f in found.findings if "'column'" in f.message] == [Code.MCH_LAG]


def test_outliers_do_not_move_constants() -> None:
    data = _readings(np.random.default_rng(75), 0.5e-3)
    clean = _found(data, robust=True).model
    data.reading[[30, 31, 200, 390]] += [0.2, -0.3, 0.2, 0.5]
    found = _found(data, robust=True)
    assert set(np.flatnonzero(found.outlier)) == {30, 31, 200, 390}
    for lag, before in zip(found.model.lags, clean.lags, strict=True):
        assert abs(np.log(lag.constant_s / before.constant_s)) < before.u_relative


def test_the_slope_is_the_derivative_and_a_lag_starts_in_equilibrium() -> None:
    clock = Clock(np.array([0.0, 7000.0]), np.zeros(2, dtype=np.intp), (_history(np.random.default_rng(76)),))
    at, more = (lag_signals((Lag("column", "T1", 3000.0 * f),), clock) for f in (1.0, np.exp(1e-4)))
    assert at["column"][0] == clock.histories[0].signals["T1"][0]
    assert (more["column"][1] - at["column"][1]) / 1e-4 == pytest.approx(at[slope_name(COLUMN)][1], rel=1e-3)


def test_at_the_end_of_a_log_a_step_is_felt_by_its_share() -> None:
    time_s = np.array([0.0, 1.0, 3000.0])
    now = signals_at_end(History(time_s, {"T1": np.array([20.0, 30.0, 30.0])}), (COLUMN,))
    assert now["T1"] == 30.0
    assert now["column"] == pytest.approx(30 - 10 * np.exp(-1), abs=0.01)


def test_the_sensors_that_matter_are_chosen_and_the_others_are_not() -> None:
    """T1 felt late and the speed drive the machine; T2 follows T1 and something else, T3 is noise."""
    rng = np.random.default_rng(77)
    data = _readings(rng, 0.5e-3, 600)
    history: History = data.clock.histories[0]  # type: ignore[union-attr]
    t1 = history.signals["T1"]
    others: dict[str, Array] = {"T2": 0.5 * t1 + np.sin(history.time_s / 3000), "T3": rng.normal(20, 2, len(t1))}
    whole = History(history.time_s, {**history.signals, **others})
    clock = Clock(data.clock.time_s, data.clock.source, (whole,))  # type: ignore[union-attr]
    signals = {**data.state.signals, **{n: np.interp(clock.time_s, whole.time_s, v) for n, v in others.items()}}
    data = Observations(
        State(data.state.positions, 0.0, signals, data.state.tool_mm),
        *(data.along, data.reading, data.is_angle, data.standard_u, data.run),
        clock=clock,
    )
    names = ("T1", "T2", "T3", "column", "bearing", "late")
    late = Lag("late", "T2", 1000.0, between_s=(300.0, 20000.0))
    plain = (Term(error_name("EZ0S")), Term(error_name("EAZ"), TERMS[1].parts))
    form = Form(
        plain, (COLUMN, BEARING, late), (Choice(error_name("EZ0S"), tuple(Part(CONSTANT, n, 0.0) for n in names), 3),)
    )
    found, chosen = fit_form(MILL, form, data)
    assert {c.signal for c in chosen} == {"column", "bearing"}
    assert chosen[-1].rms_with == pytest.approx(1.0, abs=0.1)
    assert [lag.constant_s for lag in found.model.lags] == pytest.approx([3000.0, 900.0], rel=0.1)


def test_readings_without_time_and_readings_outside_the_log() -> None:
    data = _readings(np.random.default_rng(78), 0.5e-3)
    untimed = Observations(data.state, data.along, data.reading, data.is_angle, data.standard_u, data.run)
    with pytest.raises(TrueloopError, match="needs the time") as refusal:
        _found(untimed)
    assert refusal.value.code is Code.MCH_HISTORY
    assert data.clock is not None
    late = Clock(data.clock.time_s + 3600, data.clock.source, data.clock.histories)
    with pytest.raises(TrueloopError, match="but the history") as refusal:
        lag_signals((COLUMN,), late)
    assert refusal.value.code is Code.MCH_HISTORY


def test_a_lag_is_in_the_unit_of_what_it_follows_to_its_power() -> None:
    data = _readings(np.random.default_rng(78), 0.0)
    model = _found(replace(data, units={"T1": "°C", "spindle": "rev/min"})).model
    assert dict(model.units) == {"T1": "°C", "spindle": "rev/min", "column": "°C", "bearing": "(rev/min)^2"}
    hot = State(MILL.chain.positions({}), 0.0, {"column": 99.0, "bearing": 0.0})
    with pytest.raises(TrueloopError, match=r"column is 99 °C; the model was found from [\d.]+ °C"):
        check_state(model, hot, ("X", "Y", "Z"))
