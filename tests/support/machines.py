"""Machines with known errors: random coefficients, and what instruments would read on them."""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from tests.support.exact_kinematics import Values, exact_error_mm
from trueloop.arrays import Array
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.chain import AxisKind, Chain, Vector
from trueloop.machine.model.kinematics import influences
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import CONSTANT, Part, Term, chain_of, segments

TRAVEL = {"X": (0.0, 500.0), "Y": (-200.0, 200.0), "Z": (-300.0, 0.0)}


def chain_with_travel(structure: str) -> Chain:
    chain = chain_of(structure)
    return chain.with_axes({a.name: replace(a, travel=TRAVEL[a.name]) for a in chain.axes if a.name in TRAVEL})


def set_back_chain(structure: str) -> Chain:
    """A structure whose axes all travel alike and stand off each other."""
    chain = chain_of(structure)
    return chain.with_axes(
        {
            a.name: replace(a, travel=(-300.0, 400.0), offset_mm=(20.0 + k, -35.0, 50.0 * k))
            for k, a in enumerate(chain.axes)
        }
    )


def any_model(chain: Chain, rng: np.random.Generator, count: int = 4, degree: int = 3, ways: int = 5) -> MachineModel:
    """Every error of the chain: motions of axes as splines of up to so many segments and up to that degree.

    Every third depends on T1 too, every error number `ways` on the way of travel.
    """
    terms = []
    for k, name in enumerate(chain.errors()):
        axis = chain.axis(name.axis)
        moves = axis.kind is not AxisKind.SPINDLE and not name.place
        parts = [Part(segments(*axis.travel, 1 + k % count, k % degree + 1) if moves else CONSTANT)]
        if k % 3 == 0:
            parts.append(Part(segments(*axis.travel, 2, 2) if moves else CONSTANT, "T1", 20.0))
        terms.append(Term(name, tuple(parts), both_ways=moves and k % ways == 0))
    return random_model(Machine("any", chain), tuple(terms), rng)


def random_model(machine: Machine, terms: tuple[Term, ...], rng: np.random.Generator) -> MachineModel:
    """Errors of some 15 µm and 30 µrad, zeros of the terms kept."""
    free = block_diag(*[term.admissible() for term in terms])
    size = np.concatenate([np.full(t.size, 30e-6 if t.name.is_rotation else 0.015) for t in terms])
    wanted = rng.normal(0, 1, len(size)) * size
    coefficients = free @ (free.T @ wanted)
    return MachineModel(machine, terms, coefficients, np.zeros((len(size), len(size))))


def readings(
    truth: MachineModel, state: State, along: Array, noise_mm: float, rng: np.random.Generator, run: str = "1"
) -> Observations:
    """Displacement readings of the exact machine with normal noise, `along` (n, 3)."""
    exact = exact_error_mm(truth.machine.chain, state.positions, state.tool_mm, truth.values(state))
    count = len(state.positions)
    return Observations(
        state,
        along,
        np.einsum("ni,ni->n", along, exact) + rng.normal(0, noise_mm, count),
        np.zeros(count, dtype=bool),
        np.full(count, noise_mm) if noise_mm > 0 else np.full(count, np.nan),
        (run,) * count,
    )


def random_state(chain: Chain, count: int, rng: np.random.Generator, arms_mm: float = 150.0) -> State:
    """Positions over the whole travel with travel ways and tools of several lengths: what volumetric tests visit."""
    positions = np.stack([rng.uniform(*chain.axis(name).travel, count) for name in chain.order], axis=-1)
    travel = rng.choice([-1.0, 1.0], positions.shape)
    return State(positions, travel, {}, rng.uniform(-arms_mm, arms_mm, (count, 3)))


def random_directions(count: int, rng: np.random.Generator, plane: bool = False) -> Array:
    """Unit vectors, for a lathe in the plane of turning."""
    vectors = rng.normal(0, 1, (count, 3))
    if plane:
        vectors[:, 1] = 0.0
    unit: Array = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return unit


def first_order_error_mm(chain: Chain, positions: Array, tool_mm: Array | Vector, values: Values) -> Array:
    """E to first order, (n, 3), work coordinates: the influences' sum."""
    columns = influences(chain, positions, tool_mm)
    total = np.zeros((len(positions), 3))
    for name, value in values.items():
        total += columns[name].displacement * np.broadcast_to(value, (len(positions),))[:, None]
    return total
