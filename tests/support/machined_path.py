"""Where a machine with known errors really takes the tool along a program, and how far that is from where it should."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from scipy.spatial import cKDTree

from tests.support.exact_kinematics import exact_error_of
from tests.support.forward_model import ForwardMachine, random_machine
from tests.support.linuxcnc import Move, Tool, interpret
from trueloop.arrays import Array
from trueloop.domain.option import MapOptions
from trueloop.domain.record import MARK
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.machine.correct import Setup, compensation_field
from trueloop.machine.identify.form import Form, fit_form
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import PRESETS, chain_of, five_axis_terms, frame_terms
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion

STARTUP = "G17 G21 G40 G49 G54 G64 G80 G90 G91.1 G94"


FREE: Final = MapOptions(limit_mm=np.inf, slope=np.inf)
"""No limit: what is looked at is where the path goes."""


def corrected(
    source: str,
    model: MachineModel,
    setup: Setup,
    tolerance_mm: float = 0.0002,
    *,
    dialect: str = "linuxcnc",
    skipped_blocks: bool = False,
) -> str:
    """The program with the model's correction written in, without the mark."""
    with TemporaryDirectory() as folder:
        program, target = Path(folder) / "program.ngc", Path(folder) / "corrected.ngc"
        program.write_text(source)
        field = compensation_field(model, setup, {})
        map_program(
            program,
            target,
            field,
            replace(FREE, tolerance_mm=tolerance_mm, skipped_blocks=skipped_blocks),
            dialect=dialect,
        )
        lines = target.read_text().splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith(f"({MARK}"))


def interpreted_points(
    source: str, folder: Path, name: str, step_mm: float, tools: Sequence[Tool] = ()
) -> tuple[Array, Array]:
    """(points along all feed moves, their ends), (n, 3) mm, as LinuxCNC's interpreter commands them."""
    file = folder / f"{name}.ngc"
    file.write_text(source)
    moves = [move for move in interpret(file, tools=tools, startup=STARTUP) if move.kind != "rapid"]
    points = [_along(move, step_mm) for move in moves]
    return np.concatenate(points), np.array([move.end_mm for move in moves])


def _along(move: Move, step_mm: float) -> Array:
    start, end = np.array(move.start_mm), np.array(move.end_mm)
    if move.kind == "line":
        count = max(2, int(np.linalg.norm(end - start) / step_mm))
        line: Array = start + np.linspace(0, 1, count)[:, None] * (end - start)
        return line
    # the interpreter does not say the plane: it is the one of the spoke in which the arc comes to its end, or XY
    spoke = np.abs(start - np.array(move.centre_mm))
    planes = [plane for plane in ((0, 1), (1, 2), (2, 0)) if spoke[3 - plane[0] - plane[1]] < 1e-9]
    arcs = [_in_plane(move, plane, step_mm) for plane in planes]
    return min(arcs, key=lambda points: round(float(np.linalg.norm(points[-1] - end)), 6))


def _in_plane(move: Move, plane: tuple[int, int], step_mm: float) -> Array:
    assert move.centre_mm is not None and move.sweep_rad is not None
    first, second = plane
    start, centre = np.array(move.start_mm), np.array(move.centre_mm)
    radius = float(np.hypot(start[first] - centre[first], start[second] - centre[second]))
    share = np.linspace(0, 1, max(9, int(radius * abs(move.sweep_rad) / step_mm)))
    angle = np.arctan2(start[second] - centre[second], start[first] - centre[first]) - move.sweep_rad * share
    points = start + share[:, None] * (np.array(move.end_mm) - start)
    points[:, first] = centre[first] + radius * np.cos(angle)
    points[:, second] = centre[second] + radius * np.sin(angle)
    round_: Array = points
    return round_


def run_points(source: str, count: int = 9) -> tuple[Array, Array]:
    """The same by our own runner, for programs of straight moves: (`count` points a move, ends)."""
    path = read_program(source.encode(), "linuxcnc").run()
    feeds = np.flatnonzero(path.motion == Motion.LINE)
    share = np.linspace(0, 1, count)[:, None]
    points = [path.start_mm[k] + share * (path.end_mm[k] - path.start_mm[k]) for k in feeds]
    return np.concatenate(points), path.end_mm[feeds]


def actual_mm(truth: MachineModel, setup: Setup, points: Array) -> Array:
    """Where the machine with the exact errors of `truth` takes the tool when sent to program points."""
    zero, tool = np.array(setup.work_zero_mm[1]), np.array(setup.tool_mm[-1])
    chain = truth.machine.chain
    axes = points + zero - tool
    positions = chain.positions({name: axes[:, k] for k, name in enumerate("XYZ") if name in chain.order})
    actual: Array = points + exact_error_of(truth, State(positions, 0.0, setup.signals, tool))
    return actual


def distances_mm(wanted: Array, found: Array) -> Array:
    """Of each wanted point to the nearest of those found."""
    return np.asarray(cKDTree(found).query(wanted)[0], dtype=np.float64)


def rms(values: Array | Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


TRAVEL = {"X": (-200.0, 200.0), "Y": (-200.0, 200.0), "Z": (-250.0, 50.0)}
TRAVEL |= {"A": (-1.2, 0.6), "B": (-1.2, 0.6), "C": (-2.0, 2.0)}


@cache
def known_machine(structure: str, sense: float) -> tuple[MachineModel, ForwardMachine]:
    """A random machine, and its model from exact readings; `sense` −1: rotary axes turn against ISO 841."""
    rng, chain = np.random.default_rng(11), chain_of(structure)
    changed = {a.name: replace(a, travel=TRAVEL[a.name]) for a in chain.axes if a.name in chain.order}
    changed |= {name: replace(axis, sense=sense) for name, axis in changed.items() if name in "ABC"}
    chain = chain.with_axes(changed)
    truth, count = random_machine(PRESETS[structure], TRAVEL, rng), 3000
    at = {name: rng.uniform(*TRAVEL[name], count) for name in chain.order}
    tool = rng.uniform([-60, -60, -180], [60, 60, -60], (count, 3))
    along = rng.normal(0, 1, (count, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    reading = np.einsum("ni,ni->n", along, truth.error_mm(physical(at, sense), tool))
    terms = five_axis_terms(chain)
    data = Observations(
        State(chain.positions(at), 0.0, {}, tool),
        along,
        reading,
        np.zeros(count, bool),
        np.full(count, 1e-4),
        ("volume",) * count,
    )
    return fit_form(Machine(structure, chain), Form(terms, frame=frame_terms(chain, terms)), data)[0].model, truth


def physical(at: dict[str, Array], sense: float) -> dict[str, Array]:
    """Positions by ISO 841 of a machine whose rotary axes turn in that sense."""
    return {name: (sense if name in "ABC" else 1.0) * values for name, values in at.items()}
