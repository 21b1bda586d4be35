"""Poses of the tool in the work, tip and axis, on a machine that errs; the axis positions at which they are as wanted.

A pose has five numbers: the tip, mm, and the direction from tip to spindle, a unit vector, both in work coordinates.
Rotary axes are moved until the direction is right, then linear ones until the tip is. A rotary axis to which the tool
is nearly parallel turns the direction hardly at all: it stays where it is, and so does a part of the direction's error.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.machine.model.chain import AxisKind
from trueloop.machine.model.kinematics import PROBE_MM, apply, tool_in_work_mm
from trueloop.machine.model.model import MachineModel, State, design

PARALLEL: Final = float(np.sin(np.radians(1.0)))
"""A rotary axis stays where it is where a radian of it turns the tool by less: the tool is within 1° of its line."""

SPINDLE: Final = np.array([0.0, 0.0, 1.0])
_ROUNDS: Final = 3
_STEP_RAD: Final = 1e-4


@dataclass(frozen=True)
class Pose:
    """Tips (n, 3), mm, and unit vectors from tip to spindle (n, 3), in work coordinates."""

    tip_mm: Array
    axis: Array


@dataclass(frozen=True)
class Solved:
    """Axis positions (n, axes) and where a rotary axis, of those that may move, stays since the tool is parallel to it,
    (n,).
    """

    positions: Array
    parallel: Flags


@dataclass(frozen=True)
class PoseModel:
    """Poses by a machine model; `turning` are the rotary axes that may be moved, by name."""

    model: MachineModel
    turning: Collection[str]

    def nominal(self, state: State) -> Pose:
        """Returns the commanded pose: exact."""
        chain, tool_mm = self.model.machine.chain, np.asarray(state.tool_mm)
        tip = tool_in_work_mm(chain, state.positions, tool_mm)
        return Pose(tip, (tool_in_work_mm(chain, state.positions, tool_mm + PROBE_MM * SPINDLE) - tip) / PROBE_MM)

    def actual(self, state: State) -> Pose:
        """Returns the pose with the machine's errors, to first order."""
        chain, pose = self.model.machine.chain, self.nominal(state)
        error, turn = (
            design(chain, self.model.terms, state, rotations=rotations) @ self.model.coefficients
            for rotations in (False, True)
        )
        return Pose(pose.tip_mm + error, pose.axis + np.cross(turn, pose.axis))

    def reach(self, state: State, tip_mm: Array) -> Array:
        """Returns axis positions (n, axes) at which the commanded tip is there; rotary axes stay where they are."""
        return self._moved(state, tip_mm - self.nominal(state).tip_mm)

    def solve(self, wanted: Pose, state: State, step_rad: float) -> Solved:
        """Returns axis positions at which the actual pose is the wanted one, from those of `state`, which are near.

        Rotary axes stop at multiples of `step_rad`, at which a control's words are; the tip is right there.
        """
        parallel = np.zeros(len(state.positions), dtype=np.bool_)
        for _ in range(_ROUNDS):
            turned, parallel = self._turned(state, wanted.axis - self.actual(state).axis)
            state = self._at_tip(replace(state, positions=turned), wanted)
        columns = self._columns(AxisKind.ROTARY)
        moved = state.positions.copy()
        moved[:, columns] = np.round(moved[:, columns] / step_rad) * step_rad
        state = replace(state, positions=moved)
        for _ in range(_ROUNDS):
            state = self._at_tip(state, wanted)
        return Solved(state.positions, parallel)

    def turns(self, state: State) -> Array:
        """Returns the change of the tool's direction by a radian of each axis that may turn, (n, 3, turning)."""
        found = []
        for column in self._columns(AxisKind.ROTARY):
            ends = []
            for step in (_STEP_RAD, -_STEP_RAD):
                moved = state.positions.copy()
                moved[:, column] += step
                ends.append(self.nominal(replace(state, positions=moved)).axis)
            found.append((ends[0] - ends[1]) / (2 * _STEP_RAD))
        return np.stack(found, axis=-1) if found else np.zeros((len(state.positions), 3, 0))

    def _columns(self, kind: AxisKind) -> list[int]:
        chain = self.model.machine.chain
        movable = [name for name in chain.order if name in self.turning or chain.axis(name).kind is AxisKind.LINEAR]
        return [chain.order.index(name) for name in movable if chain.axis(name).kind is kind]

    def _turned(self, state: State, miss: Array) -> tuple[Array, Flags]:
        """Returns positions with rotary axes moved, by least squares, to take the miss (n, 3) out of the direction."""
        turns, moved = self.turns(state), state.positions.copy()
        stays = np.linalg.norm(turns, axis=1) < PARALLEL
        turns = np.where(stays[:, None, :], 0.0, turns)
        columns = self._columns(AxisKind.ROTARY)
        if columns:
            moved[:, columns] += np.einsum("nij,nj->ni", np.linalg.pinv(turns), miss)
        return moved, stays.any(axis=1)

    def _at_tip(self, state: State, wanted: Pose) -> State:
        moved = self._moved(state, wanted.tip_mm - self.actual(state).tip_mm)
        return replace(state, positions=moved)

    def _moved(self, state: State, by_mm: Array) -> Array:
        """Returns positions with linear axes moved so that the tip, as seen from the work, moves by (n, 3)."""
        tip, columns = self.nominal(state).tip_mm, self._columns(AxisKind.LINEAR)
        along = []
        for column in columns:
            probed = state.positions.copy()
            probed[:, column] += PROBE_MM
            along.append((self.nominal(replace(state, positions=probed)).tip_mm - tip) / PROBE_MM)
        moved = state.positions.copy()
        moved[:, columns] += apply(np.linalg.inv(np.stack(along, axis=-1)), by_mm)
        return moved
