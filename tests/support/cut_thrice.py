"""A path cut three times with three tables, and a lathe model of two temperatures and both ways of travel."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag

from trueloop.arrays import Array
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import CONSTANT, Part, Term, chain_of, segments, turning_terms
from trueloop.realtime.image import Block, Identity, Image, RealTimeLimits, bank_of, signals_of

TRAVEL = {"X": (-20.0, 320.0), "Z": (-320.0, 120.0)}
TOOL_OFFSET = (7.5, -12.25)
OPEN = (-1e4, 1e4)
PATH = ("G1 Z-60", "G3 X30 Z-70 I0 K-10", "G1 X36 Z-90", "G2 X40 Z-94 I4 K0")
PROGRAM = "\n".join(
    [
        "G18 G21 G8 G90 G94 G40 G64 P0.0001 Q0",
        f"G43.1 X{TOOL_OFFSET[0]} Z{TOOL_OFFSET[1]}",
        "G0 X60 Z5",
        *[line for _ in range(3) for line in ("G0 X20 Z2", "F3000", *PATH, "G0 X60", "G0 Z5")],
        "G49",
        "M2",
        "",
    ]
)
POINTS = np.array([[20.0, 2.0], [20.0, -60.0], [30.0, -70.0], [36.0, -90.0], [40.0, -94.0]])
CENTRES = (None, (20.0, -70.0), None, (40.0, -90.0))


def lathe_model(seed: int = 8) -> MachineModel:
    """Some 10 µm and 25 µrad of everything, lost motion, drift with T1, expansion and tilt with T2."""
    chain = chain_of("turning")
    axes = {a.name: replace(a, travel=TRAVEL[a.name]) for a in chain.axes if a.name in TRAVEL}
    chain = chain.with_axes(axes)
    standard = [t for t in turning_terms(chain, degree=3, count=3, both_ways=True) if str(t.name) != "EZZ"]
    grown = segments(*TRAVEL["Z"], 1, 3), Part(segments(*TRAVEL["Z"], 1, 1, (0.0,)), "T2", 20.0)
    more = (
        Term(error_name("EZZ"), (Part(grown[0]), grown[1]), both_ways=True),
        Term(error_name("EX0C"), (Part(CONSTANT, "T1", 20.0),)),
        Term(error_name("EZ0C"), (Part(CONSTANT, "T1", 20.0), Part(CONSTANT, "T2", 20.0))),
        Term(error_name("EB0C"), (Part(CONSTANT, "T2", 20.0),)),
    )
    terms = (*standard, *more)
    rng = np.random.default_rng(seed)
    size = np.concatenate([_size(term) for term in terms])
    free = block_diag(*[term.admissible() for term in terms])
    coefficients = free @ (free.T @ (rng.normal(0, 1, len(size)) * size))
    nothing = np.zeros((len(size), len(size)))
    known = {"T1": (10.0, 45.0), "T2": (10.0, 45.0)}
    return MachineModel(Machine("lathe", chain, "8"), terms, coefficients, nothing, known, (), {"T1": "°C", "T2": "°C"})


def _size(term: Term) -> Array:
    """How large its coefficients are: those of a degree a tenth of the others."""
    usual = 25e-6 if term.name.is_rotation else 0.010
    parts = [np.full(part.basis.size, usual * (1.0 if part.signal is None else 0.1)) for part in term.parts]
    return np.concatenate(parts * (2 if term.both_ways else 1))


def image(model: MachineModel | None = None, *, tables: bool = True) -> Image:
    """Model and tables; travel as wide as the virtual machine's."""
    model = model or lathe_model()
    bank = bank_of(model, (1.5, 0.0, -2.5), signals_of(model))
    limits = RealTimeLimits((OPEN, OPEN, OPEN), 0.3, 0.1)
    identity = Identity("lathe", "8", "11" * 32, "thrice.ngc" if tables else "", "22" * 32 if tables else "")
    return Image(identity, limits, bank, blocks() if tables else ())


def blocks() -> tuple[Block, ...]:
    """Three passes, each with its own table along lines and arcs; rows in machine coordinates."""
    lines = PROGRAM.splitlines()
    first = [k + 1 for k, text in enumerate(lines) if text == "F3000"]
    found = []
    for number, line in enumerate(first):
        for k, ((a, b), centre) in enumerate(zip(pairwise(POINTS), CENTRES, strict=True)):
            found.append(Block(line + 1 + k, rows(a, b, centre, k, number)))
    return tuple(found)


def rows(start: Array, end: Array, centre: tuple[float, float] | None, place: int, number: int) -> Array:
    """x, z, dx, dz along a line or an arc of the quarter turn, (n, 4)."""
    u = np.linspace(0.0, 1.0, 301)[:, None]
    at = start + u * (end - start)
    if centre is not None:
        a, b = (np.arctan2(*(point - centre)) for point in (start, end))
        angle = a + u[:, 0] * ((b - a + np.pi) % (2 * np.pi) - np.pi)
        at = centre + np.hypot(*(start - centre)) * np.column_stack([np.sin(angle), np.cos(angle)])
    s = place + u[:, 0]
    added = 0.008 * np.column_stack([np.sin(2 * s + number), np.cos(3 * s - 2 * number)])
    return np.column_stack([at + TOOL_OFFSET, added])
