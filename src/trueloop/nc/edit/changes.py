"""Changes of a program as a record lists them, and the refusal of a change that did not come out as intended; edits of
an edited program as edits of its source; the place of a comment about the whole program.

Moves that keep their shape when their ends are displaced, and those that words left unchanged would distort.

An arc may be given by its angle (`AR=`), a point on it (CIP), the direction of the move before (CT) or a pole; a line
by its angle (`ANG=`) or about a pole; a corner by its size. Displacing coordinates and leaving those words would write
another path.
"""

import math
import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.domain.record import ChangedWord
from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import Edit, in_order, insert_blocks_after, line_ending, spliced
from trueloop.nc.program.program import Program, Word
from trueloop.nc.program.tool_path import NO_COMPENSATION, Motion, ToolPath
from trueloop.units import UM_PER_MM

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


STATES: Final = ("feed", "feed_mode", "compensation", "plane", "tool", "work_offset", "spindle_mode", "spindle_speed")
"""The modal state of a move that a written program has to keep, beside its end."""


def changes(program: Program, edits: Sequence[Edit]) -> list[ChangedWord]:
    """Edits as a person reads them, in order."""
    listed: list[ChangedWord] = []
    for edit in sorted(edits, key=lambda edit: edit.start):
        place = program.place(edit.start)
        before = program.source[edit.start : edit.end].decode("latin-1")
        listed.append(ChangedWord(place.line or 0, place.column or 0, before, edit.text))
    return listed


def not_as_intended(message: str) -> TrueloopError:
    """Returns the error CMP-READ-BACK of a written program that does not do what was intended."""
    return Code.CMP_READ_BACK.refusal(
        message, hint="nothing was written; please report the program, this should not happen"
    )


def otherwise(before: ToolPath, after: ToolPath, moves: tuple[Integers, Integers]) -> Iterator[tuple[Flags, str]]:
    """Yields in which of the `moves`, (n,) of each path, which stand for each other, the later path is not the earlier
    one apart from where it goes, (n,), and in which respect: kind, way of turning, feed, tool and the like.
    """
    old, new = moves
    yield before.motion[old] != after.motion[new], "makes another move than the source"
    yield np.abs(before.sweep_rad[old] - after.sweep_rad[new]) > math.pi, "turns another way than the source"
    planeless = (before.motion[old] != Motion.ARC) & (before.compensation[old] == NO_COMPENSATION)
    for name in STATES:
        was, now = getattr(before, name)[old], getattr(after, name)[new]
        kept = (was == now) | np.isnan(was) & np.isnan(now) | (planeless & (name == "plane"))
        yield ~kept, f"has another {name.replace('_', ' ')} than the source"


def verify_written(
    before: ToolPath,
    after: ToolPath,
    moves: tuple[Integers, Integers],
    wanted_mm: Array,
    checked: Flags | bool = True,
    *,
    allowed_mm: float,
) -> None:
    """Refuses a written program, run again as `after`, of which a move is not the source's (`before`) or ends elsewhere
    than intended.

    `moves`: those of the source and of the written program that stand for each other, (n,) each. `wanted_mm` (n, 3):
    where they are to end, compared along the axes that `checked` (n, 3) has. The centres of arcs stay.
    """
    old, new = moves
    off = np.where(checked, np.abs(after.end_mm[new] - wanted_mm), 0.0).max(axis=1, initial=0.0)
    arcs = np.flatnonzero(before.motion[old] == Motion.ARC)
    centres = np.abs(after.centre_mm[new[arcs]] - before.centre_mm[old[arcs]]).max(axis=1, initial=0.0)
    off[arcs] = np.maximum(off[arcs], centres)
    for wrong, what in (
        *otherwise(before, after, moves),
        (~(off <= allowed_mm), "ends {off:.2f} µm from where it was to end"),
    ):
        if np.any(wrong):
            worst = int(np.argmax(np.where(wrong, np.nan_to_num(off, nan=np.inf), -1.0)))
            text = what.format(off=float(off[worst]) * UM_PER_MM)
            raise not_as_intended(f"the move of line {after.line[new[worst]]} of the written program {text}")


def composed(source: bytes, first: Sequence[Edit], second: Sequence[Edit]) -> list[Edit]:
    """Returns the edits of `source` that do what `first` does and then `second` to the result.

    Edits of both that touch each other become one. Insertions at one place keep their order.
    """
    between, written, grown = spliced(source, first), list[tuple[int, int]](), [0]
    for edit in in_order(first):
        start = edit.start + grown[-1]
        grown.append(grown[-1] + len(edit.text) - (edit.end - edit.start))
        written.append((start, edit.end + grown[-1]))
    ends = [end for _, end in written]

    def longer(at: int) -> int:
        """Returns by how many bytes the edited program is longer than its source, up to there."""
        return grown[bisect_right(ends, at)]

    edits, later = [], in_order(second)
    starts = [edit.start for edit in later]
    for low, high in _touching(written + [(edit.start, edit.end) for edit in second]):
        near = later[bisect_left(starts, low) : bisect_right(starts, high)]
        own = [Edit(e.start - low, e.end - low, e.text) for e in near if e.end <= high]
        text = spliced(between[low:high], own).decode("latin-1")
        edits.append(Edit(low - longer(low - 1), high - longer(high), text))
    return edits


def _touching(spans: Sequence[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Yields the spans that those become which overlap or meet."""
    low, high = -1, -1
    for start, end in sorted(spans):
        if low >= 0 and start > high:
            yield low, high
        low, high = (start, end) if low < 0 or start > high else (low, max(high, end))
    if low >= 0:
        yield low, high


_HAS_TO_BE_FIRST: Final = re.compile(
    rb"""\s*(?:
        % .*                                             # tape mark, or the program's name behind it
        | \$ [^\s%]+ %                                   # Okuma's name of the file
        | ;\$PATH .*                                     # where Sinumerik files the program
        | \d* [ \t]* BEGIN [ \t]+ PGM .*                 # head of Klartext
        | (?:[O:] \d+ | <[^<>]+>) [ \t]* (?:\(.*\))? ;?  # number or name: controls drop what comes before it
        | (?:N\d+)? [ \t]* \(ID, .*                      # GE 2000T's name of the program
    )?\s*""",
    re.IGNORECASE | re.VERBOSE,
)
"""A block that has to be among a program's first, or an empty one. `O100 sub` is a block of LinuxCNC's like others."""


def insert_heading(program: Program, texts: Sequence[str]) -> Edit:
    """Writes blocks behind those that have to be first, numbered as the program is; at the top where there are none."""
    last = _last_of_heading(program)
    if last is None:
        top = program.block(0).start if program.block_count else len(program.source)  # behind a byte order mark
        return Edit(top, top, "".join(f"{text}{line_ending(program)}" for text in texts))
    return insert_blocks_after(program, last, texts)


def _last_of_heading(program: Program) -> int | None:
    last = None
    for index in range(program.block_count):
        block = program.block(index)
        text = program.source[block.start : block.end]
        if not _HAS_TO_BE_FIRST.fullmatch(text):
            break
        if text.strip():
            last = index
    return last
