"""The source of a translation: blocks as they were executed, with what their words mean."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import ToolPath
from trueloop.nc.translate.controls import Control
from trueloop.nc.translate.statements import Lost, Statement, Vector

Said: TypeAlias = tuple[Word | None, Statement | Lost]
"""A statement or a loss, and the word that it comes from."""


@dataclass(frozen=True)
class Source:
    """A program, its path, and the controls to translate from and to.

    `changes_by_m6`: M06 changes the tool, T makes it ready. `names_tools`: T has a name somewhere, not a number.
    """

    program: Program
    path: ToolPath
    control: Control
    target: Control
    same: bool
    changes_by_m6: bool
    names_tools: bool


@dataclass(frozen=True)
class Executed:
    """A block as it was executed: its words with a meaning, its moves, the state and the place after it.

    `codes`: by what they do, without arguments: `Motion`, `WorkOffset`, `MEnd`; the last one counts. `before`: moves of
    earlier blocks that waited for this one, such as a corner between two. `offset_mm` is machine less program position,
    by what the program says itself, `offset_change_mm` what the block changed of it.
    """

    block: Block
    codes: Mapping[str, Word]
    meanings: Mapping[int, str]
    before: range
    moves: range
    state: int
    at_mm: Vector
    offset_mm: Vector
    offset_change_mm: Vector

    def number(self, letters: str) -> Word | None:
        """The first word of one of these letters that has a number."""
        return next((word for word in self.block.words if word.letter in letters and word.kind == "number"), None)


@dataclass(frozen=True)
class Course:
    """How far the reading has come: the target's less the source's coordinates, the axes whose position is known, the
    last of what is only written when it changes, and blocks whose comments are written.
    """

    shift_mm: Vector = (0.0, 0.0, 0.0)
    known: frozenset[int] = frozenset()
    last: Mapping[str, object] = field(default_factory=dict)
    ended: bool = False


def executed_block(program: Program, path: ToolPath, row: int) -> Executed:
    """A block of a traced run, by its place in the order of execution."""
    index, moves, state = path.executed[row].tolist()
    done = int(path.executed[row - 1, 1]) if row else 0
    offset, offset_before = path.executed_offset_mm[row], path.executed_offset_mm[row - 1] if row else np.zeros(3)
    block = program.block(index)
    meanings = {word.index: found for word in block.words if (found := program.core.meaning(word.index))}
    codes = {meanings[word.index].partition("(")[0]: word for word in block.words if word.index in meanings}
    waited = int(np.argmax(np.append(path.block[done:moves] == index, True)))
    return Executed(
        block,
        codes,
        meanings,
        range(done, done + waited),
        range(done + waited, moves),
        state,
        _vector(path.executed_at_mm[row]),
        _vector(offset),
        _vector(offset - offset_before),
    )


def _vector(values: np.ndarray) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
