"""Cycles that run on a contour kept elsewhere in the program: which one finishes it, and which ones rough it."""

from typing import Final

from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import ToolPath

_FINISH: Final = ("FinishContour", "Profile(Finish)")
_ROUGH: Final = ("RoughContour", "Profile")


def finishing_cycle(program: Program, path: ToolPath, move: int) -> Block | None:
    """The block of the finishing cycle that runs the contour of a move; None of a move in the program's own course."""
    call = int(path.call[move])
    block = program.block(int(path.calls[call, 0])) if call >= 0 else None
    return block if block is not None and _does(program, block, _FINISH) else None


def calls_by_name(program: Program, cycle: Block) -> bool:
    """Whether its contour is a subroutine that it names, not the blocks between two numbers."""
    return _does(program, cycle, _FINISH[1:])


def is_finish(program: Program, word: Word) -> bool:
    """Whether a word is the code of a finishing cycle."""
    return _means(program, word).startswith(_FINISH)


def roughing_cycles(program: Program) -> list[Block]:
    """The blocks of the cycles that rough a contour, without those that only say how."""
    return [block for block in program.blocks if _roughs(program, block) and _named(block)]


def roughed_by(program: Program, cycle: Block) -> list[Block]:
    """The roughing cycles on the contour that this finishing cycle runs."""
    return [block for block in roughing_cycles(program) if _named(block) == _named(cycle)]


def _roughs(program: Program, block: Block) -> bool:
    return _does(program, block, _ROUGH) and not _does(program, block, _FINISH)


def _does(program: Program, block: Block, meanings: tuple[str, ...]) -> bool:
    return any(_means(program, word).startswith(meanings) for word in block.words)


def _means(program: Program, word: Word) -> str:
    return (program.core.meaning(word.index) or "") if word.letter == "G" else ""


def _named(block: Block) -> dict[str, str]:
    """The words that name a cycle's contour: P and Q, or Q."""
    names = {word.letter: word.text[1:].strip() for word in block.words if word.letter in "PQ"}
    return {letter: text.lstrip("0") for letter, text in names.items()} if "Q" in names else {}
