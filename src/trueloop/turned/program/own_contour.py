"""A contour of its own for the finishing cycle, so that correcting it does not change the roughing on the given one.

The blocks that roughing reads stay, to the byte. Where they lie between two numbered blocks (G70 P Q), the finishing
cycle is written out: the contour's blocks in its place, and the rapid move back to where it began. No control has to
find a second contour then, or to pass it over. Where the contour has a number or a name (LinuxCNC, Sinumerik, OSP), the
cycle gets a copy under one of its own.
"""

import re

import numpy as np

from trueloop.arrays import Integers
from trueloop.nc.edit.edit import Edit, coordinate_text, line_ending
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.program.contour_copies import of_name, of_sequence, of_subroutine, refusal
from trueloop.turned.program.contour_cycles import ContourCycle, finishing_cycle, roughed_by


def own_contour(program: Program, path: ToolPath, move: int) -> list[Edit]:
    """Returns the edits after which no roughing cycle reads the blocks of the contour that `move` is on; none where
    none does.

    Raises NC-EDIT where they cannot be written.
    """
    cycle = finishing_cycle(program, path, move)
    if cycle is None or not roughed_by(program, cycle):
        return []
    if cycle.roughs or cycle.by == "earlier":
        raise refusal(program, cycle.block, "this cycle, which roughs too or takes its contour from an earlier block,")
    if cycle.by == "numbers":
        return [_written_out(program, path, int(path.call[move]), cycle)]
    copies = {"subroutine": of_subroutine, "name": of_name, "sequence": of_sequence}
    return copies[cycle.by](program, cycle)


def _written_out(program: Program, path: ToolPath, call: int, cycle: ContourCycle) -> Edit:
    """Writes the contour in the place of the cycle's words; the block's other words come first."""
    block, moves = cycle.block, np.flatnonzero(path.call == call)
    contour = [program.block(index) for index in _between(program, path, block, moves[[0, -1]])]
    blocks = [_without(program, one, _number_of(one)) for one in contour]
    own = [word for word in block.data if word.letter in "PQ" or word == cycle.word]
    others = _without(program, block, [*_number_of(block), *own])
    lines = [*([others] if re.search(r"\w", others) else []), *blocks, *_way_back(program, path, int(moves[-1]))]
    return Edit(block.data[0].start, block.end, line_ending(program).join(lines))


def _between(program: Program, path: ToolPath, cycle: Block, moves: Integers) -> range:
    """Returns the blocks from P to Q: of those with these numbers the ones next to the moves of the contour (first,
    last).
    """
    named = {word.letter: word.value for word in cycle.data if word.letter in "PQ"}
    first = [b.index for b in program.blocks if b.number == named["P"] and b.index <= path.block[moves[0]]]
    last = [b.index for b in program.blocks if b.number == named["Q"] and b.index >= path.block[moves[1]]]
    if cycle.skipped or not (first and last):
        raise refusal(program, cycle, "this cycle, a block with a slash or one that computes P or Q,")
    return range(first[-1], last[0] + 1)


def _number_of(block: Block) -> list[Word]:
    return [word for word in block.words if word.letter == "N"]


def _without(program: Program, block: Block, words: list[Word]) -> str:
    """Returns the text of a block without some of its words."""
    done, text = block.start, ""
    for word in words:
        text, done = text + program.source[done : word.start].decode("latin-1").rstrip(" \t"), word.end
    return (text + program.source[done : block.end].decode("latin-1")).strip(" \t\r")


def _way_back(program: Program, path: ToolPath, last: int) -> list[str]:
    """Returns the cycle's last move, which no word sets."""
    back = last + 1
    if back == len(path) or path.block[back] != path.block[last] or path.motion[back] != Motion.RAPID:
        return []
    state = path.coordinate_state(back)
    from_mm = path.start_mm[back] if state.incremental else np.zeros(3)
    ends = zip("XZ", (path.end_mm[back] - from_mm)[[0, 2]], strict=True)
    return [" ".join(["G00", *(coordinate_text(program.dialect, axis, float(end), state) for axis, end in ends)])]
