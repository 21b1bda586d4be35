"""First-order influence of every axis error on the tool point: the composition of E, and the sensitivity of
measurements.

E ≈ Σ columns[name] · value. Neglected are products of two errors: with 50 µrad and arms of 1 m, some 2.5 nm.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.model.chain import Axis, AxisKind, Chain, Vector
from trueloop.machine.model.kinematics import Frames, Values, apply, rotation, travelled
from trueloop.machine.model.names import ErrorName


@dataclass(frozen=True)
class Influence:
    """The influence of a unit error: displacement of the tool point (mm) and rotation of the tool (rad), (n, 3), in
    work axes.
    """

    displacement: Array
    rotation: Array


def influences(
    chain: Chain, positions: Array, tool_mm: Array | Vector, only: Collection[ErrorName] | None = None
) -> Mapping[ErrorName, Influence]:
    """Returns the influence of every error of the chain (or `only` those) at each position; shapes as in
    `tool_in_work_mm`.
    """
    tool_steps = _steps(chain.tool, 1.0, chain, positions)
    work_steps = _steps(chain.work, -1.0, chain, positions)
    last = tool_steps[-1][1] if tool_steps else _bed(len(positions))
    tip_mm = last.shifted(np.asarray(tool_mm)).origin_mm
    to_work = np.swapaxes(work_steps[-1][1].turn, -1, -2) if work_steps else _bed(len(positions)).turn
    found: dict[ErrorName, Influence] = {}
    for steps, sense in ((work_steps, -1.0), (tool_steps, 1.0)):
        for (axis, after), before in zip(steps, _befores(steps, len(positions)), strict=True):
            joint = before.shifted(axis.offset_mm)
            for name in axis.errors():
                if only is not None and name not in only:
                    continue
                if not name.place:
                    bed = _rigid(joint if sense < 0 else after, name, tip_mm)
                elif axis.kind is AxisKind.LINEAR:
                    bed = _direction(joint, axis, name, travelled(chain, axis, positions))
                else:
                    bed = _rigid(joint, name, tip_mm, sense)
                found[name] = Influence(apply(to_work, bed.displacement), apply(to_work, bed.rotation))
    return found


def first_order_error_mm(chain: Chain, positions: Array, tool_mm: Array | Vector, values: Values) -> Array:
    """Returns E to first order, (n, 3), work coordinates."""
    columns = influences(chain, positions, tool_mm)
    total = np.zeros((len(positions), 3))
    for name, value in values.items():
        total += columns[name].displacement * np.broadcast_to(value, (len(positions),))[:, None]
    return total


def _steps(axes: tuple[Axis, ...], sense: float, chain: Chain, positions: Array) -> list[tuple[Axis, Frames]]:
    """Returns each axis with the nominal frame after it."""
    frame = _bed(len(positions))
    steps = []
    for axis in axes:
        along = np.zeros((len(positions), 3))
        along[:, axis.number] = sense * travelled(chain, axis, positions)
        frame = frame.shifted(axis.offset_mm)
        frame = frame.shifted(along) if axis.kind is AxisKind.LINEAR else frame.turned(rotation(along))
        steps.append((axis, frame))
    return steps


def _befores(steps: list[tuple[Axis, Frames]], count: int) -> list[Frames]:
    return [_bed(count), *[frame for _, frame in steps]][: len(steps)]


def _bed(count: int) -> Frames:
    return Frames(np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3)))


def _rigid(frame: Frames, name: ErrorName, tip_mm: Array, sense: float = 1.0) -> Influence:
    """Returns the influence of a motion of everything beyond `frame` as one body along or about the frame's axis
    `name.number`.
    """
    direction = sense * frame.turn[:, :, name.number]
    if name.is_rotation:
        return Influence(np.cross(direction, tip_mm - frame.origin_mm), direction)
    return Influence(direction, np.zeros_like(direction))


def _direction(joint: Frames, axis: Axis, name: ErrorName, by: Array) -> Influence:
    """Returns the influence of a linear axis out of square: it moves along another direction and turns nothing.

    Both branches alike: the tool's path as seen from the work is the same line.
    """
    about, along = joint.turn[:, :, name.number], joint.turn[:, :, axis.number]
    displacement = np.cross(about, along) * by[:, None]
    return Influence(displacement, np.zeros_like(displacement))
