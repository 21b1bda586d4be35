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
from trueloop.machine.model.chain import AxisKind, ErrorName
from trueloop.machine.model.kinematics import PROBE_MM, apply, influences, tool_in_work_mm
from trueloop.machine.model.model import MachineModel, State

PARALLEL: Final = float(np.sin(np.radians(1.0)))
"""A rotary axis stays where it is where a radian of it turns the tool by less: the tool is within 1° of its line."""

SPINDLE: Final = np.array([0.0, 0.0, 1.0])
_ROUNDS: Final = 2


@dataclass(frozen=True)
class Pose:
    """Tips (n, 3), mm, and unit vectors from tip to spindle (n, 3), in work coordinates."""

    tip_mm: Array
    axis: Array


@dataclass(frozen=True)
class Deviations:
    """How a pose changes: by the machine's errors, displacement of the tip, mm, and rotation, rad, (n, 3); by a
    millimetre of each linear axis, displacement, and by a radian of each axis that may turn, rotation, (n, 3, axes).
    """

    error_mm: Array
    turn_rad: Array
    along: Array
    turns: Array

    def of(self, pose: Pose) -> Pose:
        """Returns the pose with the machine's errors, to first order."""
        return Pose(pose.tip_mm + self.error_mm, pose.axis + np.cross(self.turn_rad, pose.axis))


@dataclass(frozen=True)
class Solved:
    """Axis positions (n, axes); where a rotary axis that may turn stays since the tool is parallel to it, (n,); how far
    the tool leans from the wanted direction there, rad, and how far the tip was off before, mm, (n,).
    """

    positions: Array
    parallel: Flags
    lean_rad: Array
    error_mm: Array


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
        return self._deviations(state).of(self.nominal(state))

    def reach(self, state: State, tip_mm: Array) -> Array:
        """Returns axis positions (n, axes) at which the commanded tip is there; rotary axes stay where they are."""
        return self._moved(state, self._deviations(state, errors=False), tip_mm - self.nominal(state).tip_mm)

    def solve(self, wanted: Pose, state: State, step_rad: float) -> Solved:
        """Returns axis positions at which the actual pose is the wanted one, from those of `state`, which are near.

        Rotary axes stop at multiples of `step_rad`, at which a control's words are; the tip is right there.
        """
        deviations = self._deviations(state)
        off_mm = np.linalg.norm(deviations.of(self.nominal(state)).tip_mm - wanted.tip_mm, axis=1)
        parallel = np.zeros(len(off_mm), dtype=np.bool_)
        for _ in range(_ROUNDS):
            turned, parallel = self._turned(state, deviations, wanted)
            state = self._at_tip(replace(state, positions=turned), deviations, wanted)
            deviations = self._deviations(state)
        columns = self._columns(AxisKind.ROTARY)
        moved = state.positions.copy()
        moved[:, columns] = np.round(moved[:, columns] / step_rad) * step_rad
        state = self._at_tip(replace(state, positions=moved), deviations, wanted)
        lean = np.linalg.norm(deviations.of(self.nominal(state)).axis - wanted.axis, axis=1)
        return Solved(state.positions, parallel, lean, off_mm)

    def _columns(self, kind: AxisKind) -> list[int]:
        chain = self.model.machine.chain
        movable = [name for name in chain.order if name in self.turning or chain.axis(name).kind is AxisKind.LINEAR]
        return [chain.order.index(name) for name in movable if chain.axis(name).kind is kind]

    def _deviations(self, state: State, *, errors: bool = True) -> Deviations:
        """Returns what the machine's errors do, without `errors` nothing, and the motions of its axes."""
        chain, shape = self.model.machine.chain, (len(state.positions), 3)
        values = self.model.values(state) if errors else {}
        linear, rotary = (
            [ErrorName(chain.order[column], chain.order[column]) for column in self._columns(kind)]
            for kind in (AxisKind.LINEAR, AxisKind.ROTARY)
        )  # an error motion of X along X, or of A about A, is a motion of that axis
        found = influences(chain, state.positions, state.tool_mm, {*values, *linear, *rotary})
        error, turn = np.zeros(shape), np.zeros(shape)
        for name, value in values.items():
            error += found[name].displacement * value[:, None]
            turn += found[name].rotation * value[:, None]
        turns = [chain.axis(name.axis).sense * found[name].rotation for name in rotary]
        return Deviations(
            error,
            turn,
            np.stack([found[name].displacement for name in linear], axis=-1),
            np.stack(turns, axis=-1) if turns else np.zeros((*shape, 0)),
        )

    def _turned(self, state: State, deviations: Deviations, wanted: Pose) -> tuple[Array, Flags]:
        """Returns positions with rotary axes moved, by least squares, so that the direction is the wanted one."""
        pose, moved = self.nominal(state), state.positions.copy()
        turns = np.cross(deviations.turns, pose.axis[:, :, None], axis=1)
        stays = np.linalg.norm(turns, axis=1) < PARALLEL
        columns = self._columns(AxisKind.ROTARY)
        if columns:
            by: Array = np.linalg.pinv(np.where(stays[:, None, :], 0.0, turns))
            moved[:, columns] += apply(by, wanted.axis - deviations.of(pose).axis)
        return moved, stays.any(axis=1)

    def _at_tip(self, state: State, deviations: Deviations, wanted: Pose) -> State:
        off_mm = wanted.tip_mm - deviations.of(self.nominal(state)).tip_mm
        return replace(state, positions=self._moved(state, deviations, off_mm))

    def _moved(self, state: State, deviations: Deviations, by_mm: Array) -> Array:
        """Returns positions with linear axes moved so that the tip, as seen from the work, moves by (n, 3)."""
        moved = state.positions.copy()
        by = np.asarray(np.linalg.inv(deviations.along), dtype=np.float64)
        moved[:, self._columns(AxisKind.LINEAR)] += apply(by, by_mm)
        return moved
