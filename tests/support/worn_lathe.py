"""A turning centre that errs by plain transforms, and parts cut on it with a model's correction in force."""

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.model.chain import Axis, AxisKind, error_name
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import CONSTANT, Part, Term, chain_of, segments
from trueloop.machine.refine.left import LeftOnParts

TOOLS = np.array([[-12.0, -30.0], [-70.0, 60.0], [-40.0, 10.0]])


def lathe_model(u_mm: float = 2e-4) -> MachineModel:
    """A turning centre whose model says that it has no errors, sure of that to `u_mm`."""
    chain = chain_of("turning").with_axes(
        {
            "X": Axis("X", AxisKind.LINEAR, 0, travel=(-10.0, 310.0)),
            "Z": Axis("Z", AxisKind.LINEAR, 2, travel=(-300.0, 110.0)),
        }
    )
    terms = (
        Term(error_name("EXX"), (Part(segments(-10.0, 310.0, 1, 2)),)),
        Term(error_name("EXZ"), (Part(segments(-300.0, 110.0, 1, 3)),), both_ways=True),
        Term(error_name("EZ0C"), (Part(CONSTANT), Part(CONSTANT, "T1", 20.0))),
    )
    size = sum(term.size for term in terms)
    known = {"X": (-10.0, 310.0), "Z": (-300.0, 110.0), "T1": (20.0, 44.0)}
    return MachineModel(Machine("lathe", chain, "4711"), terms, np.zeros(size), u_mm**2 * np.eye(size), known)


def straightness(slides: Array, tool: Array, warm: Array) -> Array:
    """The carriage goes 12 µm towards larger X in the middle of its way."""
    return np.column_stack([0.012 * np.sin(np.pi * (slides[:, 1] + 300) / 410), np.zeros(len(slides))])


def yaw(slides: Array, tool: Array, warm: Array) -> Array:
    """The carriage turns about Y by r = 100 µrad · z/300: a point dx, dz off its frame moves by r · (dz, −dx)."""
    turn = 1e-4 * slides[:, 1] / 300
    return np.column_stack([turn * tool[:, 1], -turn * (slides[:, 0] + tool[:, 0])])


def growth(slides: Array, tool: Array, warm: Array) -> Array:
    """The spindle takes the work by 0.8 µm/K along +Z: the tool stands that much less along Z on it."""
    return np.column_stack([np.zeros(len(slides)), -0.0008 * (warm - 20.0)])


def nothing(slides: Array, tool: Array, warm: Array) -> Array:
    return np.zeros((len(slides), 2))


def cut(model: MachineModel, truth, seed: int, parts: int = 12, noise_mm: float = 1e-3) -> LeftOnParts:  # type: ignore[no-untyped-def]
    """Parts of three types, cut with the command moved by −E_model; what stands off the nominal surface is measured."""
    rng, rows = np.random.default_rng(seed), []
    for part in range(parts):
        kind, warm = part % 3, rng.uniform(21, 44)
        begin, radius = (-180.0, -150.0, -120.0)[kind], (90.0, 60.0, 110.0)[kind]
        for k, tool in enumerate(TOOLS[[kind, (kind + 1) % 3]]):
            for t in range(8):
                rows.append((part, kind, warm, radius - 20 * k, begin + 40 * k + 4 * t, 1.0, 0.0, *tool))
                rows.append((part, kind, warm, radius - 20 * k - 2 * t, begin + 40 * k + 40, 0.0, 1.0, *tool))
    table = np.array(rows)
    number, types, heat = table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2]
    point, normal, own = table[:, 3:5], table[:, 5:7], table[:, 7:9]
    spread = np.zeros((2, len(table), 3))
    spread[:, :, [0, 2]] = normal, own
    state = State(point - own, 0.0, {"T1": heat}, spread[1])
    slides = point - own - model.error_mm(state)[:, [0, 2]]
    surface = slides + own + truth(slides, own, heat)
    left = np.sum(normal * (surface - point), axis=1) + rng.normal(0, noise_mm, len(table))
    set_up = rng.normal(0, noise_mm, (parts, 2))[number]
    left = left + np.sum(normal * set_up, axis=1)
    return LeftOnParts(number, types, spread[0], state, left)


def left_truly(model: MachineModel, truth, seed: int = 99) -> float:  # type: ignore[no-untyped-def]
    """RMS of what the model leaves on other parts without noise, µm."""
    return 1e3 * float(np.sqrt(np.mean(cut(model, truth, seed, 9, 1e-9).residual_mm ** 2)))
