"""Refusal of moves that cannot be written by their ends, with the reason."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import number_said
from trueloop.nc.edit.shape_words import asks_corner, is_made, is_shaped
from trueloop.nc.expand.splines import makes_spline, spline_blocks
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import INVERSE_TIME, ToolPath


def require_writable(program: Program, path: ToolPath, block: Block, moves: Sequence[int]) -> None:
    """Raises NC-EDIT where the moves of one run of a block cannot be written by their ends."""
    corners = [k for k in moves if is_made(path, k)]
    if not all(asks_corner(program, path, k) or makes_spline(program, path, k) for k in corners):
        raise refusal(program, block, "a cycle makes its moves", "write the cycle out as moves")
    shaped = is_shaped(program, path, moves[0])
    if corners and path.feed_mode[corners[0]] == INVERSE_TIME:
        raise refusal(program, block, "the time of its move is given (G93)", "program the feed by G94 or G95 there")
    formula = next((w for w in _behind(program, path, moves) if w.is_expression and math.isnan(number_said(w))), None)
    if shaped and formula is not None:
        hint = "write the coordinates beside it as numbers, or the corner or arc as a block of its own"
        raise refusal(program, block, f"it depends on {formula.text}, which another value would change", hint)


def _behind(program: Program, path: ToolPath, moves: Sequence[int]) -> Iterable[Word]:
    """The words on which moves hang: those of their start, of their block, and of where the next one ends."""
    first = moves[0]
    yield from _setting(program, path, first)
    yield from _setting(program, path, max(first - 1, 0))  # a tangent arc's direction; of others no more than asked
    block = program.block(int(path.block[first]))
    blocks = spline_blocks(program, block) if makes_spline(program, path, first) else [block]
    yield from (w for own in blocks for w in own.data if w.letter not in "GMFSTD")
    if moves[-1] + 1 < len(path):
        yield from (program.word(int(index)) for index in path.word[moves[-1] + 1] if index >= 0)


def _setting(program: Program, path: ToolPath, move: int) -> Iterable[Word]:
    """The words that set where a move starts."""
    for axis in range(3):
        found = np.flatnonzero(path.word[:move, axis] >= 0)
        if len(found):
            yield program.word(int(path.word[found[-1], axis]))


def refusal(program: Program, block: Block, why: str, hint: str) -> TrueloopError:
    """Returns the error NC-EDIT at a block."""
    text = program.source[block.start : block.end].decode("latin-1").strip()
    return Code.NC_EDIT.refusal(
        f"{text[:60]!r} cannot be written out as explicit moves: {why}",
        hint=hint,
        place=program.place(block.data[0].start if block.data else block.start),
    )
