"""Which moves keep their shape when their ends are displaced, and which would be bent by words that stay behind.

An arc may be given by its angle (`AR=`), a point on it (CIP), the direction of the move before (CT) or a pole; a line
by its angle (`ANG=`) or about a pole. Displacing coordinates and leaving those words would write another path.
"""

from collections.abc import Iterable
from typing import Final

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program import Program, Word
from trueloop.nc.tool_path import Motion, ToolPath

SHAPE: Final = frozenset("apqnijktcrws")
"""Letters of the words that shape a move beside its end: AR, RP, AP, ANG, I1, J1, K1, TURN, corners and the like."""
ENDS: Final = frozenset("XYZUVW")
"""Letters of the words that set an end by themselves; a line's angle may set one too."""
CENTRE: Final = frozenset("IJKR")
"""Letters of the words that give an arc's circle in its own block."""


def require_own_shape(program: Program, path: ToolPath, moves: Iterable[int], *, absolute_centres: bool = True) -> None:
    """Raises NC-EDIT for the first of these moves that is not given by its end and, of an arc, by I, J, K or R.

    absolute_centres: whether a centre given as a position, `I=AC(5)`, is taken too.
    """
    for move in moves:
        words = [word for word in program.block(int(path.block[move])).words if word.kind in ("number", "expression")]
        setting = {int(word) for word in path.word[move] if word >= 0}
        wrong = [word for word in words if word.letter in SHAPE or (word.index in setting and word.letter not in ENDS)]
        centre = [word for word in words if word.letter in CENTRE]
        if not absolute_centres:
            wrong += [word for word in centre if word.increment is not None]
        if wrong or (path.motion[move] == Motion.ARC and not centre) or _is_made(path, move):
            raise _refusal(program, path, move, wrong)


def _is_made(path: ToolPath, move: int) -> bool:
    """Whether a cut is set by no word: a corner or a cycle makes it."""
    cuts = path.motion[move] in (Motion.LINE, Motion.ARC)
    return bool(cuts and (path.word[move] < 0).all() and (path.start_mm[move] != path.end_mm[move]).any())


def _refusal(program: Program, path: ToolPath, move: int, wrong: list[Word]) -> TrueloopError:
    block = program.block(int(path.block[move]))
    what = f"{wrong[0].text} shapes this move" if wrong else "a pole, a corner or the move before shapes this move"
    return TrueloopError(
        Code.NC_EDIT,
        f"{what}, which would not follow when ends of moves are displaced",
        hint="write the move by its end, an arc with I and K (I, J) from its start or with its radius",
        place=program.place(wrong[0].start if wrong else block.data[0].start if block.data else block.start),
    )
