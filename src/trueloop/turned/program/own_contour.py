"""A contour of its own for the finishing cycle, so that correcting it leaves what is roughed on the given one alone.

The blocks that roughing reads stay, to the byte. Where they lie between two numbered blocks (G70 P Q), the finishing
cycle is written out: the contour's blocks in its place, and the rapid move back to where it began. No control has to
find a second contour then, or to pass it over. Where the contour is a subroutine that the cycle names (LinuxCNC), the
cycle gets a copy under a number of its own.
"""

import re
from itertools import count
from typing import Final

import numpy as np

from trueloop.arrays import Integers
from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import Edit, coordinate_text, line_ending
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import Motion, ToolPath
from trueloop.turned.program.contour_cycles import calls_by_name, finishing_cycle, is_finish, roughed_by

_LABEL: Final = re.compile(r"o\s*(\d+)\s*(?=sub|endsub)", re.IGNORECASE)
_HINT: Final = 'have the roughing move along: `programs.roughing = "moves"`'


def own_contour(program: Program, path: ToolPath, move: int) -> list[Edit]:
    """The edits after which no roughing cycle reads the blocks of the contour that `move` is on; none where none does.

    Raises NC-EDIT where they cannot be written.
    """
    cycle = finishing_cycle(program, path, move)
    if cycle is None or not roughed_by(program, cycle):
        return []
    if calls_by_name(program, cycle):
        return _copied(program, path, move, cycle)
    return [_written_out(program, path, int(path.call[move]), cycle)]


def _written_out(program: Program, path: ToolPath, call: int, cycle: Block) -> Edit:
    """The contour in the place of the cycle's words; what else stands in the block comes first."""
    moves = np.flatnonzero(path.call == call)
    contour = [program.block(index) for index in _between(program, path, cycle, moves[[0, -1]])]
    blocks = [_without(program, block, _number_of(block)) for block in contour]
    others = _without(program, cycle, [*_number_of(cycle), *(word for word in cycle.data if _is_call(program, word))])
    lines = [*([others] if re.search(r"\w", others) else []), *blocks, *_way_back(program, path, int(moves[-1]))]
    return Edit(cycle.data[0].start, cycle.end, line_ending(program).join(lines))


def _between(program: Program, path: ToolPath, cycle: Block, moves: Integers) -> range:
    """The blocks from P to Q: of those with these numbers the ones next to the moves of the contour (first, last)."""
    named = {word.letter: word.value for word in cycle.data if word.letter in "PQ"}
    first = [b.index for b in program.blocks if b.number == named["P"] and b.index <= path.block[moves[0]]]
    last = [b.index for b in program.blocks if b.number == named["Q"] and b.index >= path.block[moves[1]]]
    if cycle.skipped or not (first and last):
        raise _refusal(program, cycle, "this cycle, a block with a slash or one that computes P or Q")
    return range(first[-1], last[0] + 1)


def _is_call(program: Program, word: Word) -> bool:
    return word.letter in "PQ" or is_finish(program, word)


def _number_of(block: Block) -> list[Word]:
    return [word for word in block.words if word.letter == "N"]


def _without(program: Program, block: Block, words: list[Word]) -> str:
    """The text of a block without some of its words."""
    done, text = block.start, ""
    for word in words:
        text, done = text + program.source[done : word.start].decode("latin-1").rstrip(" \t"), word.end
    return (text + program.source[done : block.end].decode("latin-1")).strip(" \t\r")


def _way_back(program: Program, path: ToolPath, last: int) -> list[str]:
    """The cycle's last move, which no word sets."""
    back = last + 1
    if back == len(path) or path.block[back] != path.block[last] or path.motion[back] != Motion.RAPID:
        return []
    state = path.coordinate_state(back)
    from_mm = path.start_mm[back] if state.incremental else np.zeros(3)
    ends = zip("XZ", (path.end_mm[back] - from_mm)[[0, 2]], strict=True)
    return [" ".join(["G00", *(coordinate_text(program.dialect, axis, float(end), state) for axis, end in ends)])]


def _copied(program: Program, path: ToolPath, move: int, cycle: Block) -> list[Edit]:
    """A copy of the subroutine behind it, and its number in the cycle."""
    name = next(word for word in cycle.data if word.letter == "Q")
    if np.isnan(name.value):
        raise _refusal(program, cycle, f"this cycle, which computes {name.text}")
    text = program.source.decode("latin-1")
    taken = {int(found) for found in re.findall(r"(?i)\bo\s*(\d+)", text)}
    number = next(number for number in count(int(name.value) + 1) if number not in taken)
    ends = [found for found in _LABEL.finditer(text) if int(found[1]) == name.value]
    lines = [program.block(text.count("\n", 0, found.start())) for found in ends]
    if len(lines) != 2:
        raise _refusal(program, cycle, "this cycle, whose subroutine is not there once")
    body = text[lines[0].start : lines[1].end]
    copy = _LABEL.sub(lambda found: found[0].replace(found[1], str(number)), body)
    ending = line_ending(program)
    return [
        Edit(name.value_start, name.end, str(number)),
        Edit(lines[1].end, lines[1].end, ending + copy),
    ]


def _refusal(program: Program, cycle: Block, what: str) -> TrueloopError:
    return TrueloopError(
        Code.NC_EDIT,
        f"roughing shall stay where it is, and {what} cannot be given a contour of its own",
        hint=_HINT,
        place=program.place(cycle.start),
    )
