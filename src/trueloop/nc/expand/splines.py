"""Splines of LinuxCNC (G5, G5.1, G5.2 to G5.3): the blocks and words that give one, which its chords replace.

A run already has the chords that its interpreter hands on; they are the path, whatever curve was meant.
"""

from functools import lru_cache
from typing import Final

from trueloop.errors import Code
from trueloop.nc.edit.shape_words import is_wordless
from trueloop.nc.expand.block import OUT
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import ToolPath

_BEGINS: Final = "Motion(Spline(Points))"
_ENDS: Final = "EndSpline"
_ONE_BLOCK: Final = ("Motion(Spline(Cubic))", "Motion(Spline(Quadratic))")
_CHORDS: Final = dict(zip(_ONE_BLOCK, (60, 45), strict=True))
"""15 for each of the points that shape one."""
_WORDS: Final = frozenset("XYIJPQL")


def makes_spline(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether a move is a chord of a spline; where that turns back on itself, a chord may have length 0."""
    if not program.dialect.splines or not is_wordless(path, move):
        return False
    return _codes_in_force(program)[int(path.block[move])] in (*_ONE_BLOCK, _ENDS)


def chords_of_one(program: Program, block: int) -> int | None:
    """Returns the number of chords of a spline that is given in this block alone; None for any other block."""
    return _CHORDS.get(_codes_in_force(program)[block]) if program.dialect.splines else None


def spline_blocks(program: Program, block: Block) -> list[Block]:
    """Returns the blocks that give the spline cut in this block: itself, or all from G5.2 to its G5.3.

    Raises NC-EDIT where something else may be run among them.
    """
    if _codes_in_force(program)[block.index] != _ENDS:
        return [block]
    blocks = [block]
    while _BEGINS not in (codes := _codes(program, blocks[0])):
        moves = blocks[0] is not block and any(code.startswith("Motion(") for code in codes)
        if moves or blocks[0].index == 0 or any(word.kind in ("flow", "call") for word in blocks[0].words):
            raise Code.NC_EDIT.refusal(
                "the points of this spline are not in the blocks before it alone",
                hint="write them one after the other, from G5.2 to G5.3, outside of loops and calls",
                place=program.place(block.start),
            )
        blocks.insert(0, program.block(blocks[0].index - 1))
    return blocks


def gives_spline(program: Program, block: Block) -> bool:
    """Returns whether a block begins, ends or is a spline."""
    return not {_BEGINS, _ENDS, *_ONE_BLOCK}.isdisjoint(_codes(program, block))


def without_spline(program: Program, block: Block) -> dict[int, str]:
    """Returns the words of a block that give a spline, each to be left out."""
    return {word.index: OUT for word in block.data if _gives_spline(program, word)}


def _gives_spline(program: Program, word: Word) -> bool:
    meaning = program.core.meaning(word.index) or ""
    numbers = word.kind in ("number", "expression") and word.letter in _WORDS
    return numbers or meaning in (_BEGINS, _ENDS, *_ONE_BLOCK)


def _codes(program: Program, block: Block) -> list[str]:
    return [program.core.meaning(word.index) or "" for word in block.data]


@lru_cache(maxsize=1)
def _codes_in_force(program: Program) -> list[str]:
    """The last motion code up to each block."""
    last, codes = "", []
    for block in program.blocks:
        found = [code for code in _codes(program, block) if code == _ENDS or code.startswith("Motion(")]
        last = (found or [last])[-1]
        codes.append(last)
    return codes
