"""Places along the moves of a tool path, and the positions that the program itself states."""

from typing import Final

import numpy as np

from trueloop._core import nc_said
from trueloop.arrays import Array, Flags, Integers
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion, ToolPath

PLANE_AXES: Final = {17: (0, 1), 18: (2, 0), 19: (1, 2)}
"""First and second axis of each plane: a positive angle turns from the first to the second."""


def points_along(path: ToolPath, move: Integers | np.intp, share: Array) -> Array:
    """Positions (n, 3) at shares (n,), 0 to 1, of moves (n,), or of one.

    On an arc the radius goes evenly from that of the start to that of the end, which rounding makes differ; a helix
    rises evenly.
    """
    move = np.broadcast_to(move, share.shape)
    start, end = path.start_mm[move], path.end_mm[move]
    points: Array = start + share[:, None] * (end - start)
    arcs = path.motion[move] == Motion.ARC
    for plane in np.unique(path.plane[move[arcs]]):
        i, j = PLANE_AXES[int(plane)]
        of = arcs & (path.plane[move] == plane)
        centre = path.centre_mm[move[of]][:, [i, j]]
        before, after = start[of][:, [i, j]] - centre, end[of][:, [i, j]] - centre
        first, last = np.hypot(*before.T), np.hypot(*after.T)
        radius = first + share[of] * (last - first)
        angle = np.arctan2(before[:, 1], before[:, 0]) - share[of] * path.sweep_rad[move[of]]  # sweep is clockwise
        points[of, i], points[of, j] = centre[:, 0] + radius * np.cos(angle), centre[:, 1] + radius * np.sin(angle)
    return points


def lengths_mm(path: ToolPath, move: Integers | None = None) -> Array:
    """Returns lengths of moves (n,), all by default: of an arc along it, of a helix √(arc² + rise²)."""
    move = np.arange(len(path)) if move is None else move
    way, arm = path.end_mm[move] - path.start_mm[move], path.start_mm[move] - path.centre_mm[move]
    length: Array = np.linalg.norm(way, axis=1)
    for plane, (i, j) in PLANE_AXES.items():
        of = (path.motion[move] == Motion.ARC) & (path.plane[move] == plane)
        turned = np.hypot(arm[of, i], arm[of, j]) * path.sweep_rad[move][of]
        length[of] = np.hypot(turned, way[of, 3 - i - j])
    return length


def said_ends(program: Program, path: ToolPath) -> tuple[Flags, Flags]:
    """Returns whether X, Y, Z are at positions that the program states, at start and end of each move, (n, 3) each.

    Before an axis is first named, after a way to a place of the machine (G28, G53) and after a change of tool or
    offset a run only assumes where it is. An increment from such a place leads to another.
    """
    block, word = path.block.astype(np.int32), path.word.astype(np.int32)
    after = nc_said(
        program.core, block, word, path.incremental, path.renamed.astype(np.uint32), path.plane.astype(np.uint8)
    )
    before = np.vstack([np.zeros((1, 3), dtype=np.bool_), after[:-1]])
    return before, after
