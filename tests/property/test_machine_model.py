"""A machine model in its several forms, over machines of every structure with random errors, positions and travel.

What is first order is held to it by scale: errors a half as large leave a quarter of the difference.
"""

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.support.exact_kinematics import exact_error_of
from tests.support.machines import any_model, chain_with_travel, random_model, set_back_chain
from trueloop.arrays import Array
from trueloop.machine.correct import axis_table
from trueloop.machine.model.compiled import compile_model
from trueloop.machine.model.kinematics import bed_to_work
from trueloop.machine.model.model import Machine, MachineModel, State, design
from trueloop.machine.model.term import PRESETS, mill_terms, turning_terms

ROUNDING = 2e-15
"""Of the sum of what the errors contribute: some dozens of operations, each to 1e-16."""


@dataclass(frozen=True)
class Visit:
    """A model at positions: of X, Y, Z (n, 3), with the travel (n, 3) there, and the whole state."""

    model: MachineModel
    positions: Array
    travel: Array
    state: State
    fixed: dict[str, float]


@st.composite
def visits(draw: st.DrawFn) -> Visit:
    """Any structure, any errors, neighbours or places far apart, within the travel and beyond."""
    chain = set_back_chain(draw(st.sampled_from(sorted(PRESETS))))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    model = any_model(chain, rng, draw(st.integers(1, 4)), draw(st.integers(1, 5)), draw(st.integers(1, 5)))
    count, reach = draw(st.integers(1, 40)), draw(st.sampled_from([1.0, 60.0, 500.0]))
    positions = rng.uniform(-300, 400, 3) + rng.uniform(-reach, reach, (count, 3))
    travel = rng.choice([-1.0, 0.0, 1.0], (1 if reach == 1.0 else count, 3)) * np.ones((count, 1))
    fixed = {name: rng.uniform(-2, 2) for name in chain.order if name in "ABC"}
    given_: dict[str, Array | float] = dict(fixed)
    given_ |= {name: positions[:, k] for k, name in enumerate("XYZ") if name in chain.order}
    ways = np.stack([travel[:, "XYZ".index(n)] if n in "XYZ" else np.zeros(count) for n in chain.order], axis=1)
    tool = (float(rng.uniform(-50, 50)), -8.0, -140.0)
    return Visit(model, positions, travel, State(chain.positions(given_), ways, {"T1": 26.5}, tool), fixed)


@settings(max_examples=40)
@given(visits())
def test_the_compiled_form_is_the_model(visit: Visit) -> None:
    state, model = visit.state, visit.model
    compiled = compile_model(model, state.signals, state.tool_mm, visit.fixed)
    found = compiled.error_mm(visit.positions, visit.travel)
    parts = np.abs(design(model.machine.chain, model.terms, state) * model.coefficients).sum(axis=2)
    assert (np.abs(found - model.error_mm(state)) <= ROUNDING * parts.max()).all()
    unknown = model.error_mm(replace(state, travel=0.0))
    assert (np.abs(compiled.error_mm(visit.positions) - unknown) <= ROUNDING * parts.max()).all()


@settings(max_examples=40)
@given(visits())
def test_the_exact_error_differs_by_the_second_order(visit: Visit) -> None:
    """Bounded by Σ|rotations| · (Σ|displacements| + Σ|rotations| · the machine's reach)."""

    def beyond(share: float) -> float:
        part = replace(visit.model, coefficients=share * visit.model.coefficients)
        return float(np.abs(exact_error_of(part, visit.state) - part.error_mm(visit.state)).max())

    values = visit.model.values(visit.state)
    sums = [sum(np.abs(v).max() for n, v in values.items() if n.is_rotation is turns) for turns in (True, False)]
    offsets = sum(float(np.linalg.norm(axis.offset_mm)) for axis in visit.model.machine.chain.axes)
    reach = offsets + np.abs(visit.positions).sum(axis=1).max() + float(np.linalg.norm(visit.state.tool_mm))
    assert beyond(1.0) <= sums[0] * (sums[1] + sums[0] * reach)
    assume(beyond(1.0) > 1e-8)  # less is rounding of metres
    assert 0.2 < beyond(0.5) / beyond(1.0) < 0.3


@settings(max_examples=40)
@given(visits())
def test_comp_mtg_undoes_the_error_to_second_order(visit: Visit) -> None:
    """E of what was commanded with COMP_MTG added, and COMP_MTG itself, along the axes that move: nothing is left."""
    chain = visit.model.machine.chain
    smooth = _smooth(visit.model)
    inside = np.clip(visit.state.positions, -250, 350)
    columns = [chain.order.index(name) for name in "XYZ" if name in chain.order]
    axes = ["XYZ".index(chain.order[column]) for column in columns]
    to_axes = bed_to_work(chain, visit.fixed).T

    def left(share: float) -> tuple[float, float]:
        part = replace(smooth, coefficients=share * smooth.coefficients)
        state = replace(visit.state, positions=inside)
        comp = part.comp_mtg_mm(state) @ to_axes
        moved = inside.copy()
        moved[:, columns] += comp[:, axes]
        rest = part.error_mm(replace(state, positions=moved)) @ to_axes + comp
        return float(np.abs(rest[:, axes]).max()), float(np.abs(comp).max())

    (whole, size), (half, _) = left(1.0), left(0.5)
    assert whole <= 0.02 * size
    assume(whole > 1e-9)
    assert 0.2 < half / whole < 0.3


def _smooth(model: MachineModel) -> MachineModel:
    """Without terms that have kinks where segments of straight lines meet, which no order describes."""
    kept = [all(len(part.basis.breaks) == 2 for part in term.parts) for term in model.terms]
    coefficients = [model.coefficients[where] for where, keep in zip(model.slices(), kept, strict=True) if keep]
    terms = tuple(term for term, keep in zip(model.terms, kept, strict=True) if keep)
    return replace(model, terms=terms, coefficients=np.concatenate(coefficients))


@settings(max_examples=40)
@given(st.sampled_from([p for p in sorted(PRESETS) if "five" not in p]), st.integers(0, 2**32 - 1), st.integers(2, 9))
def test_a_table_is_the_model_at_its_entries(structure: str, seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    chain = chain_with_travel(structure)
    terms = (turning_terms if structure == "turning" else mill_terms)(chain, count=3, both_ways=True)
    model = random_model(Machine("any", chain), terms, rng)
    axis, output = str(rng.choice(list(chain.order))), str(rng.choice(list(chain.order)))
    base = {name: float(rng.uniform(*chain.axis(name).travel)) for name in chain.order if name != axis}
    table = axis_table(model, axis, output, count, base)
    for way in (1.0, -1.0):
        travel = np.where(np.array(chain.order) == axis, way, 0.0)
        placed = chain.positions({**base, axis: table.position_mm})
        state = State(placed, np.broadcast_to(travel, placed.shape))
        expected = model.error_mm(state)[:, "XYZ".index(output)]
        np.testing.assert_allclose(table.error_mm(table.position_mm, way), expected, rtol=0, atol=1e-15)
