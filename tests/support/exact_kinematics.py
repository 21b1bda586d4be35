"""The tool as seen from the work with errors, by the exact transforms: what the product computes to first order."""

from collections.abc import Mapping, Sequence

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.model.chain import Axis, AxisKind, Chain, ErrorName, Vector
from trueloop.machine.model.kinematics import Frames, apply, rotation, travelled
from trueloop.machine.model.model import MachineModel, State

Values = Mapping[ErrorName, Array | float]


def exact_error_of(model: MachineModel, state: State) -> Array:
    """Returns E of a model by the exact transforms, (n, 3)."""
    return exact_error_mm(model.machine.chain, state.positions, state.tool_mm, model.values(state))


def exact_error_mm(chain: Chain, positions: Array, tool_mm: Array | Vector, values: Values) -> Array:
    """Returns E by the exact transforms, (n, 3): second-order products of errors included."""
    return erring_tool_in_work_mm(chain, positions, tool_mm, values) - erring_tool_in_work_mm(
        chain, positions, tool_mm, {}
    )


def erring_tool_in_work_mm(chain: Chain, positions: Array, tool_mm: Array | Vector, values: Values) -> Array:
    """Returns the tool point in work coordinates, (n, 3): the exact product of homogeneous transforms, errors as
    rotation vectors.

    `tool_mm` is the tool point from the frame of the last axis that carries the tool, (3,) or (n, 3).
    """
    count = len(positions)
    tool = _branch(chain.tool, 1.0, chain, positions, values).shifted(np.broadcast_to(tool_mm, (count, 3)))
    work = _branch(chain.work, -1.0, chain, positions, values)
    return apply(np.swapaxes(work.turn, -1, -2), tool.origin_mm - work.origin_mm)


def _branch(axes: Sequence[Axis], sense: float, chain: Chain, positions: Array, values: Values) -> Frames:
    count = len(positions)
    frame = Frames(np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3)))
    for axis in axes:
        frame = _joint(frame.shifted(axis.offset_mm), axis, sense, travelled(chain, axis, positions), values)
    return frame


def _joint(frame: Frames, axis: Axis, sense: float, by: Array, values: Values) -> Frames:
    """Returns the frame after one axis. The tool's branch meets its motion, then its error; the work's branch the
    inverses of both, in the other order.
    """
    count = len(by)
    place_mm, place_rad = _six(values, axis.name, True, count)
    motion_mm, motion_rad = _six(values, axis.name, False, count)
    if axis.kind is not AxisKind.LINEAR:
        frame = frame.shifted(place_mm).turned(rotation(place_rad))
    if sense < 0:
        frame = frame.turned(rotation(-motion_rad)).shifted(-motion_mm)
    if axis.kind is AxisKind.LINEAR:
        frame = frame.shifted(rotation(place_rad)[:, :, axis.number] * (sense * by)[:, None])
    else:
        nominal = np.zeros((count, 3))
        nominal[:, axis.number] = sense * by
        frame = frame.turned(rotation(nominal))
    return frame.shifted(motion_mm).turned(rotation(motion_rad)) if sense > 0 else frame


def _six(values: Values, axis: str, place: bool, count: int) -> tuple[Array, Array]:
    columns: list[Array] = [np.broadcast_to(values.get(ErrorName(c, axis, place), 0.0), (count,)) for c in "XYZABC"]
    six = np.stack(columns, axis=-1)
    return six[:, :3], six[:, 3:]
