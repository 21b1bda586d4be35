"""The start of a contour that roughing cycles read, too: they come to it from elsewhere than the finishing cycle."""

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.turned.program.contour_cycles import finishing_cycle, roughed_by


def require_named(program: Program, path: ToolPath, move: int, axis: int, letter: str) -> None:
    """Raises NC-EDIT where an axis would be written into a contour that roughing cycles share before it names the axis.

    The value would be that of the finishing cycle's beginning, and the roughing would go there, through the part.
    """
    cycle = finishing_cycle(program, path, move)
    if cycle is None or cycle.by != "subroutine" or not roughed_by(program, cycle):
        return
    own = (path.call[: move + 1] == path.call[move]) & (path.word[: move + 1, axis] >= 0)
    if not own.any():
        raise TrueloopError(
            Code.NC_EDIT,
            f"{letter} is displaced on the contour before it names {letter}, and a roughing cycle begins it elsewhere",
            hint='name X and Z in the first block of the contour, or have `programs.roughing = "stays"`',
            place=program.place(program.block(int(path.block[move])).start),
        )
