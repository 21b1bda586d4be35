"""Moves that keep their shape when their ends are displaced, and those that words left unchanged would distort.

An arc may be given by its angle (`AR=`), a point on it (CIP), the direction of the move before (CT) or a pole; a line
by its angle (`ANG=`) or about a pole; a corner by its size. Displacing coordinates and leaving those words would write
another path.
"""

from collections.abc import Iterable
from typing import Final

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import Program, Word
from trueloop.nc.program.tool_path import Motion, ToolPath

SHAPE: Final = frozenset("apqnijktcrws")
"""Letters of the words that shape a move beside its end: AR, RP, AP, ANG, I1, J1, K1, TURN, corners and the like."""
TURNS: Final = "t"
"""Letter of the full turns that an arc makes besides."""
PLAIN_CORNER: Final = frozenset("RIK")
"""Letters of lathes that ask for a corner on a straight move; of an arc they are radius and centre."""
EVERY_CORNER: Final = "s"
"""The letter of the word that makes a corner at the end of every block (RNDM)."""
ANGLES: Final = frozenset("Aan")
"""Letters of the words that give a line's angle."""
ENDS: Final = frozenset("XYZUVW")
"""Letters of the words that set an end by themselves; a line's angle may set one too."""
CENTRE: Final = frozenset("IJK")
"""Letters of the words that give an arc's centre in its own block."""


def require_own_shape(program: Program, path: ToolPath, moves: Iterable[int], *, absolute_centres: bool = True) -> None:
    """Raises NC-EDIT for the first of these moves that is not given by its end and, of an arc, by I, J, K or R.

    absolute_centres: whether a centre given as a position, `I=AC(5)`, is taken too.
    """
    for move in moves:
        words = _values(program, path, move)
        wrong = shaping_words(program, path, move) + _ways(program, path, move)
        wrong += [word for word in words if word.letter == TURNS]
        centre = [word for word in words if word.letter in CENTRE | {program.dialect.radius_letter}]
        if not absolute_centres:
            wrong += [word for word in centre if word.increment is not None]
        if wrong or (path.motion[move] == Motion.ARC and not centre) or is_made(path, move):
            raise _refusal(program, path, move, wrong)


def shaping_words(program: Program, path: ToolPath, move: int) -> list[Word]:
    """Returns the words of a move's block that shape it beside its end and its centre, full turns left out."""
    words = _values(program, path, move)
    setting = {int(word) for word in path.word[move] if word >= 0}
    of_tool = any(word.letter == "G" and word.text[1:].strip() == "76" for word in words)  # A of a threading cycle
    shapes = SHAPE - {TURNS} | ({"A"} if program.dialect.line_angle and not of_tool else set())
    corners = path.corner_words
    return [
        word
        for word in words
        if word.letter in shapes or word.index in corners or (word.index in setting and word.letter not in ENDS)
    ]


def is_shaped(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether a move is given by other words than those of its end and, of an arc, radius, centre or a CC."""
    if shaping_words(program, path, move) or is_made(path, move):
        return True
    circle = CENTRE | {program.dialect.radius_letter}
    centre = any(word.letter in circle for word in _values(program, path, move))
    return bool(path.motion[move] == Motion.ARC and not centre and not _is_about_pole(program, path, move))


def is_made(path: ToolPath, move: int) -> bool:
    """Returns whether a cut is set by no word: a corner or a cycle makes it."""
    return is_wordless(path, move) and bool((path.start_mm[move] != path.end_mm[move]).any())


def is_wordless(path: ToolPath, move: int) -> bool:
    """Returns whether a cut is set by no word, including one of length 0."""
    cuts = path.motion[move] in (Motion.LINE, Motion.ARC)
    return bool(cuts and (path.word[move] < 0).all())


def asks_every_corner(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether a move is a corner that RNDM requests, or is in the block of RNDM."""
    letters = {word.letter for word in _values(program, path, move)}
    return EVERY_CORNER in letters or path.corners.get(move, 0) < 0


def _is_about_pole(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether an arc is a C of Klartext, with the CC before it."""
    words = program.block(int(path.block[move])).data
    return program.dialect.klartext and any(word.text.upper() == "C" for word in words)


def _ways(program: Program, path: ToolPath, move: int) -> list[Word]:
    """Returns the words APPR and DEP, whose way is the control's own and depends on the place before it."""
    words = program.block(int(path.block[move])).data if program.dialect.klartext else []
    return [word for word in words if word.text.upper().startswith(("APPR", "DEP"))]


def _values(program: Program, path: ToolPath, move: int) -> list[Word]:
    words = program.block(int(path.block[move])).words
    return [word for word in words if word.kind in ("number", "expression")]


def _refusal(program: Program, path: ToolPath, move: int, wrong: list[Word]) -> TrueloopError:
    block = program.block(int(path.block[move]))
    what = f"{wrong[0].text} shapes this move" if wrong else "a pole, a corner or the move before shapes this move"
    return Code.NC_EDIT.refusal(
        f"{what}, which would not follow when ends of moves are displaced",
        hint="write the move by its end, an arc with I and K (I, J) from its start or with its radius",
        place=program.place(wrong[0].start if wrong else block.data[0].start if block.data else block.start),
    )
