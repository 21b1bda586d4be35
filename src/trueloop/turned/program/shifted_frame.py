"""The moves that run in a shifted frame when a contour is to be cut there, and the blocks between which it is shifted.

A coordinate that a move inherits is not shifted: the tool stays where it is when the frame changes. So the shift begins
before both coordinates of the contour's beginning are set. It begins and ends outside of cutter compensation, under
which controls do not let the frame change (LinuxCNC stops in the cut), and around a finishing cycle as a whole.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Flags
from trueloop.errors import Code, TrueloopError
from trueloop.nc.expand.loops import loops_of
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.turned.program.contour_cycles import finishing_cycle

OFF: Final = 40
ON: Final = frozenset({41, 42})
FINISHING_CYCLE: Final = 70.0


@dataclass(frozen=True)
class Shifted:
    """Moves `first` to `last` are shifted, both included: from before block `begin` to after block `end`."""

    first: int
    last: int
    begin: int
    end: int


@dataclass(frozen=True)
class _Cycle:
    """A finishing cycle: its block, and the blocks of its contour."""

    block: int
    contour: Collection[int]

    def runs(self, block: int) -> bool:
        return block == self.block or block in self.contour


def shifted_moves(program: Program, path: ToolPath, cuts: tuple[int, int]) -> Shifted:
    """Returns the moves to be shifted so that moves `cuts` (first, last) are. Raises NC-OFFSET where a block that
    begins or ends the shift is not to be found, or where frame or tool change in between.
    """
    cycle = _cycle_of_calls(program, path, cuts[0]) or _finishing_cycle(program, int(path.block[cuts[0]]))
    first, last = cuts[0] - 1, cuts[1]
    if cycle is not None:
        while first > 0 and cycle.runs(int(path.block[first - 1])):
            first -= 1
        while last + 1 < len(path) and cycle.runs(int(path.block[last + 1])):
            last += 1
    first, begin = _begin(program, path, _both_set(program, path, first, cuts[0]))
    last, end = _end(program, path, last)
    for loop in loops_of(program):  # shifted as a whole: a block inside runs again and again
        moves = np.flatnonzero((path.block >= loop.first) & (path.block <= loop.last))
        begin, first = (loop.first, min(first, int(moves[0]))) if loop.has(begin) else (begin, first)
        end, last = (loop.last, max(last, int(moves[-1]))) if loop.has(end) else (end, last)
    among = slice(first, last + 1)
    for values, what in ((path.origin_mm, "frame"), (path.tool[:, None], "tool")):
        changed = np.flatnonzero(np.any(values[among] != values[first], axis=1))
        if changed.size:
            raise _refusal(program, int(path.block[first + changed[0]]), f"the {what} changes among the shifted moves")
    # Refuses blocks that run outside of the shift too: another tool's pass would be shifted with them
    every = np.arange(len(path))
    outside = path.block[(every < first) | (every > last)]
    again = np.intersect1d(path.block[first : last + 1], outside)
    if again.size:
        raise _refusal(program, int(again[0]), "the blocks run several times")
    return Shifted(first, last, *(cycle.block if cycle and cycle.runs(block) else block for block in (begin, end)))


def positions_set(program: Program, path: ToolPath, move: int) -> Flags:
    """Returns whether a word sets each coordinate of a move's end as a position, (3,): not inherited, no increment."""
    found = np.zeros(3, dtype=np.bool_)
    for axis, index in enumerate(path.word[move]):
        if index >= 0:
            increment = program.word(int(index)).increment
            found[axis] = not (path.incremental[move] if increment is None else increment)
    return found


def _both_set(program: Program, path: ToolPath, first: int, cut: int) -> int:
    """Returns the last move not after `first` from which to the cut both X and Z are set."""
    found = np.zeros(3, dtype=np.bool_)
    for move in range(cut - 1, -1, -1):
        found |= positions_set(program, path, move)
        if found[0] and found[2] and move <= first:
            return move
    raise _refusal(program, int(path.block[cut]), "X and Z are not both set by words before the contour begins here")


def _begin(program: Program, path: ToolPath, first: int) -> tuple[int, int]:
    """Returns the first move of the compensation in force, and the block that switches it on; else move and block."""
    compensation, block = path.compensation, path.block
    while first > 0 and compensation[first] != OFF and compensation[first - 1] != OFF:
        first -= 1
    if compensation[first] == OFF:
        return first, int(block[first])
    earliest = int(block[first - 1]) if first else -1
    return first, _switch(program, range(int(block[first]), earliest, -1), ON, int(block[first]))


def _end(program: Program, path: ToolPath, last: int) -> tuple[int, int]:
    """Returns the last move of the compensation in force, and the block that switches it off; else move and block."""
    compensation, block = path.compensation, path.block
    if compensation[last] == OFF:
        return last, int(block[last])
    while last + 1 < len(path) and compensation[last + 1] != OFF:
        last += 1
    more = last + 1 < len(path)
    latest = int(block[last + 1]) if more else program.block_count - 1
    found = _switch(program, range(int(block[last]), latest + 1), {OFF}, int(block[last]))
    return last + (more and found == latest), found


def _switch(program: Program, blocks: Iterable[int], codes: Collection[int], seen_from: int) -> int:
    """Returns the first of the blocks with one of these G codes."""
    for block in blocks:
        words = (word for word in program.block(block).words if word.letter == "G" and word.kind == "number")
        if any(int(word.value) in codes for word in words):
            return block
    raise _refusal(
        program, seen_from, "compensation is in force, and the block that switches it is not next to the cut"
    )


def _cycle_of_calls(program: Program, path: ToolPath, cut: int) -> _Cycle | None:
    """Returns the G70 that calls the contour by its name; its blocks are those of its moves."""
    cycle = finishing_cycle(program, path, cut)
    if cycle is None or cycle.by == "numbers":
        return None
    return _Cycle(cycle.block.index, frozenset(path.block[path.call == path.call[cut]].tolist()))


def _finishing_cycle(program: Program, contour_block: int) -> _Cycle | None:
    """Returns the G70 that runs the contour; None where the program cuts it in its own course."""
    if not program.dialect.contours_by_number:
        return None
    blocks = list(program.blocks)
    for block in blocks:
        ends = [b.index for b in blocks if b.number is not None and b.number in _contour_of(block)]
        contour = range(min(ends, default=0), max(ends, default=-1) + 1)
        if contour_block in contour:
            return _Cycle(block.index, contour)
    return None


def _contour_of(block: Block) -> set[float]:
    """Returns the block numbers P and Q of a finishing cycle; of another block none."""
    if not any(word.letter == "G" and word.value == FINISHING_CYCLE for word in block.words):
        return set()
    return {word.value for word in block.words if word.letter in {"P", "Q"}}


def _refusal(program: Program, block: int, what: str) -> TrueloopError:
    return Code.NC_OFFSET.refusal(
        f"line {block + 1}: {what}, so that no shift of the frame can be put around the contour",
        hint="correct the contour, or set the tool's offset at the control",
        place=program.place(program.block(block).start),
    )
