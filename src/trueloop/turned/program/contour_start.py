"""Where a contour begins that roughing cycles read, too: they come to it from elsewhere than the finishing cycle."""

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import Block, Program
from trueloop.nc.program.tool_path import ToolPath

FINISHES = "Profile(Finish)"


def require_named(program: Program, path: ToolPath, move: int, axis: int, letter: str) -> None:
    """Raises NC-EDIT where an axis would be written into a contour that roughing cycles share before it names the axis.

    The value would be that of the finishing cycle's beginning, and the roughing would go there, through the part.
    """
    call = int(path.call[move])
    if call < 0 or not finishes(program, path, move) or not _is_roughed(program):
        return
    own = (path.call[: move + 1] == call) & (path.word[: move + 1, axis] >= 0)
    if not own.any():
        raise TrueloopError(
            Code.NC_EDIT,
            f"{letter} is displaced on the contour before it names {letter}, and a roughing cycle begins it elsewhere",
            hint="name X and Z in the first block of the contour",
            place=program.place(program.block(int(path.block[move])).start),
        )


def finishes(program: Program, path: ToolPath, move: int) -> bool:
    """Whether a move is one of a contour that a finishing cycle (G70 of LinuxCNC) calls by name."""
    call = int(path.call[move])
    return call >= 0 and FINISHES in _meanings(program, program.block(int(path.calls[call, 0])))


def _is_roughed(program: Program) -> bool:
    meanings = (meaning for block in program.blocks for meaning in _meanings(program, block))
    return any(meaning.startswith("Profile") and meaning != FINISHES for meaning in meanings)


def _meanings(program: Program, block: Block) -> set[str]:
    return {program.core.meaning(word.index) or "" for word in block.words if word.letter == "G"}
