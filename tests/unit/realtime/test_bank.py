"""The bank of a model: bodies, signals, tool. That it is the model is shown with the core, in test_core_model."""

import numpy as np
import pytest

from tests.support.machines import any_model, chain_with_travel, set_back_chain
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.compiled import compile_model
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import CONSTANT, PRESETS, Part, Term, segments
from trueloop.realtime.image import SignalLimits, bank_of, signals_of


@pytest.mark.parametrize("structure", sorted(PRESETS))
def test_arms_are_linear_in_the_tool(structure: str) -> None:
    """What the component relies on: the tool's vector is added to every arm, and nothing else of a model moves."""
    rng = np.random.default_rng(7)
    model = any_model(set_back_chain(structure), rng)
    tool = rng.uniform(-200, 200, 3)
    without, with_tool = compile_model(model, {"T1": 21.0}), compile_model(model, {"T1": 21.0}, tool)
    np.testing.assert_array_equal(with_tool.slope, without.slope)
    for bare, armed in zip(without.bodies, with_tool.bodies, strict=True):
        np.testing.assert_allclose(armed.arm_mm, bare.arm_mm + tool, rtol=0, atol=1e-10)
        np.testing.assert_allclose(armed.powers, bare.powers, rtol=0, atol=1e-18)
        np.testing.assert_array_equal(armed.carries, bare.carries)


def test_tables_of_nothing_are_left_out() -> None:
    """X depends on T1, the spindle on nothing, Y has no errors: two bodies, of which one has a table per unit."""
    grows = Term(error_name("EXX"), (Part(segments(0, 500, 1, 2)), Part(segments(0, 500, 1, 1), "T1", 20.0)))
    terms = (grows, Term(error_name("EYY"), (Part(segments(-200, 200, 1, 2)),)), Term(error_name("EZ0S"), (Part(),)))
    coefficients = np.array([0.0, 0.01, 0.02, 0.0, 0.001, 0.0, 0.0, 0.0, 0.003])
    machine = Machine("mill", chain_with_travel("mill-gantry"))
    model = MachineModel(machine, terms, coefficients, np.zeros((9, 9)), {"T1": (18.0, 25.0)}, units={"T1": "°C"})
    bank = bank_of(model, (0.0, 0.0, -50.0), signals_of(model))
    assert [(body.axis, [place for place, _ in body.per_unit]) for body in bank.bodies] == [(0, [0]), (0, [])]
    assert not bank.slope.any()


def of_signals(*parts: Part, **known: tuple[float, float]) -> MachineModel:
    machine = Machine("mill", chain_with_travel("mill-gantry"))
    terms = (Term(error_name("EZ0S"), parts),)
    size = terms[0].size
    units = {"T1": "°C", "speed": "rev/min"}
    return MachineModel(machine, terms, np.ones(size), np.eye(size), known, units=units)


def test_ranges_and_steps_come_from_the_data_unless_stated() -> None:
    model = of_signals(
        Part(CONSTANT, "speed"), Part(CONSTANT, "T1", 20.0), speed=(0.0, 3000.0), T1=(18.0, 25.0), T9=(1.0, 2.0)
    )
    speed, warm = signals_of(model)
    assert (speed.name, speed.unit, speed.low, speed.high, speed.most_step) == ("speed", "rev/min", 0.0, 3000.0, 3000.0)
    assert (warm.name, warm.reference, warm.low, warm.high, warm.most_step) == ("T1", 20.0, 18.0, 25.0, 2.0)
    stated = SignalLimits({"T1": (15.0, 35.0)}, {"T1": 0.5, "speed": 100.0})
    assert [(s.low, s.high, s.most_step) for s in signals_of(model, stated)] == [(0, 3000, 100), (15, 35, 0.5)]
