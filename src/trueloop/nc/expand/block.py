"""One block rewritten: its words changed, left out or put in, comments and spaces kept; words of explicit moves as
each control has them; moves that cannot be written by their ends, and why; blocks of one spline, which its chords
replace.

A run already has the chords that LinuxCNC's interpreter hands on (G5, G5.1, G5.2 to G5.3); they are the path, whatever
curve was meant. Of M codes beside a move, those that act after it go along with the last of its blocks.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.nc.edit.changes import is_made, is_shaped, is_wordless
from trueloop.nc.edit.edit import Edit, circle_text, coordinate_text, insert_blocks_after, number_said
from trueloop.nc.program.along import PLANE_AXES
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import INVERSE_TIME, Motion, ToolPath
from trueloop.units import MM_PER_INCH

BEFORE_MOVE: Final = frozenset({3, 4, 6, 7, 8})
"""M codes that act before the move of their block, as far as controls agree: they stay in the first block."""

AFTER_MOVE: Final = frozenset({0, 1, 2, 5, 9, 30, 60, 98, 99})
"""M codes that stop, end or call after the move (M5 and M9 on most controls): they go to the last block."""


def late_codes(words: Sequence[Word], block: Block) -> list[Word]:
    """Returns the M codes that act after the move. Raises NC-EDIT for a code of which that is not known."""
    codes = [word for word in words if word.letter == "M" and word.kind != "assignment"]
    for word in codes:
        if word.value not in BEFORE_MOVE | AFTER_MOVE:
            raise Code.NC_EDIT.refusal(
                f"{word.text} stands in the block of a move that becomes several: whether it acts before or after the "
                "move is the control's affair",
                hint=f"put {word.text} into a block of its own",
                place=Place(line=block.index + 1),
            )
    return [word for word in codes if word.value in AFTER_MOVE]


COORDINATES: Final = frozenset("XYZUVW")
OUT: Final = ""
"""The text of a word that is left out."""


def rewritten(
    program: Program, block: Block, changed: Mapping[int, str], new: Sequence[str], more: Sequence[str]
) -> list[Edit]:
    """Returns edits of a block: the texts of `changed` words by index, `new` words, and `more` blocks after it.

    New words take the place of the first one left out, else they come after the coordinates. M codes that act after a
    move go to the last block. Raises NC-EDIT where it is not known which a code is, and in an optional block.
    """
    late = late_codes(block.data, block) if more else []
    texts = {word.index: changed.get(word.index, word.text) for word in block.data}
    texts |= dict.fromkeys((word.index for word in late), OUT)
    if new:
        place = _place(block, changed)
        texts[place.index] = " ".join(filter(None, [texts[place.index], *new]))
        if b" " in program.source[block.start : block.end] and program.source[place.start - 1 : place.start] != b" ":
            texts[place.index] = " " * (place.start > block.start) + texts[place.index]
    edits = _changes(program, block, texts)
    if more:
        last = " ".join([more[-1], *(word.text for word in late)])
        edits.append(insert_blocks_after(program, block.index, [*more[:-1], last]))
    if edits and block.skipped:
        raise Code.NC_EDIT.refusal(
            "an optional block would have to become several" if more else "an optional block would have to change",
            hint="take the slash away, or write the corner out as a block of its own",
            place=program.place(block.start),
        )
    return edits


def _place(block: Block, changed: Mapping[int, str]) -> Word:
    """The word at which new ones are written."""
    left_out = [word for word in block.data if changed.get(word.index) == OUT and word.letter != "G"]
    coordinates = [word for word in block.data if word.letter in COORDINATES]
    return (left_out or coordinates[-1:] or list(block.data))[0]


def _changes(program: Program, block: Block, texts: Mapping[int, str]) -> list[Edit]:
    """An edit for each word that changes; one left out takes the space before it along."""
    edits = []
    for word in block.data:
        text = texts[word.index]
        if text == word.text:
            continue
        start = word.start
        while text == OUT and program.source[start - 1 : start] in (b" ", b"\t") and start > block.start:
            start -= 1
        edits.append(Edit(start, word.end, text))
    return edits


WIDE_RAD: Final = math.radians(120.0)
"""Arcs that turn more are written by their centre: from a radius, rounding would move one too far."""
_CODES: Final = {Motion.RAPID: 0, Motion.LINE: 1}


def g_digits(program: Program) -> int:
    """Returns the number of digits of the program's motion codes: 2 of `G01`, 1 of `G1`; 2 without any."""
    for block in program.blocks:
        word = motion_word(program, block)
        if word is not None and word.kind == "number" and word.value in range(4):
            return len(word.text) - 1
    return 2


def g_code(path: ToolPath, move: int, digits: int) -> str:
    """Returns the code of a rapid, a line or an arc; empty for other moves."""
    kind = Motion(path.motion[move])
    if kind == Motion.ARC:
        return f"G{2 if path.sweep_rad[move] > 0 else 3:0{digits}d}"
    return f"G{_CODES[kind]:0{digits}d}" if kind in _CODES else ""


def motion_word(program: Program, block: Block) -> Word | None:
    """Returns the first word of a block that sets its motion; DR of Klartext comes after it."""
    meanings = ((word, program.core.meaning(word.index) or "") for word in block.data)
    return next((word for word, meaning in meanings if meaning.startswith("Motion(")), None)


def klartext_name(path: ToolPath, move: int, block: Block, new: Sequence[str]) -> str:
    """Returns the name of a Klartext move: L of a line; of an arc CR where it has a radius, C about its pole."""
    if path.motion[move] != Motion.ARC:
        return "L"
    return "CR" if any(text.startswith("R") for text in [*new, *(w.text for w in block.data)]) else "C"


def circle_words(program: Program, path: ToolPath, move: int, start: Array, end: Array) -> str:
    """Returns the radius, or of a wide arc its centre from the start, moved to be as far from both rounded ends."""
    state, axes, centre = path.coordinate_state(move), PLANE_AXES[int(path.plane[move])], path.centre_mm[move]
    if is_wide(path, move):
        return circle_text(program, state, axes, centre, start, by_radius=False, end_mm=end)
    return circle_text(program, state, axes, centre, path.start_mm[move], by_radius=True)


def is_wide(path: ToolPath, move: int) -> bool:
    """Returns whether an arc is to be written by its centre."""
    return bool(abs(path.sweep_rad[move]) > WIDE_RAD)


def is_about_pole(path: ToolPath, move: int) -> bool:
    """Returns whether an arc of Klartext is to be written about a CC, which alone names a plane."""
    return is_wide(path, move) or PLANE_AXES[int(path.plane[move])] != (0, 1)


def klartext_turn(path: ToolPath, move: int) -> str:
    """Returns the word of an arc's direction in Klartext: DR- clockwise."""
    return f"DR{'-' if path.sweep_rad[move] > 0 else '+'}"


def pole_block(program: Program, path: ToolPath, move: int) -> str:
    """Returns the CC block of an arc of Klartext."""
    state = path.coordinate_state(move)
    axes = sorted(PLANE_AXES[int(path.plane[move])])
    words = [coordinate_text(program.dialect, "XYZ"[axis], float(path.centre_mm[move, axis]), state) for axis in axes]
    return " ".join(["CC", *words])


def feed_word(program: Program, path: ToolPath, move: int) -> str:
    """Returns the F word of a move's feed."""
    feed = float(path.feed[move]) / (MM_PER_INCH if path.inch[move] else 1.0)
    text = f"F{feed:.6f}".rstrip("0")
    return text.rstrip(".") if program.dialect.klartext else text


def require_writable(program: Program, path: ToolPath, block: Block, moves: Sequence[int]) -> None:
    """Raises NC-EDIT where the moves of one run of a block cannot be written by their ends."""
    corners = [k for k in moves if is_made(path, k)]
    if not all(k in path.corners or makes_spline(program, path, k) for k in corners):
        raise refusal(program, block, "a cycle makes its moves", "write the cycle out as moves")
    shaped = is_shaped(program, path, moves[0])
    if corners and path.feed_mode[corners[0]] == INVERSE_TIME:
        raise refusal(program, block, "the time of its move is given (G93)", "program the feed by G94 or G95 there")
    formula = next((w for w in _behind(program, path, moves) if w.is_expression and math.isnan(number_said(w))), None)
    if shaped and formula is not None:
        hint = "write the coordinates beside it as numbers, or the corner or arc as a block of its own"
        raise refusal(program, block, f"it depends on {formula.text}, which another value would change", hint)


def is_place(program: Program, path: ToolPath, move: int) -> bool:
    """Returns whether a move goes to the place of a hole: the cycle of its block then moves along the third axis."""
    after, axes = move + 1, list(PLANE_AXES[int(path.plane[move])])
    if after >= len(path) or path.block[after] != path.block[move] or after in path.corners:
        return False
    stays = path.end_mm[after, axes] == path.start_mm[after, axes]
    return bool(stays.all()) and not is_wordless(path, move) and not makes_spline(program, path, after)


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
