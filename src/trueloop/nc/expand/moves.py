"""Moves written by their ends, arcs by radius or centre, into the blocks that gave them in other words."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.nc.edit.changes import ENDS, EVERY_CORNER, is_made, shaping_words
from trueloop.nc.edit.edit import Edit, coordinate_text, line_ending, number, number_said, word_with
from trueloop.nc.expand.block import (
    OUT,
    circle_words,
    feed_word,
    g_code,
    g_digits,
    is_wide,
    klartext_name,
    klartext_turn,
    makes_spline,
    motion_word,
    pole_block,
    refusal,
    require_writable,
    rewritten,
    spline_blocks,
    without_spline,
)
from trueloop.nc.program.along import PLANE_AXES
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import CoordinateState, Motion, ToolPath

AXES: Final = "XYZ"
CENTRES: Final = "IJK"
_SAME_MM: Final = 1e-7


class Explicit:
    """The edits that write moves out, by block; gathered visit by visit, in the order of cutting.

    Held between visits: the last move written out, where the written program has the tool after it, the motion code
    and the feed in force there.
    """

    def __init__(self, program: Program, path: ToolPath) -> None:
        self.program, self.path = program, path
        self.edits: dict[int, list[Edit]] = {}
        self._digits = g_digits(program)
        self._klartext = program.dialect.klartext
        self._last, self._end, self._code, self._feed = -1, np.zeros(3), "", math.nan

    def write(self, moves: Sequence[int]) -> None:
        """Writes out the moves that one run of a block makes: its own, and the corner after it."""
        block = self.program.block(int(self.path.block[moves[0]]))
        if self._last != moves[0] - 1:
            self._begin(moves[0], block)
        require_writable(self.program, self.path, block, moves)
        if makes_spline(self.program, self.path, moves[0]):
            self._spline(moves, block)
            return
        changed: dict[int, str] = {}
        new: list[str] = []
        own = [k for k in moves if not is_made(self.path, k)]
        for k in own:
            self._own(k, block, changed, new)
        more = [self._corner(k) for k in moves[len(own) :]]
        if not own:  # a corner with a block to itself
            changed |= {word.index: OUT for word in block.data if word.index in self.path.corner_words}
            new, more = more, []
        self._last = moves[-1]
        self._keep(block, rewritten(self.program, block, changed, new, more))

    def _spline(self, moves: Sequence[int], block: Block) -> None:
        """The chords of a spline in place of what gave it; its feed stays where it is."""
        self._code, self._feed = "", float(self.path.feed[moves[0]])
        texts = [self._corner(k) for k in moves]
        self._last = moves[-1]
        for other in spline_blocks(self.program, block):
            changed, own = without_spline(self.program, other), other.index == block.index
            new, more = (texts[:1], texts[1:]) if own else ((), ())
            self._keep(other, rewritten(self.program, other, changed, new, more))

    def end_every_corner(self) -> None:
        """Takes RNDM out of a program whose corners are all written out. Raises NC-EDIT beside blocks not run."""
        for block in self.program.blocks:
            values = [word for word in block.data if word.kind in ("number", "expression")]
            if block.index not in self.path.block and any(word.letter in "XYZ" for word in values):
                hint = "write RND into the blocks that are to end in a corner"
                raise refusal(self.program, block, "RNDM may be in force here, and it is not run", hint)
            every = {word.index: OUT for word in values if word.letter == EVERY_CORNER}
            if every and block.index not in self.path.block:
                self.edits[block.index] = rewritten(self.program, block, every, (), ())

    def _begin(self, move: int, block: Block) -> None:
        """Reads the state in force before a move, if no move before it was written out."""
        path = self.path
        self._end, self._feed = path.start_mm[move] + self._carried(move), float(path.feed[move])
        tangent = path.motion[move] == Motion.ARC and not any(w.letter in "IJKRapq" for w in block.data)
        self._code = "" if tangent else g_code(path, move, self._digits)

    def _carried(self, move: int) -> Array:
        """How far rounding holds the tool off where a move starts: increments since the last one written keep it."""
        carried, between = np.zeros(3), range(self._last + 1, move)
        for axis in range(3) if self._last >= 0 else ():
            words = [(int(self.path.word[k, axis]), bool(self.path.incremental[k])) for k in between]
            if all(_is_increment(self.program.word(word), mode) for word, mode in words if word >= 0):
                carried[axis] = self._end[axis] - self.path.end_mm[self._last, axis]
        return carried

    def _own(self, move: int, block: Block, changed: dict[int, str], new: list[str]) -> None:
        """The move that the block's words give."""
        changed |= {word.index: OUT for word in shaping_words(self.program, self.path, move)}
        end = np.array([self._coordinate(move, axis, changed, new) for axis in range(3)])
        if self.path.motion[move] == Motion.ARC:
            self._circle(move, block, end, changed, new)
        self._motion(move, block, changed, new)
        if self.path.motion[move] != Motion.RAPID:
            if not any(word.letter == "F" for word in block.data) and self._feed_changes(move):
                new.append(feed_word(self.program, self.path, move))
            self._feed = float(self.path.feed[move])
        self._end = end

    def _coordinate(self, move: int, axis: int, changed: dict[int, str], new: list[str]) -> float:
        """One coordinate of the end, where the program then has it."""
        path, letter = self.path, AXES[axis]
        index, target, held = int(path.word[move, axis]), float(path.end_mm[move, axis]), float(self._end[axis])
        state, dialect = path.coordinate_state(move), self.program.dialect
        written = _written(dialect, letter, target, held, state)
        if index < 0 and (target == held or written == _written(dialect, letter, held, held, state)):
            return held
        word = self.program.word(index) if index >= 0 else None
        if word is None or word.letter not in ENDS:
            new.append(written[1])
            return written[0]
        start = float(path.start_mm[move, axis])
        increment = _is_increment(word, state.incremental)
        said = number_said(word) * state.unit_mm(letter, increment) + (start if increment else 0.0)
        if math.isnan(said) or abs(said - target) <= _SAME_MM:
            return held + target - start if increment else target
        plain = word.kind == "number" and word.letter == letter and increment == state.incremental
        value = target - held if increment else target
        changed[index] = word_with(word, value, dialect, state) if plain else written[1]
        return written[0]

    def _circle(self, move: int, block: Block, end: Array, changed: dict[int, str], new: list[str]) -> None:
        """Radius or centre of an arc; `self._end` is where it starts."""
        path, state = self.path, self.path.coordinate_state(move)
        given = {word.letter: word for word in block.data if word.kind in ("number", "expression")}
        if "R" in given:
            if given["R"].value < 0.0 and abs(path.sweep_rad[move]) < math.pi:
                changed[given["R"].index] = word_with(
                    given["R"], float(path.programmed_radius_mm[move]), self.program.dialect, state
                )
            return
        axes = PLANE_AXES[int(path.plane[move])]
        if not any(CENTRES[axis] in given for axis in axes):
            self._new_circle(move, block, end, changed, new)
            return
        for axis in axes:
            letter, centre = CENTRES[axis], float(path.centre_mm[move, axis])
            value, word = centre - float(self._end[axis]), given.get(letter)
            said = number_said(word) * state.unit_mm(letter) if word is not None else 0.0
            if (word is not None and word.increment is False) or abs(said - value) <= _SAME_MM:
                continue
            text = coordinate_text(self.program.dialect, letter, value, state)
            if word is None:
                new.append(text)
            else:
                plain = word.kind == "number"
                changed[word.index] = word_with(word, value, self.program.dialect, state) if plain else text

    def _new_circle(self, move: int, block: Block, end: Array, changed: dict[int, str], new: list[str]) -> None:
        """The circle of an arc that has neither radius nor centre; in Klartext a wide one is about a CC before it."""
        if not self._klartext:
            new.append(circle_words(self.program, self.path, move, self._end, end))
            return
        word = motion_word(self.program, block)
        if word is None or (word.text.upper() == "CP" and is_wide(self.path, move)):
            return
        if is_wide(self.path, move):
            changed[word.index] = f"{pole_block(self.program, self.path, move)}{line_ending(self.program)}C"
        else:
            new.append(circle_words(self.program, self.path, move, self._end, end))
        if not any(word.text.upper().startswith("DR") for word in block.data):
            new.append(klartext_turn(self.path, move))

    def _motion(self, move: int, block: Block, changed: dict[int, str], new: list[str]) -> None:
        """The word that says how the block moves."""
        word = motion_word(self.program, block)
        if self._klartext:
            if word is not None and word.text.upper() != (name := klartext_name(self.path, move, block, new)):
                changed.setdefault(word.index, name)
            return
        code = g_code(self.path, move, self._digits)
        if word is not None and word.kind == "name":
            changed[word.index] = code
        elif word is None and code and code != self._code:
            first = block.data[0]
            changed[first.index] = " ".join(filter(None, [code, changed.get(first.index, first.text)]))
        self._code = code

    def _corner(self, move: int) -> str:
        """A corner as a move of its own."""
        path, dialect, state = self.path, self.program.dialect, self.path.coordinate_state(move)
        axes = sorted(PLANE_AXES[int(path.plane[move])])
        end = np.array(self._end)
        words = []
        for axis in axes:
            target, held = float(path.end_mm[move, axis]), float(self._end[axis])
            end[axis], text = _written(dialect, AXES[axis], target, held, state)
            words.append(text)
        arc = path.motion[move] == Motion.ARC
        code = g_code(path, move, self._digits)
        if self._klartext:
            pole = [pole_block(self.program, path, move), "C"] if arc and is_wide(path, move) else []
            code = line_ending(self.program).join(pole) or ("CR" if arc else "L")
        if arc:
            words += [] if code.endswith("C") else [circle_words(self.program, path, move, self._end, end)]
            words += [klartext_turn(path, move)] if self._klartext else []
        if code != self._code or self._klartext:
            words.insert(0, code)
        if self._feed_changes(move) and not self._klartext:
            words.append(feed_word(self.program, path, move))
        self._end, self._code, self._feed = end, code, float(path.feed[move])
        return " ".join(words)

    def _feed_changes(self, move: int) -> bool:
        return bool(self.path.feed[move] != self._feed and not math.isnan(self.path.feed[move]))

    def _keep(self, block: Block, edits: list[Edit]) -> None:
        if self.edits.setdefault(block.index, edits) != edits:
            raise refusal(
                self.program, block, "it runs several times to different places", "write the loop or calls out"
            )


def _is_increment(word: Word, in_force: bool) -> bool:
    """Returns whether a word says how far its axis goes."""
    return in_force if word.increment is None else word.increment


def _written(dialect: Dialect, letter: str, target: float, held: float, state: CoordinateState) -> tuple[float, str]:
    """Where a coordinate of a move from `held` then is, and its word: an increment where those are in force, mm."""
    origin = held if state.incremental else 0.0
    text, value_mm = number(dialect, letter, target - origin, state)
    return origin + value_mm, letter + text
