"""The correspondence of moves of a written program with those of its source: a block may have become several."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from trueloop.nc.edit.changes import not_as_intended
from trueloop.nc.edit.edit import Edit
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath

AT_ONE_PLACE_MM = 1e-6
"""Moves of one block whose ends lie nearer are the same move, made again."""


def aligned(
    program: Program, before: ToolPath, after: ToolPath, edits: Sequence[Edit], replaced: Iterable[int]
) -> tuple[range, ...]:
    """Returns for each move of `before` the moves of `after` that stand for it.

    `edits` of the program made `after`; `replaced` are the moves whose blocks became several. Raises CMP-READ-BACK
    where the numbers of moves do not go together.
    """
    more = _more_blocks(program, edits)
    motion_of = {int(before.block[move]): int(before.motion[move]) for move in replaced}
    images, at = [], 0
    for block, motion in zip(before.block.tolist(), before.motion.tolist(), strict=True):
        count = 1 + (more.get(block, 0) if motion_of.get(block) == motion else 0)
        images.append(range(at, at + count))
        at += count
    if at != len(after):
        raise not_as_intended(f"the written program has {len(after)} moves, where {at} are those of the source")
    return tuple(images)


def _more_blocks(program: Program, edits: Sequence[Edit]) -> Mapping[int, int]:
    """Returns how many blocks more stand for a block."""
    more: dict[int, int] = {}
    for edit in edits:
        block = (program.place(edit.start).line or 1) - 1
        new = edit.text.count("\n") - program.source[edit.start : edit.end].count(b"\n")
        more[block] = more.get(block, 0) + new
    return more


def again(path: ToolPath, moves: range) -> dict[int, int]:
    """Moves outside of a range that one of its blocks makes again, at the same place, each with that of the range."""
    first: dict[tuple[int, int], list[int]] = {}
    for move in moves:
        first.setdefault((int(path.block[move]), int(path.motion[move])), []).append(move)
    found: dict[int, int] = {}
    for move in np.flatnonzero(np.isin(path.block, path.block[moves.start : moves.stop])).tolist():
        if move in moves:
            continue
        same = first.get((int(path.block[move]), int(path.motion[move])), [])
        twin = next((k for k in same if _ends_alike(path, k, move)), None)
        if twin is not None:
            found[move] = twin
    return found


def _ends_alike(path: ToolPath, one: int, other: int) -> bool:
    return bool(np.all(np.abs(path.end_mm[one] - path.end_mm[other]) <= AT_ONE_PLACE_MM))
