"""Cycles that run on a contour kept elsewhere in the program: which one finishes it, and which ones rough it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

from trueloop.errors import Code
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import ToolPath

_BOTH: Final = range(9, 13)
_ROUGHS: Final = range(1, 5)
"""VARI of CYCLE95: those that rough, and those that finish after it."""
_VARI: Final = 8
_VARI_952: Final = 3
_FINISHING: Final = 2


@dataclass(frozen=True)
class ContourCycle:
    """A cycle and its contour: the block, its word, and what names the contour, as it compares.

    `by`: the contour lies between the blocks of two numbers (P, Q), is the subroutine of a number (Q of LinuxCNC), or
    has a name: a subprogram's, or two labels (Sinumerik); it may stand in an earlier block (CYCLE62).
    Or it has the sequence name of its first block (OSP), which is then `word`.
    """

    block: Block
    word: Word
    named: tuple[str, ...]
    roughs: bool
    finishes: bool
    by: Literal["numbers", "subroutine", "name", "earlier", "sequence"]


def finishing_cycle(program: Program, path: ToolPath, move: int) -> ContourCycle | None:
    """Returns the finishing cycle that runs the contour of a move; None of a move in the program's own course."""
    call = int(path.call[move])
    found = _cycle(program, program.block(int(path.calls[call, 0]))) if call >= 0 else None
    return found if found is not None and found.finishes else None


def roughing_cycles(program: Program) -> list[ContourCycle]:
    """Returns the cycles that rough a contour, without the blocks that only state how."""
    return [found for found in _cycles(program) if found.roughs]


def roughed_by(program: Program, cycle: ContourCycle) -> list[ContourCycle]:
    """Returns the roughing cycles on the contour that this finishing cycle runs; itself where it does both."""
    return [found for found in roughing_cycles(program) if found.named == cycle.named]


def _cycles(program: Program) -> Iterator[ContourCycle]:
    return (found for block in program.blocks if (found := _cycle(program, block)) is not None)


def _cycle(program: Program, block: Block) -> ContourCycle | None:
    for word in block.words:
        meaning = (program.core.meaning(word.index) or "") if word.letter == "G" or word.kind == "name" else ""
        finishes = meaning in ("FinishContour", "Profile(Finish)")
        if finishes or meaning.startswith(("RoughContour", "Profile")):
            letters = "Q" if meaning.startswith("Profile") else "PQ"
            named = tuple(other.text[1:].strip().lstrip("0") for other in block.words if other.letter in letters)
            by: Literal["numbers", "subroutine"] = "subroutine" if letters == "Q" else "numbers"
            if len(named) == len(letters):
                return ContourCycle(block, word, named, not finishes, finishes, by)
        if meaning.startswith(("Lap(Rough", "Lap(Finish")):
            return _lap(block, word, finishes=meaning == "Lap(Finish)")
        if meaning == "Removal(Stock)":
            return _stock_removal(block, word)
        if meaning == "Removal(Contour)":
            return _contour_turning(program, block, word)
    return None


def _lap(block: Block, word: Word, *, finishes: bool) -> ContourCycle | None:
    """G85, G86, G87 of OSP: the sequence name behind the code."""
    behind = [other for other in block.words if other.start > word.start and other.letter == "N"]
    if not behind:
        return None
    return ContourCycle(block, behind[0], (behind[0].text[1:].lstrip("0").upper(),), not finishes, finishes, "sequence")


def _stock_removal(block: Block, word: Word) -> ContourCycle:
    """CYCLE95: its first argument names the contour, the ninth says what it does."""
    given = arguments(word)
    kind = given[_VARI].strip() if len(given) > _VARI else ""
    number = int(kind) if kind.isdigit() else 0
    name = given[0].strip().strip('"').lower()
    roughs, both = number in _ROUGHS or not number, number in _BOTH
    return ContourCycle(block, word, (name,), roughs or both, not roughs, "name")


def _contour_turning(program: Program, block: Block, word: Word) -> ContourCycle:
    """CYCLE952: the last CYCLE62 names the contour, the tens of the fourth argument say what it does."""
    given = arguments(word)
    kind = given[_VARI_952].strip() if len(given) > _VARI_952 else ""
    finishes = kind.isdigit() and int(kind) // 10 % 10 == _FINISHING
    earlier = (other for before in program.blocks if before.index < block.index for other in before.words)
    names = [other for other in earlier if program.core.meaning(other.index) == "Removal(Names)"]
    named = tuple(arguments(names[-1])) if names else ()
    return ContourCycle(block, word, named, not finishes, finishes, "earlier")


def arguments(word: Word) -> list[str]:
    """Returns the arguments in brackets behind a name, as they are written."""
    return word.text.partition("(")[2].rpartition(")")[0].split(",")


def require_named(program: Program, path: ToolPath, move: int, axis: int, letter: str) -> None:
    """Raises NC-EDIT where an axis would be written into a contour that roughing cycles share before it names the axis.

    The value would be that of the finishing cycle's beginning, and the roughing would go there, through the part.
    """
    cycle = finishing_cycle(program, path, move)
    if cycle is None or cycle.by != "subroutine" or not roughed_by(program, cycle):
        return
    own = (path.call[: move + 1] == path.call[move]) & (path.word[: move + 1, axis] >= 0)
    if not own.any():
        raise Code.NC_EDIT.refusal(
            f"{letter} is displaced on the contour before it names {letter}, and a roughing cycle begins it elsewhere",
            hint='name X and Z in the first block of the contour, or have `programs.roughing = "stays"`',
            place=program.place(program.block(int(path.block[move])).start),
        )
