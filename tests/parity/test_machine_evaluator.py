"""The Rust evaluator against the readable model: structures, ways of travel, signals, segments, rotary axes."""

import numpy as np
import pytest

from tests.support.machines import any_model, set_back_chain
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.compiled import compile_model
from trueloop.machine.model.model import State
from trueloop.machine.model.term import PRESETS


@pytest.mark.parametrize("structure", PRESETS)
def test_same_numbers_as_the_model(structure: str) -> None:
    rng = np.random.default_rng(51)
    chain = set_back_chain(structure)
    model = any_model(chain, rng)
    fixed = {name: 0.3 + 0.2 * k for k, name in enumerate(chain.order) if name in "ABC"}
    positions, travel = rng.uniform(-290, 390, (500, 3)), rng.choice([-1.0, 0.0, 1.0], (500, 3))
    tool = (15.0, -8.0, -140.0)
    compiled = compile_model(model, {"T1": 26.5}, tool, fixed)
    given: dict[str, np.ndarray | float] = dict(fixed)
    given |= {name: positions[:, k] for k, name in enumerate("XYZ") if name in chain.order}
    ways = np.stack([travel[:, "XYZ".index(n)] if n in "XYZ" else np.zeros(500) for n in chain.order], axis=1)
    expected = model.error_mm(State(chain.positions(given), ways, {"T1": 26.5}, tool))
    for threads in (1, 3):
        np.testing.assert_allclose(compiled.error_mm(positions, travel, threads), expected, rtol=0, atol=1e-12)
    unknown = model.error_mm(State(chain.positions(given), 0.0, {"T1": 26.5}, tool))
    np.testing.assert_allclose(compiled.error_mm(positions), unknown, rtol=0, atol=1e-12)


def test_beyond_the_segments_the_end_values_hold() -> None:
    rng = np.random.default_rng(52)
    model = any_model(set_back_chain("mill-gantry"), rng)
    compiled = compile_model(model, {"T1": 20.0})
    far = np.array([[-900.0, 0.0, 0.0], [0.0, 900.0, -900.0]])
    expected = model.error_mm(
        State(model.machine.chain.positions({n: far[:, k] for k, n in enumerate("XYZ")}), 0.0, {"T1": 20.0})
    )
    np.testing.assert_allclose(compiled.error_mm(far), expected, rtol=0, atol=1e-12)


def test_no_positions_and_numbers_that_are_none() -> None:
    compiled = compile_model(any_model(set_back_chain("mill-gantry"), np.random.default_rng(53)), {"T1": 20.0})
    assert compiled.error_mm(np.zeros((0, 3)), threads=4).shape == (0, 3)
    assert np.isnan(compiled.error_mm(np.array([[np.nan, 0.0, 0.0]]))).any()


def test_a_signal_that_is_not_given() -> None:
    with pytest.raises(TrueloopError) as refusal:
        compile_model(any_model(set_back_chain("turning"), np.random.default_rng(54)), {})
    assert refusal.value.code is Code.MCH_SIGNAL
