"""The standard terms of every structure against a machine written apart: 4×4 transforms, all errors polynomials."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.support.forward_model import ForwardMachine, random_machine
from trueloop.arrays import Array
from trueloop.machine.identify.form import Form, fit_form
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.model import Machine, State
from trueloop.machine.model.term import PRESETS, Term, chain_of, five_axis_terms, frame_terms, mill_terms, turning_terms

TRAVEL = {
    "X": (0.0, 500.0),
    "Y": (-200.0, 200.0),
    "Z": (-300.0, 0.0),
    "A": (-1.2, 0.6),
    "B": (-1.0, 1.5),
    "C": (-2.0, 2.0),
}
NOISE_MM = 0.3e-3
COUNT = 6000


def _chain(structure: str) -> Chain:
    chain = chain_of(structure)
    return chain.with_axes({a.name: replace(a, travel=TRAVEL[a.name]) for a in chain.axes if a.name in chain.order})


def _form(structure: str, chain: Chain) -> Form:
    make: Callable[..., tuple[Term, ...]] = mill_terms
    if structure == "turning":
        make = turning_terms
    elif structure.startswith("five-axis"):
        make = five_axis_terms
    terms = make(chain)
    return Form(terms, frame=frame_terms(chain, terms))


def _visit(chain: Chain, rng: np.random.Generator, count: int, plane: bool) -> tuple[dict[str, Array], Array]:
    at = {name: rng.uniform(*TRAVEL[name], count) for name in chain.order}
    tool = np.column_stack([rng.uniform(-60, 60, count), rng.uniform(-60, 60, count), rng.uniform(-180, -60, count)])
    return at, tool * [1.0, 0.0, 1.0] if plane else tool


def _read(chain: Chain, truth: ForwardMachine, rng: np.random.Generator, plane: bool) -> Observations:
    at, tool = _visit(chain, rng, COUNT, plane)
    along = rng.normal(0, 1, (COUNT, 3)) * ([1.0, 0.0, 1.0] if plane else [1.0, 1.0, 1.0])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    reading = np.einsum("ni,ni->n", along, truth.error_mm(at, tool)) + rng.normal(0, NOISE_MM, COUNT)
    state = State(chain.positions(at), 0.0, {}, tool)
    return Observations(state, along, reading, np.zeros(COUNT, bool), np.full(COUNT, NOISE_MM), ("volume",) * COUNT)


@pytest.mark.parametrize("structure", PRESETS)
def test_the_standard_terms_represent_any_machine_of_the_structure(structure: str) -> None:
    """Places that were not read are known to less than the noise of one reading, of random machines."""
    rng, chain, plane = np.random.default_rng(101), _chain(structure), structure == "turning"
    truth = random_machine(PRESETS[structure], TRAVEL, rng, plane=plane)
    found, _ = fit_form(Machine(structure, chain), _form(structure, chain), _read(chain, truth, rng, plane))
    at, tool = _visit(chain, rng, 2000, plane)
    actual = truth.error_mm(at, tool)
    rest = actual - found.model.error_mm(State(chain.positions(at), 0.0, {}, tool))
    assert np.sqrt(np.mean(rest**2)) < 0.5 * NOISE_MM
    assert np.abs(rest).max() < 4 * NOISE_MM
    assert np.std(actual) > 10 * NOISE_MM
    assert not found.outlier.sum() > 3
    assert found.scatter == pytest.approx(1.0, abs=0.08)
