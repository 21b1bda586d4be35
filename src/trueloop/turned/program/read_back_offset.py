"""The offset variant read back: in machine coordinates the contour has moved by the offset, and nothing else has."""

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.nc.edit.changes import not_as_intended, verify_written
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import CoordinateState, ToolPath
from trueloop.turned.program.read_back import SAME_MM
from trueloop.turned.program.shifted_frame import Shifted, positions_set
from trueloop.units import UM_PER_MM


def require_same_path(before: ToolPath, after: ToolPath) -> None:
    """Refuses a program that does not command the same moves."""
    _require_same_kinds(before.motion, after.motion)
    moves = np.arange(len(before))
    verify_written(before, after, (moves, moves), before.end_mm, allowed_mm=SAME_MM)


def require_shift(
    program: Program,
    before: ToolPath,
    after: ToolPath,
    shifted: Shifted,
    cuts: tuple[int, int],
    offset_mm: tuple[float, float],
    tolerance_mm: float,
) -> None:
    """Refuses a program that does not cut moves `cuts` (first, last) off by the offset (x as a radius, z) in machine
    coordinates, from their beginning, or that ends a move outside of `shifted` elsewhere than the source.

    A coordinate that a move inherits or sets by an increment follows the tool: but in the cut it may be either.
    """
    moves = _programmed(before)
    _require_same_kinds(before.motion[moves], after.motion[_programmed(after)])
    inside = ((shifted.first <= moves) & (moves <= shifted.last))[:, None]
    offset = np.array([offset_mm[0], 0.0, offset_mm[1]])
    wanted, other = np.where(inside, offset, 0.0), np.where(inside, 0.0, offset)
    starts, ends = (_moved_mm(before, after, name) for name in ("start_mm", "end_mm"))
    off = np.abs(ends - wanted)
    free = ~np.array([positions_set(program, before, int(move)) for move in moves])
    off[free] = np.minimum(off, np.abs(ends - other))[free]
    cut = (cuts[0] <= moves) & (moves <= cuts[1])
    off[cut] = np.maximum(off, np.maximum(np.abs(ends - offset), np.abs(starts - offset)))[cut]
    if not np.max(off) <= tolerance_mm:
        worst = int(np.argmax(np.max(off, axis=1)))
        raise not_as_intended(
            f"line {before.line[moves[worst]]} would end shifted by {_microns(ends[worst])}, and begin by "
            f"{_microns(starts[worst])}; meant is {_microns(wanted[worst])}"
        )


def require_updates(after: Program, state: CoordinateState, values_mm: dict[str, float], tool: int) -> None:
    """Refuses a program that does not update that tool's offsets to these values; `state` is how it writes them."""
    for axis, value_mm in values_mm.items():
        step_mm = (after.dialect.resolution_inch if state.inch else after.dialect.resolution_mm) * state.unit_mm(axis)
        read = [s.value * state.unit_mm(axis) for s in after.offset_statements if (s.axis, s.tool) == (axis, tool)]
        if len(read) != 1 or not abs(read[0] - value_mm) <= step_mm / 2 + SAME_MM:
            raise not_as_intended(
                f"the {axis} offset of tool {tool} is updated to {read} mm instead of {value_mm:.6f} mm"
            )


def _moved_mm(before: ToolPath, after: ToolPath, name: str) -> Array:
    """Returns how far points of the programmed moves have moved in machine coordinates, (n, 3)."""
    there, here = ((getattr(path, name) + path.origin_mm)[_programmed(path)] for path in (after, before))
    return np.asarray(there - here)


def _require_same_kinds(before: Integers, after: Integers) -> None:
    if not np.array_equal(before, after):
        raise not_as_intended(f"the written program has {len(after)} moves, not the {len(before)} of the source")


def _programmed(path: ToolPath) -> Integers:
    """Returns the moves whose end a word of their block set; whether a finishing cycle adds a way back depends on the
    frame.
    """
    return np.flatnonzero(np.max(path.word, axis=1) >= 0)


def _microns(xyz_mm: Array) -> str:
    x, _, z = xyz_mm * UM_PER_MM
    return f"x {x:.2f} µm (radius), z {z:.2f} µm"
