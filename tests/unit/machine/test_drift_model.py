"""Lags against closed forms, and a dynamic model of a machine whose time constants are known."""

import numpy as np
import pytest

from trueloop.errors import TrueloopError
from trueloop.machine.drift import fit_drift
from trueloop.machine.model.history import lagged


def test_lag_of_a_step_and_a_ramp_in_uneven_steps() -> None:
    time_s = np.cumsum(np.random.default_rng(61).uniform(1, 60, 300))
    time_s -= time_s[0]
    ramp = 2.0 + 0.01 * time_s
    found = lagged(time_s, ramp[:, None], np.array([0.0, 500.0]))
    np.testing.assert_allclose(found[:, 0, 0], ramp, atol=1e-9)
    expected = ramp - 0.01 * 500 * (1 - np.exp(-time_s / 500))
    np.testing.assert_allclose(found[:, 0, 1], expected, atol=1e-12)


def test_times_that_do_not_ascend() -> None:
    with pytest.raises(TrueloopError, match="row 3"):
        lagged(np.array([0.0, 1.0, 1.0]), np.zeros((3, 1)), np.array([1.0]))


def test_a_machine_with_known_constants_is_predicted_and_its_sensor_found() -> None:
    """T2 drives the drift with 1800 s; T1 and T3 are other temperatures of the same hall."""
    rng = np.random.default_rng(62)
    time_s = np.arange(0.0, 40 * 3600.0, 30.0)
    speed = np.repeat(rng.choice([0.0, 2000.0, 4000.0], 20), len(time_s) // 20)
    heat = lagged(time_s, (speed[:, None] / 1000) ** 2, np.array([1200.0]))[:, 0, 0]
    hall = 2 * np.sin(time_s / 15000)
    signals = {
        "T1": 20 + hall + rng.normal(0, 0.02, len(time_s)),
        "T2": 22 + heat + hall + rng.normal(0, 0.02, len(time_s)),
        "T3": 21 + 0.5 * hall + rng.normal(0, 0.02, len(time_s)),
        "spindle_rpm": speed,
    }
    drift = 3.0 * lagged(time_s, (heat + hall)[:, None], np.array([1800.0]))[:, 0, 0] + rng.normal(0, 0.05, len(time_s))
    known = np.arange(len(time_s)) < 0.7 * len(time_s)
    model = fit_drift(time_s[known], {n: v[known] for n, v in signals.items()}, drift[known])
    rest = (model.predict(time_s, signals) - drift)[~known]
    assert np.sqrt(np.mean(rest**2)) < 0.05 * np.std(drift)
    assert "T2" in model.inputs


@pytest.mark.parametrize("name", ["T1", "spindle_rpm"])
def test_one_signal_alone_is_a_model_too(name: str) -> None:
    time_s = np.arange(0.0, 12 * 3600.0, 60.0)
    swing = np.sin(time_s / 2500.0)
    signal = np.where(swing > 0, 1000.0, 0.0) if name == "spindle_rpm" else 20.0 + swing
    felt = lagged(time_s, signal[:, None], np.array([600.0]))[:, 0, 0]
    model = fit_drift(time_s, {name: signal}, felt)
    assert model.inputs and all(name in used for used in model.inputs)
    assert np.std(model.predict(time_s, {name: signal}) - felt) < 0.2 * np.std(felt)
