"""Machine models as banks of their signals, images of any numbers, and where they are asked."""

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st

from tests.support.machines import any_model, set_back_chain
from trueloop.arrays import Array
from trueloop.machine.model.chain import Vector
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import PRESETS
from trueloop.realtime.image import Bank, Body, Identity, Image, RealTimeLimits, Signal, bank_of, signals_of

RANGES = {"T1": (15.0, 30.0), "T2": (18.0, 40.0), "speed": (0.0, 4000.0), "speed^2 after 20 min": (0.0, 1.6e7)}
UNITS = {"T1": "°C", "T2": "°C", "speed": "rev/min", "speed^2 after 20 min": "(rev/min)^2"}


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
def any_asked(draw: st.DrawFn) -> Asked:
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
    """The model's bank, rotary axes standing at zero."""
    standing = [name for name in model.machine.chain.order if name in "ABC"]
    return bank_of(model, tool, signals_of(model), standing)


def columns(bank: Bank, at: Asked) -> Array:
    """The signals that the bank has, in its order."""
    return at.signals[:, [list(RANGES).index(signal.name) for signal in bank.signals]]


def by_the_model(at: Asked) -> Array:
    """E by the model itself, with the tool less the offset."""
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


@st.composite
def any_image(draw: st.DrawFn) -> Image:
    """A bank of any numbers of the size of errors: 0 to 16 signals, up to 8 bodies, with travel and without."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(0, 16))
    signals = tuple(Signal(f"S{k}", "°C", float(rng.uniform(15, 25)), -50.0, 90.0, 5.0) for k in range(count))
    bodies = tuple(_any_body(rng, count) for _ in range(draw(st.integers(0, 8))))
    tool = (float(rng.normal(0, 50)), 0.0, -80.0)
    bank = Bank(signals, bodies, rng.normal(0, 1e-5, (1 + count, 3, 3)), tool)
    return Image(Identity("any", ""), RealTimeLimits(((-300.0, 400.0),) * 3), bank)


def _any_body(rng: np.random.Generator, signals: int) -> Body:
    breaks = np.cumsum(rng.uniform(1, 60, rng.integers(2, 6))) - 60
    powers = int(rng.integers(1, 9))
    shape = (int(rng.choice([1, 3])), len(breaks) - 1, powers, 6)
    falling = 60.0 ** -np.arange(powers)[:, None] * np.repeat([1e-2, 1e-5], 3)
    places = np.flatnonzero(rng.random(signals) < 0.7).tolist()
    added = tuple((place, 0.1 * falling * rng.normal(size=shape)) for place in places)
    carries = rng.choice([0.0, 1.0], 3)
    return Body(int(rng.integers(3)), breaks, falling * rng.normal(size=shape), added, rng.normal(0, 99, 3), carries)
