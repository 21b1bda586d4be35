"""The source of a translation: blocks as they were executed, with what their words mean."""

from collections.abc import Iterator, Mapping
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


def executed_blocks(program: Program, path: ToolPath) -> Iterator[Executed]:
    """The blocks of a traced run, in order of execution."""
    done, offset = 0, np.zeros(3)
    rows = zip(path.executed.tolist(), path.executed_at_mm, path.executed_offset_mm, strict=True)
    for (index, moves, state), at, offset_after in rows:
        block = program.block(index)
        meanings = {word.index: found for word in block.words if (found := program.core.meaning(word.index))}
        codes = {meanings[word.index].partition("(")[0]: word for word in block.words if word.index in meanings}
        change = offset_after - offset
        waited = int(np.argmax(np.append(path.block[done:moves] == index, True)))
        yield Executed(
            block,
            codes,
            meanings,
            range(done, done + waited),
            range(done + waited, moves),
            state,
            _vector(at),
            _vector(offset_after),
            _vector(change),
        )
        done, offset = moves, offset_after


def _vector(values: np.ndarray) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
