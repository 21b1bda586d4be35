"""A bank, written to an image and evaluated by plain sums, is the model: at any place, signals, travel and tool."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support import image_reference
from tests.support.machines import any_model, chain_with_travel, set_back_chain
from trueloop.arrays import Array
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.machine.model.chain import Vector
from trueloop.machine.model.compiled import compile_model
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.names import error_name
from trueloop.machine.model.position_basis import CONSTANT, polynomial
from trueloop.machine.model.structure import PRESETS
from trueloop.machine.model.term import Part, Term
from trueloop.realtime.bank import Stated, bank_of, signals_of
from trueloop.realtime.image import Bank, Identity, Image, RealTimeLimits

RANGES = {"T1": (15.0, 30.0), "T2": (18.0, 40.0), "speed": (0.0, 4000.0), "speed^2 after 20 min": (0.0, 1.6e7)}
UNITS = {"T1": "°C", "T2": "°C", "speed": "rev/min", "speed^2 after 20 min": "(rev/min)^2"}
LIMITS = RealTimeLimits(((-300.0, 400.0),) * 3)


@dataclass(frozen=True)
class Asked:
    """A model and where it is asked, one row each."""

    model: MachineModel
    positions: Array
    travel: Array
    signals: Array
    tool: Vector
    offset: Array


def many_signals(model: MachineModel, rng: np.random.Generator) -> MachineModel:
    """The same model, its signals drawn from several, each part with a reference of its own."""
    drawn, coefficients = [], model.coefficients.copy()
    for term, where in zip(model.terms, model.slices(), strict=True):
        name = str(rng.choice(list(RANGES)))
        low, high = RANGES[name]
        parts = [replace(p, signal=name, reference=rng.uniform(low, high)) if p.signal else p for p in term.parts]
        drawn.append(replace(term, parts=tuple(parts)))
        factor = np.concatenate([np.full(p.basis.size, 10 / (high - low) if p.signal else 1.0) for p in parts])
        coefficients[where] *= np.tile(factor, 2 if term.both_ways else 1)
    return replace(model, terms=tuple(drawn), coefficients=coefficients, identified=RANGES, units=UNITS)


@st.composite
def asked(draw: st.DrawFn) -> Asked:
    """Any structure with any errors, within the travel and beyond."""
    chain = set_back_chain(draw(st.sampled_from(sorted(PRESETS))))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    model = any_model(chain, rng, draw(st.integers(1, 4)), draw(st.integers(1, 5)), draw(st.integers(1, 5)))
    count = 12
    here = [axis in chain.order for axis in "XYZ"]
    signals = np.array([rng.uniform(*known, count) for known in RANGES.values()]).T
    return Asked(
        many_signals(model, rng),
        rng.uniform(-350, 450, (count, 3)) * here,
        rng.choice([-1.0, 0.0, 1.0], (count, 3)) * here,
        signals,
        (float(rng.uniform(-50, 50)), -8.0, -140.0),
        rng.uniform(-100, 100, (count, 3)),
    )


def bank_for(model: MachineModel, tool: Vector = (0.0, 0.0, 0.0)) -> Bank:
    standing = [name for name in model.machine.chain.order if name in "ABC"]
    return bank_of(model, tool, signals_of(model), standing)


def by_plain_sums(bank: Bank, at: Asked) -> Array:
    found = image_reference.read(image_to_bytes(Image(Identity("any", ""), LIMITS, bank)))
    columns = [list(RANGES).index(signal.name) for signal in bank.signals]
    rows = zip(at.positions, at.travel, at.signals[:, columns], at.offset, strict=True)
    return np.array([image_reference.error_mm(found, *map(list, row)) for row in rows])


def by_the_model(at: Asked) -> Array:
    chain = at.model.machine.chain
    columns = [chain.order.index(axis) for axis in "XYZ" if axis in chain.order]
    here = ["XYZ".index(chain.order[column]) for column in columns]
    positions, travel = np.zeros((2, len(at.positions), len(chain.order)))
    positions[:, columns], travel[:, columns] = at.positions[:, here], at.travel[:, here]
    found = [
        at.model.error_mm(
            State(positions[[k]], travel[[k]], dict(zip(RANGES, at.signals[k], strict=True)), at.tool - at.offset[k])
        )[0]
        for k in range(len(positions))
    ]
    return np.array(found)


@settings(max_examples=60)
@given(asked())
def test_the_bank_is_the_model(at: Asked) -> None:
    found = by_plain_sums(bank_for(at.model, at.tool), at)
    np.testing.assert_allclose(found, by_the_model(at), rtol=0, atol=1e-12)


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
    grows = Term(error_name("EXX"), (Part(polynomial(0, 500, 2)), Part(polynomial(0, 500, 1), "T1", 20.0)))
    terms = (grows, Term(error_name("EYY"), (Part(polynomial(-200, 200, 2)),)), Term(error_name("EZ0S"), (Part(),)))
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
    stated = Stated({"T1": (15.0, 35.0)}, {"T1": 0.5, "speed": 100.0})
    assert [(s.low, s.high, s.most_step) for s in signals_of(model, stated)] == [(0, 3000, 100), (15, 35, 0.5)]
