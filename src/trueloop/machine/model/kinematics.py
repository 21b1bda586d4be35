"""The tool as seen from the work, with and without errors: exact, and to first order.

E(p) = actual − commanded position of the tool point in work coordinates. An error *motion* (EXX, EBZ …) is the motion
of the tool's side against the work's side of the axis, so it has the sign of the instrument reading whichever side
moves. From work to tool every axis contributes its commanded motion and then its error motion: rotations turn about the
origin of the axis' frame on the *tool's* side, along and about that frame's directions. So the arm of ECX is what lies
between that frame and the tool (the axes nearer to the tool, `offset_mm`, the tool), and never the position of X
itself; the error motion of a rotary table is stated in directions that do not turn with it, as ISO 230-7 measures it.

An error of *place* (EC0Y, EX0C …) is where the axis itself lies in the frame that carries it: a work spindle that
drifts by EX0C = +0.01 takes the work along, and E is −0.01.

`values` maps an error's name to mm or rad, shape () or (n,). `positions` has shape (n, axes) in `chain.order`.

First-order influence of every axis error on the tool point: the composition of E, and the sensitivity of
measurements.

E ≈ Σ columns[name] · value. Neglected are products of two errors: with 50 µrad and arms of 1 m, some 2.5 nm.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.model.chain import Axis, AxisKind, Chain, ErrorName, Vector

PROBE_MM = 1024.0
"""Distance by which axes are moved to probe their effect: as long as offsets are, so that no digits are lost."""


@dataclass(frozen=True)
class Frames:
    """n frames: columns of `turn` (n, 3, 3) are their axes, `origin_mm` (n, 3) their origins, seen from the bed."""

    turn: Array
    origin_mm: Array

    def shifted(self, local_mm: Array | Vector) -> "Frames":
        """Returns the frames moved by a vector given in the frame itself."""
        return Frames(self.turn, self.origin_mm + apply(self.turn, np.asarray(local_mm)))

    def turned(self, rotation: Array) -> "Frames":
        """Returns the frames turned about their own origin."""
        return Frames(self.turn @ rotation, self.origin_mm)


def tool_in_work_mm(chain: Chain, positions: Array, tool_mm: Array | Vector) -> Array:
    """Returns the commanded tool point in work coordinates, (n, 3): the exact product of homogeneous transforms.

    `tool_mm` is the tool point from the frame of the last axis that carries the tool, (3,) or (n, 3).
    """
    bed = _bed(len(positions))
    tool, work = (
        steps[-1][1] if (steps := _steps(axes, sense, chain, positions)) else bed
        for axes, sense in ((chain.tool, 1.0), (chain.work, -1.0))
    )
    return apply(np.swapaxes(work.turn, -1, -2), tool.shifted(tool_mm).origin_mm - work.origin_mm)


def bed_to_work(chain: Chain, fixed: Mapping[str, float]) -> Array:
    """Returns the bed's axes in work coordinates, as rows, with rotary axes at `fixed` (rad), the others at 0.

    A row is the displacement of the tool by a millimetre of X, Y or Z as seen from the work.
    """
    given: dict[str, Array | float] = dict(fixed)
    probes = np.vstack([np.zeros(3), PROBE_MM * np.eye(3)])
    given |= {name: probes[:, k] for k, name in enumerate("XYZ") if name in chain.order}
    tool_at = tool_in_work_mm(chain, np.broadcast_to(chain.positions(given), (4, len(chain.order))), np.zeros(3))
    rows: Array = (tool_at[1:] - tool_at[0]) / PROBE_MM
    for missing in np.flatnonzero(np.linalg.norm(rows, axis=1) < 0.5):
        rows[missing] = np.cross(rows[(missing + 1) % 3], rows[(missing + 2) % 3])
    return rows


def travelled(chain: Chain, axis: Axis, positions: Array) -> Array:
    """Returns the commanded motion of one axis, (n,), positive by ISO 841; a spindle has none."""
    if axis.kind is AxisKind.SPINDLE:
        return np.zeros(len(positions))
    position: Array = axis.sense * positions[:, chain.order.index(axis.name)]
    return position


def rotation(vector_rad: Array) -> Array:
    """Returns the rotation matrices (n, 3, 3) of rotation vectors (n, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(vector_rad, axis=-1)[:, None, None]
    x, y, z = vector_rad.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
    # sin(a)/a and (1 − cos a)/a² as sinc, which is exact at 0 and loses nothing at microradians
    matrices: Array = (
        np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (cross @ cross)
    )
    return matrices


def apply(matrices: Array, vectors: Array) -> Array:
    """Multiplies each matrix with its vector: (n, 3, 3) and (n, 3) or (3,) to (n, 3)."""
    product: Array = np.einsum("nij,nj->ni", matrices, np.broadcast_to(vectors, (len(matrices), 3)))
    return product


@dataclass(frozen=True)
class Influence:
    """The influence of a unit error: displacement of the tool point (mm) and rotation (rad), (n, 3), in work axes."""

    displacement: Array
    rotation: Array


def influences(
    chain: Chain, positions: Array, tool_mm: Array | Vector, only: Collection[ErrorName] | None = None
) -> Mapping[ErrorName, Influence]:
    """Returns the influence of the chain's errors (or `only` those) by position; shapes as in `tool_in_work_mm`."""
    tool_steps = _steps(chain.tool, 1.0, chain, positions)
    work_steps = _steps(chain.work, -1.0, chain, positions)
    last = tool_steps[-1][1] if tool_steps else _bed(len(positions))
    tip_mm = last.shifted(np.asarray(tool_mm)).origin_mm
    to_work = np.swapaxes(work_steps[-1][1].turn, -1, -2) if work_steps else _bed(len(positions)).turn
    found: dict[ErrorName, Influence] = {}
    for steps, sense in ((work_steps, -1.0), (tool_steps, 1.0)):
        befores = [_bed(len(positions)), *(frame for _, frame in steps)]
        for (axis, after), before in zip(steps, befores, strict=False):
            joint = before.shifted(axis.offset_mm)
            for name in axis.errors():
                if only is not None and name not in only:
                    continue
                if not name.place:
                    bed = _rigid(joint if sense < 0 else after, name, tip_mm)
                elif axis.kind is AxisKind.LINEAR:
                    # The influence of a linear axis out of square: it moves along another direction and turns nothing.
                    # Both branches alike: the tool's path as seen from the work is the same line.
                    about, along = joint.turn[:, :, name.number], joint.turn[:, :, axis.number]
                    displacement = np.cross(about, along) * travelled(chain, axis, positions)[:, None]
                    bed = Influence(displacement, np.zeros_like(displacement))
                else:
                    bed = _rigid(joint, name, tip_mm, sense)
                found[name] = Influence(apply(to_work, bed.displacement), apply(to_work, bed.rotation))
    return found


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


def _bed(count: int) -> Frames:
    return Frames(np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3)))


def _rigid(frame: Frames, name: ErrorName, tip_mm: Array, sense: float = 1.0) -> Influence:
    """Returns the influence of moving all beyond `frame` as one body along or about the frame's axis `name.number`."""
    direction = sense * frame.turn[:, :, name.number]
    if name.is_rotation:
        return Influence(np.cross(direction, tip_mm - frame.origin_mm), direction)
    return Influence(direction, np.zeros_like(direction))
