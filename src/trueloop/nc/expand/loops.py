"""Macro loops written out: one word cuts many moves, of which each is to be corrected by itself.

The loop's text, from the statement that opens it to the one that closes it, gives way to a block for each move that it
makes. Its variables have no value then: a loop whose variables are read afterwards is refused.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.errors import TrueloopError
from trueloop.nc.edit.changes import is_shaped
from trueloop.nc.edit.edit import Edit, coordinate_text, line_ending
from trueloop.nc.expand.block import feed_word, g_code, g_digits, refusal
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import INVERSE_TIME, Motion, ToolPath

OPENS: Final = (
    (re.compile(r"o(<[^>]*>|\d+)\s*(?:while|repeat)\b"), r"o\s*{0}\s*end(?:while|repeat)\b"),
    (re.compile(r"o(<[^>]*>|\d+)\s*do\b"), r"o\s*{0}\s*while\b"),
    (re.compile(r"while\b.*\bdo\s*(\d)$|while.*\]\s*do\s*(\d)$"), r"end\s*{0}$"),
    (re.compile(r"(?:while|for)\b"), r"end(?:while|for)\b"),
    (re.compile(r"loop\b"), r"endloop\b"),
    (re.compile(r"repeat\b"), r"until\b"),
)
"""Statements that open a loop, and with their label what closes it."""

OUTLIVES: Final = 500
"""Numbered variables from here on keep their values after the program."""

INSIDE: Final = frozenset("GXZUWFN")
"""Words that a loop which is written out may have beside assignments and flow."""

VARIABLE: Final = re.compile(r"#<[^>]*>|#\d+|R\d+")


@dataclass(frozen=True)
class Loop:
    """The blocks of a loop, the statements that open and close it among them."""

    first: int
    last: int

    def has(self, block: int) -> bool:
        """Returns whether a block is one of the loop's."""
        return self.first <= block <= self.last


def loops_written_out(program: Program, path: ToolPath, moves: set[int]) -> list[Edit]:
    """Returns the edits that write out every loop in which one block makes several of the moves. Raises NC-EDIT."""
    blocks, counts = np.unique(path.block[sorted(k for k in moves if 0 <= k < len(path))], return_counts=True)
    again = [int(block) for block in blocks[counts > 1]]
    if not again:
        return []
    loops = [loop for loop in loops_of(program) if any(loop.has(block) for block in again)]
    return [_written(program, path, loop) for loop in loops if not _is_shaped(program, path, loop)]


def loops_of(program: Program) -> Iterator[Loop]:
    """Yields the loops of a program, those inside others left out."""
    open_loops: list[tuple[int, re.Pattern[str]]] = []
    for block in program.blocks:
        for word in block.data:
            if word.kind not in ("flow", "statement"):
                continue
            text = word.text.lower().strip()
            if open_loops and open_loops[-1][1].match(text):
                first = open_loops.pop()[0]
                if not open_loops:
                    yield Loop(first, block.index)
            elif (closes := _closer(text)) is not None:
                open_loops.append((block.index, closes))


def _closer(text: str) -> re.Pattern[str] | None:
    for opens, closes in OPENS:
        if found := opens.match(text):
            label = next((group for group in found.groups() if group), "") if found.groups() else ""
            return re.compile(closes.format(re.escape(label)))
    return None


def _made_by(path: ToolPath, loop: Loop) -> NDArray[np.intp]:
    """The moves that its blocks make."""
    return np.flatnonzero((path.block >= loop.first) & (path.block <= loop.last))


def _is_shaped(program: Program, path: ToolPath, loop: Loop) -> bool:
    """Returns whether corners, angles or poles shape moves of it: each run of the loop would write them otherwise."""
    return any(is_shaped(program, path, k) or k in path.corners for k in _made_by(path, loop).tolist())


def _written(program: Program, path: ToolPath, loop: Loop) -> Edit:
    inside = [program.block(k) for k in range(loop.first, loop.last + 1)]
    _require_plain(program, inside)
    _require_unread(program, loop, inside)
    made = _made_by(path, loop)
    if made[-1] - made[0] + 1 != len(made):
        raise refusal(program, inside[0], "it runs several times", "write the finish pass as a loop of its own")
    comment, ending = program.dialect.comment, line_ending(program)
    lines = [comment(f"loop of lines {inside[0].line} to {inside[-1].line} written out, {len(made)} moves")]
    feeds = any(word.letter == "F" for block in inside for word in block.data)
    feed = np.nan if feeds else float(path.feed[made[0]])
    digits = g_digits(program)
    for k in made.tolist():
        lines.append(_block(program, path, k, digits, feed))
        feed = feed if path.motion[k] == Motion.RAPID else float(path.feed[k])
    return Edit(inside[0].start, inside[-1].end, ending.join([*lines, comment("end of the loop")]))


def _block(program: Program, path: ToolPath, move: int, digits: int, feed: float) -> str:
    block, state = program.block(int(path.block[move])), path.coordinate_state(move)
    if path.motion[move] not in (Motion.RAPID, Motion.LINE) or state.incremental or _leaves_plane(path, move):
        hint = "make the loop of straight moves along X and Z, by positions (G90)"
        raise refusal(program, block, "its loop makes other moves than straight ones along X and Z", hint)
    if path.feed_mode[move] == INVERSE_TIME:
        raise refusal(program, block, "the time of its move is given (G93)", "program the feed by G94 or G95 there")
    words = [g_code(path, move, digits)]
    words += [
        coordinate_text(program.dialect, letter, float(path.end_mm[move, axis]), state)
        for axis, letter in ((0, "X"), (2, "Z"))
    ]
    if path.motion[move] == Motion.LINE and path.feed[move] != feed:
        words.append(feed_word(program, path, move))
    return " ".join(words)


def _leaves_plane(path: ToolPath, move: int) -> bool:
    return bool(path.end_mm[move, 1] != path.start_mm[move, 1])


def _require_plain(program: Program, inside: Sequence[Block]) -> None:
    """Refuses a loop that does more than count, move straight and set the feed."""
    for block in inside:
        for word in block.data:
            if word.kind in ("assignment", "flow") or block in (inside[0], inside[-1]):
                continue
            motion = word.letter != "G" or word.value in (0, 1)
            if word.kind not in ("number", "expression") or word.letter not in INSIDE or not motion or block.skipped:
                hint = "leave nothing in the loop but assignments, G0 and G1 with X and Z, and F"
                raise refusal(program, block, f"its loop has {word.text}, which must stay in it", hint)


def _require_unread(program: Program, loop: Loop, inside: Sequence[Block]) -> None:
    """Refuses a loop whose variables may be read after it."""
    assigned = {name for block in inside for word in block.data if word.kind == "assignment" for name in _set_by(word)}
    kept = [name for name in assigned if name[1:].isdigit() and int(name[1:]) >= OUTLIVES]
    rest = [block for block in program.blocks if not loop.has(block.index)]
    calls = any(word.kind == "call" for block in rest for word in block.data)
    after = [block for block in rest if calls or block.index > loop.last]
    for block in after:
        for word in block.data:
            read = word.text.partition("=")[2] if word.kind == "assignment" else word.text
            if found := assigned & set(VARIABLE.findall(read)):
                raise _read_later(program, inside[0], f"{sorted(found)[0]} is read again in line {block.line}")
    if kept:
        raise _read_later(program, inside[0], f"{kept[0]} keeps its value after the program")


def _set_by(word: Word) -> Iterator[str]:
    yield from VARIABLE.findall(word.text.partition("=")[0])[:1]


def _read_later(program: Program, block: Block, why: str) -> TrueloopError:
    return refusal(program, block, why, "give the loop variables of its own, which nothing else reads")
