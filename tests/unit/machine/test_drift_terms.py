"""A drift model inside of a machine model says what it says alone, along the right axis and with the right sign."""

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.machine.drift import DriftModel, Member, turned, with_drift, zeroed_at
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.history import History, signals_at_end
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import chain_of

TIME_S = np.arange(0.0, 7201.0, 60.0)
WARM, SPEED = 20 + 3 * np.sin(TIME_S / 1500), np.where(TIME_S > 1800, 3000.0, 0.0)
MEMBERS = (
    Member(("T1_degC", "S_rpm", "S_rpm²"), (0.0, 900.0), np.array([1.0, 2.0, -0.5, 0.25, 0.75, 3.0]), 0.4),
    Member(("T1_degC", "S_rpm", "S_rpm²"), (0.0, 3600.0), np.array([0.5, 4.0, 0.1, -0.2, 0.3, 1.0]), 0.2),
)
DRIFT = DriftModel(
    MEMBERS, {"T1_degC": 19.0, "S_rpm": 0.0, "S_rpm²": 0.0}, {"T1_degC": (10, 30), "S_rpm": (0, 4000)}, left_um=1.5
)


def _bare(structure: str) -> MachineModel:
    return MachineModel(Machine("m", chain_of(structure)), (), np.zeros(0), np.zeros((0, 0)))


def _history(rows: int) -> History:
    return History(TIME_S[:rows], {"T1": WARM[:rows], "S": SPEED[:rows]})


@pytest.mark.parametrize(("structure", "error", "axis"), [("mill-gantry", "EZ0S", 2), ("turning", "EX0C", 0)])
def test_e_is_the_drift_along_the_axis(structure: str, error: str, axis: int) -> None:
    """On a lathe EX0C moves the work: its coefficients turn round, E does not."""
    model = with_drift(_bare(structure), DRIFT, error_name(error))
    expected = DRIFT.predict(TIME_S, {"T1_degC": WARM, "S_rpm": SPEED})
    other = with_drift(_bare(structure), turned(DRIFT), error_name(error))
    for rows in (30, 80, 121):
        state = State(np.zeros((1, len(model.machine.chain.order))), 0.0, signals_at_end(_history(rows), model.lags))
        along = np.zeros(3)
        along[axis] = expected[rows - 1] * 1e-3
        np.testing.assert_allclose(model.error_mm(state)[0], along, atol=1e-12)
        np.testing.assert_allclose(other.error_mm(state)[0], -along, atol=1e-12)
        assert model.standard_u_mm(state)[0, axis] == pytest.approx(1.5e-3)


def test_a_zero_set_in_between_takes_with_it_what_had_drifted() -> None:
    model = with_drift(_bare("mill-gantry"), DRIFT, error_name("EZ0S"))
    then, now = (signals_at_end(_history(rows), model.lags) for rows in (60, 121))
    error = [model.error_mm(State(np.zeros((1, 3)), 0.0, signals))[0, 2] for signals in (then, now)]
    since = zeroed_at(model, then).error_mm(State(np.zeros((1, 3)), 0.0, now))[0, 2]
    assert since == pytest.approx(error[1] - error[0], abs=1e-12) and abs(error[0]) > 1e-3
    assert zeroed_at(model, then).error_mm(State(np.zeros((1, 3)), 0.0, then))[0, 2] == pytest.approx(0, abs=1e-15)


@pytest.mark.parametrize(("error", "code"), [("EZZ", Code.MCH_AXIS), ("EA0S", Code.MCH_AXIS), ("EZ0S", Code.MCH_DATA)])
def test_refusals(error: str, code: Code) -> None:
    model = with_drift(_bare("mill-gantry"), DRIFT, error_name("EZ0S"))
    with pytest.raises(TrueloopError) as refused:
        with_drift(model, DRIFT, error_name(error))
    assert refused.value.code is code
