"""A program's tool path in machine coordinates, and the machine error along it."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Array
from trueloop.machine.chain import Vector
from trueloop.machine.kinematics import bed_to_work
from trueloop.machine.model import MachineModel, State
from trueloop.machine.term import Signals
from trueloop.machine.validity import check_state
from trueloop.nc.tool_path import ToolPath

Indices = NDArray[np.integer]


@dataclass(frozen=True)
class Setup:
    """What a program does not say: where its zero lies, how long its tools are, how warm the machine is.

    `work_zero_mm`: machine coordinates of the program's zero by number of the work offset (1 is G54), for a tool of
    no length. `tool_mm`: tool point from the frame of the last axis, by T number; under −1 for every other tool.
    `fixed`: where rotary axes stand, which the program has to leave alone, rad; 0 for those not named.
    """

    work_zero_mm: Mapping[int, Vector]
    tool_mm: Mapping[int, Vector] = field(default_factory=lambda: {-1: (0.0, 0.0, 0.0)})
    signals: Signals = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class CommandedPath:
    """Moves of a program with what is needed to ask the model about any point of them; arrays (n, 3) and (n,)."""

    model: MachineModel
    setup: Setup
    path: ToolPath
    zero_mm: Array
    tool_mm: Array
    travel: Array
    to_axes: Array

    def error_mm(self, point_mm: Array, move: Indices, tangent: Array | None = None) -> Array:
        """E at program points (m, 3) of moves (m,). The tangent says which way each axis travels there.

        Along X, Y, Z of the program, which are those of the machine: a turned table carries no coordinates with it.
        """
        along_axes: Array = self.model.error_mm(self.state(point_mm, move, tangent)) @ self.to_axes
        return along_axes

    def state(self, point_mm: Array, move: Indices, tangent: Array | None = None) -> State:
        """Axis positions there: program point + work zero − tool vector."""
        chain = self.model.machine.chain
        axes = point_mm + self.zero_mm[move] - self.tool_mm[move]
        given: dict[str, Array | float] = dict(self.setup.fixed)
        given |= {name: axes[:, k] for k, name in enumerate("XYZ") if name in chain.order}
        way = self.travel[move]
        if tangent is not None:
            way = np.where(np.abs(tangent) > 1e-9, np.sign(tangent), way)
        columns = [way[:, "XYZ".index(n)] if n in "XYZ" else np.zeros(len(move)) for n in chain.order]
        return State(chain.positions(given), np.stack(columns, axis=-1), self.setup.signals, self.tool_mm[move])


def commanded_path(
    model: MachineModel, setup: Setup, path: ToolPath, extrapolate: Collection[str] = ()
) -> CommandedPath:
    """Places a path in the machine.

    Raises MCH-FRAME (an unknown work offset or tool, a turned head), MCH-TRAVEL, MCH-RANGE.
    """
    zero = _looked_up(path.work_offset, setup.work_zero_mm, "work offset", path)
    known = dict(setup.tool_mm)
    tools = np.where(np.isin(path.tool, list(known)), path.tool, -1)
    tool = _looked_up(tools, known, "tool", path)
    _check_head_upright(model, setup)
    to_axes = bed_to_work(model.machine.chain, setup.fixed).T
    placed = CommandedPath(model, setup, path, zero, tool, _travel(path), to_axes)
    moves = np.arange(len(path))
    # the start of the first move is where the tool happens to be; rapids to home are outside the programmed frame
    if len(moves):
        check_state(model, placed.state(path.end_mm, moves), extrapolate)
    return placed


def _check_head_upright(model: MachineModel, setup: Setup) -> None:
    """With a head turned, tool vectors would no longer be what work offsets are taken off."""
    for axis in model.machine.chain.tool:
        if setup.fixed.get(axis.name, 0.0) != 0.0:
            raise TrueloopError(
                Code.MCH_FRAME,
                f"{axis.name} turns the tool by {setup.fixed[axis.name]:g} rad: where its tip lies is not told",
                hint="only rotary axes that carry the work may stand away from 0",
            )


def _looked_up(numbers: Indices, table: Mapping[int, Vector], what: str, path: ToolPath) -> Array:
    vectors = np.zeros((len(numbers), 3))
    for number in np.unique(numbers):
        if int(number) not in table:
            line = int(path.line[np.flatnonzero(numbers == number)[0]])
            given = ", ".join(str(n) for n in table) or "none"
            raise TrueloopError(
                Code.MCH_FRAME,
                f"{what} {int(number)} is used in line {line}, but only {given} is known in machine coordinates",
                hint="the model lives in machine coordinates: give --work-zero 1=X,Y,Z for G54, --tool T=X,Y,Z",
            )
        vectors[numbers == number] = table[int(number)]
    return vectors


def _travel(path: ToolPath) -> Array:
    """+1 or −1 an axis: the way of the last move that moved it, 0 before."""
    step = np.sign(path.end_mm - path.start_mm)
    step[np.abs(path.end_mm - path.start_mm) < 1e-9] = 0.0
    last = np.maximum.accumulate(np.where(step != 0, np.arange(len(step))[:, None], -1), axis=0)
    return np.where(last >= 0, np.take_along_axis(step, np.maximum(last, 0), axis=0), 0.0)
